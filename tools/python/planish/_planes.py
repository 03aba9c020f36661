"""Planes of flat elements whose points are in space, found as the program does it for files.

The arithmetic is that of src/io/file/plane_find.c and plane.c, operation by operation, so that coordinates have the
bits that they have in files of doubles.
"""

from __future__ import annotations

import math
import sys
from typing import NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array
from ._cell_types import CORNERS
from ._elements import Elements

_NOISE = 1e-8  # of a constant column, as a part of the longer side
_TOLERANCE, TOLERANCE_OF_FLOATS = 1e-8, 1e-6  # distance from a tilted plane, of the diagonal
_NARROW, _THICK = 1e-12, 30  # of the diagonal; times the distance from the plane: nodes along a line are no wider
_PASSES, _SWEEPS = 3, 30
_AS_NEAR, _NEAR = 1 - 1e-6, 2  # of normals to an axis; of the origin of columns, in diagonals
_ORDER = ((0, 1, 2), (1, 2, 0), (2, 0, 1))  # of axes, the one across last; x and y first

_Rows = list[list[float]]


class Plane(NamedTuple):
    """A plane in space, and the coordinates in it."""

    axis: tuple[int, int, int]  # columns of coordinates 0 and 1, and the one across
    is_tilted: bool = False
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    slope: tuple[float, float] = (0.0, 0.0)
    xu: float = 1.0
    yu: float = 0.0
    yv: float = 1.0
    off: float = 0.0  # largest distance of nodes from it

    def columns(self, points: Array) -> Array:
        """Return the two columns [n, 2] of points that are the coordinates, as a view of points."""
        first, second, _ = self.axis
        return points[:, first:second + 1] if second > first else points[:, 2::-2]

    def project(self, points: Array) -> NDArray[np.float64]:
        """Return the coordinates [n, 2] of points [n, 3] in a tilted plane."""
        x = points[:, self.axis[0]].astype(np.float64) - self.origin[0]
        y = points[:, self.axis[1]].astype(np.float64) - self.origin[1]
        return np.column_stack([self.xu * x + self.yu * y, self.yv * y])

    def places(self, uv: Array, dtype: np.dtype[np.generic]) -> Array:
        """Return the points [n, 3] in space, numbers of a type, at coordinates [n, 2] in a tilted plane."""
        found = np.zeros((len(uv), 3), dtype=dtype)
        first, second, across = self.axis
        y = uv[:, 1] / self.yv
        x = (uv[:, 0] - self.yu * y) / self.xu
        found[:, first], found[:, second] = self.origin[0] + x, self.origin[1] + y
        x, y = found[:, first].astype(np.float64), found[:, second].astype(np.float64)
        up = self.slope[0] * (x - self.origin[0]) + self.slope[1] * (y - self.origin[1])
        found[:, across] = self.origin[2] + up
        return found


# ---- finding it -------------------------------------------------------------------------------------


def _sum(values: Array) -> float:
    """Return the sum in the order of values, as a loop adds them."""
    return float(np.add.accumulate(values)[-1])


def _coordinates(at: Array, frame: _Rows) -> list[Array]:
    """Return the coordinates of places [3, k] in a frame of unit vectors."""
    return [v[0] * at[0] + v[1] * at[1] + v[2] * at[2] for v in frame]


def _mean(at: list[Array]) -> list[float]:
    return [_sum(x) / len(x) for x in at]


def _spread(at: list[Array]) -> _Rows:
    """Return the sums of products of coordinates about their mean."""
    centred = [x - mean for x, mean in zip(at, _mean(at))]
    return [[_sum(a * b) for b in centred] for a in centred]


def _turn(spread: _Rows, frame: _Rows, p: int, q: int) -> None:
    """Turn rows p and q of the frame, and the spread along with it, so that spread[p][q] vanishes."""
    if spread[p][q] == 0:
        return
    theta = (spread[q][q] - spread[p][p]) / (2 * spread[p][q])
    t = (1 if theta >= 0 else -1) / (abs(theta) + math.sqrt(theta * theta + 1))
    c = 1 / math.sqrt(t * t + 1)
    s = t * c
    for row in spread:
        row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
    for rows in spread, frame:
        for i, (a, b) in enumerate(zip(list(rows[p]), list(rows[q]))):
            rows[p][i], rows[q][i] = c * a - s * b, s * a + c * b


def _normal(at: Array) -> tuple[list[float], float]:
    """Return the direction in which places [3, k] spread least, and how wide they do in the next one."""
    frame: _Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    spread = frame
    for _ in range(_PASSES):
        spread = _spread(_coordinates(at, frame))
        for _ in range(_SWEEPS):  # Jacobi's method
            for p, q in (0, 1), (0, 2), (1, 2):
                _turn(spread, frame, p, q)
        for v in frame:
            length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            v[:] = [x / length for x in v]
    order = sorted(range(3), key=lambda i: spread[i][i])
    return frame[order[0]], math.sqrt(max(spread[order[1]][order[1]], 0) / at.shape[1])


def _through_mean(at: Array, n: list[float], middle: Array, size: float) -> Plane:
    """Return the plane with normal n through the mean of places [3, k], which are about middle, in units of size."""
    mean = _mean(list(at))
    most = max(abs(x) for x in n)
    across = 2 if abs(n[2]) >= _AS_NEAR * most else 0 if abs(n[0]) >= _AS_NEAR * most else 1
    axis = ((across + 1) % 3, (across + 2) % 3, across)
    p, q = -n[axis[0]] / n[across], -n[axis[1]] / n[across]
    xu = math.sqrt(1 + p * p)
    # The origin is that of the columns where that is near, so that nothing is rounded.
    origin = [float(middle[i]) if abs(middle[i]) > _NEAR * size else 0.0 for i in axis[:2]]
    from_mean = [(o - float(middle[i])) - size * mean[i] for o, i in zip(origin, axis)]
    up = float(middle[across]) + (size * mean[across] + p * from_mean[0] + q * from_mean[1])
    off = n[0] * (at[0] - mean[0]) + n[1] * (at[1] - mean[1]) + n[2] * (at[2] - mean[2])
    return Plane(axis, True, (origin[0], origin[1], up), (p, q), xu, p * q / xu, math.sqrt((1 + p * p + q * q) / (1 + p * p)),
                 float(np.abs(off).max()) * size)


def _tilted(points: Array, tolerance: float) -> Optional[Plane]:
    """Return the tilted plane that fits points [k, 3] best; None: some are farther off than by tolerance."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle = low + (high - low) / 2
    size = float(np.hypot(np.hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]))
    if not sys.float_info.min <= size <= sys.float_info.max:
        return None
    at = ((points - middle) / size).T
    normal, width = _normal(at)
    plane = _through_mean(at, normal, middle, size)
    if plane.off > tolerance * size:
        return None
    if not (width > _NARROW and width * size > _THICK * plane.off):
        raise ValueError(f"the elements have points in space that all lie near one line (up to {plane.off:.3g} off it): "
                         "planish cannot find their plane")
    return plane


def find_plane(points: Array, elements: Elements) -> Optional[Plane]:
    """Return the plane of flat elements with points [n, 3 or more]; None: they lie in none, or points are no numbers.

    Raise ValueError if the points are near one line.
    """
    nodes = elements.as_layout().nodes
    nodes = nodes[nodes >= 0]  # missing mids
    if not nodes.size or nodes.max() >= len(points):
        return None
    is_used = np.zeros(len(points), dtype=bool)
    is_used[nodes] = True
    used = points[is_used, :3].astype(np.float64)
    if not np.isfinite(used).all():
        return None
    low, high, first = used.min(axis=0), used.max(axis=0), points[nodes[0]]
    for axis in _ORDER:
        most = max(_NOISE * high[i] - _NOISE * low[i] for i in axis[:2])
        level = float(first[axis[2]])
        if abs(low[axis[2]] - level) <= most and abs(high[axis[2]] - level) <= most:
            return Plane(axis)
    return _tilted(used, TOLERANCE_OF_FLOATS if points.dtype.itemsize == 4 else _TOLERANCE)


# ---- signs after smoothing --------------------------------------------------------------------------


def _turns(uv: Array, nodes: Array) -> Array:
    """Return the signs [k] of triangles [k, 3]."""
    a, b, c = (uv[nodes[:, i]] for i in range(3))
    found: Array = np.sign((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    return found


def _corner_triangles(elements: Elements) -> Array:
    """Return the triangles [k, 3] whose signs are looked at: elements, and the corners of quadrilaterals."""
    layout = elements.as_layout()
    first, n = layout.offsets[:-1], CORNERS[layout.types]
    parts = [layout.nodes[first[n == 3][:, None] + np.arange(3)]]
    quads = layout.nodes[first[n == 4][:, None] + np.arange(4)]
    parts += [quads[:, [k, (k + 1) % 4, (k + 3) % 4]] for k in range(4)]
    return np.concatenate(parts)


class Rounding:
    """Coordinates in a tilted plane, to be rounded to what the points in space hold of them."""

    def __init__(self, plane: Plane, points: Array, elements: Elements) -> None:
        """Take the points [n, 3] before smoothing."""
        self.plane, self.points, self.elements = plane, points[:, :3].copy(), elements
        self.before = plane.project(self.points)

    def has_moved(self, uv: Array) -> NDArray[np.bool_]:
        """Return a mask [n] of the nodes that are not where they were."""
        moved: NDArray[np.bool_] = (uv != self.before).any(axis=1)
        return moved

    def places(self, uv: Array) -> Array:
        """Return the points [n, 3] in space: those from before where nodes have not moved."""
        found, moved = self.points.copy(), self.has_moved(uv)
        found[moved] = self.plane.places(uv[moved], self.points.dtype)
        return found

    def round(self, uv: Array, back: NDArray[np.uint8]) -> int:
        """Round coordinates in place. Return the number of nodes that go back.

        back: mask [n] of nodes that go back; those are added with which triangles would have another sign in space
        """
        if self.points.dtype.itemsize == 4:
            self._round(uv)
        triangles, is_back, n = _corner_triangles(self.elements), np.zeros(len(uv), dtype=bool), 0
        signs, going = _turns(uv, triangles), back != 0
        while True:
            n += int((going & self.has_moved(uv)).sum())
            uv[going] = self.before[going]
            is_back |= going
            going = self._harmed(uv, triangles, signs)
            if not going.any():
                break
        back[:] = is_back
        self._follow(uv, is_back)
        return n

    def _harmed(self, uv: Array, triangles: Array, signs: Array) -> NDArray[np.bool_]:
        """Return a mask [n] of the moved nodes of triangles that have another sign than signs, as stored in space."""
        moved, first, second = self.has_moved(uv), *self.plane.axis[:2]
        places = self.places(uv)[:, [first, second]].astype(np.float64)
        is_wrong = (_turns(places, triangles) != signs) | (_turns(uv, triangles) != signs)
        found = np.zeros(len(uv), dtype=bool)
        found[triangles[is_wrong & moved[triangles].any(axis=1)]] = True
        harmed: NDArray[np.bool_] = found & moved
        return harmed

    def _follow(self, uv: Array, is_back: NDArray[np.bool_]) -> None:
        """Let mids, and nodes inside of elements, follow corners that have gone back, by their mean way."""
        layout = self.elements.as_layout()
        for first, last, n in zip(layout.offsets[:-1], layout.offsets[1:], CORNERS[layout.types]):
            corners = layout.nodes[first:first + n]
            if last - first == n or not is_back[corners].any():
                continue
            for k, node in enumerate(layout.nodes[first + n:last]):
                ends = corners if k >= n else corners[[k, (k + 1) % n]]
                if node >= 0 and is_back[ends].any() and not is_back[node]:
                    uv[node] = self.before[node] + (uv[ends] - self.before[ends]).mean(axis=0)

    def _round(self, uv: Array) -> None:
        """Make coordinates those of what is stored, if they lead back to it."""
        places = self.plane.places(uv, self.points.dtype)
        rounded = self.plane.project(places)
        same = (self.plane.places(rounded, self.points.dtype) == places).all(axis=1) & self.has_moved(uv)
        uv[same] = rounded[same]
