"""plane: examples 1 and 2 of the paper, a square and a square with holes.

Well spaced nodes and their Delaunay triangulation: good meshes, which spoil.py then makes bad.
Needs numpy and scipy.
"""
import numpy as np
from scipy.spatial import Delaunay

from simplices import radius_ratios, volumes
from spoil import spoil

def polygon_nodes(corners, per_side):
    sides = zip(corners, np.roll(corners, -1, axis=0))
    return np.vstack([start + (end - start) * np.arange(per_side)[:, None] / per_side
                      for start, end in sides])


def octagon(centre, radius):
    angle = (np.arange(8) + 0.5) * np.pi / 4
    return centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])


SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
HOLES = [((0.27, 0.29), 0.12), ((0.72, 0.26), 0.11), ((0.29, 0.73), 0.11), ((0.71, 0.70), 0.13)]


def triangulate(points, holes):
    """Delaunay triangles, without those in a hole and those of collinear nodes."""
    triangles = Delaunay(points).simplices
    centres = points[triangles].mean(axis=1)
    keep = np.abs(volumes(points, triangles)) > 1e-9
    for centre, radius in holes:
        keep &= np.linalg.norm(centres - centre, axis=1) > 0.9 * radius
    triangles = triangles[keep]
    turned = volumes(points, triangles) < 0
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return triangles


def neighbour_means(points, triangles):
    total, count = np.zeros_like(points), np.zeros(len(points))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        for a, b in ((i, j), (j, i)):
            np.add.at(total, triangles[:, a], points[triangles[:, b]])
            np.add.at(count, triangles[:, a], 1)
    return total / count[:, None]


def random_inside(random, count, holes):
    inside = []
    while len(inside) < count:
        place = random.uniform(0.05, 0.95, 2)
        if all(np.linalg.norm(place - centre) > radius + 0.03 for centre, radius in holes):
            inside.append(place)
    return np.array(inside)


def good_plane(seed, n_free, outline, holes):
    """Nodes (the free ones last) and triangles: random nodes, evened out by moving each to the mean
    of its neighbours in the triangulation of the moment."""
    points = np.vstack([outline, random_inside(np.random.default_rng(seed), n_free, holes)])
    for _ in range(40):
        triangles = triangulate(points, holes)
        means = neighbour_means(points, triangles)
        points[len(outline):] = means[len(outline):]
    return points, triangulate(points, holes)


def plane_example(n_free, n_triangles, per_side, holes, worst):
    """The first seed whose mesh has the right count and good shapes, made worse."""
    outline = np.vstack([polygon_nodes(SQUARE, per_side)] +
                        [octagon(centre, radius) for centre, radius in holes])
    for seed in range(1000):
        points, triangles = good_plane(seed, n_free, outline, holes)
        if len(triangles) != n_triangles or radius_ratios(points, triangles).max() > 2:
            continue
        free = np.arange(len(outline), len(points))
        direction = np.random.default_rng(seed).normal(size=(n_free, 2))
        spoiled = spoil(points, free, triangles, direction, worst)
        if spoiled is not None:
            return spoiled, triangles
    raise RuntimeError("no seed gives the mesh")
