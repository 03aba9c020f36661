"""Views of flat elements with points in space, in a plane that is not one of constant z."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, Points, is_in_space
from ._elements import Elements
from ._file_view import OF_OFF, facing_alike
from ._files import Mesh
from ._planes import TOLERANCE_OF_FLOATS, Plane, Rounding, find_plane
from ._structures import Options, Surface
from ._view import View

_DOUBLES = 0  # planish_precision


class PlaneView(View):
    """Elements in a plane of constant x or y. Coordinates are two columns of the points, in place."""

    has_own_axes = True

    def __init__(self, in_space: Array, elements: Elements, plane: Plane, threads: int) -> None:
        """Take points [n, 3 or more] in a plane."""
        Points(in_space, 3)  # which refuses what are no points
        self.in_space = in_space
        self.plane = plane
        super().__init__(self._given(elements), elements, 2, threads)

    def _given(self, _elements: Elements) -> Array:
        """Return the coordinates [n, 2] to smooth."""
        return self.plane.columns(self.in_space)

    def surface(self) -> Surface:
        """Return the planish_surface, with the tolerance that files of floats have."""
        found = super().surface()
        if self.in_space.dtype.itemsize == 4:
            found.tolerance = TOLERANCE_OF_FLOATS
        return found

    def in_plane(self, points: Any) -> Any:
        """Return the coordinates of other points of the mesh."""
        if points is self.given or np.ndim(points) != 2:
            return points
        if points.shape[1] < 3:
            raise ValueError(f"points has {points.shape[1]} columns, but those of the plan are in space")
        if is_in_space(points[:, list(self.plane.axis)]):
            raise ValueError("points have left the plane of those that the plan was made for; make another plan")
        return self.plane.columns(points)

    def shown(self, found: Array) -> Array:
        """Return the points in space for coordinates."""
        points = self.in_space[:, :3].astype(np.float64)
        points[:, list(self.plane.axis[:2])] = found
        return points

    def box(self, numbers: Array) -> tuple[Array, Array]:
        """Return the corners of a box in the axes of space, in their order."""
        low, high = super().box(numbers)
        return (low[::-1], high[::-1]) if self.plane.axis[0] > self.plane.axis[1] else (low, high)

    def places_of(self, other: Any) -> Any:
        """Return the coordinates of the same mesh elsewhere, in its plane, seen from the side that shows here."""
        is_flat_file = isinstance(other, Mesh) and other.dim == 2
        points = other.space_points() if is_flat_file else getattr(other, "points", other)
        if not isinstance(points, np.ndarray) or points.ndim != 2 or len(points) != self.n:
            return points  # for which others have a message
        if points.shape[1] < 3:
            raise ValueError(f"the points of the mesh are in space, but those to compare it with have {points.shape[1]} "
                             "columns; give 3")
        plane = find_plane(points, self.elements)
        if plane is None:
            raise ValueError("the mesh lies in a plane, but the points to compare it with lie in none")
        found = plane.project(points) if plane.is_tilted else plane.columns(points)
        if plane.axis == self.plane.axis and not plane.is_tilted and not self.is_tilted:
            return found
        return facing_alike(self.elements.as_layout(), self.given, found)


class TiltedView(PlaneView):
    """Elements in a tilted plane. Coordinates are those of a frame in it; finish moves the points in space."""

    is_tilted = True
    is_for_one_run = True

    def _given(self, elements: Elements) -> Array:
        """Return the coordinates [n, 2] to smooth."""
        self._rounding = Rounding(self.plane, self.in_space, elements)
        return self._rounding.before.copy()

    def shown(self, found: Array) -> Array:
        """Return the points in space for coordinates."""
        return self._rounding.places(found).astype(np.float64)

    def round_in_plane(self, back: NDArray[np.uint8]) -> int:
        """Round coordinates to what the points hold. Return the number of nodes that go back, also those in back [n]."""
        return self._rounding.round(self.given, back)

    def check_writable(self) -> None:
        """Raise ValueError if the points in space are read-only."""
        Points(self.in_space, 3, writes=True)

    def finish(self) -> None:
        """Set the points in space of the nodes that have moved."""
        moved = self._rounding.has_moved(self.given)
        if moved.any():
            self.in_space[moved, :3] = self._rounding.places(self.given)[moved]

    def rounding(self, wanted: Any) -> float:
        """Return how far a straight edge's mid may be off the middle. wanted None: what the points hold."""
        if wanted is not None or self.elements.layout is None:
            return wanted or 0.0
        usual = View.rounding_of_floats(self.in_space[:, :3]) if self.in_space.dtype.itemsize == 4 else 0.0
        return max(usual, OF_OFF * self.plane.off)

    def set_storage(self, options: Options, taken: Points) -> None:
        """Leave rounding to round_in_plane, as in files."""
        options.precision = _DOUBLES

    def box(self, numbers: Array) -> tuple[Array, Array]:
        """Raise ValueError: a box follows the axes of space."""
        raise ValueError("box follows the axes of space, but the elements are in a tilted plane; hold nodes by fix, or "
                         "rotate the mesh")


def view_in_plane(points: Array, elements: Elements, plane: Plane, threads: int) -> PlaneView:
    """Return the view of flat elements with points [n, 3 or more] in a plane."""
    return (TiltedView if plane.is_tilted else PlaneView)(points, elements, plane, threads)
