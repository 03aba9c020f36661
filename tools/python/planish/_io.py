"""Calls of planish_io, the library of mesh files: functions, arguments, results."""

from __future__ import annotations

import ctypes
import os
from ctypes import byref, c_char_p, c_int, c_int64, c_void_p
from typing import Any, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from ._io_structures import Data, Hold
from ._library import files
from ._structures import MeshView, Surface

_RESULTS: dict[str, Any] = {
    "formats": ctypes.POINTER(c_char_p), "format_info": c_int, "close": None, "mesh": MeshView,
    "coordinates": c_void_p, "get_info": None, "plane": c_int, "cell_arrays": ctypes.POINTER(c_char_p),
    "region_arrays": ctypes.POINTER(c_char_p), "data_info": c_int, "surface": Surface, "get_marked": c_int64,
    "element_number": c_int64, "node_number": c_int64, "can_write": c_int, "can_convert": c_int,
    "target": c_char_p}


def io(name: str) -> Any:
    """Return the function planish_file_NAME of the library of mesh files."""
    function = getattr(files(), "planish_file_" + name)
    function.restype = _RESULTS.get(name, c_int)
    return function


def texts(found_at: Any) -> list[str]:
    """Return the texts of a C array that NULL ends."""
    found: list[str] = []
    while found_at and found_at[len(found)] is not None:
        found.append(found_at[len(found)].decode(errors="surrogateescape"))
    return found


def text_of(text: Union[str, bytes, "os.PathLike[str]"]) -> bytes:
    """Return a path or a name for the library; raise ValueError if C would take a part of it for all."""
    encoded = os.fsencode(text)
    if b"\0" in encoded:
        raise ValueError(f"{encoded!r} has a null byte; no path or name has one")
    return encoded


def texts_of(names: Sequence[str]) -> Any:
    """Return a C array of texts for the library."""
    return (c_char_p * max(len(names), 1))(*(text_of(name) for name in names))


def values_of(data: Data) -> tuple[NDArray[np.float64], bool]:
    """Return the values [n, components] of data, and whether they are of elements. Free data."""
    try:
        shape = int(data.n), int(data.n_components)
        values = np.zeros(shape)
        if values.size:
            ctypes.memmove(values.ctypes.data, data.values or 0, values.nbytes)
        return values, bool(data.of_elements)
    finally:
        free = files().planish_data_free
        free.restype = None
        free(byref(data))


def hold_of(tags: Sequence[str], **more: Any) -> tuple[Hold, Any]:
    """Return a planish_hold for groups, and the array that it points to, for the caller to keep alive."""
    texts = texts_of(tags)
    return Hold(tags=ctypes.addressof(texts), n_tags=len(tags), **more), texts
