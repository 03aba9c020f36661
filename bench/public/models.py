#!/usr/bin/python3
"""models: parametric models of Gmsh's OpenCASCADE kernel, meshed by Gmsh, TetGen, Netgen and CGAL.

    models.py FOLDER [--count N] [--seed N] [--only gmsh|tetgen|netgen|cgal] [--cgal PROGRAM]

Makes N models (200), the same for the same seed and the same versions of the meshers: primitives, fillets, chamfers,
booleans, extruded and turned profiles; tetrahedra, hexahedra, wedges, pyramids, triangles, quadrilaterals, surfaces in
space; first and second order; several file formats. A model that a mesher cannot mesh is tried again with other
numbers. Files that are there already stay. PROGRAM is cgal.cpp, built; without it there are none of CGAL."""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys

import gmsh
import recipes

SHARES = {"gmsh": 0.84, "tetgen": 0.06, "netgen": 0.06, "cgal": 0.04}
ATTEMPTS = 6
SECONDS = 120
SOLID_FORMATS = ("msh", "msh22", "msh_binary", "vtk", "mesh", "bdf", "inp", "su2", "unv", "vtk_binary")
SECOND_FORMATS = ("msh", "msh22", "vtk", "unv", "inp", "msh_binary")
SURFACE_FORMATS = ("msh", "stl", "vtk", "stl_binary", "mesh")
EXTENSIONS = {"msh22": "msh", "msh_binary": "msh", "vtk_binary": "vtk", "stl_binary": "stl"}


def chance(seed, *what):
    """Random numbers of a model: the same on every run."""
    return random.Random("/".join(map(str, (seed, *what))))


def write(path, kind):
    """The mesh in Gmsh's memory, to a file that is whole or not there."""
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2 if kind == "msh22" else 4.1)
    gmsh.option.setNumber("Mesh.Binary", int(kind.endswith("_binary")))
    part = path.with_name("part" + path.suffix)
    gmsh.write(str(part))
    part.rename(path)


def until_there(path, attempt):
    """Call attempt(number) in processes of their own, which Gmsh may end, until one has made the file."""
    for number in range(ATTEMPTS):
        child = os.fork()
        if child == 0:
            signal.alarm(SECONDS)
            try:
                attempt(number)
            except Exception as error:  # pylint: disable=broad-except # Gmsh has one kind for all
                print(f"models: {path.name}: {str(error)[:80]}", file=sys.stderr)
            os._exit(0)
        os.waitpid(child, 0)
        if path.exists():
            return path
    return None


def by_gmsh(folder, index, seed):
    """One model of Gmsh's; its path."""
    names = list(recipes.RECIPES)
    name = names[index % len(names)]
    recipe = recipes.RECIPES[name]
    order = 2 if not recipe.is_surface and (index // len(names)) % 3 == 2 else 1
    formats = SURFACE_FORMATS if recipe.is_surface else SECOND_FORMATS if order == 2 else SOLID_FORMATS
    kind = formats[(index * 7 + index // len(names)) % len(formats)]
    if recipe.only_triangles is False and kind.startswith("stl"):
        kind = "msh"
    path = folder / f"{index:03d}_{name}{'_2' if order == 2 else ''}.{EXTENSIONS.get(kind, kind)}"
    if path.exists():
        return path
    def attempt(number):
        recipes.make(recipe, chance(seed, "gmsh", index, number), order)
        if recipes.has_mesh():
            write(path, kind)
    return until_there(path, attempt)


def by_tetgen(folder, index, seed):
    """A surface of Gmsh's, filled by TetGen."""
    path = folder / f"{index:03d}.1.ele"
    if path.exists():
        return path
    stl, names = folder / f"{index:03d}.stl", recipes.SOLIDS

    def attempt(number):
        rng = chance(seed, "tetgen", index, number)
        recipes.make(recipes.RECIPES[names[(index + number) % len(names)]], rng, 1, dim=2)
        write(stl, "stl")
        options = rng.choice(("-pqQ", "-pq1.3Q", "-pqO9/7Q", "-pQ", "-pq1.6Q"))
        subprocess.run(["tetgen", options, stl], check=True, timeout=SECONDS, stdout=subprocess.DEVNULL)
    found = until_there(path, attempt)
    stl.unlink(missing_ok=True)
    return found


NETGEN = """
import sys
from netgen.csg import CSGeometry, Cone, Cylinder, Ellipsoid, OrthoBrick, Plane, Pnt, Sphere, Torus, Vec
from netgen.geom2d import SplineGeometry
path, kind, a, b, h, order = sys.argv[1], int(sys.argv[2]), *map(float, sys.argv[3:6]), int(sys.argv[6])
brick = OrthoBrick(Pnt(0, 0, 0), Pnt(1, 1 + a, 1 + b))
solids = (lambda: brick - Sphere(Pnt(0.5, 0.5, 0.5), 0.25 + 0.2 * a),
          lambda: brick - Cylinder(Pnt(0.4, 0.5, -1), Pnt(0.4 + 0.2 * a, 0.5, 3), 0.2 + 0.1 * b),
          lambda: Sphere(Pnt(0, 0, 0), 1) * OrthoBrick(Pnt(-2, -2, -2), Pnt(0.2 + a, 0.3 + b, 2)),
          lambda: Sphere(Pnt(0, 0, 0), 1) - Sphere(Pnt(0.3 * a, 0, 0), 0.3 + 0.2 * b),
          lambda: Cylinder(Pnt(0, 0, 0), Pnt(1, 0, 0), 0.5) * OrthoBrick(Pnt(-1 - a, -2, -2), Pnt(1 + b, 2, 2)))
if kind < len(solids):
    shape = CSGeometry()
    shape.Add(solids[kind]())
    mesh = shape.GenerateMesh(maxh=h)
else:
    shape = SplineGeometry()
    shape.AddRectangle((0, 0), (1 + a, 1), bc="outer")
    shape.AddCircle((0.5, 0.5), 0.2 + 0.15 * b, leftdomain=0, rightdomain=1, bc="hole")
    mesh = shape.GenerateMesh(maxh=h / 3)
if order == 2:
    mesh.SecondOrder()
if path.endswith(".msh"):
    mesh.Export(path, "Gmsh2 Format")
else:
    mesh.Save(path)
"""


def by_netgen(folder, index, seed):
    """A model of Netgen's own."""
    rng = chance(seed, "netgen", index)
    suffix = "msh" if index % 3 == 1 else "vol"
    path = folder / f"{index:03d}.{suffix}"
    if not path.exists():
        part = folder / f"part.{suffix}"
        done = subprocess.run(["/usr/bin/python3", "-c", NETGEN, part, str(index % 6), f"{rng.random():.3f}",
                               f"{rng.random():.3f}", f"{rng.uniform(0.2, 0.4):.3f}", str(1 + (index % 4 == 3))],
                              check=False, timeout=300, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if done.returncode or not part.exists():
            return None
        part.rename(path)
    return path


def by_cgal(folder, index, seed, program):
    """An implicit domain, meshed by cgal.cpp."""
    rng = chance(seed, "cgal", index)
    path = folder / f"{index:03d}.mesh"
    if not path.exists():
        part = folder / "part.mesh"
        subprocess.run([program, part, str(index), f"{rng.random():.3f}", f"{rng.uniform(0.15, 0.3):.3f}",
                        str(index % 2)], check=True, timeout=300, stdout=subprocess.DEVNULL)
        part.rename(path)
    return path


def main():
    parser = argparse.ArgumentParser(prog="models.py")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=SHARES)
    parser.add_argument("--cgal")
    chosen = parser.parse_args()
    makers = {"gmsh": by_gmsh, "tetgen": by_tetgen, "netgen": by_netgen}
    if chosen.cgal:
        makers["cgal"] = lambda *which: by_cgal(*which, os.path.abspath(chosen.cgal))
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    missing = 0
    for name, maker in makers.items():
        if chosen.only in (None, name):
            folder = chosen.folder / name
            folder.mkdir(parents=True, exist_ok=True)
            for index in range(round(SHARES[name] * chosen.count)):
                if maker(folder, index, chosen.seed) is None:
                    print(f"models: no mesh {name} {index}", file=sys.stderr)
                    missing += 1
    gmsh.finalize()
    return int(missing > 0)


if __name__ == "__main__":
    sys.exit(main())
