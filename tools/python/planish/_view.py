"""Views: a planish_mesh, and the arrays that it points to."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_double
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, Points, address, pointer
from ._elements import Elements
from ._library import call, library, threads_to_use
from ._results import CellQuality, SlideInfo
from ._structures import CellValueArrays, MeshView, Options, Surface

_DOUBLES, _FLOATS = 0, 1  # planish_precision
_FIXED = 1  # planish_constraint


class View:
    """A mesh of arrays, or of a file (a subclass).

    has_own_axes: coordinates are not the first columns of the points. is_tilted: they are of a frame, and the library
    cannot round them as the points are stored. is_for_one_run: finish has to follow each run.
    """

    has_own_axes = False
    is_tilted = False
    is_for_one_run = False

    def __init__(self, given: Any, elements: Elements, dim: int, threads: int) -> None:
        """Take points [n, dim or more]; dim is 3 for flat elements in space."""
        self.given = given
        self.elements = elements
        self.dim = dim
        self.threads = threads
        self.n = len(given) if hasattr(given, "__len__") else 0
        self.points = Points(given, dim)
        self.constraint: Optional[NDArray[np.uint8]] = None
        self.direction: Optional[NDArray[np.float64]] = None
        self.layer_nodes: Optional[NDArray[np.bool_]] = None  # held as those of layers
        self.is_layer: Optional[NDArray[np.bool_]] = None  # mask of the elements that keep their heights
        self.region: Optional[NDArray[np.int32]] = None
        self.region_arrays: list[str] = []
        self.has_targets = False
        self.point_data: dict[str, Any] = {}
        self._kept: dict[str, Any] = {}  # what mesh points to
        self.mesh = self._new_mesh()
        self.give_elements(as_cells=dim > elements.dim)

    def _new_mesh(self) -> MeshView:
        """Return the structure, without elements."""
        return MeshView(dim=self.dim, n_nodes=self.n, n_elements=self.elements.n,
                        coordinates=address(self.points.array), node_stride=self.points.strides[0],
                        component_stride=self.points.strides[1])

    # ---- arrays of the structure --------------------------------------------------------------------

    def give(self, field: str, array: Optional[Array]) -> None:
        """Point a field of mesh to an array, which the view keeps alive."""
        self._kept[field] = array
        setattr(self.mesh, field, address(array))

    def give_elements(self, as_cells: bool = False) -> None:
        """Set the elements of mesh: an array of simplices of one type, or a planish_cells of others or if as_cells."""
        simple = None if as_cells else self.elements.simple
        is_wide = simple is not None and simple.dtype == np.int64
        self.give("elements64", simple if is_wide else None)
        self.give("elements", None if is_wide else simple)
        self.mesh.cells = None
        if simple is None:
            layout = self.elements.as_layout()
            self._kept["cells"] = layout, layout.structure()
            self.mesh.cells = ctypes.addressof(self._kept["cells"][1])

    def own_elements(self) -> None:
        """Copy elements of 32 bits, so that callers cannot change them. The library copies those of 64 bits."""
        if self._kept.get("elements") is not None:
            self.give("elements", self._kept["elements"].copy())

    def fix(self, nodes: Array) -> None:
        """Fix nodes, by their numbers or a mask."""
        if self.constraint is None:
            self.constraint = np.zeros(self.n, dtype=np.uint8)
        self.constraint[nodes] = _FIXED
        self.give("constraint", self.constraint)

    def constrain(self, constraint: Optional[NDArray[np.uint8]], direction: Optional[NDArray[np.float64]]) -> None:
        """Set the constraints of nodes, and the directions of those that slide."""
        self.constraint, self.direction = constraint, direction
        self.give("constraint", constraint)
        self.give("direction", direction)

    # ---- what differs for files -----------------------------------------------------------------------

    def surface(self) -> Surface:
        """Return the planish_surface: regions, tagged facets and edges."""
        found = Surface(region=address(self.region))
        if self.dim > self.elements.dim:
            return found
        facets, edges = self.elements.tagged("facets"), self.elements.tagged("edges")
        self._kept["surface"] = facets, edges
        if facets:
            found.n_facets, found.facets, found.facet_tag = (
                len(facets.tags), address(facets.nodes), address(facets.tags))
            found.facet_offset = address(facets.offsets)
        if edges:
            found.n_edges, found.edges, found.edge_tag = len(edges.tags), address(edges.nodes), address(edges.tags)
        return found

    def rounding(self, wanted: Optional[float]) -> float:
        """Return how far a straight edge's mid may be off the middle. wanted None: what floats leave, as in files."""
        if wanted is not None or not self.points.is_float or not self.n:
            return wanted or 0.0
        return self.rounding_of_floats(self.points.array)

    @staticmethod
    def rounding_of_floats(at: Array) -> float:
        """Return how far floats at places [n, dim] may be off."""
        return max(1e-6 * float(np.linalg.norm(np.ptp(at, axis=0))), 2.0**-22 * float(np.abs(at).max()))

    def set_storage(self, options: Options, taken: Points) -> None:
        """Set in options the type in which coordinates are stored in the end."""
        options.precision = _FLOATS if taken.is_float else _DOUBLES

    def in_plane(self, points: Any) -> Any:
        """Return the coordinates of other points of the mesh."""
        return points

    def shown(self, found: Array) -> Array:
        """Return the points for coordinates [n, dim], as callers have them."""
        return np.ascontiguousarray(found)

    def check_writable(self) -> None:
        """Raise ValueError if finish could not write."""

    def finish(self) -> None:
        """Set the caller's points, if they are others than those that were smoothed."""

    def round_in_plane(self, _back: NDArray[np.uint8]) -> int:
        """Round coordinates in a tilted plane to what the points hold. Return the number of nodes that go back."""
        return 0

    def box(self, numbers: Array) -> tuple[Array, Array]:
        """Return the lower and upper corner [dim] of a box of 2 dim numbers."""
        if numbers.size != 2 * self.dim:
            raise ValueError(f"box has {numbers.size} numbers, but a mesh of {self.dim} dimensions needs {2 * self.dim}")
        return numbers[:self.dim], numbers[self.dim:]

    def prepare_targets(self) -> None:
        """Note that elements get targets."""
        self.has_targets = True

    def places_of(self, other: Any) -> Any:
        """Return the coordinates of points, or of a mesh of the same elements."""
        return getattr(other, "points", other)

    def named_size(self, name: str) -> Array:
        """Return the sizes or metrics of an array of points of the mesh."""
        if name not in self.point_data:
            raise ValueError(f"size: the mesh has no array of points {name!r}; it has: "
                             + (", ".join(self.point_data) or "none"))
        return np.asarray(self.point_data[name])

    def sizes_from(self, path: Any) -> Array:
        """Return the sizes or metrics of a solution file."""
        raise ValueError(f"size_from is for meshes of planish.read; give the values of {path} as size")

    def name_min_volumes(self, volumes: Any) -> NDArray[np.float64]:
        """Return the minimum volumes [m] of groups by their names."""
        raise ValueError("min_volume by groups is for meshes of planish.read; give one value for each element")

    def find_slides(self, surface: Surface) -> SlideInfo:
        """Find which nodes slide."""
        info, constraint, direction = self.slides_by(surface)
        self.constrain(constraint, direction)
        return info

    def has_marks(self) -> bool:
        """Whether a file marks nodes as fixed, perhaps only to say where the surface is."""
        return False

    def hold_for_onto(self, ignores_marks: bool) -> None:
        """Release the nodes that only lines, facets and interfaces hold: the fit decides on them."""

    def hold_on_surface(self, holds_curves: bool) -> None:
        """Fix further nodes of a surface in space."""

    # ---- what follows from the mesh --------------------------------------------------------------------

    def slides_by(self, surface: Surface) -> tuple[SlideInfo, NDArray[np.uint8], NDArray[np.float64]]:
        """Return counts, constraint [n] and direction [n, dim] of the nodes that slide with the present constraints."""
        info, constraint = SlideInfo(), np.zeros(self.n, dtype=np.uint8)
        direction = np.zeros((self.n, self.dim))
        call(library.planish_find_slides, byref(self.mesh), byref(surface), threads_to_use(self.threads),
             pointer(constraint), pointer(direction), byref(info))
        return info, constraint, direction

    def mesh_now(self) -> MeshView:
        """Return the structure with the coordinates of the points as they are now, until the next call."""
        self._now = Points(self.given, self.dim, self.points.strides)
        mesh = MeshView.from_buffer_copy(self.mesh)
        mesh.coordinates = address(self._now.array)
        return mesh

    def states(self) -> NDArray[np.uint8]:
        """Return the planish_cell_state of each element as points are now."""
        state = np.zeros(self.mesh.n_elements, dtype=np.uint8)
        call(library.planish_measure_cells, byref(self.mesh_now()), c_double(self.rounding(None)),
             threads_to_use(self.threads), byref(CellQuality()), byref(CellValueArrays(state=address(state))))
        return state

    def has_types(self) -> bool:
        """Whether ratios are aspect ratios, by the types of the elements or against targets."""
        return self.elements.has_types() or bool(self.mesh.reference)

    def move_to(self, places: Any, what: str) -> None:
        """Set the coordinates of mesh to other places. what: the argument, for messages."""
        points = self.places_of(places)
        if np.shape(points)[:1] != (self.n,):
            raise ValueError(f"{what} must have a row for each of {self.n} points, not the shape {np.shape(points)}")
        self._moved = Points(points, self.dim, self.points.strides, name=what)
        self.mesh.coordinates = address(self._moved.array)
