"""Views of the meshes that callers give."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple, Optional, Sequence

import numpy as np

from ._arrays import chosen_nodes, is_in_space
from ._blocks import is_by_type
from ._elements import Elements, elements_of
from ._file_view import FileHolding, FileView, view_in_space
from ._files import Mesh
from ._groups import data_of_points, names_in, nodes_to_fix
from ._plane_views import view_in_plane
from ._planes import Plane, find_plane
from ._regions import BY_RULE, names_of, take_regions
from ._view import View


class Source:
    """A mesh as callers give it: points and cells, or a whole mesh and None."""

    def __init__(self, points: Any, cells: Any) -> None:
        """Take a mesh."""
        self.points = points
        self.cells = cells

    @functools.cached_property
    def elements(self) -> Elements:
        """Elements of a mesh that is not of a file."""
        return elements_of(self.points, self.cells)

    @property
    def array(self) -> Any:
        """Coordinates of the points."""
        return self.points if self.cells is not None else getattr(self.points, "points", self.points)

    @functools.cached_property
    def has_flat_elements_in_space(self) -> bool:
        """Whether this is no file, and flat elements have points in no plane of constant z."""
        points, cells = self.array, self.cells
        if isinstance(self.points, Mesh) or not isinstance(points, np.ndarray) or not is_in_space(points):
            return False
        if cells is not None and not is_by_type(cells) and np.ndim(cells) == 2 and np.shape(cells)[1] != 3:
            return False  # as quickly as that, as most are tetrahedra
        return self.elements.dim == 2

    @functools.cached_property
    def plane(self) -> Optional[Plane]:
        """Plane of flat elements whose points are in space; None: they lie in none, or in one of constant z."""
        return find_plane(self.array, self.elements) if self.has_flat_elements_in_space else None


class Holding(NamedTuple):
    """Options that hold nodes."""

    fix: Any = None
    regions: Any = BY_RULE
    slides: bool = False  # tags and regions of the surface hold none: it is to be found which of them slide
    slide_groups: Sequence[str] = ()


def _hold(view: View, source: Source, holding: Holding) -> None:
    """Fix the nodes that other cells, the caller and regions hold."""
    held = view.elements.held(view.n, holding.slides)
    if held is not None and held.any():
        view.fix(held != 0)
    if holding.fix is not None:
        view.fix(nodes_to_fix(source.points, holding.fix, view.n))


def _of_elements(source: Source, elements: Elements, holding: Holding, threads: int) -> View:
    """Return the view of solid elements, or of flat ones in a plane."""
    if holding.slide_groups:
        raise ValueError(f"slide must be auto, curved, none or None, not {', '.join(holding.slide_groups)}: groups are "
                         "for meshes of planish.read")
    view = (View(source.array, elements, elements.dim, threads) if source.plane is None
            else view_in_plane(source.array, elements, source.plane, threads))
    view.point_data = data_of_points(source.points)
    _hold(view, source, holding)
    take_regions(view, holding.regions, not holding.slides)
    return view


def _of_file(mesh: Mesh, holding: Holding, threads: int) -> FileView:
    """Return the view of a mesh of a file."""
    groups, regions = names_in(holding.fix), holding.regions
    nodes = None if holding.fix is None or groups else chosen_nodes(holding.fix, len(mesh.points), "fix")
    if regions is not None and regions is not BY_RULE:
        names = names_of(regions)
        if names is None:
            raise ValueError("regions must be names of arrays of the file, or None")
        mesh.choose_regions(names)
    return FileView(mesh, FileHolding(groups, nodes, regions is None, holding.slides, holding.slide_groups), threads)


def view_of(source: Source, holding: Holding, threads: int) -> View:
    """Return the view of a mesh."""
    if isinstance(source.points, Mesh):
        if source.points.is_in_space:
            raise ValueError(f"{source.points.path} is a surface in space, which smooth and quality take")
        return _of_file(source.points, holding, threads)
    return _of_elements(source, source.elements, holding, threads)


def surface_in_space(source: Source, holding: Holding, threads: int) -> Optional[View]:
    """Return the view of a surface in space: flat elements in no common plane. None: the mesh is another one."""
    if isinstance(source.points, Mesh):
        return _of_file(source.points, holding, threads) if source.points.is_in_space else None
    if not source.has_flat_elements_in_space or source.plane is not None:
        return None
    view = View(source.array, source.elements, 3, threads)
    view.fix(np.zeros(0, dtype=np.int64))
    _hold(view, source, Holding(holding.fix))
    take_regions(view, holding.regions, False)
    return view


def view_of_shape(source: Source, regions: Any, threads: int) -> View:
    """Return the view of solids, or of a surface in space, to make a shape of."""
    if isinstance(source.points, Mesh):
        mesh = source.points
        return view_in_space(mesh, threads) if mesh.dim == 2 else _of_file(mesh, Holding(None, regions, True), threads)
    elements, points = source.elements, source.array
    if elements.dim == 2 and np.ndim(points) == 2 and np.shape(points)[1] >= 3:
        view = View(points, elements, 3, threads)
        take_regions(view, regions, False)
        return view
    return _of_elements(source, elements, Holding(None, regions, True), threads)
