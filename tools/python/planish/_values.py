"""Arrays of measures of single elements for the library to fill."""

from __future__ import annotations

import ctypes
from typing import Any, Optional

import numpy as np

from ._arrays import address
from ._results import CellValues
from ._structures import CellValueArrays
from ._view import View


def room(view: View, is_wanted: bool) -> Optional[CellValues]:
    """Return arrays [m] for the library to fill; None: they are not wanted."""
    if not is_wanted:
        return None
    m = view.mesh.n_elements
    state, is_curved = np.zeros((2, m), dtype=np.uint8)
    return CellValues(view.elements.at, state, is_curved, *np.zeros((4, m)))


def structure(arrays: Optional[CellValues]) -> Any:
    """Return a pointer to the structure that points to the arrays."""
    if arrays is None:
        return None
    fields = {name: address(array) for name, array in arrays._asdict().items() if name != "number"}
    return ctypes.byref(CellValueArrays(**fields))


def finished(arrays: Optional[CellValues]) -> Optional[CellValues]:
    """Return the filled arrays for callers, with is_curved as a mask."""
    return None if arrays is None else arrays._replace(is_curved=arrays.is_curved.astype(bool))
