"""planish: smooth and untangle meshes of tetrahedra or triangles, in place.

A thin module over the shared library: arrays of numpy go to it as they are, nothing is built.

    import planish
    result = planish.smooth(points, cells)      # points [n, 2 or 3], cells [m, 3 or 4]: in place
    result = planish.smooth(mesh)               # a mesh of meshio or pyvista: its points, in place
    print(planish.quality(points, cells).min_angle_deg)

    with planish.Plan(points, cells) as plan:   # once for a connectivity, for many positions
        for points in positions:
            plan.smooth(points)

The library is what the environment variable PLANISH_LIBRARY names; without it, it is looked for beside
the installation that this file is part of, and where the system's linker looks.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import operator
import os
import pathlib
import sys
import threading
from ctypes import POINTER, byref, c_char, c_double, c_int, c_int64, c_size_t, c_uint8, c_void_p
from typing import Any, Callable, Optional, Sequence

import numpy as np

__all__ = ["Error", "Plan", "Progress", "Quality", "Result", "checksum", "find_layers", "quality",
           "smooth", "version"]

# ---- the library's structures, as in include/planish/planish.h --------------------------------


class _Error(ctypes.Structure):
    _fields_ = [("code", c_int), ("element", c_int64), ("node", c_int64), ("text", c_char * 512)]


class _Mesh(ctypes.Structure):
    _fields_ = [
        ("dim", c_int),
        ("n_nodes", c_int64),
        ("n_elements", c_int64),
        ("coordinates", c_void_p),
        ("elements", c_void_p),
        ("constraint", c_void_p),
        ("direction", c_void_p),
        ("n_periodic", c_int64),
        ("periodic", c_void_p),
        ("min_volume", c_void_p),
        ("elements64", c_void_p),
        ("node_stride", c_int64),
        ("component_stride", c_int64),
        ("neighbours", c_void_p),
        ("neighbours64", c_void_p),
        ("part", c_void_p),
        ("reserved", c_void_p * 7),
    ]


class Progress(ctypes.Structure):
    """How far smoothing is: planish_progress of planish.h, field by field."""

    _fields_ = [
        ("sweep", c_int),
        ("colour", c_int),
        ("n_colours", c_int),
        ("sweep_done", c_int),
        ("rms", c_double),
        ("rms_movable", c_double),
        ("objective", c_double),
        ("inverted", c_int64),
        ("below_min_volume", c_int64),
        ("restoring", c_int),
        ("worst", c_int),
        ("visits", c_int64),
        ("seconds", c_double),
        ("elapsed", c_double),
        ("colour_visits", c_int64),
        ("reserved", c_int64 * 3),
    ]


_PROGRESS = ctypes.CFUNCTYPE(c_int, POINTER(Progress), c_void_p)


class _Options(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_size_t),
        ("threads", c_int),
        ("bind", c_int),
        ("isa", c_int),
        ("method", c_int),
        ("objective", c_int),
        ("direction", c_int),
        ("min_volume", c_double),
        ("min_volume_fraction", c_double),
        ("area_weight", c_double),
        ("lower", c_void_p),
        ("upper", c_void_p),
        ("box_lower", c_double * 3),
        ("box_upper", c_double * 3),
        ("max_displacement", c_double),
        ("displacement_unit", c_int),
        ("precision", c_int),
        ("untangle", c_int),
        ("worst", c_int),
        ("worst_rise", c_double),
        ("max_sweeps", c_int),
        ("tolerance", c_double),
        ("time_limit", c_double),
        ("only_worse_than", c_double),
        ("layers", c_int),
        ("n_around", c_int64),
        ("around", c_void_p),
        ("around_elements", c_void_p),
        ("progress", _PROGRESS),
        ("progress_user", c_void_p),
        ("project", c_void_p),
        ("project_user", c_void_p),
        ("allocator", c_void_p),
        ("parallel", c_void_p),
        ("parallel_user", c_void_p),
        ("log", c_void_p),
        ("log_user", c_void_p),
        ("round", c_void_p),
        ("round_user", c_void_p),
    ]


class _Printed(ctypes.Structure):
    """A structure that shows its values."""

    def as_dict(self) -> dict[str, Any]:
        """Its values by name; arrays as lists."""
        names = [name.lstrip("_") for name, *_ in self._fields_ if name != "reserved"]
        values = {name: getattr(self, name) for name in names}
        return {
            name: list(value)
            if isinstance(value, ctypes.Array)
            else value.as_dict()
            if isinstance(value, _Printed)
            else value
            for name, value in values.items()
        }

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value!r}" for name, value in self.as_dict().items())
        return f"{type(self).__name__}({values})"


class Spread(_Printed):
    """Smallest, mean and largest value of a measure over the valid elements."""

    _fields_ = [("min", c_double), ("mean", c_double), ("max", c_double)]


class Quality(_Printed):
    """What a mesh is worth: planish_quality of planish.h, field by field."""

    _fields_ = [
        ("n_elements", c_int64),
        ("inverted", c_int64),
        ("min_volume", c_double),
        ("max_volume", c_double),
        ("total_volume", c_double),
        ("rms_radius_ratio", c_double),
        ("rms_radius_ratio_movable", c_double),
        ("mean_radius_ratio", c_double),
        ("max_radius_ratio", c_double),
        ("worst_element", c_int64),
        ("min_angle_deg", c_double),
        ("max_angle_deg", c_double),
        ("max_radius_ratio_movable", c_double),
        ("min_angle_deg_movable", c_double),
        ("n_fixed", c_int64),
        ("fixed_rms_radius_ratio", c_double),
        ("fixed_max_radius_ratio", c_double),
        ("radius_ratio", Spread),
        ("circumradius_to_edge", Spread),
        ("edge_to_inradius", Spread),
        ("edge_ratio", Spread),
        ("mean_ratio", Spread),
        ("scaled_jacobian", Spread),
        ("smallest_angle_deg", Spread),
        ("largest_angle_deg", Spread),
        ("histogram_edges", c_double * 13),
        ("histogram_counts", c_int64 * 12),
        ("angle_edges_deg", c_double * 16),
        ("angle_counts", c_int64 * 15),
        ("reversed", c_int64),
        ("reserved", c_int64 * 7),
    ]


class Result(_Printed):
    """What smoothing did: planish_result of planish.h, field by field."""

    _fields_ = [
        ("_stop", c_int),
        ("sweeps", c_int),
        ("untangling_sweeps", c_int),
        ("worst_sweeps", c_int),
        ("visits", c_int64),
        ("moved_nodes", c_int64),
        ("max_displacement", c_double),
        ("put_back", c_int64),
        ("inverted", c_int64),
        ("rms", c_double),
        ("rms_movable", c_double),
        ("min_volume", c_double),
        ("below_min_volume", c_int64),
        ("held_outside", c_int64),
        ("objective_before", c_double),
        ("objective", c_double),
        ("objective_of_worst", c_double),
        ("worst_before", c_double),
        ("worst_after", c_double),
        ("evaluations", c_int64),
        ("kkt_residual", c_double),
        ("kkt_rms", c_double),
        ("max_multiplier", c_double),
        ("n_active", c_int64),
        ("seconds", c_double),
        ("reserved", c_int64 * 8),
    ]

    @property
    def stop(self) -> str:
        """Why it ended: converged, max-sweeps, time-limit, interrupted or infeasible."""
        return ("converged", "max-sweeps", "time-limit", "interrupted", "infeasible")[self._stop]


class Error(ValueError):
    """What the library refuses: its text says what, where and what to do.

    code is a planish_status; element and node are the ones meant, or -1.
    """

    def __init__(self, text: str, code: int = 0, element: int = -1, node: int = -1) -> None:
        super().__init__(text)
        self.code = code
        self.element = element
        self.node = node


# ---- the library ---------------------------------------------------------------------------------

_NAME, _VERSION = "libplanish.so.0.1", "0.1."


# How the installed library is reached from this file's folder; cmake --install fills it in.
_BESIDE = ""


def _candidates() -> list[str]:
    if os.environ.get("PLANISH_LIBRARY"):
        return [os.environ["PLANISH_LIBRARY"]]
    beside = [str(pathlib.Path(__file__).resolve().parent / _BESIDE / _NAME)] if _BESIDE else []
    return beside + [_NAME, ctypes.util.find_library("planish") or _NAME]


def _open(path: str) -> ctypes.CDLL:
    """The library at path, if its structures are those of this module: of any 0.1."""
    library = ctypes.CDLL(path)
    if not hasattr(library, "planish_version"):
        raise OSError(f"{path}: is no library of planish")
    library.planish_version.restype = ctypes.c_char_p
    found = library.planish_version().decode()
    if not found.startswith(_VERSION):
        raise OSError(f"{path}: is version {found}, but this module needs {_VERSION}x")
    return library


def _load() -> ctypes.CDLL:
    failures = []
    for path in _candidates():
        try:
            return _open(path)
        except OSError as failure:
            failures.append(str(failure))
    raise ImportError(
        "the library of planish was not found; install it, or name it in PLANISH_LIBRARY ("
        + "; ".join(dict.fromkeys(failures)) + ")"
    )


_library = _load()
_library.planish_checksum.restype = ctypes.c_uint64
_library.planish_options_init.restype = None
_library.planish_plan_destroy.restype = None
_library.planish_plan_destroy.argtypes = [c_void_p]
_library.planish_plan_get_free.restype = None
_library.planish_plan_get_free.argtypes = [c_void_p, c_void_p]
for _name in ("planish_plan_create", "planish_smooth", "planish_measure", "planish_measure_elements",
              "planish_measure_mesh", "planish_find_layers"):
    getattr(_library, _name).restype = c_int


# A child of a fork has none of the parent's threads, and libgomp waits for them for ever.
_is_forked = False


def _after_fork() -> None:
    global _is_forked  # pylint: disable=global-statement
    _is_forked = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _threads(wanted: int) -> int:
    """How many to ask the library for."""
    return 1 if _is_forked and wanted == 0 else _whole(wanted, "threads")


def _whole(value: Any, name: str) -> int:
    """An integer that C's int can hold."""
    number = operator.index(value)
    if not -(2**31) <= number < 2**31:
        raise ValueError(f"{name} is {number}, which is out of range")
    return number


def version() -> str:
    """Version of the library in use."""
    return _library.planish_version().decode()


# ---- arrays --------------------------------------------------------------------------------------

_OBJECTIVES = {"radius-ratio": 0, "mean-ratio": 1, "edge-ratio": 2, "worst": 0}
_WORST = {"radius-ratio": 1, "dihedral": 2}
_TETRAHEDRON, _TRIANGLE = "tetra", "triangle"
_VTK_NAMES = {10: _TETRAHEDRON, 5: _TRIANGLE}


def _flat(nodes: Any) -> list[int]:
    """All numbers in lists of lists, as of the faces of polyhedra."""
    if isinstance(nodes, (list, tuple, np.ndarray)):
        return [number for part in nodes for number in _flat(part)]
    return [int(nodes)]


def _nodes_of(data: Any) -> np.ndarray:
    """Nodes of cells: [m, k], or, of cells that have not the same number, all in one row."""
    try:
        nodes = np.asarray(data)
    except ValueError:
        nodes = np.empty(0, dtype=object)
    return nodes if nodes.dtype != object else np.array(_flat(data), dtype=np.int64)


def _listed(cells: Any) -> np.ndarray:
    """The nodes of VTK's lists: a count, so many nodes, a count, ..."""
    flat = np.zeros(0, dtype=np.int64) if cells is None else np.asarray(cells).ravel()
    is_node = np.ones(len(flat), dtype=bool)
    at = 0
    while at < len(flat):
        is_node[at] = False
        at += 1 + int(flat[at])
    return flat[is_node]


def _blocks(mesh: Any) -> list[tuple[str, np.ndarray]]:
    """Names of kinds of cells, and their nodes, of a mesh of meshio or of pyvista."""
    if hasattr(mesh, "cells_dict") and not isinstance(getattr(mesh, "cells", None), list):
        return [(_VTK_NAMES.get(int(kind), "other"), np.asarray(cells))
                for kind, cells in mesh.cells_dict.items()]
    if isinstance(getattr(mesh, "cells", None), list):
        return [(block.type, _nodes_of(block.data)) for block in mesh.cells]
    if hasattr(mesh, "regular_faces"):
        faces = np.asarray(mesh.regular_faces)
        kind = _TRIANGLE if faces.ndim == 2 and faces.shape[1] == 3 else "polygon"
        others = [_listed(getattr(mesh, name, None)) for name in ("lines", "verts")]
        return [(kind, faces)] + [("other", nodes) for nodes in others if len(nodes)]
    raise TypeError("give points and cells as arrays, or a mesh of meshio or pyvista")


def _take_mesh(mesh: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (the mesh's own array), cells, and which nodes other cells hold."""
    blocks = _blocks(mesh)
    kinds = {kind for kind, _ in blocks}
    kind = _TETRAHEDRON if _TETRAHEDRON in kinds else _TRIANGLE
    if kind not in kinds:
        raise ValueError("the mesh has neither tetrahedra nor triangles")
    cells = [data for name, data in blocks if name == kind]
    held = np.zeros(len(mesh.points), dtype=np.uint8)
    for name, data in blocks:
        if name != kind:
            held[data.ravel()] = 1
    points = mesh.points
    return points, cells[0] if len(cells) == 1 else np.concatenate(cells), held


class _Points:
    """Coordinates as the library takes them: the caller's array, or a copy to be written back.

    strides: those that the array must have, in doubles; None: any will do. writes: it will change.
    """

    def __init__(
        self, points: Any, dim: int, strides: Optional[tuple[int, int]] = None, writes: bool = False
    ) -> None:
        if not isinstance(points, np.ndarray) or points.ndim != 2:
            raise TypeError("points must be an array of numpy of two dimensions")
        if points.shape[1] < dim:
            raise ValueError(f"points has {points.shape[1]} columns, but cells need {dim}")
        if points.dtype.newbyteorder("=") not in (np.float64, np.float32):
            raise TypeError(f"points must be of float64 or float32, not {points.dtype}")
        if writes and not points.flags.writeable:
            raise ValueError("points is read-only; give a copy")
        if dim == 2 and points.shape[1] >= 3 and len(points):
            # but for what geometry kernels leave of roundings, as in files
            noise = 1e-8 if points.dtype.itemsize == 8 else 1e-6
            if not np.ptp(points[:, 2]) <= noise * np.ptp(points[:, :2], axis=0).max():
                raise ValueError("triangles must lie in a plane of constant z")
        self.points = points[:, :dim]
        self.is_float = points.dtype.itemsize == 4
        self.array = self.points
        if not self._fits(strides):
            self.array = self._room(strides or (dim, 1))
            self.array[...] = self.points
        self.strides = tuple(step // 8 for step in self.array.strides)

    def _fits(self, strides: Optional[tuple[int, int]]) -> bool:
        steps = self.points.strides
        return (
            self.points.dtype == np.float64
            and self.points.dtype.isnative
            and self.points.flags.aligned
            and all(step > 0 and step % 8 == 0 for step in steps)
            and strides in (None, tuple(step // 8 for step in steps))
        )

    def _room(self, strides: tuple[int, int]) -> np.ndarray:
        n, dim = self.points.shape
        room = np.zeros(max(n - 1, 0) * strides[0] + (dim - 1) * strides[1] + 1)
        steps = tuple(8 * step for step in strides)
        return np.lib.stride_tricks.as_strided(room, self.points.shape, steps)

    def write_back(self) -> None:
        if self.array is not self.points:
            self.points[...] = self.array


def _cells(cells: Any) -> np.ndarray:
    cells = np.asarray(cells)
    if cells.ndim != 2 or cells.shape[1] not in (3, 4):
        raise ValueError(f"cells must be [m, 3] (triangles) or [m, 4] (tetrahedra), not {cells.shape}")
    if cells.dtype.kind not in "iu":
        raise TypeError(f"cells must be integers, not {cells.dtype}")
    if cells.dtype == np.uint64 and cells.size and cells.max() > np.iinfo(np.int64).max:
        raise ValueError(f"cells has node {cells.max()}, which is out of range")
    return np.require(cells, np.int32 if cells.dtype.itemsize <= 4 and cells.dtype.kind == "i"
                      else np.int64, "CA")


def _nodes(nodes: Any, n: int, what: str) -> np.ndarray:
    """Numbers of nodes, from numbers or a mask [n]."""
    nodes = np.asarray(nodes)
    if nodes.dtype == bool:
        if nodes.shape != (n,):
            raise ValueError(f"{what} is a mask of shape {nodes.shape}, not ({n},)")
        return np.flatnonzero(nodes)
    if nodes.size and nodes.dtype.kind not in "iu":
        raise TypeError(f"{what} must be numbers of nodes or a mask, not {nodes.dtype}")
    nodes = nodes.astype(np.int64).ravel()
    if nodes.size and not (0 <= nodes.min() and nodes.max() < n):
        raise ValueError(f"{what} has a number that is not in 0 .. {n - 1}")
    return nodes


def _address(array: Optional[np.ndarray]) -> Optional[int]:
    return None if array is None else array.ctypes.data


def _check(status: int, error: _Error) -> None:
    if status:
        text = error.text.decode()
        raise MemoryError(text) if error.code == -3 else Error(text, error.code, error.element, error.node)


class _View:
    """A planish_mesh, and the arrays that it points to."""

    def __init__(self, points: Any, cells: Any, fixed: Any, min_volumes: Any) -> None:
        held = None
        if cells is None:
            points, cells, held = _take_mesh(points)
        self.cells = _cells(cells)
        self.dim = self.cells.shape[1] - 1
        self.given = points
        self.points = _Points(points, self.dim)
        n = len(points)
        self.n = n
        self.constraint = None
        if fixed is not None or (held is not None and held.any()):
            self.constraint = held if held is not None else np.zeros(n, dtype=np.uint8)
            if fixed is not None:
                self.constraint[_nodes(fixed, n, "fixed")] = 1
        self.min_volumes = None
        if min_volumes is not None:
            self.min_volumes = np.require(min_volumes, np.float64, "CA")
            if self.min_volumes.shape != (len(self.cells),):
                raise ValueError("min_volumes must have one value for each cell")
        wide = self.cells.dtype == np.int64
        self.mesh = _Mesh(
            dim=self.dim,
            n_nodes=n,
            n_elements=len(self.cells),
            coordinates=_address(self.points.array),
            elements=None if wide else _address(self.cells),
            elements64=_address(self.cells) if wide else None,
            constraint=_address(self.constraint),
            min_volume=_address(self.min_volumes),
            node_stride=self.points.strides[0],
            component_stride=self.points.strides[1],
        )

    def own_cells(self) -> None:
        """Make the cells a copy that nobody changes; of 64 bits the library has its own."""
        if self.cells.dtype == np.int32:
            self.cells = self.cells.copy()
            self.mesh.elements = _address(self.cells)


# ---- what people call ----------------------------------------------------------------------------


class Plan:
    """Stars, colours and memory of one connectivity, for many positions of its nodes.

    points [n, 2 or 3] and cells [m, 3 or 4] are arrays of numpy, or points is a mesh of meshio or
    pyvista (cells is None then), whose nodes on cells of other kinds are held. fixed: numbers, or a
    mask, of nodes that stay besides those of the boundary. min_volumes [m]: least volume of each
    cell, 0 for none. threads: 0 as many as there are and the mesh is large enough for; one in a child of
    os.fork (multiprocessing), where those of the parent would be waited for.
    only_worse_than and layers: only nodes of cells whose radius ratio exceeds it move, and of so
    many layers around. around: only these nodes (numbers) move, and of so many layers around;
    qualities and results are then of the cells at these.

    One plan serves one thread at a time. To be closed, or used in a with statement.
    """

    def __init__(
        self,
        points: Any,
        cells: Any = None,
        *,
        fixed: Any = None,
        min_volumes: Any = None,
        threads: int = 0,
        only_worse_than: float = 0,
        layers: int = 0,
        around: Optional[Sequence[int]] = None,
    ) -> None:
        self._plan = c_void_p()
        self._is_busy = False
        self._view = _View(points, cells, fixed, min_volumes)
        self._view.own_cells()  # the plan reads them as long as it lives
        self._options = _Options()
        _library.planish_options_init(byref(self._options))
        self._options.threads = _threads(threads)
        self._process = os.getpid()
        self._options.only_worse_than = only_worse_than
        self._options.layers = _whole(layers, "layers")
        self._around = None if around is None else _nodes(around, self._view.n, "around")
        if self._around is not None:
            self._options.around = _address(self._around) or 1
            self._options.n_around = self._around.size
        error = _Error()
        _check(
            _library.planish_plan_create(
                byref(self._view.mesh), byref(self._options), byref(self._plan), byref(error)
            ),
            error,
        )

    def close(self) -> None:
        """Release what the plan holds. It cannot be used any more then."""
        self._check_idle()
        if self._plan:
            _library.planish_plan_destroy(self._plan)
            self._plan = c_void_p()

    def _check_idle(self) -> None:
        if self._is_busy:
            raise RuntimeError("the plan is at work, in another thread or in the smooth that calls progress: "
                               "it smooths one mesh at a time")

    def __reduce__(self) -> Any:
        raise TypeError("a plan can be neither copied nor pickled; make another one")

    def __enter__(self) -> Plan:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_plan", None):
            self.close()

    def _coordinates(self, points: Any, writes: bool = False) -> _Points:
        """points (a mesh, or None: those given at first), laid out as the plan's mesh is."""
        if not self._plan:
            raise ValueError("the plan is closed")
        if self._process != os.getpid() and self._options.threads != 1:
            raise RuntimeError("the plan was made before this process was forked, and may have threads that "
                               "are not here; make it with threads=1, or another one here")
        if points is None:
            points = self._view.given
        points = getattr(points, "points", points)
        taken = _Points(points, self._view.dim, self._view.points.strides, writes)
        if len(points) != self._view.n:
            raise ValueError(f"points has {len(points)} rows, but the plan is for {self._view.n}")
        return taken

    def free(self) -> np.ndarray:
        """Mask [n] of the nodes that may move anywhere."""
        mask = np.zeros(self._view.n, dtype=np.uint8)
        if not self._plan:
            raise ValueError("the plan is closed")
        _library.planish_plan_get_free(self._plan, _address(mask))
        return mask.astype(bool)

    def quality(self, points: Any = None) -> Quality:
        """What points [n, 2 or 3] are worth (None: those given at first)."""
        taken, error, found = self._coordinates(points), _Error(), Quality()
        _check(
            _library.planish_measure(
                self._plan, c_void_p(_address(taken.array)), byref(found), byref(error)
            ),
            error,
        )
        return found

    def radius_ratios(self, points: Any = None) -> np.ndarray:
        """Radius ratio [m] of each element at points: 1 is best, 0 inverted or flat; nan of those
        that a plan around some nodes does not know."""
        taken, error = self._coordinates(points), _Error()
        ratios = np.empty(self._view.mesh.n_elements)
        _check(
            _library.planish_measure_elements(
                self._plan, c_void_p(_address(taken.array)), c_void_p(_address(ratios)), byref(error)
            ),
            error,
        )
        return ratios

    def smooth(
        self,
        points: Any = None,
        *,
        objective: str = "radius-ratio",
        worst_measure: str = "dihedral",
        worst_rise: float = 0.01,
        min_volume: float = 0,
        min_volume_fraction: float = 0,
        area_weight: float = 0,
        max_displacement: float = 0,
        untangle: bool = True,
        max_sweeps: int = 200,
        tolerance: float = 1e-5,
        time_limit: float = 0,
        progress: Optional[Callable[[Progress], Any]] = None,
    ) -> Result:
        """Smooth points [n, 2 or 3] (None: those given at first) in place, after untangling them.

        objective: radius-ratio, mean-ratio, edge-ratio, or worst: radius-ratio, and then the worst
        cells by worst_measure (dihedral, radius-ratio), for which F may rise by worst_rise of
        itself. The other options are those of planish_options in planish.h. progress is called after
        every colour of nodes; if it returns something true, smoothing ends there (it may be called once
        more, for the end of the sweep); what it raises, or a signal's handler meanwhile, is raised here,
        and points are then as good as they had become. Without progress signals wait for the end.
        """
        if objective not in _OBJECTIVES:
            raise ValueError(f"objective must be one of {', '.join(_OBJECTIVES)}, not {objective!r}")
        if worst_measure not in _WORST:
            raise ValueError(f"worst_measure must be one of {', '.join(_WORST)}, not {worst_measure!r}")
        self._check_idle()
        taken = self._coordinates(points, writes=True)
        options, error, result = self._options, _Error(), Result()
        options.objective = _OBJECTIVES[objective]
        options.worst = _WORST[worst_measure] if objective == "worst" else 0
        options.worst_rise = worst_rise
        options.min_volume = min_volume
        options.min_volume_fraction = min_volume_fraction
        options.area_weight = area_weight
        options.max_displacement = max_displacement
        options.untangle = bool(untangle)
        options.max_sweeps = _whole(max_sweeps, "max_sweeps")
        options.tolerance = tolerance
        options.time_limit = time_limit
        options.precision = taken.is_float
        raised: list[BaseException] = []

        def call(seen: Any, _user: Any) -> int:
            if raised:
                return 1
            try:
                return bool(progress(Progress.from_buffer_copy(seen.contents)))  # type: ignore[misc]
            except BaseException as exception:  # pylint: disable=broad-except
                raised.append(exception)
                return 1

        def note(unraisable: Any) -> None:
            """What a signal's handler raises before call's first line, as KeyboardInterrupt."""
            if unraisable.object is call:
                raised.append(unraisable.exc_value)
            else:
                hook(unraisable)

        options.progress = _PROGRESS(call) if progress is not None else _PROGRESS()
        hook = sys.unraisablehook
        if threading.current_thread() is threading.main_thread():  # where handlers of signals run
            sys.unraisablehook = note
        self._is_busy = True
        try:
            status = _library.planish_smooth(
                self._plan, c_void_p(_address(taken.array)), byref(options), byref(result), byref(error)
            )
        finally:
            self._is_busy = False
            if sys.unraisablehook is note:
                sys.unraisablehook = hook
            options.progress = _PROGRESS()
        _check(status, error)
        taken.write_back()
        if raised:
            raise raised[0]
        return result


_OF_PLAN = ("fixed", "min_volumes", "threads", "only_worse_than", "layers", "around")


def smooth(points: Any, cells: Any = None, **options: Any) -> Result:
    """Smooth a mesh in place: points and cells as for Plan, options those of Plan and Plan.smooth."""
    known = {*_OF_PLAN, *Plan.smooth.__kwdefaults__}
    if not known.issuperset(options):
        raise TypeError(f"{min(set(options) - known)} is no option of smooth: {', '.join(sorted(known))}")
    of_plan = {name: options.pop(name) for name in _OF_PLAN if name in options}
    with Plan(points, cells, **of_plan) as plan:
        return plan.smooth(**options)


def quality(points: Any, cells: Any = None, *, fixed: Any = None) -> Quality:
    """What a mesh is worth: points, cells and fixed as for Plan."""
    view, error, found, options = _View(points, cells, fixed, None), _Error(), Quality(), _Options()
    _library.planish_options_init(byref(options))
    options.threads = _threads(0)
    _check(_library.planish_measure_mesh(byref(view.mesh), byref(options), byref(found), byref(error)), error)
    return found


def find_layers(points: Any, cells: Any = None, *, threads: int = 0) -> np.ndarray:
    """Mask [m] of the cells that are thin in layers, as those of a boundary layer: smoothing would
    make them regular, unless their nodes are fixed. points and cells as for Plan."""
    view, error = _View(points, cells, None, None), _Error()
    mask = np.zeros(len(view.cells), dtype=np.uint8)
    _check(
        _library.planish_find_layers(
            byref(view.mesh), c_int(_threads(threads)), c_void_p(_address(mask)), None, byref(error)
        ),
        error,
    )
    return mask.astype(bool)


def checksum(points: Any, cells: Any = None) -> int:
    """A number for the bits of the points: equal if these are."""
    view = _View(points, cells, None, None)
    return _library.planish_checksum(byref(view.mesh))
