"""Sizes and metrics of files, brought to the nodes."""

from __future__ import annotations

import math
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array
from ._elements import Layout

_MOST_RATIO = 1e12  # sizes that differ by more are no sizes of one mesh
_MOST_ENTRY = 1e290  # of a metric, so that no sum of metrics overflows
_ROUNDING = 1e-6  # of the largest entry, by which symmetric matrices may be unsymmetric


def _owners(layout: Layout) -> tuple[Array, Array]:
    """Return the nodes of all elements in a row, without missing mids, and the element of each."""
    owners = np.repeat(np.arange(len(layout.types)), np.diff(layout.offsets))
    is_there = layout.nodes >= 0
    return layout.nodes[is_there], owners[is_there]


def _logarithms(values: Array) -> NDArray[np.float64]:
    """Return logarithms by Python's math, which has the bits of C's log; numpy's may differ."""
    return np.array([math.log(value) for value in values.tolist()])


def _exponentials(values: Array) -> NDArray[np.float64]:
    return np.array([math.exp(value) for value in values.tolist()])


def _check_positive(values: Array, what: str) -> None:
    wrong = np.flatnonzero(~(values > 0))
    if len(wrong):
        raise ValueError(f"the size at {what} {wrong[0]} is {values[wrong[0]]:g}: it must be above 0")


def sizes_at_nodes(values: Array, layout: Layout, of_elements: bool, n: int) -> NDArray[np.float64]:
    """Return sizes at the nodes [n].

    Sizes of elements become their geometric mean at each node. A node in no element gets the mean of the others.
    Raise ValueError for sizes that are not positive, or too different.
    """
    nodes, owners = _owners(layout)
    count = np.bincount(nodes, minlength=n)
    is_used = count > 0
    if of_elements:
        _check_positive(values, "element")
        sums = np.bincount(nodes, weights=_logarithms(values)[owners], minlength=n)
        size = np.ones(n)
        size[is_used] = _exponentials(sums[is_used] / count[is_used])
    else:
        _check_positive(np.where(is_used, values, 1), "node")
        size = values.astype(float)
    if not is_used.all():
        logarithms = np.append(0, np.cumsum(_logarithms(size[is_used])))  # one after the other, as in C
        size[~is_used] = math.exp(logarithms[-1] / max(len(logarithms) - 1, 1))
    if size.size and size.max() / size.min() > _MOST_RATIO:
        raise ValueError(f"sizes reach from {size.min():g} to {size.max():g}: the largest may be {_MOST_RATIO:g} times "
                         "the smallest at most")
    return size


def _refuse_metrics(is_wrong: Array, what: str, why: str) -> None:
    wrong = np.flatnonzero(is_wrong)
    if len(wrong):
        raise ValueError(f"the metric at {what} {wrong[0]} {why}")


def _are_positive(matrices: Array) -> Array:
    """Return whether matrices [n, dim, dim] are positive definite: their pivots are positive."""
    rest, least = matrices.copy(), np.full(len(matrices), np.inf)
    with np.errstate(all="ignore"):  # quotients keep pivots in the range of the entries, however small these are
        while rest.shape[1]:
            pivot, column = rest[:, 0, 0], rest[:, 1:, 0]
            least = np.where(pivot > 0, least, -1)
            rest = rest[:, 1:, 1:] - (column / pivot[:, None])[:, :, None] * column[:, None, :]
    return least > 0


def _matrices(values: Array, dim: int, is_solution: bool, is_used: Array, what: str) -> NDArray[np.float64]:
    """Return symmetric matrices [.., dim, dim]. A row of values is a lower triangle or a matrix, by its length."""
    width = values.shape[1]
    if width in (4, 9) and width in (dim * dim, 9):
        full = values.reshape(-1, math.isqrt(width), math.isqrt(width))[:, :dim, :dim]
        off = np.abs(full - full.transpose(0, 2, 1)).max(axis=(1, 2))
        _refuse_metrics(is_used & (off > _ROUNDING * np.abs(values).max(axis=1)), what, "is not symmetric")
        made: NDArray[np.float64] = np.tril(full) + np.tril(full, -1).transpose(0, 2, 1)
        return made
    if width != 6 and not (width == 3 and dim == 2 and is_solution):
        raise ValueError(f"the array has {width} numbers for each of its values: a size is one number, and a metric a "
                         "symmetric tensor")
    rows, columns = np.tril_indices(dim)
    full = np.zeros((len(values), dim, dim))
    full[:, rows, columns] = full[:, columns, rows] = values[:, :len(rows)]
    return full


def _turned(full: Array, frame: Array) -> NDArray[np.float64]:
    """Return metrics [.., 2, 2] in a plane for those in space [.., 3, 3]. frame: its directions [2, 3]."""
    half = [[along[0] * full[:, 0, c] + along[1] * full[:, 1, c] + along[2] * full[:, 2, c] for c in range(3)]
            for along in frame]
    found = np.zeros((len(full), 2, 2))
    for a, b in ((0, 0), (1, 0), (1, 1)):
        x, y, z = half[a]
        found[:, a, b] = found[:, b, a] = x * frame[b, 0] + y * frame[b, 1] + z * frame[b, 2]
    return found


def metrics_at_nodes(values: Array, layout: Layout, of_elements: bool, n: int, dim: int, is_solution: bool,
                     frame: Optional[Array] = None) -> NDArray[np.float64]:
    """Return metrics at the nodes [n, dim, dim]. frame: directions [2, 3] of a plane that is not that of x and y.

    Metrics of elements become their mean at each node. A node in no element gets the mean of the others.
    Raise ValueError for the first metric that is not symmetric and positive definite, or has too large an entry.
    """
    nodes, owners = _owners(layout)
    count = np.bincount(nodes, minlength=n)
    is_used = count > 0
    what, counts = ("element", np.full(len(values), True)) if of_elements else ("node", is_used)
    if frame is not None and values.shape[1] in (3, 4):
        raise ValueError("metrics of two dimensions are for meshes in the plane of x and y: give symmetric tensors of three")
    matrices = _matrices(values, dim if frame is None else 3, is_solution, counts, what)
    _refuse_metrics(counts & ~(np.abs(matrices).max(axis=(1, 2)) <= _MOST_ENTRY), what,
                    f"has an entry that is not a number from -{_MOST_ENTRY:g} to {_MOST_ENTRY:g}")
    if frame is not None:
        matrices = _turned(matrices, frame)
    _refuse_metrics(counts & ~_are_positive(matrices), what, "is not positive definite")
    if of_elements:
        flat = matrices.reshape(len(matrices), -1)
        sums = np.stack([np.bincount(nodes, weights=part[owners], minlength=n) for part in flat.T], axis=1)
    else:
        count = is_used.astype(int)
        sums = matrices.reshape(n, -1) * is_used[:, None]
    means = sums / np.maximum(count, 1)[:, None]
    means[~is_used] = sums.sum(axis=0) / max(int(count.sum()), 1)
    found: NDArray[np.float64] = means.reshape(n, dim, dim)
    return found
