"""Measures of meshes; nodes that slide, sizes and layers in them."""

from __future__ import annotations

from ctypes import byref, c_double
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _layers, _targets, _values
from ._arrays import pointer
from ._choices import Fix, PlanChoices, check_curved
from ._files import opened
from ._library import call, library, new_options, threads_to_use
from ._regions import BY_RULE
from ._results import CellQuality, LayerHeights, Quality, SizeQuality, Slides
from ._shapes import shape_for
from ._surfaces import SpaceSurface
from ._view import View
from ._views import Holding, Source, view_of


def _measure_mesh(view: View, found: Quality) -> None:
    """Measure the elements that are smoothed."""
    options = new_options()
    options.threads = threads_to_use(view.threads).value
    if view.elements.is_smoothed():
        call(library.planish_measure_mesh, byref(view.mesh), byref(options), byref(found))


def _measure_cells(view: View, rounding: Optional[float], per_element: bool, found: Quality) -> None:
    """Measure elements of all types."""
    arrays = _values.room(view, per_element)
    found.cells = CellQuality()
    call(library.planish_measure_cells, byref(view.mesh), c_double(view.rounding(rounding)),
         threads_to_use(view.threads), byref(found.cells), _values.structure(arrays))
    found.elements = _values.finished(arrays)


def _take_size(view: View, size: Any, start: Any) -> None:
    """Give a view sizes, metrics or the array of that name. start: points where they were given; None: its points."""
    _targets.take_size(view, view.named_size(size) if isinstance(size, str) else size)
    if start is not None:
        _targets.take_places(view, opened(start), "start")


def quality(points: Any, cells: Any = None, *, fix: Optional[Fix] = None, regions: Any = BY_RULE,
            rounding: Optional[float] = None, per_element: bool = False, like: Any = None, size: Any = None,
            start: Any = None, threads: int = 0) -> Quality:
    """Return the quality of a mesh. A surface in space is measured face by face, each in its own plane.

    Raise Error, a ValueError, if planish refuses the mesh, and ValueError or TypeError for a wrong argument.

    Args:
        points: as for Plan
        cells: as for Plan
        fix: as for Plan: elements without a movable node are also counted by themselves
        regions: as for Plan
        rounding: as for Plan
        per_element: measure each element, too; the result then has elements
        like: as for Plan: measure elements against their shapes there
        size: metrics, as for Plan: lengths in AR are measured by these
        start: points [n, 2 or 3] where size was given; None: points
        threads: as for Plan
    """
    if start is not None and size is None:
        raise ValueError("start is where the size was given: give size, too")
    source = Source(points, cells)
    surface = SpaceSurface.of(source, PlanChoices(fix=fix, regions=regions, threads=threads))
    if surface is not None:
        if like is not None or size is not None:
            raise ValueError(f"{'like' if size is None else 'size'} is not for surfaces in space")
        return surface.quality(per_element)
    view, found = view_of(source, Holding(fix, regions), threads), Quality()
    is_simple = view.elements.layout is None and like is None and size is None
    if like is not None:
        _targets.take_like(view, opened(like))
    _measure_mesh(view, found)
    if size is not None:
        _take_size(view, size, start)
    if per_element or not is_simple:
        _measure_cells(view, rounding, per_element, found)
    return found


def find_slides(points: Any, cells: Any = None, *, fix: Optional[Fix] = None, regions: Any = BY_RULE,
                surface_of: Any = None, slide_interfaces: bool = False, threads: int = 0) -> Slides:
    """Return the constraint of each node: free, fixed, or sliding on a plane or straight edge.

    Args:
        points: as for Plan
        cells: as for Plan
        fix: as for Plan
        regions: as for Plan
        surface_of: as for Plan; nodes then slide on its patches and curves, too
        slide_interfaces: as for Plan
        threads: as for Plan
    """
    source = Source(points, cells)
    view = view_of(source, Holding(fix, regions, True), threads)
    check_curved(view.dim, surface_of is not None)
    shape = None if surface_of is None else shape_for(source, opened(surface_of), regions, 0, threads)
    surface = view.surface()
    surface.slide_interfaces = bool(slide_interfaces)
    surface.shape = None if shape is None else shape.pointer().value
    info = view.find_slides(surface)
    assert view.constraint is not None and view.direction is not None
    return Slides(view.constraint, view.direction, info)


def find_sizes(points: Any, cells: Any = None, *, threads: int = 0) -> NDArray[np.float64]:
    """Return the size at each point [n]: the mean over its elements of the edge length of an ideal element as large.

    Args:
        points: as for Plan
        cells: as for Plan
        threads: as for Plan
    """
    return _targets.sizes_of(view_of(Source(points, cells), Holding(regions=None), threads))


def size_quality(points: Any, cells: Any = None, *, size: Any, start: Any = None, per_element: bool = False,
                 threads: int = 0) -> SizeQuality:
    """Return measures of the sizes of elements against the wanted sizes.

    Args:
        points: as for Plan
        cells: as for Plan
        size: sizes or metrics, as for Plan
        start: points [n, 2 or 3] where size was given; None: points
        per_element: measure each element, too; the result then has ratio [m]
        threads: as for Plan
    """
    view, found = view_of(Source(points, cells), Holding(regions=None), threads), SizeQuality()
    _take_size(view, size, start)
    ratio = np.zeros(view.mesh.n_elements) if per_element else None
    call(library.planish_measure_sizes, byref(view.mesh), threads_to_use(threads), byref(found), pointer(ratio))
    found.ratio = ratio
    return found


def find_layers(points: Any, cells: Any = None, *, threads: int = 0) -> NDArray[np.bool_]:
    """Return a mask [m] of the elements that are thin in layers, such as a boundary layer.

    Args:
        points: as for Plan
        cells: as for Plan
        threads: as for Plan
    """
    return _layers.layers_of(view_of(Source(points, cells), Holding(regions=None), threads))


def layer_heights(points: Any, cells: Any = None, *, start: Any = None, per_node: bool = False,
                  threads: int = 0) -> LayerHeights:
    """Return the heights of layers, in parts of the heights that are wanted.

    Args:
        points: as for Plan
        cells: as for Plan
        start: points [n, 2 or 3], a mesh or a path with the same elements, with the layers and heights that are wanted.
            Where a wall has moved there, the rows inside tell the heights. None: points
        per_node: measure at each node, too; the result then has off [n]
        threads: as for Plan
    """
    view, found = view_of(Source(points, cells), Holding(regions=None), threads), LayerHeights()
    places = view.mesh.coordinates
    if start is not None:
        view.move_to(opened(start), "start")
    view.give("is_layer", _layers.layers_of(view).astype(np.uint8))
    view.mesh.reference, view.mesh.coordinates = view.mesh.coordinates, places
    off = np.zeros(view.n) if per_node else None
    call(library.planish_measure_layers, byref(view.mesh), threads_to_use(threads), byref(found), pointer(off))
    found.off = off
    return found


def checksum(points: Any, cells: Any = None) -> int:
    """Return a checksum of the coordinates: equal for equal bits.

    Args:
        points: as for Plan
        cells: as for Plan
    """
    view = view_of(Source(points, cells), Holding(regions=None), 1)
    return int(library.planish_checksum(byref(view.mesh)))
