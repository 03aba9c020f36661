#!/usr/bin/env python3
"""converge: smooth meshes, displace the results by smooth fields, and smooth again.

   converge.py PROGRAMS OUT.csv MESH ...     meshes whose elements of the highest dimension have one type

Write a row for each mesh and error: the number of sweeps, on one thread. All meshes are displaced
before the first one is timed. The errors are 95 % of what keeps the mesh valid:
  warp, twist, stretch    the interior moves by the solution of a graph Laplace equation times a
                          constant, a rotation, a stretching; the boundary stays
  left behind             the boundary is sheared, and the interior stays
"""
import csv
import json
import pathlib
import subprocess
import sys

import numpy
from scipy import sparse
from scipy.sparse import linalg

import cells
import meshfile

PART = 0.95  # of the largest amplitude
HALVINGS = 40
REPEATS = 3
START = "as meshed"
KINDS = ("warp", "twist", "stretch", "left behind")

# ---- meshes --------------------------------------------------------------------------------------

# Of each type: corners, and the ends of their dim edges. The one determinant of a simplex is at its first.
CORNERS = {
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2)),
    "tet": ((0, 1, 2, 3),),
    "hex": ((0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7), (4, 7, 5, 0), (5, 4, 6, 1),
            (6, 5, 7, 2), (7, 6, 4, 3)),
    "wedge": ((0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)),
}


class Mesh:
    """x [n][dim]: coordinates; type: a key of cells.KINDS; nodes [m][corners]: of the elements;
    edges [e][2]: each once; used, inside [n]: nodes of elements, and those not on the boundary."""

    def __init__(self, path):
        self.x, elements = meshfile.read_vtk(path)
        (self.type, self.nodes), = elements.blocks
        self.edges = self.edges_once()
        self.used = numpy.zeros(len(self.x), bool)
        self.used[self.nodes] = True
        self.inside = self.used & ~self.on_boundary()

    def keys(self, rows):
        """[k] a number for each row of nodes [k][.]: no two faces have the same lowest three."""
        n = len(self.x)
        assert n < 2 ** 21, "three nodes do not fit into 63 bits"
        found = 0
        for column in numpy.sort(rows, 1)[:, :3].T:
            found = found * n + column
        return found

    def edges_once(self):
        pairs = {tuple(sorted((face[j - 1], face[j])))
                 for face in cells.KINDS[self.type].faces for j in range(len(face))}
        found = numpy.unique(numpy.concatenate([self.keys(self.nodes[:, pair]) for pair in sorted(pairs)]))
        return numpy.stack(numpy.divmod(found, len(self.x)), 1)

    def on_boundary(self):
        """[n] nodes of faces that belong to one element."""
        faces = [list(face) for face in cells.KINDS[self.type].faces]
        found = [self.keys(self.nodes[:, face]) for face in faces]
        unique, times = numpy.unique(numpy.concatenate(found), return_counts=True)
        single, result = unique[times == 1], numpy.zeros(len(self.x), bool)
        for face, keys in zip(faces, found):
            result[self.nodes[numpy.isin(keys, single)][:, face]] = True
        return result

    def determinants(self, x, nodes):
        """[corners][k] of elements with these nodes [k][.]."""
        return numpy.stack([
            cells.determinant(*(x[nodes[:, end]] - x[nodes[:, corner]] for end in ends))
            for corner, *ends in CORNERS[self.type]])

    def elements(self):
        return cells.Cells((self.type, self.nodes))


# ---- errors --------------------------------------------------------------------------------------


def graph_laplace(mesh):
    """[n] the solution for a load of 1 inside and 0 on the boundary; at most 1."""
    n = len(mesh.x)
    graph = sparse.csr_matrix((numpy.ones(len(mesh.edges)), mesh.edges.T), (n, n))
    graph = graph + graph.T
    matrix = (sparse.diags(numpy.asarray(graph.sum(1)).ravel()) - graph).tocsr()
    matrix = matrix[mesh.inside][:, mesh.inside]
    w = numpy.zeros(n)
    w[mesh.inside] = linalg.cg(matrix, numpy.ones(mesh.inside.sum()), tol=1e-6, maxiter=3000)[0]
    return w / w.max()


def field_of(mesh, kind, w):
    """[n][dim] displacement of amplitude 1."""
    away = mesh.x - mesh.x[mesh.used].mean(0)
    dim = away.shape[1]
    if kind == "left behind":
        return numpy.where(mesh.inside[:, None], 0, numpy.roll(away, -1, axis=1))
    if kind == "twist":
        return w[:, None] * numpy.stack([-away[:, 1], away[:, 0], 0 * away[:, 0]], 1)[:, :dim]
    if kind == "stretch":
        return w[:, None] * away * [1, -1, 0.5][:dim]
    return w[:, None] * [1, 0.6, -0.3][:dim]


def displace(mesh, field):
    """The coordinates after PART of the largest displacement that is valid at the elements' corners, or
    less where elements would be inverted.

    Where an element is valid it is taken to be so at all lower amplitudes: few have to be looked at."""
    low, high, nodes = 0.0, numpy.ptp(mesh.x) / abs(field).max(), mesh.nodes
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        valid = (mesh.determinants(mesh.x + middle * field, nodes) > 0).all(0)
        low, high = (middle, high) if valid.all() else (low, middle)
        nodes = nodes if valid.all() else nodes[~valid]
    part = PART
    while cells.n_inverted(mesh.x + part * low * field, mesh.elements()):
        part *= PART
    return mesh.x + part * low * field


# ---- runs ----------------------------------------------------------------------------------------


def run(programs, source, target):
    """The report of one run."""
    done = subprocess.run([f"{programs}/planish", "smooth", source, "-o", target, "-j", "1", "-q",
                           "--layers", "ignore", "--json", "-"], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def seconds(report):
    return sum(sweep["seconds"] for sweep in report["sweeps"])


def displaced(source, kind):
    return source.with_suffix(f".{kind.replace(' ', '_')}.vtk")


def prepare(programs, source):
    """Smooth a mesh and write its displaced forms; returns its type, numbers of elements and free nodes."""
    smoothed = source.with_suffix(".smooth.vtk")
    run(programs, source, smoothed)
    mesh = Mesh(smoothed)
    if cells.n_inverted(mesh.x, mesh.elements()):
        sys.exit(f"converge: {smoothed} has inverted elements, or elements that are turned")
    w = graph_laplace(mesh)
    for kind in KINDS:
        meshfile.write_vtk(displaced(source, kind), displace(mesh, field_of(mesh, kind, w)), mesh.elements())
    return {"type": mesh.type, "elements": len(mesh.nodes), "free": int(mesh.inside.sum())}


def row_of(programs, source, error, size):
    """A row: the fastest of several runs."""
    start = source if error == START else displaced(source, error)
    reports = [run(programs, start, source.with_suffix(".out.vtk")) for _ in range(REPEATS)]
    report = min(reports, key=seconds)
    if report["before"]["inverted"] or report["mesh"]["free_nodes"] != size["free"]:
        sys.exit(f"converge: {start} is not valid, or its nodes inside are not those that planish moves")
    return {"mesh": source.stem, **size, "error": error, "sweeps": len(report["sweeps"]),
            "visits": sum(sweep["visits"] for sweep in report["sweeps"]),
            "seconds": seconds(report), "rms": report["sweeps"][-1]["rms_movable"]}


def main():
    programs, target, *sources = sys.argv[1:]
    sources = [pathlib.Path(source) for source in sources]
    sizes = [prepare(programs, source) for source in sources]
    rows = [row_of(programs, source, error, size)
            for source, size in zip(sources, sizes) for error in (START, *KINDS)]
    with open(target, "w", encoding="ascii", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
