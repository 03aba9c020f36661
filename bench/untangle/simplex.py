"""simplex: measures of meshes of triangles or tetrahedra. points [n][dim], elements
[m][dim + 1] (from 0, oriented so that a valid element has a positive determinant)."""
from fractions import Fraction

import numpy as np

# Determinants over the product of their columns' lengths, whose rounding errors are about 1e-15:
SAFE = 1e-9    # a mesh is valid beyond doubt from here on
DOUBT = 1e-14  # the sign is decided exactly below


def columns(points, elements):
    return points[elements[:, 1:]] - points[elements[:, :1]]


def determinants(points, elements):
    """dim! times the signed volumes [m]."""
    if points.shape[1] == 2:
        a, b = columns(points, elements).transpose(1, 2, 0)
        return a[0] * b[1] - a[1] * b[0]
    a, b, c = columns(points, elements).transpose(1, 2, 0)
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def shapes(points, elements):
    """The determinants of the elements scaled to columns of length 1: -1 to 1."""
    lengths = np.linalg.norm(columns(points, elements), axis=2).prod(axis=1)
    return determinants(points, elements) / np.where(lengths > 0, lengths, 1)


def is_valid(points, elements):
    """Beyond doubt."""
    return bool((shapes(points, elements) > SAFE).all())


def exact_determinant(corners):
    """Of points [dim + 1][dim], as a fraction."""
    first, *others = [[Fraction(value) for value in corner] for corner in corners.tolist()]
    rows = [[value - start for value, start in zip(other, first)] for other in others]
    if len(rows) == 2:
        return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]
    a, b, c = rows
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def inverted(points, elements):
    """[m] of bool: the determinant is not positive, decided exactly where rounding might."""
    value = shapes(points, elements)
    found = value <= 0
    for k in np.flatnonzero(abs(value) < DOUBT):
        found[k] = exact_determinant(points[elements[k]]) <= 0
    return found


def n_inverted(points, elements):
    return int(inverted(points, elements).sum())


def oriented(points, elements):
    """The elements with those turned whose determinant is negative."""
    elements = elements.copy()
    negative = determinants(points, elements) < 0
    elements[negative, :2] = elements[negative, 1::-1]
    return elements


def facets(elements):
    """All facets [m (dim + 1)][dim], outward; facet j of all elements before facet j + 1."""
    if elements.shape[1] == 3:
        opposite = ((1, 2), (2, 0), (0, 1))
    else:
        opposite = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
    return np.concatenate([elements[:, list(facet)] for facet in opposite])


def boundary_facets(elements):
    every = facets(elements)
    _, first, count = np.unique(np.sort(every, axis=1), axis=0, return_index=True,
                                return_counts=True)
    return every[np.sort(first[count == 1])]


def on_boundary(n_points, elements):
    """[n] of bool."""
    found = np.zeros(n_points, bool)
    found[boundary_facets(elements)] = True
    return found


def edges(elements):
    """Each once [e][2], sorted."""
    corners = elements.shape[1]
    pairs = np.concatenate([elements[:, [i, j]] for i in range(corners) for j in range(i)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def local_lengths(points, pairs):
    """The mean length [n] of the edges at each node."""
    length = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    ends, twice = pairs.T.ravel(), np.concatenate([length, length])
    total = np.bincount(ends, twice, len(points))
    return total / np.maximum(np.bincount(ends, minlength=len(points)), 1)


def without_unused(points, elements):
    used, flat = np.unique(elements, return_inverse=True)
    return points[used], flat.reshape(elements.shape)
