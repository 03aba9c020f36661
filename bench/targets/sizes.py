"""sizes: wanted are elements ten times as small at a circle (a cylinder) as away from it. Measure the error of their
sizes, up to the best factor, by the formula of the field and numpy."""
import numpy as np

import bases
import cells
import planish
import ratios
from period import VTK_NAMES

WEIGHTS = 0.5, 0.9
SMALLEST, SLOPE, RADIUS = 0.1, 1.5, 0.25  # of the domain, which is 1 wide
MEASURES = {"triangle": 0.5, "quad": 1, "tet": 1 / 6, "hex": 1}  # by the determinant of a corner
UNIT = {"triangle": 3 ** 0.5 / 4, "quad": 1, "tet": 2 ** 0.5 / 12, "hex": 1}  # measure with edges of 1
CORNERS_OF_HEX = (0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 4, 5), (3, 4, 6, 7), (1, 3, 4, 6)
NAMES = {**VTK_NAMES, "quad": "quad"}


def wanted(points):
    """Sizes at points [n][dim]."""
    return np.minimum(1, SMALLEST + SLOPE * np.abs(np.linalg.norm(points[:, :2] - 0.5, axis=1) - RADIUS))


def grid(name, n, dim):
    points, nodes = bases.grid(*[n] * dim)
    return points / n, cells.Cells((name, nodes))


def simplices(name, n, dim):
    """A grid cut into simplices."""
    points, nodes = bases.grid(*[n] * dim)
    cuts = ((0, 1, 2), (0, 2, 3)) if dim == 2 else [(0, a, b, 6) for a, b in
                                                    ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))]
    return points / n, cells.Cells((name, np.concatenate([nodes[:, list(cut)] for cut in cuts])))


MESHES = {
    "triangles": lambda: simplices("triangle", 100, 2),
    "quadrilaterals": lambda: grid("quad", 100, 2),
    "tetrahedra": lambda: simplices("tet", 24, 3),
    "hexahedra": lambda: grid("hex", 24, 3),
}


def measures(points, name, nodes):
    """Areas or volumes [m]."""
    if name in ("triangle", "tet"):
        return np.linalg.det(ratios.matrices(points, nodes)) * MEASURES[name]
    parts = CORNERS_OF_HEX if name == "hex" else ((0, 1, 2), (0, 2, 3))
    simplex = MEASURES["tet" if name == "hex" else "triangle"]
    return sum(np.linalg.det(ratios.matrices(points, nodes[:, list(part)])) for part in parts) * simplex


def spread(points, elements, field=wanted):
    """RMS of log(size / wanted), but for its mean. field: the sizes at points."""
    (name, nodes), = elements.blocks
    sizes = (measures(points, name, nodes) / UNIT[name]) ** (1 / elements.dim)
    logs = np.log(sizes / field(points)[nodes].mean(axis=1))
    return float(logs.std())


def smooth(points, elements, weight):
    """Smooth points in place; returns planish's result."""
    (name, nodes), = elements.blocks
    return planish.smooth(points, {NAMES[name]: nodes}, size=wanted(points), size_weight=weight, slide="auto",
                          layers="ignore", threads=1, max_sweeps=1000)


def row(kind, weight):
    points, elements = MESHES[kind]()
    before = spread(points, elements)
    result = smooth(points, elements, weight)
    quality = planish.quality(points, {NAMES[name]: nodes for name, nodes in elements.blocks}, per_element=True)
    return {"kind": kind, "elements": len(elements), "weight": weight, "before": before,
            "after": spread(points, elements), "rms": quality.cells.all.rms_aspect_ratio,
            "worst": quality.cells.all.max_aspect_ratio, "sweeps": result.sweeps, "seconds": result.seconds,
            "inverted": int(cells.n_inverted(points, elements))}


def measure():
    rows = [row(kind, weight) for kind in MESHES for weight in WEIGHTS]
    print(*rows, sep="\n", flush=True)
    return rows
