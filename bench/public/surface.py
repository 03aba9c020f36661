"""surface: how far apart two surfaces are that consist of the same facets, by samples."""
import itertools

import numpy as np

from shapes import SHAPES

CUTS = {1: 4, 2: 4}  # pieces of a facet's edge: of flat triangles samples alone, of others pieces that stand for it
MOST_SAMPLED = 2000  # facets; of larger surfaces as many at random


def _functions(base, order, at):
    """Values of the shape functions of the nodes of triangle, triangle6, quad, quad8 or quad9 at points [points][2]."""
    shape = SHAPES[base if order == 1 else {"triangle": "triangle6", "quad": "quad8"}[base]]
    x, y = at.T
    if base == "triangle":
        l = np.stack([1 - x - y, x, y], axis=1)
        if order == 1:
            return l
        return np.stack([*(l * (2 * l - 1)).T, *(4 * l[:, i] * l[:, j] for i, j in shape.between[3:])], axis=1)
    a, b = 2 * x - 1, 2 * y - 1
    ends = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    if order == 1:
        return np.stack([(1 + a * u) * (1 + b * v) / 4 for u, v in ends], axis=1)
    corner = [(1 + a * u) * (1 + b * v) * (a * u + b * v - 1) / 4 for u, v in ends]
    mid = [(1 - a * a) * (1 - b) / 2, (1 + a) * (1 - b * b) / 2, (1 - a * a) * (1 + b) / 2, (1 - a) * (1 - b * b) / 2]
    return np.stack(corner + mid, axis=1)


def _grid(base, n):
    """Points of a facet's parameters, and triangles between them."""
    is_triangle = base == "triangle"
    points = [(i / n, j / n) for i in range(n + 1) for j in range(n + 1 - is_triangle * i)]
    number = {(round(x * n), round(y * n)): k for k, (x, y) in enumerate(points)}
    triangles = []
    for i, j in itertools.product(range(n), repeat=2):
        if not is_triangle or i + j + 1 <= n:
            triangles.append([number[i, j], number[i + 1, j], number[i, j + 1]])
        if not is_triangle or i + j + 2 <= n:
            triangles.append([number[i + 1, j + 1], number[i, j + 1], number[i + 1, j]])
    return np.array(points), np.array(triangles)


def pieces(points, facets):
    """Samples [facets][samples][3], triangles [facets][pieces][3][3] that stand for the facets, and how far these may be
    off them. facets: (base, order, nodes [facets][nodes])."""
    base, order, nodes = facets
    is_flat = base == "triangle" and order == 1
    at, triangles = _grid(base, CUTS[1] if is_flat else CUTS[2])
    places = points[nodes]
    samples = np.einsum("sn,fnd->fsd", _functions(base, order, at), places)
    if is_flat:
        return samples, places[:, None], 0.0
    corners = samples[:, triangles]
    middle = np.einsum("sn,fnd->fsd", _functions(base, order, at[triangles].mean(axis=1)), places)
    edge = np.einsum("sn,fnd->fsd", _functions(base, order, (at[triangles] + at[triangles[:, [1, 2, 0]]]).reshape(-1, 2) / 2),
                     places).reshape(*corners.shape)
    off = max(np.abs(middle - corners.mean(axis=2)).max(),
              np.abs(edge - (corners + corners[:, :, [1, 2, 0]]) / 2).max())
    return samples, corners, 4.0 * float(off)


def to_triangles(points, a, b, c):
    """Distances of points to triangles, of leading shapes that go together."""
    n = np.cross(b - a, c - a)
    square = np.maximum((n * n).sum(-1), 1e-300)
    height = ((points - a) * n).sum(-1) / square
    foot = points - height[..., None] * n
    inside = np.ones(height.shape, bool)
    best = np.full(height.shape, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, foot - u) * n).sum(-1) >= 0
        t = np.clip(((points - u) * (v - u)).sum(-1) / np.maximum(((v - u) ** 2).sum(-1), 1e-300), 0, 1)
        best = np.minimum(best, np.sqrt(((points - u - t[..., None] * (v - u)) ** 2).sum(-1)))
    return np.where(inside, np.minimum(best, np.abs(height) * np.sqrt(square)), best)


def farthest(new, old, groups, bound):
    """Largest distance of samples of the facets at new [nodes][3] from the surface at old, less what that is uncertain
    by. groups: facets by their types, as pieces() takes them. Samples of a facet near its own old place are not
    compared with others."""
    samples, there, slack = [], [], 0.0
    for facets in groups:
        samples += list(pieces(new, facets)[0])
        _, triangles, off = pieces(old, facets)
        there += list(triangles)
        slack = max(slack, off)
    every = np.concatenate(there)
    centre = every.mean(axis=1)
    radius = np.sqrt(((every - centre[:, None]) ** 2).sum(axis=2)).max()
    chosen, most = np.arange(len(samples)), 0.0
    if len(chosen) > MOST_SAMPLED:
        chosen = np.random.default_rng(1).choice(chosen, MOST_SAMPLED, replace=False)
    for i in chosen:
        own = to_triangles(samples[i][None], *(there[i][:, None, k] for k in range(3))).min(axis=0)
        if own.max() <= bound + slack:
            continue
        middle = samples[i].mean(axis=0)
        reach = own.max() + np.sqrt(((samples[i] - middle) ** 2).sum(axis=1)).max() + radius
        close = every[((centre - middle) ** 2).sum(axis=1) <= reach * reach]
        least = to_triangles(samples[i][None], *(close[:, None, k] for k in range(3))).min(axis=0)
        most = max(most, float(np.minimum(own, least).max()))
    return max(most - slack, 0.0)
