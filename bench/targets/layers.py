"""layers: twelve layers of prisms that grow from a wall, which is moved or bent while the inside stays
behind. Compare the heights of layers after smoothing with those before."""
import numpy as np

import bases
import cells
import ratios

LAYERS, OUTSIDE = 12, 8  # layers that grow; layers of one height beyond
GROWTHS = 1.2, 1.5
MOVES = 3, 10            # of the wall, in first heights


def heights(growth, size):
    """Heights [LAYERS + OUTSIDE + 1] over the wall, up to elements as high as size."""
    steps = size / growth ** np.arange(LAYERS, 0, -1)
    return np.concatenate([[0], np.cumsum(np.append(steps, np.full(OUTSIDE, size)))])


def stacked(wall, triangles, direction, levels):
    """Points and wedges over the wall, in its directions."""
    n = len(wall)
    points = np.concatenate([wall + level * direction for level in levels])
    wedges = [np.hstack([triangles + k * n, triangles + (k + 1) * n]) for k in range(len(levels) - 1)]
    return points, cells.Cells(("wedge", np.concatenate(wedges)))


def ball(growth):
    """Around a ball of radius 1."""
    wall, triangles = icosphere(3)
    size = np.linalg.norm(wall[triangles[:, 0]] - wall[triangles[:, 1]], axis=1).mean()
    return wall, *stacked(wall, triangles, wall, heights(growth, size))


def plate(growth):
    """Over a square of side 1 with irregular triangles."""
    points, elements = bases.triangles("targets", 24, 24)
    wall = np.column_stack([points / 24, np.zeros(len(points))])
    return wall, *stacked(wall, elements.blocks[0][1], np.array([0, 0, 1.]), heights(growth, 1 / 24))


def icosphere(times):
    """Nodes on the unit sphere, and outward triangles: an icosahedron, each triangle cut in four so many times."""
    golden = (1 + 5 ** 0.5) / 2
    points = np.array([(x, y * golden, 0) for x in (-1, 1) for y in (-1, 1)])
    points = np.concatenate([points, np.roll(points, 1, axis=1), np.roll(points, 2, axis=1)])
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    near = np.isclose(apart, 2)
    triangles = np.array([(i, j, k) for i in range(12) for j in range(i) for k in range(j)
                          if near[i, j] and near[j, k] and near[k, i]])
    for _ in range(times):
        corners = points[triangles]
        mids = (corners + corners[:, [1, 2, 0]]) / 2
        parts = [np.stack([corners[:, j], mids[:, j], mids[:, j - 1]], axis=1) for j in range(3)]
        x = np.concatenate([*parts, mids]).reshape(-1, 3)
        _, first, number = np.unique(np.round(x, 9), axis=0, return_index=True, return_inverse=True)
        points, triangles = x[first], number.reshape(-1, 3)
        points /= np.linalg.norm(points, axis=1)[:, None]
    points /= np.linalg.norm(points, axis=1)[:, None]
    is_inward = np.linalg.det(points[triangles]) < 0
    triangles[is_inward, :2] = triangles[is_inward, 1::-1]
    return points, triangles


def moved(wall):
    return np.broadcast_to([1., 0, 0], wall.shape)


def squeezed(wall):
    """A ball becomes flatter along z, and wider."""
    return wall * [0.5, 0.5, -1]


def bent(wall):
    """A plate bulges; its sides stay."""
    bulge = (np.sin(np.pi * wall[:, :2]) ** 2).prod(axis=1)
    return np.column_stack([np.zeros((len(wall), 2)), bulge])


CASES = (("ball", ball, "moved", moved), ("ball", ball, "squeezed", squeezed), ("plate", plate, "bent", bent))
WAYS = {"like": [], "plain": ["--layers", "ignore"]}


def change(points, original, n):
    """Largest relative change of the first heights, and of all heights, of layers of n nodes."""
    def of(x):
        x = x[:(LAYERS + 1) * n].reshape(LAYERS + 1, n, 3)
        return np.linalg.norm(np.diff(x, axis=0), axis=2)
    relative = abs(of(points) / of(original) - 1)
    return {"first": float(relative[0].max()), "all": float(relative.max())}


def measure(program):
    rows = []
    for body, make, motion, displacement in CASES:
        for growth in GROWTHS:
            wall, original, elements = make(growth)
            n = len(wall)
            first = np.linalg.norm(original[n] - original[0])
            for move in MOVES:
                points = original.copy()
                points[:n] += move * first * displacement(wall)
                for way, options in WAYS.items():
                    smoothed, report = program.smooth(points, elements, original if way == "like" else None, options)
                    rows.append({"body": body, "motion": motion, "growth": growth, "first_heights": move, "way": way,
                                 "elements": len(elements), "inverted": cells.n_inverted(smoothed, elements),
                                 "rms": ratios.rms(smoothed, original, elements),
                                 "sweeps": len(report["sweeps"]), "seconds": report["seconds"]["smooth"],
                                 **change(smoothed, original, n)})
                    print(rows[-1], flush=True)
    return rows
