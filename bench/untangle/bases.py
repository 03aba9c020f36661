"""bases: the valid, irregular meshes that are spoilt. Simplices are made by Gmsh and TetGen once, then
kept as .npz in build-bench/meshes/untangle, or where PLANISH_BENCH_MESHES says. Meshes of other
elements are grids that are cut up here."""
import os
import subprocess
import zlib
from collections import namedtuple

import numpy as np

import cells
import medit
import simplex

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
FOLDER = os.environ.get("PLANISH_BENCH_MESHES", os.path.join(ROOT, "build-bench/meshes/untangle"))

# dimension; maker, its argument (of grids: what their elements are) and element size; the hole that can be turned: its centre, the
# number of coordinates that its distance counts in (2: about z), its radius and that where turning
# ends.
Recipe = namedtuple("Recipe", "dim make argument size hole", defaults=(None,))
# fixed [n]: on the boundary; lengths [n]: of the edges at a node.
Base = namedtuple("Base", "points elements fixed edges hole")


def gmsh(name, recipe):
    path = f"{FOLDER}/{name}.mesh"
    size = [] if recipe.size is None else ["-setnumber", "h", str(recipe.size)]
    subprocess.run(["gmsh", f"-{recipe.dim}", "-nt", "1", "-v", "1", *size, "-setstring", "shape", name,
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


# ---- grids ---------------------------------------------------------------------------------------

PUSH = 0.15  # of a grid's spacing, at most, by which inner nodes are not where it has them


def grid(*counts):
    """Points of a grid of so many bricks of size 1, and the bricks, x fastest."""
    sides = [np.arange(n + 1.) for n in counts]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, len(counts))
    number = np.arange(len(points)).reshape([n + 1 for n in counts])
    low, high = slice(None, -1), slice(1, None)
    around = [(low, low), (high, low), (high, high), (low, high)]
    if len(counts) == 3:
        around = [(*xy, z) for z in (low, high) for xy in around]
    return points, np.stack([number[corner].ravel() for corner in around], axis=1)


def pushed(name, points, elements):
    """With inner nodes pushed about: irregular."""
    random = np.random.RandomState(zlib.crc32(name.encode("ascii")))
    inside = ~cells.on_boundary(len(points), elements)
    push = random.uniform(-PUSH, PUSH, points.shape)
    return np.where(inside[:, None], points + push, points), elements


def joined(points, elements):
    """With points at one place made one."""
    _, first, number = np.unique(np.round(points, 6), axis=0, return_index=True,
                                 return_inverse=True)
    number = number.ravel()
    return points[first], cells.Cells(*[(name, number[nodes]) for name, nodes in elements.blocks])


def in_two(quads):
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def triangles(name, *counts):
    """Of a grid whose quads are cut at random: three to eight at a node."""
    random = np.random.RandomState(zlib.crc32(name.encode("ascii")))
    points, quads = grid(*counts)
    turned = np.where(random.uniform(size=len(quads)) < 0.5, 1, 0)[:, None]
    quads = np.take_along_axis(quads, (np.arange(4) + turned) % 4, axis=1)
    return pushed(name, points, cells.Cells(("triangle", in_two(quads))))


def in_quads(points, nodes):
    """Triangles, each as three quads around its middle."""
    x = points[nodes]
    mids, middle = (x + x[:, [1, 2, 0]]) / 2, x.mean(axis=1)
    found = [np.stack([x[:, j], mids[:, j], middle, mids[:, j - 1]], axis=1) for j in range(3)]
    return joined_from(np.concatenate(found), "quad")


def joined_from(x, name):
    """Elements by their points [m][corners][dim]."""
    return joined(x.reshape(-1, x.shape[2]),
                  cells.Cells((name, np.arange(x[:, :, 0].size).reshape(x.shape[:2]))))


def extruded(points, elements, layers, height):
    """A plane mesh as layers of hexes and wedges."""
    n = len(points)
    heights = height * np.arange(layers + 1.)
    places = np.concatenate([np.column_stack([points, np.full(n, z)]) for z in heights])
    solid = {"quad": "hex", "triangle": "wedge"}
    return places, cells.Cells(*[
        (solid[name], np.concatenate([np.hstack([nodes + k * n, nodes + (k + 1) * n])
                                      for k in range(layers)])) for name, nodes in elements.blocks])


def curled(points, elements, about):
    """A grid around a hole: the first axis goes around, the second outwards from 0.4 to 1."""
    angle, part = 2 * np.pi * points[:, 0] / about, points[:, 1] / points[:, 1].max()
    radius = 0.4 * 2.5 ** part
    points = np.column_stack([radius * np.sin(angle), radius * np.cos(angle), *points[:, 2:].T])
    return joined(points, elements)


def quads(name):
    points, nodes = grid(40, 24)
    return pushed(name, points, cells.Cells(("quad", nodes)))


def quad_ring(_):
    points, nodes = grid(60, 14)
    return curled(points, cells.Cells(("quad", nodes)), 60)


def triquads(name):
    points, elements = triangles(name, 20, 12)
    return in_quads(points, elements.blocks[0][1])


def quads_and_triangles(name):
    points, nodes = grid(36, 24)
    is_cut = np.random.RandomState(1).uniform(size=len(nodes)) < 0.4
    return pushed(name, points, cells.Cells(("quad", nodes[~is_cut]),
                                            ("triangle", in_two(nodes[is_cut]))))


def hexes(name):
    points, nodes = grid(18, 10, 9)
    return pushed(name, points, cells.Cells(("hex", nodes)))


def hex_tube(_):
    points, nodes = grid(32, 7, 8)
    points[:, 2] /= 8
    return curled(points, cells.Cells(("hex", nodes)), 32)


def hex_prisms(name):
    """Quads of triangles, extruded."""
    points, elements = triangles(name, 12, 7)
    return extruded(*in_quads(points, elements.blocks[0][1]), 5, 1)


# Tetrahedra of a brick around the diagonal from corner 0 to corner 6.
KUHN = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def hex_quarters(name):
    """Tetrahedra, each as four hexes around its middle."""
    points, nodes = grid(6, 4, 4)
    points, elements = pushed(name, points, cells.Cells(("hex", nodes)))
    x = points[elements.blocks[0][1][:, KUHN].reshape(-1, 4)]
    found = []
    for a, b, c, d in ((0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 2, 1, 0)):
        around = [(a,), (a, b), (a, b, c), (a, c), (a, d), (a, b, d), (a, b, c, d), (a, c, d)]
        found.append(np.stack([x[:, corners].mean(axis=1) for corners in around], axis=1))
    return joined_from(np.concatenate(found), "hex")


def wedges(name):
    return extruded(*triangles(name, 14, 8), 8, 1)


def wedge_tube(_):
    points, nodes = grid(30, 5)
    return extruded(*curled(points, cells.Cells(("triangle", in_two(nodes))), 30), 6, 0.2)


def with_middles(points, bricks):
    """Points with the middles of bricks after them, and their numbers."""
    return (np.vstack([points, points[bricks].mean(axis=1)]),
            len(points) + np.arange(len(bricks)))


def pyramids_of(bricks, middle):
    """Six of each brick around its middle: their base, and this apex."""
    found = [np.column_stack([bricks[:, face[::-1]], middle])
             for face in cells.KINDS["hex"].faces]
    return np.concatenate(found)


def pyramids(name):
    points, bricks = grid(10, 6, 6)
    points, middle = with_middles(points, bricks)
    return pushed(name, points, cells.Cells(("pyramid", pyramids_of(bricks, middle))))


def of_all_types(name):
    """Hexes at one end, then half of it wedges, half of it pyramids on what is beside, and
    tetrahedra between these."""
    points, bricks = grid(15, 8, 8)
    low = points[bricks[:, 0]]
    is_hex, is_wedge = low[:, 0] < 7, (low[:, 0] >= 7) & (low[:, 1] < 4)
    split = bricks[~is_hex & ~is_wedge]
    points, middle = with_middles(points, split)
    found = pyramids_of(split, middle)
    at = points[found[:, :4]].mean(axis=1)
    is_base = (at[:, 0] == 7) | (at[:, 1] == 4)
    base = found[~is_base]
    # Both sides of a face cut it from its lowest number.
    turn = base[:, :4].argmin(axis=1)[:, None]
    base[:, :4] = np.take_along_axis(base[:, :4], (np.arange(4) + turn) % 4, axis=1)
    return pushed(name, points, cells.Cells(
        ("hex", bricks[is_hex]), ("pyramid", found[is_base]),
        ("wedge", bricks[is_wedge][:, [0, 1, 2, 4, 5, 6, 0, 2, 3, 4, 6, 7]].reshape(-1, 6)),
        ("tet", base[:, [0, 1, 2, 4, 0, 2, 3, 4]].reshape(-1, 4))))


SHAPES = "bench/untangle/shapes.geo"
RECIPES = {
    "box": Recipe(3, gmsh, "bench/fem/box.geo", 0.075),
    "bracket": Recipe(3, gmsh, "docs/examples/bracket.geo", 4),
    "hole": Recipe(3, gmsh, SHAPES, None, ((0, 0, 0), 2, 0.221, 0.49)),
    "angle": Recipe(3, gmsh, SHAPES, None),
    "shell": Recipe(3, gmsh, SHAPES, None, ((0, 0, 0), 3, 0.451, 0.98)),
    "bar": Recipe(3, gmsh, SHAPES, None),
    "graded": Recipe(3, gmsh, SHAPES, None),
    "cavity": Recipe(3, tetgen, cavity, 0.003, ((0, 0, 0), 3, 0.61, 0.99)),
    "star": Recipe(3, tetgen, star, 0.0008),
    "bracket100k": Recipe(3, gmsh, "docs/examples/bracket.geo", 1.33),
    "plate": Recipe(2, gmsh, "bench/plate.geo", 0.2, ((4, 6.4), 2, 1.81, 3.5)),
    "ring": Recipe(2, gmsh, SHAPES, None, ((0, 0), 2, 0.401, 0.99)),
    "corner": Recipe(2, gmsh, SHAPES, None),
    "square": Recipe(2, gmsh, SHAPES, None),
    "strip": Recipe(2, gmsh, SHAPES, None),
    "plate100k": Recipe(2, gmsh, "bench/plate.geo", 0.055),
}
GRIDS = {
    "quads": Recipe(2, quads, "quad", None),
    "quadring": Recipe(2, quad_ring, "quad", None, ((0, 0), 2, 0.401, 0.99)),
    "triquads": Recipe(2, triquads, "quad", None),
    "quadtri": Recipe(2, quads_and_triangles, "quad and triangle", None),
    "hexes": Recipe(3, hexes, "hex", None),
    "hextube": Recipe(3, hex_tube, "hex", None, ((0, 0, 0), 2, 0.401, 0.99)),
    "hexprisms": Recipe(3, hex_prisms, "hex", None),
    "hexquarters": Recipe(3, hex_quarters, "hex", None),
    "wedges": Recipe(3, wedges, "wedge", None),
    "wedgetube": Recipe(3, wedge_tube, "wedge", None, ((0, 0, 0), 2, 0.401, 0.99)),
    "pyramids": Recipe(3, pyramids, "pyramid", None),
    "alltypes": Recipe(3, of_all_types, "mixed", None),
}
RECIPES.update(GRIDS)


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
    if name in GRIDS:
        points, elements = GRIDS[name].make(name)
        if not cells.is_valid(points, elements):
            raise SystemExit(f"bases: {name} is not valid")
        return Base(points, elements, cells.on_boundary(len(points), elements),
                    cells.edges(elements), GRIDS[name].hole)
    path = path_of(name)
    if not os.path.exists(path):
        make(name, path)
    with np.load(path) as file:
        points, elements = file["points"], file["elements"]
    fixed = simplex.on_boundary(len(points), elements)
    return Base(points, elements, fixed, simplex.edges(elements), RECIPES[name].hole)
