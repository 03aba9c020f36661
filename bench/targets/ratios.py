"""ratios: aspect ratios against targets (docs/targets.md), by numpy and without planish."""
import numpy as np

import cells

# The corners of an element: a node, and the ends of its edges, in the order in which the determinant of a
# valid element is positive. One corner of a simplex has the ratio of all.
CORNERS = {
    "triangle": ((0, 1, 2),),
    "quad": tuple((j, (j + 1) % 4, (j + 3) % 4) for j in range(4)),
    "tet": ((0, 1, 2, 3),),
    "hex": (*((j, (j + 1) % 4, (j + 3) % 4, j + 4) for j in range(4)),
            *((j + 4, (j + 3) % 4 + 4, (j + 1) % 4 + 4, j) for j in range(4))),
    "wedge": (*((j, (j + 1) % 3, (j + 2) % 3, j + 3) for j in range(3)),
              *((j + 3, (j + 2) % 3 + 3, (j + 1) % 3 + 3, j) for j in range(3))),
}

# Edges of a corner of the regular element, as columns.
REGULAR = {
    "triangle": np.array([[1, 1 / 2], [0, 3 ** 0.5 / 2]]),
    "quad": np.eye(2),
    "tet": np.array([[1, 1 / 2, 1 / 2], [0, 3 ** 0.5 / 2, 12 ** -0.5], [0, 0, (2 / 3) ** 0.5]]),
    "hex": np.eye(3),
}


def matrices(points, nodes):
    """The edges [m][dim][dim] of corners [m][dim + 1], as columns."""
    return (points[nodes[:, 1:]] - points[nodes[:, :1]]).transpose(0, 2, 1)


def inverse_targets(targets, name, nodes):
    """W^-1 of corners [m][dim + 1]: that of their edges in targets; None: of the regular element."""
    return np.linalg.inv(REGULAR[name] if targets is None else matrices(targets, nodes))


def mean_ratios(points, inverse, nodes):
    """mu [m] of T = A W^-1; infinite where det T is not positive."""
    t = matrices(points, nodes) @ inverse
    dim, determinant = points.shape[1], np.linalg.det(t)
    square = (t * t).sum(axis=(1, 2))
    positive = np.where(determinant > 0, determinant, 1)
    return np.where(determinant > 0, square / (dim * positive ** (2 / dim)), np.inf)


def means(points, targets, elements, power):
    """The mean of mu^power over the corners of each element. targets: points, or None for regular elements."""
    found = []
    for name, nodes in cells.blocks_of(elements):
        corners = [nodes[:, list(corner)] for corner in CORNERS[name]]
        found.append(np.mean([mean_ratios(points, inverse_targets(targets, name, corner), corner) ** power
                              for corner in corners], axis=0))
    return np.concatenate(found)


def squares(points, targets, elements):
    """AR^2 of each element."""
    return means(points, targets, elements, 2)


def rms(points, targets, elements):
    """RMS of AR; infinite if an element is inverted."""
    return float(np.sqrt(squares(points, targets, elements).mean()))
