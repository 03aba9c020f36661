"""cases: the catalogue. A case is all in its name, BASE_MAP_SPOILER:

    box_asis_move-5-10        the box, 10 % of its inner nodes moved by 5 edge lengths
    bar_bend-80_left          the bar bent to 80 % of what it stands, its inner nodes left behind
    box_flaw-ear_asis         the box with planted elements that nothing can repair (flaws.py)
    hexes_pinch-95_left       a grid of hexahedra: bases.GRIDS are of other elements than simplices

The random numbers are seeded by the name."""
import zlib
from collections import namedtuple
from functools import lru_cache

import numpy as np

import bases
import cells
import deform
import flaws
import simplex
from spoil import RAISABLE, SPOILERS, Mesh

PERCENT = (1, 10, 50, 100)
AS_IS = ([f"move-{lengths}-{percent}" for lengths in (0.5, 1, 2, 5, 20) for percent in PERCENT]
         + ["pairs-1", "pairs-10", "pairs-50", "patches-10", "patches-30", "patches-50", "centre"]
         + [f"swap{how}-{percent}" for how in ("near", "far") for percent in (1, 10, 50)]
         + ["throw-1-1", "throw-10-1", "throw-3-10", "throw-10-100"]
         + ["mixed-1", "mixed-10", "mixed-50"])
AS_IS_BIG = ["move-1-1", "move-0.5-100", "move-2-10", "move-20-50", "pairs-10", "patches-50",
             "centre", "swapnear-10", "swapfar-50", "throw-3-10", "mixed-10"]
AS_IS_GRID = ["move-0.5-100", "move-1-10", "move-2-50", "move-5-100", "pairs-10", "pairs-50",
              "patches-30", "centre", "swapnear-10", "swapfar-10", "throw-3-10", "mixed-10"]
SHARES = (50, 80, 95)  # percent of the largest strength
DEFORMED = ["left", "move-2-50", "patches-30"]
HARDEST = "99_left"
DEFORMED_GRID = [*[f"{share}_{spoiler}" for spoiler in DEFORMED[:2] for share in SHARES],
                 "80_patches-30", HARDEST]
DEFORMED_BIG = [f"{name}-80_left" for name in ("bend", "twist", "wave", "shear")]
FLAWED = ["asis", "move-1-10"]  # what else happens to a mesh with flaws
RAISES = 8

# points: tangled; valid: the known solution; fixed [n] of bool or None: held besides the boundary;
# flaws: lists of elements that cannot be repaired, none in a feasible case.
Case = namedtuple("Case", "name family points valid elements held fixed flaws")

load = lru_cache(maxsize=4)(bases.load)


class NoCase(Exception):
    """Nothing is inverted however much it is spoilt, or there is no valid mesh."""


def is_big(base):
    return base.endswith("100k")


def catalogue():
    """All names; those of grids first."""
    found = []
    for base, recipe in bases.GRIDS.items():
        found += [f"{base}_asis_{spoiler}" for spoiler in AS_IS_GRID]
        found += [f"{base}_{name}-{deformed}" for name in deform.names(recipe)
                  for deformed in DEFORMED_GRID]
    for base, recipe in bases.RECIPES.items():
        if base in bases.GRIDS:
            continue
        if is_big(base):
            found += [f"{base}_asis_{spoiler}" for spoiler in AS_IS_BIG]
            found += [f"{base}_{deformed}" for deformed in DEFORMED_BIG]
            continue
        found += [f"{base}_asis_{spoiler}" for spoiler in AS_IS]
        for name in deform.names(recipe):
            found += [f"{base}_{name}-{share}_{spoiler}"
                      for share in SHARES for spoiler in DEFORMED]
            found.append(f"{base}_{name}-{HARDEST}")
    return found + [f"{name}_{spoiler}" for name in flaws.names() for spoiler in FLAWED]


def family_of(name):
    """What the table sums up: dimension, and the spoiler, the map or the kind of flaw; of a grid its
    elements, and whether it is deformed."""
    base, shape, spoiler = name.split("_")
    kind = shape.split("-")
    if shape == "narrow":
        what = "narrow"
    elif shape == "asis":
        what = spoiler.split("-")[0]
    elif kind[0] == "flaw":
        what = f"unfixable: {kind[1]}"
    else:
        what = f"deformed: {kind[0]}"
    if base in bases.GRIDS:
        return f"{bases.GRIDS[base].argument} {'spoilt' if shape == 'asis' else 'deformed'}"
    return f"{bases.RECIPES[base].dim}-D {what}"


@lru_cache(maxsize=4)
def valid_points(base, shape):
    """Of the known solution."""
    mesh = load(base)
    if shape == "asis":
        return mesh.points
    name, share = shape.split("-")
    return deform.deformed(mesh, name, int(share) / 100)


def spoilt(random, spoiler, valid, free, elements, original=None):
    """The points after the spoiler; its first amount doubled until something is inverted."""
    pairs = cells.edges(elements)
    kind, *amounts = spoiler.split("-")
    amounts = [float(amount) for amount in amounts]
    for _ in range(RAISES if kind in RAISABLE else 1):
        if kind == "left":
            points = np.where(free[:, None], original, valid)
        else:
            mesh = Mesh(valid, free, pairs, simplex.local_lengths(valid, pairs))
            SPOILERS[kind](random, mesh, *amounts)
            points = mesh.points
        if cells.n_inverted(points, elements):
            return points
        amounts = [2 * amount if i == 0 else amount for i, amount in enumerate(amounts)]
    raise NoCase(f"{spoiler} inverts nothing")


def build(name):
    """The case of that name."""
    base, shape, spoiler = name.split("_")
    random = np.random.RandomState(zlib.crc32(name.encode("ascii")))
    mesh = load(base)
    if shape == "narrow" or shape.startswith("flaw-"):
        return flawed(name, random, mesh, shape.split("-")[-1], spoiler)
    valid = valid_points(base, shape)
    if not cells.is_valid(valid, mesh.elements):
        raise NoCase("the solution is not valid")
    points = spoilt(random, spoiler, valid, ~mesh.fixed, mesh.elements, mesh.points)
    return Case(name, family_of(name), points, valid, mesh.elements, mesh.fixed, None, [])


def flawed(name, random, mesh, kind, spoiler):
    planted = flaws.plant(random, mesh, kind)
    if planted is None:
        raise NoCase(f"no place for {kind}")
    points, held = planted.points, planted.held()
    if spoiler != "asis":
        points = spoilt(random, spoiler, points, ~held, planted.elements)
    elif not cells.n_inverted(points, planted.elements):
        raise NoCase("nothing is inverted")
    return Case(name, family_of(name), points, planted.solved, planted.elements, held,
                planted.fixed if planted.fixed.any() else None, planted.flaws)
