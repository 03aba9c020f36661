"""Regions (materials): the arrays of cells that they come from, and the nodes between regions."""

from __future__ import annotations

from ctypes import byref, c_int, c_int64
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, address, pointer, refuse_masked
from ._library import call, library, threads_to_use
from ._structures import CellArray
from ._view import View

_NUMBERS = {"int32": 0, "int64": 1, "int8": 2, "int16": 3, "uint8": 4, "uint16": 5, "uint32": 6, "uint64": 7,
            "float32": 8, "float64": 9}  # planish_number


class ByRule:
    """Default of regions: arrays of cells that look like regions are regions."""

    def __repr__(self) -> str:
        """Return a word for it."""
        return "by the rule"


BY_RULE = ByRule()


def _numbers(values: Any, n: int) -> Optional[Array]:
    """Return values [n] in a type of the library's; None if there is not one number for each cell."""
    values = np.asarray(values)
    if values.shape == (n, 1):
        values = values[:, 0]
    if values.shape != (n,) or values.dtype.kind not in "biuf":
        return None
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    native = values.dtype.newbyteorder("=")
    wanted: Array = np.require(values, native if native.name in _NUMBERS else np.float64, ["C", "A"])
    return wanted


def names_of(regions: Any) -> Optional[list[str]]:
    """Return the names of arrays in regions; None: regions are values."""
    if isinstance(regions, str):
        return [regions]
    if isinstance(regions, np.ndarray) or not np.iterable(regions):
        return None
    return list(regions) if all(isinstance(name, str) for name in regions) else None


def _wanted(data: dict[str, Any], regions: Any) -> dict[str, Any]:
    """Return the arrays, by name, that the option regions asks for."""
    if regions is None:
        return {}
    if regions is BY_RULE:
        return data
    names = names_of(regions)
    if names is None:
        refuse_masked(regions, "regions")
        return {"regions": regions}
    for name in names:
        if name not in data:
            raise ValueError(f"the mesh has no array of cells {name!r}; it has: " + (", ".join(data) or "none"))
    return {name: data[name] for name in names}


class Regions:
    """Arrays of a mesh's cells whose values are regions, and the regions of elements."""

    def __init__(self, view: View, regions: Any) -> None:
        """Take the arrays of the view's elements that regions asks for."""
        self.view = view
        self.values: list[Array] = []
        self.names: list[str] = []
        self.is_by_rule = regions is BY_RULE
        wanted = _wanted(view.elements.data, regions) if view.elements.is_smoothed() else {}
        for name, values in wanted.items():
            self._add(name, _numbers(values, view.elements.n))
        self.arrays = (CellArray * len(self.names))(*(
            CellArray(name=name.encode(), values=address(values), type=_NUMBERS[values.dtype.name], is_region=1)
            for name, values in zip(self.names, self.values)))

    def _add(self, name: str, numbers: Optional[Array]) -> None:
        if numbers is not None:
            self.names.append(name)
            self.values.append(numbers)
        elif not self.is_by_rule:
            raise ValueError(f"regions: array {name!r} has not one number for each of {self.view.elements.n} elements")

    def used(self) -> list[str]:
        """Return the names of the arrays that are regions. By the rule, the library decides."""
        if self.is_by_rule and self.names:
            call(library.planish_find_regions, byref(self.view.mesh), self.arrays, c_int(len(self.names)),
                 threads_to_use(self.view.threads))
        return [name for name, array in zip(self.names, self.arrays) if array.is_region]

    def combined(self) -> Optional[NDArray[np.int32]]:
        """Return the region number of each element [m]; None if no array is a region."""
        if not any(array.is_region for array in self.arrays):
            return None
        region = np.zeros(self.view.elements.n, dtype=np.int32)
        call(library.planish_combine_regions, c_int64(len(region)), self.arrays, c_int(len(self.names)),
             pointer(region), None)
        return region


def nodes_between(view: View, region: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return a mask [n] of the nodes between regions."""
    between = np.zeros(view.n, dtype=np.uint8)
    call(library.planish_find_interfaces, byref(view.mesh), pointer(region), threads_to_use(view.threads),
         pointer(between), None)
    return between.astype(bool)


def take_regions(view: View, regions: Any, holds: bool) -> None:
    """Find the regions of a view; holds: fix the nodes between them."""
    found = Regions(view, regions)
    view.region_arrays = found.used()
    region = found.combined()
    if not holds:
        view.region = region
    elif region is not None:
        between = nodes_between(view, region)
        if between.any():
            view.fix(between)
