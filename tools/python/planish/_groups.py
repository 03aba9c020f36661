"""Nodes that callers name: by numbers, masks, and the sets of meshio."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import chosen_nodes


def names_in(fix: Any) -> list[str]:
    """Return the names in fix; an empty list if fix chooses nodes."""
    if isinstance(fix, str):
        return [fix]
    if isinstance(fix, (list, tuple, set, frozenset)) and fix and all(isinstance(name, str) for name in fix):
        return list(fix)
    return []


def _of_cells(mesh: Any, name: str, rows: Any) -> list[Any]:
    """Return the nodes of a set of cells of meshio's. rows: numbers of cells, or a mask, for each block."""
    return [np.asarray(block.data)[chosen_nodes(chosen, len(block.data), f"the set of cells {name!r}")].ravel()
            for block, chosen in zip(mesh.cells, rows) if chosen is not None and len(chosen)]


def _sets(mesh: Any, kind: str) -> dict[str, Any]:
    """Return the sets of a kind, without the entries "gmsh:...", which are not sets."""
    return {name: rows for name, rows in (getattr(mesh, kind, None) or {}).items() if not name.startswith("gmsh:")}


def _named(mesh: Any, name: str, n: int) -> Any:
    """Return the nodes of a set of points or cells of meshio."""
    points, cells = _sets(mesh, "point_sets"), _sets(mesh, "cell_sets")
    if name in points:
        return chosen_nodes(points[name], n, f"the set of points {name!r}")
    if name in cells:
        return np.concatenate([np.zeros(0, dtype=np.int64), *_of_cells(mesh, name, cells[name])])
    known = ", ".join([*points, *cells]) or "none"
    raise ValueError(f"fix: the mesh has no set {name!r}; it has: {known}")


def nodes_to_fix(mesh: Any, fix: Any, n: int) -> NDArray[np.int64]:
    """Return the numbers of the nodes that fix chooses by numbers, a mask, or names of sets."""
    names = names_in(fix)
    if not names:
        return chosen_nodes(fix, n, "fix")
    return chosen_nodes(np.concatenate([_named(mesh, name, n) for name in names]), n, "fix")


def data_of_points(mesh: Any) -> dict[str, Any]:
    """Return the arrays of points of a mesh by their names."""
    data = getattr(mesh, "point_data", None)
    return {str(name): data[name] for name in data.keys()} if data is not None and hasattr(data, "keys") else {}
