"""Boundary layers: elements that are thin in layers, whose nodes are held or keep their heights."""

from __future__ import annotations

from ctypes import byref
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import pointer
from ._cell_types import CORNERS, SIMPLICES
from ._library import call, library, threads_to_use
from ._view import View

KEEP_BY_TYPE = "keep those of some types"  # as smooth does where layers is None
_BY_TYPE = {3: (6, 8), 2: (4,)}  # corners of types whose layers are kept or held unless said otherwise
_MANY = 20  # one in so many elements that are not valid: others are thin by chance
_VALID = 1  # planish_cell_state


def layers_of(view: View) -> NDArray[np.bool_]:
    """Return a mask [m] of the elements that are thin in layers."""
    mask = np.zeros(view.mesh.n_elements, dtype=np.uint8)
    call(library.planish_find_layers, byref(view.mesh), threads_to_use(view.threads), pointer(mask), None)
    return mask.astype(bool)


def take_layers(view: View, layers: Optional[str]) -> None:
    """Hold or keep the layers of a view. layers: an option of Plan, or KEEP_BY_TYPE."""
    if layers not in (None, KEEP_BY_TYPE, "hold", "keep", "ignore"):
        raise ValueError(f"layers must be hold, keep, ignore or None, not {layers!r}")
    if layers == "keep":
        _keep(view)
    elif layers == KEEP_BY_TYPE and not view.has_targets:
        _keep_by_type(view)
    elif layers != "ignore":
        _hold(view, _chosen(view, layers == "hold"))


def _is_of_type(view: View) -> NDArray[np.bool_]:
    """Return a mask [m] of the elements whose layers count by default: wedges, hexahedra, quadrilaterals."""
    layout = view.elements.layout
    if layout is None:
        return np.zeros(view.elements.n, dtype=bool)
    dim = view.elements.dim
    return np.isin(CORNERS[layout.types], _BY_TYPE[dim]) & ~np.isin(layout.types, SIMPLICES[dim])


def _chosen(view: View, is_all: bool) -> NDArray[np.bool_]:
    """Return a mask [m] of the elements whose layers are held: all, or by their types.

    Elements with targets are not held, because targets keep layers. Neither are quadrilaterals without triangles beside
    them, because such meshes are often stretched throughout.
    """
    layout = view.elements.layout
    if is_all:
        return np.ones(view.elements.n, dtype=bool)
    if layout is None or view.mesh.reference or view.mesh.metric:
        return np.zeros(view.elements.n, dtype=bool)
    has_triangles = np.isin(layout.types, SIMPLICES[view.elements.dim]).any()
    return _is_of_type(view) & bool(view.elements.dim == 3 or has_triangles)


def _hold(view: View, chosen: NDArray[np.bool_]) -> None:
    """Fix the nodes of the chosen elements that are in layers."""
    if not chosen.any():
        return
    chosen = chosen & layers_of(view)
    if not chosen.any():
        return
    held = np.zeros(view.n, dtype=bool)
    held[view.elements.nodes_of(chosen)] = True
    if view.has_types():
        _free_invalid(view, held, int(chosen.sum()))
    view.layer_nodes = held
    view.fix(held)


def _free_invalid(view: View, held: NDArray[np.bool_], n_held: int) -> None:
    """Free the held nodes of invalid elements, which look thin by chance.

    If invalid elements are many, free all nodes: probably a wall was moved through its layers.
    """
    invalid, (nodes, owner) = view.states() != _VALID, view.elements.corners_of_all()
    if _MANY * len(np.unique(owner[held[nodes] & invalid[owner]])) > n_held:
        held[:] = False
    held[view.elements.nodes_of(invalid)] = False


def _keep_by_type(view: View) -> None:
    """Keep the layers if they have elements of the types that count; else hold layers as by default."""
    chosen = _is_of_type(view)
    if not chosen.any():
        _hold(view, _chosen(view, False))
        return
    found = layers_of(view)
    if (found & chosen).any() and _MANY * (view.states() != _VALID).sum() <= found.sum():
        _make_targets(view, found)


def _keep(view: View) -> None:
    """Give the elements of layers targets with their present heights."""
    if view.has_targets:
        raise ValueError(f"give {'like' if not view.mesh.size and not view.mesh.metric else 'size'} or layers='keep', "
                         "not both")
    _make_targets(view, layers_of(view))


def _make_targets(view: View, is_layer: NDArray[np.bool_]) -> None:
    if is_layer.any():
        view.prepare_targets()
        view.is_layer = is_layer
        view.give("is_layer", is_layer.astype(np.uint8))
