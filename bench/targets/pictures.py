"""pictures: an aerofoil that is turned, a tank with a wave, sizes at a crack and a metric, for docs/targets.md.   pictures.py FOLDER"""
import sys

import numpy as np

import bases
import cells
import metrics
import planish
from svg import Panel, write

AROUND, OUTWARDS, GROWTH, FIRST = 80, 18, 1.24, 0.012  # of the aerofoil's mesh
TURN = np.radians(14)
LONG, DEEP, LENGTH = 64, 14, 4.  # of the tank, whose depth is 1
CREST, STEPS = 0.3, 40
SQUARES, TIP = 40, (0.55, 0.5)  # of a plate, 1 wide, with a crack from its left side


def smoothed(points, quads, like):
    """Both smoothers hold no layers."""
    points = points.copy()
    planish.smooth(points, {"quad": quads}, layers="ignore", like=like, threads=1)
    return points


def inverted(points, quads):
    return cells.inverted(points, cells.Cells(("quad", quads)))


def panel(title, points, quads, body=()):
    return Panel(title, points, quads, inverted(points, quads), body)


def aerofoil_mesh():
    """Joukowski's, with a round trailing edge: rings of quadrilaterals around it, the body's first."""
    _, quads = bases.grid(AROUND, OUTWARDS)
    number = np.arange((AROUND + 1) * (OUTWARDS + 1)).reshape(AROUND + 1, OUTWARDS + 1)
    number[-1] = number[0]
    radius = 1 + np.append(0, np.cumsum(FIRST * GROWTH ** np.arange(OUTWARDS)))
    angle = -2 * np.pi * np.arange(AROUND + 1) / AROUND
    centre = -0.12 + 0.06j
    circle = centre + abs(1 - centre) * 1.03 * radius * np.exp(1j * angle)[:, None]
    places = (circle + 1 / circle).ravel()[:AROUND * (OUTWARDS + 1)]
    return np.stack([places.real, places.imag], axis=1), number.ravel()[quads]


def aerofoil(path):
    points, quads = aerofoil_mesh()
    body = np.arange(AROUND) * (OUTWARDS + 1)
    turned = points.copy()
    cosine, sine = np.cos(TURN), np.sin(TURN)
    turned[body] = points[body] @ np.array([[cosine, -sine], [sine, cosine]])
    titles = ("undeformed", "the body turned: inverted elements are red", "smoothed plainly",
              "smoothed --like undeformed")
    results = points, turned, smoothed(turned, quads, None), smoothed(turned, quads, points)
    write(path, [panel(title, x, quads, body) for title, x in zip(titles, results)],
          (-2.5, -1.35), (2.5, 1.35), 420)


def tank_mesh():
    """Elements become flatter towards the surface, and narrower towards the walls."""
    points, quads = bases.grid(LONG, DEEP)
    depth = np.cumsum(1.2 ** np.arange(DEEP))
    x = 0.5 - 0.5 * np.cos(np.pi * points[:, 0] / LONG)
    y = 1 - np.append(0, depth)[DEEP - points[:, 1].astype(int)] / depth[-1]
    return np.stack([LENGTH * (0.4 * x + 0.6 * points[:, 0] / LONG), y], axis=1), quads


def wave(still, points, boundary, step):
    """Place the surface and the walls: a standing wave."""
    height = CREST * np.sin(2 * np.pi * step / STEPS) * np.cos(2 * np.pi * still[boundary, 0] / LENGTH)
    points[boundary] = still[boundary]
    points[boundary, 1] *= 1 + height


def at_crest_and_rest(still, quads, like):
    """The points after a quarter and after a whole of a period."""
    boundary = np.flatnonzero(cells.on_boundary(len(still), cells.Cells(("quad", quads))))
    points, found = still.copy(), {}
    for step in range(1, STEPS + 1):
        wave(still, points, boundary, step)
        points = smoothed(points, quads, like)
        found[step] = points
    return found[STEPS // 4], found[STEPS]


def tank(path):
    still, quads = tank_mesh()
    plain, _ = at_crest_and_rest(still, quads, None)
    crest, rest = at_crest_and_rest(still, quads, still)
    panels = (("at rest", still), ("a wave, smoothed plainly", plain), ("a wave, smoothed --like at rest", crest),
              ("a period later, smoothed --like at rest", rest))
    write(path, [panel(title, points, quads) for title, points in panels],
          (-0.02, -0.02), (LENGTH + 0.02, 1.34), 420)


def from_crack(points):
    """The distance of points from the crack."""
    x = np.clip(points[:, 0], 0, TIP[0])
    return np.hypot(points[:, 0] - x, points[:, 1] - TIP[1])


def crack(path):
    points, quads = bases.grid(SQUARES, SQUARES)
    start, results = points / SQUARES, []
    for weight in 0.5, 0.9:
        points = start.copy()
        planish.smooth(points, {"quad": quads}, size=0.1 + 1.5 * from_crack(start), size_weight=weight, slide="auto",
                       layers="ignore", threads=1)
        results.append(points)
    titles = "small sizes are wanted at a crack", "--size-weight 0.5", "--size-weight 0.9"
    write(path, [panel(title, x, quads) for title, x in zip(titles, (start, *results))],
          (-0.01, -0.01), (1.01, 1.01), 300, columns=3)


def shear(path):
    points, quads = bases.grid(SQUARES, SQUARES)
    start, results = points / SQUARES, []
    for weight in 0, 0.5:
        points = start.copy()
        planish.smooth(points, {"quad": quads}, size=metrics.metrics(start), size_weight=weight, slide="auto",
                       layers="ignore", threads=1)
        results.append(points)
    titles = "thin elements are wanted at a wave", "--size-weight 0", "--size-weight 0.5"
    write(path, [panel(title, x, quads) for title, x in zip(titles, (start, *results))],
          (-0.01, -0.01), (1.01, 1.01), 300, columns=3)


def main():
    folder = sys.argv[1]
    aerofoil(f"{folder}/targets_aerofoil.svg")
    tank(f"{folder}/targets_tank.svg")
    crack(f"{folder}/targets_crack.svg")
    shear(f"{folder}/targets_metric.svg")


if __name__ == "__main__":
    main()
