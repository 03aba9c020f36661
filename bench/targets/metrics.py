"""metrics: wanted are elements ten times as long along a wavy line (surface) as across it, and regular ones away
from it. Judge the elements with lengths by this metric, by its formula and numpy."""
import numpy as np

import cells
import planish
import ratios
import sizes

WEIGHTS = 0, 0.5, 0.9
THINNEST, SLOPE, WAVE = 0.1, 3, 0.15  # of the domain, which is 1 wide
IDEAL = {"triangle": np.array([[0, 1, 0.5], [0, 0, 3 ** 0.5 / 2]]).T, "quad": np.array([[0, 0], [1, 0], [0, 1]]),
         "tet": np.array([[0, 0, 0], [1, 0, 0], [0.5, 3 ** 0.5 / 2, 0], [0.5, 3 ** 0.5 / 6, (2 / 3) ** 0.5]]),
         "hex": np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])}


def lengths(points):
    """The wanted lengths as matrices [n][dim][dim]: M^(-1/2)."""
    x, y = points[:, 0], points[:, 1]
    slope = 2 * np.pi * WAVE * np.cos(2 * np.pi * x)
    long = np.hypot(1, slope)
    off = (y - 0.5 - WAVE * np.sin(2 * np.pi * x)) / long
    across = np.zeros_like(points)
    across[:, 0], across[:, 1] = -slope / long, 1 / long
    thickness = np.minimum(1, THINNEST + SLOPE * np.abs(off))
    return np.eye(points.shape[1]) + (thickness - 1)[:, None, None] * across[:, :, None] * across[:, None, :]


def metrics(points):
    inverse = np.linalg.inv(lengths(points))
    return inverse @ inverse


def ratio(points, elements):
    """RMS of AR where lengths are measured by the metric."""
    (name, nodes), = elements.blocks
    wanted, found = lengths(points), []
    ideal = ratios.matrices(IDEAL[name], np.arange(points.shape[1] + 1)[None])
    for corner in ratios.CORNERS[name]:
        of = nodes[:, list(corner)]
        t = np.linalg.inv(wanted[of].mean(axis=1)) @ ratios.matrices(points, of) @ np.linalg.inv(ideal)
        square, determinant = (t * t).sum(axis=(1, 2)), np.linalg.det(t)
        found.append((square / (points.shape[1] * determinant ** (2 / points.shape[1]))) ** 2)
    return float(np.sqrt(np.mean(found)))


def spread(points, elements):
    """RMS of log(size / wanted), but for its mean; sizes by measures in the metric."""
    (name, nodes), = elements.blocks
    wanted = np.linalg.det(lengths(points)[nodes].mean(axis=1))
    measures = sizes.measures(points, name, nodes) / sizes.UNIT[name] / wanted
    return float(np.log(measures).std() / elements.dim)


def row(kind, weight):
    points, elements = sizes.MESHES[kind]()
    (name, nodes), = elements.blocks
    before = ratio(points, elements), spread(points, elements)
    result = planish.smooth(points, {sizes.NAMES[name]: nodes}, size=metrics(points), size_weight=weight, slide="auto",
                            layers="ignore", threads=1, max_sweeps=1000)
    return {"kind": kind, "elements": len(elements), "weight": weight, "before": before,
            "after": (ratio(points, elements), spread(points, elements)), "sweeps": result.sweeps,
            "seconds": result.seconds, "inverted": int(cells.n_inverted(points, elements))}


def measure():
    rows = [row(kind, weight) for kind in sizes.MESHES for weight in WEIGHTS]
    print(*rows, sep="\n", flush=True)
    return rows
