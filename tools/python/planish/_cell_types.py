"""Types of cells: those that the library knows, by VTK's numbers and meshio's names."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np


class CellType(NamedTuple):
    """A type of cells that the library knows."""

    number: int  # planish_cell_type, which is VTK's
    name: str  # meshio's
    dim: int
    n_nodes: int
    n_corners: int


TYPES = [CellType(*row) for row in (
    (1, "vertex", 0, 1, 1), (3, "line", 1, 2, 2), (21, "line3", 1, 3, 2),
    (5, "triangle", 2, 3, 3), (22, "triangle6", 2, 6, 3),
    (9, "quad", 2, 4, 4), (23, "quad8", 2, 8, 4), (28, "quad9", 2, 9, 4),
    (10, "tetra", 3, 4, 4), (24, "tetra10", 3, 10, 4),
    (12, "hexahedron", 3, 8, 8), (25, "hexahedron20", 3, 20, 8), (29, "hexahedron27", 3, 27, 8),
    (13, "wedge", 3, 6, 6), (26, "wedge15", 3, 15, 6), (32, "wedge18", 3, 18, 6),
    (14, "pyramid", 3, 5, 5), (27, "pyramid13", 3, 13, 5), (128, "pyramid14", 3, 14, 5))]
KNOWN: dict[Any, CellType] = {key: kind for kind in TYPES for key in (kind.number, kind.name)}

TRIANGLE = 5
SIMPLICES = {2: (5, 22), 3: (10, 24)}  # straight, second order
HELD = (27, 128)  # pyramids of second order: their nodes stay
POLYVERTEX, POLYLINE, STRIP, POLYGON = 2, 4, 6, 7  # VTK's, of any number of nodes

# Other orders of nodes: pixels and voxels by VTK's number or meshio's name, wedges by meshio's name.
WEDGE_OF_MESHIO = [0, 2, 1, 3, 5, 4]
_PIXEL, _VOXEL = (KNOWN["quad"], [0, 1, 3, 2]), (KNOWN["hexahedron"], [0, 1, 3, 2, 4, 5, 7, 6])
_REORDERED: dict[Any, tuple[CellType, list[int]]] = {
    8: _PIXEL, "pixel": _PIXEL, 11: _VOXEL, "voxel": _VOXEL, "wedge": (KNOWN["wedge"], WEDGE_OF_MESHIO)}


def type_of(name: Any) -> tuple[Optional[CellType], Optional[list[int]]]:
    """Return the type for a name of meshio's or a number of VTK's, and the order of its nodes; None: VTK's order.

    The type is None if the library does not know it.
    """
    return _REORDERED.get(name, (KNOWN.get(name), None))


def _by_number(field: str) -> Any:
    """Return a field of all types by VTK's number [256]; 0: any number, or not known."""
    return np.array([getattr(type_of(number)[0], field, 0) for number in range(256)], dtype=np.int64)


WIDTHS = _by_number("n_nodes")
CORNERS = _by_number("n_corners")
