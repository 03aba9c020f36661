"""Cells of meshio, PyVista and VTK, and cells by type, as blocks of one type each."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple, Optional

import numpy as np

from ._arrays import Array, refuse_masked
from ._cell_types import POLYGON, POLYLINE, POLYVERTEX, STRIP, TYPES, WIDTHS, CellType, type_of


class Block(NamedTuple):
    """Cells of one type, and their values in each array of cells, by the name of the array."""

    kind: Optional[CellType]  # None: the library does not know it
    name: Any  # meshio's name or VTK's number
    nodes: Array  # [n, kind.n_nodes] in VTK's order, or all nodes of cells without a kind
    at: Array  # [n] places among all cells
    data: dict[str, Any]


# ---- one block ------------------------------------------------------------------------------------


def _flat(nodes: Any) -> list[int]:
    """Return all numbers in nested lists, such as the faces of a polyhedron."""
    if isinstance(nodes, (list, tuple, np.ndarray)):
        return [number for part in nodes for number in _flat(part)]
    return [operator.index(nodes)]


def _nodes_of(data: Any) -> Array:
    """Return the nodes of cells: [m, k] if all cells have k nodes, else one row of all nodes."""
    try:
        nodes = np.asarray(data)
    except ValueError:
        nodes = np.empty(0, dtype=object)
    if nodes.dtype == object:
        nodes = np.array(_flat(data), dtype=np.int64)
    return nodes if nodes.size else nodes.astype(np.int64)


def _block(name: Any, data: Any, at: Array, values: dict[str, Any]) -> Block:
    """Return a block of cells of the type that a name of meshio's or a number of VTK's means."""
    refuse_masked(data, f"the array of cells of type {name}")
    nodes, (kind, order) = _nodes_of(data), type_of(name)
    if nodes.dtype.kind not in "iu":
        raise TypeError(f"cells of type {name} must be integers, not {nodes.dtype}")
    if kind is None:
        return Block(None, name, nodes.ravel(), at, values)
    if nodes.shape == (0,):  # an empty list
        nodes = nodes.reshape(0, kind.n_nodes)
    if nodes.ndim != 2 or nodes.shape[1] != kind.n_nodes:
        raise ValueError(f"cells of type {name} must be [m, {kind.n_nodes}], not {nodes.shape}")
    return Block(kind, name, nodes if order is None else nodes[:, order], at, values)


def _of_pairs(pairs: Any, data: dict[str, Any]) -> list[Block]:
    """Return a block for each pair (type, nodes). data: lists of arrays by name, one array for each pair."""
    blocks, n = [], 0
    for i, (name, nodes) in enumerate(pairs):
        if not isinstance(name, (str, int, np.integer)) or not hasattr(nodes, "__len__"):
            raise TypeError(f"cells by type must be meshio's names or VTK's numbers and arrays, not {name!r} and "
                            f"{type(nodes).__name__}")
        at = np.arange(n, n + len(nodes))
        blocks.append(_block(name, nodes, at, {key: values[i] for key, values in data.items()}))
        n += len(nodes)
    return blocks


# ---- VTK's arrays ---------------------------------------------------------------------------------


def _check_arrays(nodes: Array, offsets: Array, types: Array) -> None:
    """Raise ValueError if nodes, offsets and types contradict one another."""
    widths = np.diff(offsets)
    if len(offsets) != len(types) + 1 or offsets[0] != 0 or offsets[-1] != len(nodes) or (widths < 0).any():
        raise ValueError(f"the offsets of {len(types)} cells must be {len(types) + 1} numbers that ascend from 0 to "
                         f"{len(nodes)}, the number of nodes in cells")
    if len(types) and not (0 <= types.min() and types.max() < len(WIDTHS)):
        raise ValueError("types has a number that is not in 0 .. 255")
    wanted = WIDTHS[types]
    wrong = np.flatnonzero((wanted != 0) & (wanted != widths))
    if len(wrong):
        i = wrong[0]
        raise ValueError(f"cell {i} of type {types[i]} has {widths[i]} nodes, not {wanted[i]}")


def _of_arrays(nodes: Array, offsets: Array, types: Array, data: dict[str, Any]) -> list[Block]:
    """Return blocks of cells in VTK's arrays: cell i has nodes[offsets[i]:offsets[i + 1]]."""
    offsets = offsets.astype(np.int64, copy=False)  # differences of unsigned numbers are never negative
    _check_arrays(nodes, offsets, types)
    blocks = []
    for number in np.flatnonzero(np.bincount(types, minlength=256)).tolist():
        is_of = types == number
        is_all = bool(is_of.all())
        of_cells = nodes if is_all else nodes[np.repeat(is_of, np.diff(offsets))]
        at = np.flatnonzero(is_of)
        values = {name: np.asarray(values)[... if is_all else at] for name, values in data.items()}
        width = int(WIDTHS[number])
        blocks.append(_block(number, of_cells.reshape(-1, width) if width else of_cells, at, values))
    return blocks


def _starts(lists: Array, what: str, types: Optional[Array]) -> Array:
    """Return the indices of the counts in VTK's lists (a count, its nodes, the next count, ...)."""
    if types is not None and len(types) and 0 <= types.min() and types.max() < len(WIDTHS):
        starts: Array = np.cumsum(WIDTHS[types] + 1) - WIDTHS[types] - 1
    else:  # all cells may have as many nodes as the first
        starts = np.arange(0, len(lists), max(int(lists[0]), 0) + 1 if len(lists) else 1)
    ends = lists[starts] + starts + 1 if len(starts) and starts[-1] < len(lists) else starts
    fits = np.array_equal(np.append(starts, len(lists)), np.append(0, ends))
    return starts if fits else _walked(lists, what)


def _walked(lists: Array, what: str) -> Array:
    """Return the indices of the counts in VTK's lists, found one after another; raise ValueError at a wrong count."""
    starts, at = [], 0
    while at < len(lists):
        count = int(lists[at])
        if not 0 <= count < len(lists) - at:
            raise ValueError(f"{what} has the count {count} at {at}, which is negative or more than there are nodes "
                             "behind it")
        starts.append(at)
        at += 1 + count
    return np.array(starts, dtype=np.int64)


def _counted(lists: Any, what: str, types: Optional[Array] = None) -> tuple[Array, Array]:
    """Return nodes and offsets of VTK's lists (a count, its nodes, the next count, ...)."""
    lists = np.zeros(0, dtype=np.int64) if lists is None else np.asarray(lists).ravel()
    starts = _starts(lists, what, types)
    if types is not None and len(starts) != len(types):
        raise ValueError(f"{what} has {len(starts)} cells, but there are {len(types)} types")
    nodes: Array = np.delete(lists, starts)
    return nodes, np.append(starts - np.arange(len(starts)), len(nodes))


# ---- meshes of other packages -----------------------------------------------------------------------


def cell_data(mesh: Any) -> dict[str, Any]:
    """Return the arrays of cells by their names."""
    data = getattr(mesh, "cell_data", None)
    return {str(name): data[name] for name in data.keys()} if data is not None and hasattr(data, "keys") else {}


def _of_grid(mesh: Any) -> list[Block]:
    """Return blocks of the cells of PyVista's UnstructuredGrid, without a copy of its arrays where possible."""
    types = np.asarray(mesh.celltypes)
    nodes, offsets = getattr(mesh, "cell_connectivity", None), getattr(mesh, "offset", None)
    if nodes is None or offsets is None:
        nodes, offsets = _counted(getattr(mesh, "cells", None), "cells of the mesh", types)
    return _of_arrays(np.asarray(nodes), np.asarray(offsets), types, cell_data(mesh))


def _of_polydata(mesh: Any) -> list[Block]:
    """Return blocks of the cells of PyVista's PolyData. Its arrays have points first, then lines, faces and strips."""
    kinds: list[tuple[str, dict[int, int], int]] = [
        ("verts", {1: 1}, POLYVERTEX), ("lines", {2: 3}, POLYLINE), ("faces", {3: 5, 4: 9}, POLYGON),
        ("strips", {}, STRIP)]
    parts, first = [], 0
    for name, usual, other in kinds:
        nodes, offsets = _counted(getattr(mesh, name, None), f"{name} of the mesh")
        types = np.array([usual.get(width, other) for width in np.diff(offsets).tolist()], dtype=np.uint8)
        parts.append((nodes, offsets[:-1] + first, types))
        first += len(nodes)
    nodes, offsets, types = (np.concatenate(arrays) for arrays in zip(*parts))
    return _of_arrays(nodes, np.append(offsets, first), types, cell_data(mesh))


def blocks_of_mesh(mesh: Any) -> list[Block]:
    """Return the cells of a mesh of meshio or of PyVista."""
    if hasattr(mesh, "celltypes"):
        return _of_grid(mesh)
    cells = getattr(mesh, "cells", None)
    if isinstance(cells, list):
        return _of_pairs([(block.type, block.data) for block in cells], cell_data(mesh))
    if hasattr(mesh, "faces"):
        return _of_polydata(mesh)
    if hasattr(mesh, "cast_to_unstructured_grid"):
        raise TypeError(f"planish takes UnstructuredGrid and PolyData of pyvista, not {type(mesh).__name__}; give its "
                        "cast_to_unstructured_grid(), which is a copy")
    raise TypeError("give points and cells as arrays, or a mesh of planish.read, meshio or pyvista")


# ---- cells of callers -------------------------------------------------------------------------------


def _is_pair(part: Any) -> bool:
    return hasattr(part, "type") or (isinstance(part, (list, tuple)) and len(part) == 2 and np.ndim(part[0]) == 0
                                     and hasattr(part[1], "__len__"))


def is_by_type(cells: Any) -> bool:
    """Whether cells are a dict by types, pairs (type, nodes), blocks of meshio's, or VTK's arrays."""
    if isinstance(cells, tuple) and len(cells) in (2, 3) and all(
            isinstance(array, np.ndarray) and array.ndim == 1 for array in cells):
        return len({len(array) for array in cells}) > 1
    return isinstance(cells, dict) or (isinstance(cells, (list, tuple)) and len(cells) > 0
                                       and all(_is_pair(part) for part in cells))


def _of_tuple(cells: tuple[Array, ...]) -> list[Block]:
    """Return blocks of cells in VTK's arrays: (lists, types) or (nodes, offsets, types)."""
    if any(array.dtype.kind not in "iu" for array in cells):
        raise TypeError("arrays of cells must be integers")
    cells = tuple(array.astype(np.int64) if array.dtype == np.uint64 else array for array in cells)
    nodes, offsets = _counted(cells[0], "cells", cells[-1]) if len(cells) == 2 else cells[:2]
    return _of_arrays(nodes, offsets, cells[-1], {})


def blocks_by_type(cells: Any) -> list[Block]:
    """Return blocks of the cells that a caller gives in a form of is_by_type."""
    if isinstance(cells, tuple) and isinstance(cells[0], np.ndarray):
        blocks = _of_tuple(cells)
    else:
        blocks = _of_pairs(cells.items() if isinstance(cells, dict) else [
            (part.type, part.data) if hasattr(part, "type") else part for part in cells], {})
    if not blocks:
        raise ValueError("cells is empty; give an array of nodes for each type")
    for block in blocks:
        if block.kind is None:
            raise ValueError(f"planish does not know cells of type {block.name!r}; leave them out and give their "
                             f"nodes as fix. It knows {', '.join(kind.name for kind in TYPES)}")
    return blocks
