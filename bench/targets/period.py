"""period: a hole swings in a mesh, and each step is smoothed towards the mesh at the start. Measure the distance
of nodes from their start after one period, and after ten."""
import numpy as np

import bases
import cells
import planish
import ratios

MESHES = {"ring": "triangles", "shell": "tetrahedra", "hextube": "hexahedra"}  # 2 wide
STEPS, PERIODS = 100, 10
SWING = 0.2                          # a tenth of the width
TOLERANCES = 1e-5, 1e-12             # the default, and a strict one
VTK_NAMES = {"triangle": "triangle", "tet": "tetra", "hex": "hexahedron"}


def share_of_swing(base):
    """1 at the hole, 0 outside [n]."""
    centre, axes, inner, outer = base.hole
    distance = np.linalg.norm((base.points - centre)[:, :axes], axis=1)
    return np.clip((outer - distance) / (outer - inner), 0, 1)


def mean_edge(base):
    pairs = base.edges
    return np.linalg.norm(base.points[pairs[:, 0]] - base.points[pairs[:, 1]], axis=1).mean()


class Swing:
    """The mesh of a base, and the places of its boundary."""

    def __init__(self, name):
        self.base = bases.load(name)
        self.by_type = {VTK_NAMES[kind]: nodes for kind, nodes in cells.blocks_of(self.base.elements)}
        self.boundary = np.flatnonzero(self.base.fixed)
        self.reach = share_of_swing(self.base)[self.boundary]

    def put_boundary(self, points, step):
        """Place the boundary; the hole swings along the first axis."""
        points[self.boundary] = self.base.points[self.boundary]
        points[self.boundary, 0] += SWING * np.sin(2 * np.pi * step / STEPS) * self.reach

    def distance(self, points):
        """The farthest node from its start, in mean edges."""
        return float(np.linalg.norm(points - self.base.points, axis=1).max() / mean_edge(self.base))


def swing(name, tolerance, periods):
    mesh = Swing(name)
    points, sweeps, seconds, inverted, distances = mesh.base.points.copy(), 0, 0, 0, []
    with planish.Plan(points, mesh.by_type, like=mesh.base.points.copy(), threads=1) as plan:
        for step in range(1, periods * STEPS + 1):
            mesh.put_boundary(points, step)
            result = plan.smooth(points, tolerance=tolerance, max_sweeps=2000)
            sweeps, seconds = sweeps + result.sweeps, seconds + result.seconds
            inverted = max(inverted, int(cells.n_inverted(points, mesh.base.elements)))
            if step % STEPS == 0:
                distances.append(mesh.distance(points))
    return {"mesh": name, "kind": MESHES[name], "nodes": len(points), "elements": len(mesh.base.elements),
            "tolerance": tolerance, "steps": periods * STEPS, "seconds": seconds, "sweeps_a_step": sweeps / (periods * STEPS),
            "inverted": inverted, "distances": distances,
            "rms": ratios.rms(points, mesh.base.points, mesh.base.elements)}


def measure():
    rows = []
    for name in MESHES:
        for tolerance in TOLERANCES:
            rows.append(swing(name, tolerance, PERIODS))
            print(rows[-1], flush=True)
    return rows
