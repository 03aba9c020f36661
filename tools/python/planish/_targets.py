"""Targets: wanted shapes and sizes of elements."""

from __future__ import annotations

from ctypes import byref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Points, pointer, refuse_masked
from ._library import call, library, threads_to_use
from ._view import View


def take_places(view: View, points: Any, what: str) -> None:
    """Set reference of the view's mesh to points, or to those of a mesh. what: the argument, for messages."""
    points = view.places_of(points)
    if np.shape(points)[:1] != (view.n,):
        raise ValueError(f"{what} must have a row for each of {view.n} points, not the shape {np.shape(points)}")
    view.give("reference", Points(points, view.dim, view.points.strides, name=what).array)


def take_like(view: View, points: Any) -> None:
    """Make the shapes that elements have at points, or in a mesh, their targets."""
    view.prepare_targets()
    take_places(view, points, "like")


def take_size(view: View, size: Any) -> None:
    """Make sizes [n] or symmetric metrics [n, dim, dim] at the points the targets of the elements."""
    refuse_masked(size, "size")
    values, dim = np.ascontiguousarray(size, dtype=float), view.dim
    view.prepare_targets()
    if values.shape == (view.n,):
        view.give("size", values)
        return
    if view.has_own_axes:
        raise ValueError("size must have a number for each point, as matrices are for a plane of constant z")
    if values.shape != (view.n, dim, dim):
        raise ValueError(f"size must have a number or a {dim} x {dim} matrix for each of {view.n} points, not the "
                         f"shape {values.shape}")
    off = np.abs(values - values.transpose(0, 2, 1)).max(axis=(1, 2))
    wrong = np.flatnonzero(off > 1e-6 * np.abs(values).max(axis=(1, 2)))
    if len(wrong):
        raise ValueError(f"size that has matrices must have symmetric ones; that of node {wrong[0]} is not")
    rows, columns = np.tril_indices(dim)
    view.give("metric", np.ascontiguousarray(values[:, rows, columns]))


def sizes_of(view: View) -> NDArray[np.float64]:
    """Return the size of a mesh at each node [n]."""
    size = np.zeros(view.n)
    call(library.planish_find_sizes, byref(view.mesh), threads_to_use(view.threads), pointer(size))
    return size
