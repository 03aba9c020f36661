"""speed: processor time of a visit with targets and without, on the same mesh, by the same number of sweeps."""
import time

import numpy as np

import bases
import cells
import planish
import simplex
from period import VTK_NAMES

TURNS = 15
SWEEPS = 6
SHIFT = 0.1  # of the local edge length, by which inner nodes are pushed
LAYERS = 30  # of hexahedra, along each side


def tetrahedra():
    mesh = bases.load("bracket100k")
    return mesh.points, mesh.elements, mesh.fixed, mesh.edges


def hexahedra():
    points, nodes = bases.grid(*[LAYERS] * 3)
    elements = cells.Cells(("hex", nodes))
    return points, elements, cells.on_boundary(len(points), elements), cells.edges(elements)


def pushed(points, fixed, pairs):
    """The points, those inside pushed about."""
    lengths = simplex.local_lengths(points, pairs)
    push = np.random.RandomState(1).uniform(-SHIFT, SHIFT, points.shape) * lengths[:, None]
    return np.where(fixed[:, None], points, points + push)


def seconds_per_visit(plan, points):
    points, begin = points.copy(), time.process_time()
    result = plan.smooth(points, objective="mean-ratio", max_sweeps=SWEEPS, tolerance=0, untangle=False)
    return (time.process_time() - begin) / result.visits, result.visits


def compare(kind, make):
    original, elements, fixed, pairs = make()
    points = pushed(original, fixed, pairs)
    by_type = {VTK_NAMES[name]: nodes for name, nodes in cells.blocks_of(elements)}
    least, visits = {"plain": np.inf, "targets": np.inf}, {}
    with planish.Plan(points, by_type, threads=1, layers="ignore") as plain, \
            planish.Plan(points, by_type, threads=1, like=original) as targets:
        for _ in range(TURNS):
            for way, plan in (("plain", plain), ("targets", targets)):
                seconds, visits[way] = seconds_per_visit(plan, points)
                least[way] = min(least[way], seconds)
    return {"elements": len(elements), "kind": kind, "sweeps": SWEEPS, "visits": visits, "seconds_per_visit": least,
            "ratio": least["targets"] / least["plain"]}


def measure():
    rows = [compare("tetrahedra", tetrahedra), compare("hexahedra", hexahedra)]
    print(*rows, sep="\n", flush=True)
    return rows
