"""Arrays of numpy as the library takes them."""

from __future__ import annotations

from ctypes import c_void_p
from typing import Any, Callable, Optional

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def address(array: Optional[Array]) -> Optional[int]:
    """Return where an array is in memory."""
    return None if array is None else int(array.ctypes.data)


def pointer(array: Optional[Array]) -> c_void_p:
    """Return a pointer to an array, as an argument of a function."""
    return c_void_p(address(array))


def refuse_masked(values: Any, what: str) -> None:
    """Raise ValueError if any value is masked: the library would use the number behind the mask. what: the argument."""
    if isinstance(values, np.ma.MaskedArray) and np.any(values.mask):
        raise ValueError(f"{what} has masked values; leave them out, or fill them")


class _Borrowed:
    """Memory of an owner as numpy's array interface; an array over it keeps the owner alive."""

    def __init__(self, owner: Any, at: int, shape: tuple[int, ...], dtype: Any) -> None:
        self.owner = owner
        self.__array_interface__ = {"version": 3, "data": (at, False), "shape": shape,
                                    "typestr": np.dtype(dtype).str}


def borrow(owner: Any, at: Optional[int], shape: tuple[int, ...], dtype: Any) -> Array:
    """Return an array of that shape over the memory at an address, which the array keeps alive by its owner."""
    if not at or 0 in shape:
        return np.zeros(shape, dtype)
    return np.asarray(_Borrowed(owner, at, shape, dtype))


def is_in_space(points: Array) -> bool:
    """Whether points [n, 2 or 3] leave every plane of constant z by more than a geometry kernel's rounding.

    The noise may be 1e-8 of the longer side in x and y, of floats 1e-6, as in files.
    """
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        return False
    noise = 1e-8 if points.dtype.itemsize == 8 else 1e-6
    return not np.ptp(points[:, 2]) <= noise * np.ptp(points[:, :2], axis=0).max()


class Points:
    """Coordinates as the library takes them: the caller's array, or a copy to be written back."""

    def __init__(self, points: Any, dim: int, strides: Optional[tuple[int, int]] = None, writes: bool = False,
                 name: str = "points") -> None:
        """Take points [n, dim or more].

        Args:
            points: the caller's array of float64 or float32
            dim: number of columns that count
            strides: steps of the array in doubles, by rows and columns; None: any steps
            writes: the array will change, so that it must be writable
            name: argument of the caller, for messages
        """
        self._check(points, dim, writes, name)
        self.show: Optional[Callable[[Array], Array]] = None  # for points that are others than these coordinates
        self.points: Array = points[:, :dim]
        self.is_float = points.dtype.itemsize == 4
        self.array = self.points
        if not self._fits(strides):
            self.array = self._room(strides or (dim, 1))
            self.array[...] = self.points
        self.strides: tuple[int, int] = (self.array.strides[0] // 8, self.array.strides[1] // 8)

    @staticmethod
    def _check(points: Any, dim: int, writes: bool, name: str) -> None:
        if not isinstance(points, np.ndarray) or points.ndim != 2:
            raise TypeError(f"{name} must be an array of numpy of two dimensions")
        if points.shape[1] < dim:
            raise ValueError(f"{name} has {points.shape[1]} columns, but cells need {dim}")
        if points.dtype.newbyteorder("=") not in (np.float64, np.float32):
            raise TypeError(f"{name} must be of float64 or float32, not {points.dtype}")
        refuse_masked(points, name)
        if writes and not points.flags.writeable:
            raise ValueError(f"{name} is read-only; give a copy")
        if dim == 2 and is_in_space(points):
            raise ValueError("triangles must lie in a plane; smooth and quality take others, as surfaces")

    def _fits(self, strides: Optional[tuple[int, int]]) -> bool:
        steps = self.points.strides
        return (
            self.points.dtype == np.float64
            and self.points.dtype.isnative
            and bool(self.points.flags.aligned)
            and all(step > 0 and step % 8 == 0 for step in steps)
            and strides in (None, tuple(step // 8 for step in steps))
        )

    def _room(self, strides: tuple[int, int]) -> Array:
        n, dim = self.points.shape
        room = np.zeros(max(n - 1, 0) * strides[0] + (dim - 1) * strides[1] + 1)
        return np.lib.stride_tricks.as_strided(room, self.points.shape, tuple(8 * step for step in strides))

    def copy(self) -> Array:
        """Return a copy of the array, with its steps."""
        found = self._room(self.strides)
        found[...] = self.array
        return found

    def shown(self, found: Array) -> Array:
        """Return coordinates [n, dim] as callers have them."""
        return np.ascontiguousarray(found) if self.show is None else self.show(found)

    def write_back(self) -> None:
        """Copy the coordinates back to the caller's array, unless the library has used that array itself."""
        if self.array is not self.points:
            self.points[...] = self.array


def simplices(cells: Any) -> Array:
    """Return cells [m, 3 or 4] as int32 or int64, without a copy where their type and order allow that."""
    refuse_masked(cells, "cells")
    cells = np.asarray(cells)
    if cells.ndim != 2 or cells.shape[1] not in (3, 4):
        raise ValueError(f"cells must be [m, 3] (triangles) or [m, 4] (tetrahedra), not {cells.shape}")
    if cells.dtype.kind not in "iu":
        raise TypeError(f"cells must be integers, not {cells.dtype}")
    if cells.dtype == np.uint64 and cells.size and cells.max() > np.iinfo(np.int64).max:
        raise ValueError(f"cells has node {cells.max()}, which is out of range")
    is_narrow = cells.dtype.itemsize <= 4 and cells.dtype.kind == "i"
    return np.require(cells, np.int32 if is_narrow else np.int64, ["C", "A"])


def narrow(nodes: Array) -> Array:
    """Return nodes as int32; raise ValueError if one is out of range."""
    for node in (nodes.min(initial=0), nodes.max(initial=0)):
        if not -(2**31) <= node < 2**31:
            raise ValueError(f"cells has node {node}, which is out of range")
    return nodes.astype(np.int32, copy=False)


def chosen_nodes(nodes: Any, n: int, what: str) -> NDArray[np.int64]:
    """Return the numbers of nodes that numbers or a mask [n] choose. what: the argument, for messages."""
    refuse_masked(nodes, what)
    nodes = np.asarray(list(nodes) if isinstance(nodes, (set, frozenset)) else nodes)
    if nodes.dtype == bool:
        if nodes.shape != (n,):
            raise ValueError(f"{what} is a mask of shape {nodes.shape}, not ({n},)")
        return np.flatnonzero(nodes).astype(np.int64)
    if nodes.size and nodes.dtype.kind not in "iu":
        raise TypeError(f"{what} must be numbers of nodes or a mask, not {nodes.dtype}")
    numbers: NDArray[np.int64] = nodes.astype(np.int64).ravel()
    if numbers.size and not (0 <= numbers.min() and numbers.max() < n):
        raise ValueError(f"{what} has a number that is not in 0 .. {n - 1}")
    return numbers


def joined(parts: list[Any]) -> Array:
    """Return the concatenation of arrays; a single one is not copied."""
    return np.asarray(parts[0]) if len(parts) == 1 else np.concatenate([np.asarray(part) for part in parts])
