"""bases: the valid, irregular meshes that are spoilt: made by Gmsh and TetGen once, then kept as
.npz in build-bench/meshes/untangle, or where PLANISH_BENCH_MESHES says."""
import os
import subprocess
import zlib
from collections import namedtuple

import numpy as np

import medit
import simplex

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
FOLDER = os.environ.get("PLANISH_BENCH_MESHES", os.path.join(ROOT, "build-bench/meshes/untangle"))

# dimension; maker, its argument and element size; the hole that can be turned: its centre, the
# number of coordinates that its distance counts in (2: about z), its radius and that where turning
# ends.
Recipe = namedtuple("Recipe", "dim make argument size hole", defaults=(None,))
# fixed [n]: on the boundary; lengths [n]: of the edges at a node.
Base = namedtuple("Base", "points elements fixed edges hole")


def gmsh(name, recipe):
    path = f"{FOLDER}/{name}.mesh"
    size = [] if recipe.size is None else ["-setnumber", "h", str(recipe.size)]
    subprocess.run(["gmsh", f"-{recipe.dim}", "-nt", "1", "-v", "1", *size,
                    os.path.join(ROOT, recipe.argument), "-format", "mesh", "-o", path], check=True)
    with open(path, encoding="ascii") as file:
        words = file.read().split()
    simplices = {2: "Triangles", 3: "Tetrahedra"}[recipe.dim]
    os.remove(path)
    return (medit.section(words, "Vertices", 4)[:, :recipe.dim],
            medit.section(words, simplices, recipe.dim + 2)[:, :-1].astype(int) - 1)


def box_facets(first):
    """The six sides of a box whose corners, x fastest, are numbered from first."""
    sides = (0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)
    return [[first + corner for corner in side] for side in sides]


def box_corners(half):
    return [(x, y, z) for z in (-half, half) for y in (-half, half) for x in (-half, half)]


def cavity():
    """A cube with a cubic cavity: corners, facets, a point in each hole."""
    return box_corners(1) + box_corners(0.35), box_facets(0) + box_facets(8), [(0, 0, 0)]


def star():
    """A prism over a star of seven points."""
    n, corners = 14, []
    for z in (0, 0.8):
        angle, radius = 2 * np.pi * np.arange(n) / n, np.where(np.arange(n) % 2, 0.55, 1.2)
        corners += [(r * np.cos(a), r * np.sin(a), z) for r, a in zip(radius, angle)]
    sides = [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    return corners, [list(range(n)), list(range(n, 2 * n)), *sides], []


def tetgen(name, recipe):
    corners, sides, holes = recipe.argument()
    stem = f"{FOLDER}/{name}"
    with open(f"{stem}.poly", "w", encoding="ascii") as file:
        file.write(f"{len(corners)} 3 0 0\n")
        file.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(corners, 1))
        file.write(f"{len(sides)} 0\n")
        file.writelines(f"1\n{len(side)} {' '.join(str(i + 1) for i in side)}\n" for side in sides)
        file.write(f"{len(holes)}\n")
        file.writelines(f"{i} {x} {y} {z}\n" for i, (x, y, z) in enumerate(holes, 1))
    subprocess.run(["tetgen", f"-pq1.2a{recipe.size}Q", f"{stem}.poly"], check=True,
                   stdout=subprocess.DEVNULL)
    return medit.read_tetgen(f"{stem}.1")


GEO = "bench/untangle/geo/"
RECIPES = {
    "box": Recipe(3, gmsh, "bench/fem/box.geo", 0.075),
    "bracket": Recipe(3, gmsh, "docs/examples/bracket.geo", 4),
    "hole": Recipe(3, gmsh, GEO + "hole.geo", None, ((0, 0, 0), 2, 0.221, 0.49)),
    "angle": Recipe(3, gmsh, GEO + "angle.geo", None),
    "shell": Recipe(3, gmsh, GEO + "shell.geo", None, ((0, 0, 0), 3, 0.451, 0.98)),
    "bar": Recipe(3, gmsh, GEO + "bar.geo", None),
    "graded": Recipe(3, gmsh, GEO + "graded.geo", None),
    "cavity": Recipe(3, tetgen, cavity, 0.003, ((0, 0, 0), 3, 0.61, 0.99)),
    "star": Recipe(3, tetgen, star, 0.0008),
    "bracket100k": Recipe(3, gmsh, "docs/examples/bracket.geo", 1.33),
    "plate": Recipe(2, gmsh, "bench/plate.geo", 0.2, ((4, 6.4), 2, 1.81, 3.5)),
    "ring": Recipe(2, gmsh, GEO + "ring.geo", None, ((0, 0), 2, 0.401, 0.99)),
    "corner": Recipe(2, gmsh, GEO + "corner.geo", None),
    "square": Recipe(2, gmsh, GEO + "square.geo", None),
    "strip": Recipe(2, gmsh, GEO + "strip.geo", None),
    "plate100k": Recipe(2, gmsh, "bench/plate.geo", 0.055),
}


def path_of(name):
    """Another one whenever the recipe is."""
    _, make_it, argument, size, _ = RECIPES[name]
    if make_it is gmsh:
        with open(os.path.join(ROOT, argument), encoding="utf-8") as file:
            argument = file.read()
    else:
        argument = repr(argument())
    return f"{FOLDER}/{name}-{zlib.crc32(f'{argument} {size}'.encode()):08x}.npz"


def make(name, path):
    os.makedirs(FOLDER, exist_ok=True)
    recipe = RECIPES[name]
    points, elements = simplex.without_unused(*recipe.make(name, recipe))
    elements = simplex.oriented(points, elements)
    if not simplex.is_valid(points, elements):
        raise SystemExit(f"bases: {name} has flat elements")
    np.savez(path, points=points, elements=elements)


def load(name):
    """The base of that name."""
    path = path_of(name)
    if not os.path.exists(path):
        make(name, path)
    with np.load(path) as file:
        points, elements = file["points"], file["elements"]
    fixed = simplex.on_boundary(len(points), elements)
    return Base(points, elements, fixed, simplex.edges(elements), RECIPES[name].hole)
