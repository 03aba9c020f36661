"""Mesh files as the library sees them: what the program does with a file, in its order."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_double, c_int64, c_void_p
from typing import Any, Mapping, NamedTuple, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _files
from ._arrays import Array, Points, pointer
from ._cell_types import CORNERS, WIDTHS
from ._elements import Layout
from ._files import Mesh
from ._io import hold_of, io, texts_of
from ._io_structures import Plane
from ._library import call
from ._node_sizes import metrics_at_nodes, sizes_at_nodes
from ._results import SlideInfo
from ._structures import MeshView, Options, Surface
from ._view import View

_FREE, _FIXED, _ON_LINE, _ON_CURVE = 0, 1, 3, 6  # planish_constraint
_ROUNDED = 2  # planish_precision
_PLACES_OF_SURFACE = 1 | 2 | 4  # planish_file_reason: lines and points, faces, interfaces
_ROUND = ctypes.CFUNCTYPE(c_double, c_double, c_void_p)

# Rounding in a field that is wide, and tolerance of a narrow one, of the diagonal.
_WIDE_FIELD, _OF_NARROW_FIELD = 1e-8, 1e-5
OF_OFF = 4  # distance from the middle, in those that rounding takes nodes off a plane


class FileHolding(NamedTuple):
    """Choice of the nodes of a file to hold."""

    groups: Sequence[str] = ()
    nodes: Optional[Array] = None
    ignores_regions: bool = False
    slides: bool = False
    slide_groups: Sequence[str] = ()


class FileView(View):
    """The mesh of a file."""

    def __init__(self, source: Mesh, holding: FileHolding, threads: int) -> None:
        """Take a mesh that was read."""
        self.source = source
        self.holding = holding
        super().__init__(source.points, source.elements(), source.dim, threads)
        self.region_arrays = [] if holding.ignores_regions else source.region_arrays
        self.constrain(self._held(holding.slides), None)

    def _new_mesh(self) -> MeshView:
        """Return the file's structure."""
        made = MeshView.from_buffer_copy(self.source.structure)
        made.node_stride, made.component_stride = self.points.strides
        return made

    def own_elements(self) -> None:
        """Do nothing: nobody changes the file's arrays."""

    def prepare_targets(self) -> None:
        """Give elements as cells, as the program does."""
        super().prepare_targets()
        self.give_elements(as_cells=True)

    def places_of(self, other: Any) -> Any:
        """Return the coordinates of the same mesh in another file, in the plane of this one."""
        if not isinstance(other, Mesh):
            return super().places_of(other)
        _check_same(self.source, other)
        if self.dim == 2 and not _are_in_same_plane(self.source.plane(), other.plane()):
            return facing_alike(self.source.layout(), self.source.points, other.points)
        return other.points

    def _hold(self, slides: bool, ignores_marks: bool = False) -> tuple[Any, Any]:
        """Return the planish_hold, and the arrays that it points to, for the caller to keep alive."""
        groups = self.holding.slide_groups
        texts = texts_of(groups)
        hold, kept = hold_of(self.holding.groups, ignore_regions=self.holding.ignores_regions, slide=slides,
                                    ignore_marked=ignores_marks, slide_tags=ctypes.addressof(texts),
                                    n_slide_tags=len(groups))
        return hold, (texts, kept)

    def _held(self, slides: bool, ignores_marks: bool = False) -> NDArray[np.uint8]:
        """Return the constraints of the file, and of the caller."""
        constraint = np.zeros(self.n, dtype=np.uint8)
        hold, _kept = self._hold(slides, ignores_marks)
        call(io("constraints"), self.source.handle.file, byref(hold), pointer(constraint))
        if self.holding.nodes is not None:
            constraint[self.holding.nodes] = _FIXED
        return constraint

    def surface(self) -> Surface:
        """Return the file's surface."""
        hold, kept = self._hold(True)
        self._kept["hold"] = hold, kept
        found: Surface = io("surface")(self.source.handle.file, byref(hold))
        return found

    # ---- numbers of the file ------------------------------------------------------------------------------

    def rounding(self, wanted: Optional[float]) -> float:
        """Return how far a straight edge's mid may be off the middle. wanted None: as the file's digits explain."""
        if wanted is not None or self.mesh.elements:
            return wanted or 0.0
        extents = np.ptp(self.points.array, axis=0) if self.n else np.zeros(self.dim)
        size = float(np.sqrt(sum(float(extent) * float(extent) for extent in extents)))
        surface: Surface = io("surface")(self.source.handle.file, None)
        tolerance = max(surface.tolerance, _OF_NARROW_FIELD) if self._is_narrow(size) else surface.tolerance
        plane = self.source.plane()
        off = OF_OFF * plane.off if plane is not None and self.dim == 2 and plane.is_tilted else 0.0
        rounding = max(tolerance * size, off)
        return rounding if np.isfinite(rounding) else 0.0

    def _is_narrow(self, size: float) -> bool:
        """Whether the file stores some numbers with fewer digits than others."""
        info, third = self.source.info, size / 3
        if info.precision != _ROUNDED or not info.round:
            return False
        return bool(abs(_ROUND(info.round)(third, info.round_user) - third) > _WIDE_FIELD * size)

    def set_storage(self, options: Options, taken: Points) -> None:
        """Set in options how the file stores coordinates."""
        info = self.source.info
        options.precision, options.round, options.round_user = info.precision, info.round, info.round_user

    @property
    def is_tilted(self) -> bool:  # type: ignore[override]
        """Whether the plane of the mesh is a tilted one."""
        plane = self.source.plane()
        return plane is not None and bool(plane.is_tilted)

    def round_in_plane(self, back: NDArray[np.uint8]) -> int:
        """Round coordinates in a tilted plane to the file's digits. Return the number of nodes that go back."""
        n = c_int64(0)
        call(io("round_in_plane"), self.source.handle.file, pointer(self.source.points), pointer(back), byref(n))
        return n.value

    def box(self, numbers: Array) -> tuple[Array, Array]:
        """Return the corners of a box in the file's axes, in their order."""
        low, high = super().box(numbers)
        plane = self.source.plane()
        if plane is not None and plane.is_tilted:
            raise ValueError("box follows the axes of the file, but the triangles are in a tilted plane; hold nodes "
                             "by fix, or rotate the mesh")
        is_turned = plane is not None and self.dim == 2 and plane.axis[0] > plane.axis[1]
        return (low[::-1], high[::-1]) if is_turned else (low, high)

    def name_min_volumes(self, volumes: Mapping[str, float]) -> NDArray[np.float64]:
        """Return the minimum volumes [m] of groups."""
        return _files.min_volumes(self.source, volumes)

    def named_size(self, name: str) -> Array:
        """Return the sizes or metrics of an array of the file, at the nodes."""
        values, of_elements = self.source.data(name)
        return self._at_nodes(values, of_elements, False)

    def sizes_from(self, path: Any) -> Array:
        """Return the sizes or metrics of a solution file."""
        return self._at_nodes(_files.read_sizes(self.source, path), False, True)

    def _at_nodes(self, values: Array, of_elements: bool, is_solution: bool) -> Array:
        layout = self.source.layout()
        if values.shape[1] == 1:
            return sizes_at_nodes(values[:, 0], layout, of_elements, self.n)
        plane = self.source.plane()
        is_turned = plane is not None and self.dim == 2
        frame = np.array([list(row) for row in plane.direction]) if is_turned else None  # type: ignore[union-attr]
        return metrics_at_nodes(values, layout, of_elements, self.n, self.dim, is_solution, frame)

    # ---- nodes that slide ---------------------------------------------------------------------------------

    def find_slides(self, surface: Surface) -> SlideInfo:
        """Find the nodes that slide. The marks of the file hold nodes, unless they mark the whole surface."""
        if self.has_marks():
            info = self._find_unheld(surface, True)
            if self._marks_are_the_surface():
                return info
        return self._find_unheld(surface, False)

    def _find_unheld(self, surface: Surface, ignores_marks: bool) -> SlideInfo:
        """Find the nodes that slide, among those that nothing holds."""
        self.constrain(self._held(True, ignores_marks), None)
        info, constraint, direction = self.slides_by(surface)
        self.constrain(constraint, direction)
        return info

    def _marks_are_the_surface(self) -> bool:
        """Whether the file marks all nodes of the surface. Such marks say where the surface is, and hold none.

        Nodes inside that are marked are fixed then.
        """
        constraint, marked = self.constraint, np.zeros(self.n, dtype=np.uint8)
        io("get_marked")(self.source.handle.file, pointer(marked))
        assert constraint is not None
        if (constraint[marked == 0] != _FREE).any():
            return False
        self.fix((marked != 0) & (constraint == _FREE))
        return True

    def hold_on_surface(self, holds_curves: bool) -> None:
        """Fix the nodes of a surface in space that are on curves, if asked, and those of elements of order 2."""
        layout, constraint = self.source.layout(), self.constraint
        assert constraint is not None
        if holds_curves:
            self.fix(np.isin(constraint, (_ON_LINE, _ON_CURVE)))
        is_second = WIDTHS[layout.types] > CORNERS[layout.types]
        nodes = layout.nodes[np.repeat(is_second, np.diff(layout.offsets))]
        self.fix(nodes[nodes >= 0])

    def has_marks(self) -> bool:
        """Whether the file marks nodes as fixed."""
        return bool(io("get_marked")(self.source.handle.file, None) > 0)

    def hold_for_onto(self, ignores_marks: bool) -> None:
        """Release the nodes that only lines, facets and interfaces hold: the fit decides on them."""
        hold, _kept = self._hold(False, ignores_marks)
        reason = np.zeros(self.n, dtype=np.uint8)
        call(io("get_held"), self.source.handle.file, byref(hold), pointer(reason))
        constraint = (reason & ~np.uint8(_PLACES_OF_SURFACE) != 0).astype(np.uint8)
        self.constrain(constraint, None)
        for more in (self.holding.nodes, self.layer_nodes):
            if more is not None:
                self.fix(more)


# ---- the same mesh in another file --------------------------------------------------------------------


def _check_same(mine: Mesh, other: Mesh) -> None:
    """Raise ValueError if the mesh of another file differs in more than coordinates."""
    a, b = mine.layout(), other.layout()
    if mine.dim != other.dim or len(mine.points) != len(other.points) or len(a.types) != len(b.types):
        raise ValueError(f"{other!r} has other nodes or elements than {mine!r}; give the same mesh")
    is_same = np.array_equal(a.types, b.types) and np.array_equal(a.offsets, b.offsets)
    if not is_same or not np.array_equal(a.nodes, b.nodes):
        raise ValueError(f"elements of {other!r} differ from those of {mine!r}; give the same mesh")


def _are_in_same_plane(a: Optional[Plane], b: Optional[Plane]) -> bool:
    """Whether flat meshes lie in planes whose coordinates go along the same axes."""
    axes = [(0, 1, 2) if plane is None else tuple(plane.axis) for plane in (a, b)]
    return axes[0] == axes[1] and not any(plane is not None and plane.is_tilted for plane in (a, b))


def _areas(layout: Layout, x: Array) -> Array:
    """Return twice the areas of the first corners of flat elements."""
    first = layout.offsets[:-1]
    last = np.where(CORNERS[layout.types] == 3, 2, 3)
    a, b, c = x[layout.nodes[first]], x[layout.nodes[first + 1]], x[layout.nodes[first + last]]
    areas: Array = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return areas


def facing_alike(layout: Layout, mine: Array, other: Array) -> Array:
    """Return other coordinates [n, 2] of flat elements, mirrored if most of these show their backs there."""
    is_alike = (_areas(layout, mine) > 0) == (_areas(layout, other) > 0)
    return other * ((1, 1) if 2 * is_alike.sum() >= len(is_alike) else (1, -1))


def view_in_space(source: Mesh, threads: int) -> View:
    """Return a view of a mesh of flat elements with its points in space."""
    return View(source.space_points(), source.elements(), 3, threads)
