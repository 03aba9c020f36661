"""measures: radius ratios, angles, aspect ratios, scaled Jacobians and volumes, by textbook formulas."""
import itertools

import numpy as np

from shapes import SHAPES, vertices
from validity import CHUNK, coefficients


def _lengths(vectors):
    return np.sqrt((vectors * vectors).sum(axis=-1))


def _in_space(places):
    return places if places.shape[2] == 3 else np.concatenate([places, np.zeros((*places.shape[:2], 1))], axis=2)


def _triangle(places):
    """Radius ratio R / (2 r), and the smallest angle in radians."""
    p = _in_space(places)
    edges = [p[:, (i + 1) % 3] - p[:, i] for i in range(3)]
    length = [_lengths(e) for e in edges]
    area = _lengths(np.cross(edges[0], edges[1])) / 2
    ratio = np.prod(length, axis=0) * sum(length) / (16 * area * area)
    angles = [np.arctan2(2 * area, -(edges[i] * edges[i - 1]).sum(axis=1)) for i in range(3)]
    return ratio, np.min(angles, axis=0)


def _tetrahedron(places):
    """Radius ratio R / (3 r), and the smallest dihedral angle in radians."""
    a, b, c = (places[:, i] - places[:, 0] for i in (1, 2, 3))
    six = np.abs((a * np.cross(b, c)).sum(axis=1))
    normals = [np.cross(c - a, b - a), np.cross(b, c), np.cross(c, a), np.cross(a, b)]
    double = sum(map(_lengths, normals))
    square = [(e * e).sum(axis=1)[:, None] for e in (a, b, c)]
    radius = _lengths(square[0] * normals[1] + square[1] * normals[2] + square[2] * normals[3]) / (2 * six)
    ratio = radius * double / (3 * six)
    least = np.full(len(places), np.pi)
    for m, n in itertools.combinations(normals, 2):
        least = np.minimum(least, np.arctan2(_lengths(np.cross(m, n)), -(m * n).sum(axis=1)))
    return ratio, least


def simplex(name, places):
    """Radius ratios, and smallest angles in degrees, by corners."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio, angle = (_triangle if SHAPES[name].dim == 2 else _tetrahedron)(places)
    return ratio, np.degrees(angle)


def cell(name, places, sign):
    """Aspect ratios (infinite with a corner that is not positive) and least scaled Jacobians of elements of any type.
    sign None: elements in space, whose corners are taken as positive."""
    shape = SHAPES[name]
    squares, least = np.zeros(len(places)), np.full(len(places), np.inf)
    inverse, det_ideal = np.linalg.inv(shape.ideal), np.linalg.det(shape.ideal)
    for at, *others in shape.corners:
        edges = np.stack([places[:, i] - places[:, at] for i in others], axis=2)
        if edges.shape[1] == shape.dim:
            det = np.linalg.det(edges) * (1 if sign is None else sign)
        else:
            det = _lengths(np.cross(edges[:, :, 0], edges[:, :, 1]))
        with np.errstate(divide="ignore", invalid="ignore"):
            product = np.prod(np.sqrt((edges * edges).sum(axis=1)), axis=1)
            least = np.minimum(least, det / product / det_ideal * np.prod(np.linalg.norm(shape.ideal, axis=0)))
            det = np.where(det > 0, det, np.nan) / det_ideal
            mu = ((edges @ inverse) ** 2).sum(axis=(1, 2)) / (shape.dim * det ** (2 / shape.dim))
        squares += mu * mu / len(shape.corners)
    return np.where(np.isnan(squares), np.inf, np.sqrt(squares)), least


def _reference(name):
    """Nodes of an element whose volume is known, and that."""
    shape = SHAPES[name]
    unit = np.eye(3)
    if shape.base in ("triangle", "tetra"):
        corner = [np.zeros(3), *unit][:shape.dim + 1]
    elif shape.base == "wedge":
        corner = [np.array([x == 1, x == 2, z], float) for x, z in vertices("wedge")]
    else:
        corner = [np.array([*v, 0, 0][:3], float) for v in vertices(shape.base)] + [unit[2]] * (shape.base == "pyramid")
    volume = {"triangle": 1 / 2, "tetra": 1 / 6, "wedge": 1 / 2, "pyramid": 1 / 3}.get(shape.base, 1)
    nodes = np.array([np.mean([corner[i] for i in ends], axis=0) for ends in shape.between])
    return nodes[None, :, :shape.dim], volume


def volumes(name, places):
    """Signed volumes, in the plane areas, of elements as they are listed."""
    nodes, known = _reference(name)
    scale = known / coefficients(name, nodes - nodes[:, :1])[1].mean()
    parts = [places[i:i + CHUNK] for i in range(0, len(places), CHUNK)]
    return np.concatenate([scale * coefficients(name, p - p[:, :1])[1].mean(axis=1) for p in parts] or [np.zeros(0)])
