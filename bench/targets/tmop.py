"""tmop: MFEM's mesh-optimizer, its program of TMOP, on points and elements in memory."""
import os
import re
import resource
import subprocess
from collections import namedtuple

import numpy as np

import cells

GEOMETRIES = {"segment": 1, "triangle": 2, "quad": 3, "tet": 4, "hex": 5}  # MFEM's numbers
FACES = {2: "segment", 3: "triangle", 4: "quad"}                           # by their corners
HELD = 4     # the attribute of faces whose nodes stay; 1, 2, 3: they stay in x, y, z
FLAT = 1e-9  # of the domain, which is 1 wide: a face that is so flat is in a plane

# iterations: of Newton's method or L-BFGS; seconds: of the processor, without reading and writing.
Outcome = namedtuple("Outcome", "points seconds iterations converged energy")


def attributes(points, faces, slides):
    """Of boundary faces [k][corners]: their nodes stay, or slide in the plane of an axis."""
    found = np.full(len(faces), HELD)
    if slides:
        is_flat = np.ptp(points[faces], axis=1) < FLAT
        if not is_flat.any(axis=1).all():
            raise ValueError("a face of the boundary is in no plane of an axis")
        found = 1 + is_flat.argmax(axis=1)
    return found


def write_rows(file, attribute, name, nodes):
    rows = np.column_stack([attribute, np.full(len(nodes), GEOMETRIES[name]), nodes])
    np.savetxt(file, rows, "%d")


def write(path, points, elements, slides):
    """Write MFEM's own format."""
    elements = cells.Cells(*cells.blocks_of(elements))
    faces = cells.boundary_faces(elements)
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MFEM mesh v1.0\n\ndimension\n{elements.dim}\n\nelements\n{len(elements)}\n")
        for name, nodes in elements.blocks:
            write_rows(file, np.ones(len(nodes), int), name, nodes)
        file.write(f"\nboundary\n{len(faces)}\n")
        for corners, name in FACES.items():
            some = faces[(faces >= 0).sum(axis=1) == corners, :corners]
            write_rows(file, attributes(points, some, slides), name, some)
        file.write(f"\nvertices\n{len(points)}\n{elements.dim}\n")
        np.savetxt(file, points, "%.17g")


def read_points(path, dim):
    """Points [n][dim] of a file that mesh-optimizer has written: all first coordinates come first."""
    with open(path, encoding="ascii") as file:
        nodes = file.read().split("\nnodes\n")[1]
    values = np.array(nodes.split("Ordering: 0")[1].split(), float)
    return values.reshape(dim, -1).T


def used_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Optimizer:
    """The program, and a folder for its files."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def execute(self, iterations, options):
        """Processor seconds, and what the program says."""
        command = [self.program, "-m", "in.mesh", "-o", "1", "-bnd", "-no-vis", "-vl", "1", "-ni", str(iterations),
                   *options]
        before = used_seconds()
        done = subprocess.run(command, cwd=self.folder, text=True, check=False, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        if done.returncode:
            raise SystemExit(f"tmop: {' '.join(command)} ended with {done.returncode}: {done.stdout[-500:]}")
        return used_seconds() - before, done.stdout

    def smooth(self, points, elements, iterations, options, slides=False):
        """The Outcome of at most so many iterations. slides: boundary nodes do, in planes of axes."""
        write(f"{self.folder}/in.mesh", points, elements, slides)
        seconds, said = self.execute(iterations, options)
        found = read_points(f"{self.folder}/optimized.mesh", points.shape[1])
        without, _ = self.execute(0, options)
        os.remove(f"{self.folder}/in.mesh")
        energy = re.search(r"Final strain energy: (\S+)", said).group(1)
        numbers = re.findall(r"^(?:Newton|LBFGS) iteration +(\d+)", said, re.MULTILINE)
        return Outcome(found, seconds - without, int(numbers[-1]), "No convergence" not in said, float(energy))
