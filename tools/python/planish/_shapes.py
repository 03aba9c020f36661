"""Shapes: the original curved surfaces, on which nodes slide."""

from __future__ import annotations

from ctypes import byref, c_void_p
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Points, address
from ._library import call, library, threads_to_use
from ._regions import BY_RULE
from ._results import ShapeDistance, ShapeInfo
from ._structures import MeshView
from ._view import View
from ._views import Source, view_of_shape


class Handle:
    """The library's planish_shape, which is destroyed with its last user: plans and runs keep it while they need it."""

    def __init__(self) -> None:
        """Make room for a pointer."""
        self.pointer = c_void_p()

    def __del__(self) -> None:
        """Release the memory of the shape."""
        if self.pointer:
            library.planish_shape_destroy(self.pointer)


class Shape:
    """The original surface of a mesh: patches, curves between them, and corners (docs/surfaces.md).

    The mesh has solids, or triangles and quadrilaterals in space. The shape keeps its own copy of the points, so that
    many runs can use it without drift. Facets and edges among the cells are tags: the surface has an edge where tags
    change. info is a ShapeInfo. Close a shape, or use it in a with statement.
    """

    def __init__(self, points: Any, cells: Any = None, *, regions: Any = BY_RULE, crease_angle: float = 0,
                 threads: int = 0) -> None:
        """Make the shape of a mesh.

        Args:
            points: coordinates [n, 3], or a mesh, as for Plan
            cells: as for Plan
            regions: as for Plan; the surface has the facets between regions
            crease_angle: angle in degrees. Facets that turn by more have an edge between them; others have none, but
                where tags change. 0: planish finds the edges
            threads: as for Plan
        """
        self._make(view_of_shape(Source(points, cells), regions, threads), crease_angle, threads)

    @classmethod
    def of_view(cls, view: View, crease_angle: float, threads: int) -> Shape:
        """Return the shape of a view."""
        made = cls.__new__(cls)
        made._make(view, crease_angle, threads)
        return made

    def _make(self, view: View, crease_angle: float, threads: int) -> None:
        self._handle: Optional[Handle] = Handle()
        self._threads = threads
        self.info = ShapeInfo()
        self._n = view.n
        surface = view.surface()
        surface.crease_angle = crease_angle
        call(library.planish_shape_create, byref(view.mesh), byref(surface), threads_to_use(threads),
             byref(self._handle.pointer), byref(self.info))

    def handle(self) -> Handle:
        """Return what keeps the library's planish_shape as long as it is kept itself."""
        if self._handle is None:
            raise ValueError("the shape is closed")
        return self._handle

    def pointer(self) -> c_void_p:
        """Return the library's planish_shape."""
        return self.handle().pointer

    def classes(self) -> NDArray[np.uint8]:
        """Return the class [n] of each node: 0 not on the surface, 1 on a patch, 2 on a curve, 3 a corner."""
        found = np.zeros(self._n, dtype=np.uint8)
        library.planish_shape_get_classes(self.pointer(), address(found))
        return found

    def distance(self, points: Any) -> ShapeDistance:
        """Return the largest distance of the surface from this shape, and back, proved for every point.

        Args:
            points: present coordinates [n, 3] of all nodes, or the mesh
        """
        taken, found = Points(getattr(points, "points", points), 3), ShapeDistance()
        mesh = MeshView(dim=3, n_nodes=len(taken.array), coordinates=address(taken.array),
                        node_stride=taken.strides[0], component_stride=taken.strides[1])
        call(library.planish_shape_measure, self.pointer(), byref(mesh), threads_to_use(self._threads), byref(found))
        return found

    def close(self) -> None:
        """Release the memory of the shape, once nothing uses it any more. Plans cannot slide on it afterwards."""
        self._handle = None

    def __reduce__(self) -> Any:
        """Raise TypeError: a shape cannot be copied or pickled."""
        raise TypeError("a shape can be neither copied nor pickled; make another one")

    def __enter__(self) -> Shape:
        """Return the shape."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the shape."""
        self.close()


def shape_for(source: Source, given: Any, regions: Any, crease_angle: float, threads: int) -> Shape:
    """Return the shape for the option surface_of: a given Shape, or that of the mesh with its points at given.

    given None: the present points.
    """
    if isinstance(given, Shape):
        return given
    view = view_of_shape(source, regions, threads)
    if given is not None:
        view.move_to(given, "surface_of")
    return Shape.of_view(view, crease_angle, threads)
