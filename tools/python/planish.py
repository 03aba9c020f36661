"""planish: smooth, untangle and measure meshes of elements of any type, in place.

A thin module over the shared library: arrays of simplices go to it as they are, nothing is built.

    import planish
    result = planish.smooth(points, cells)      # points [n, 2 or 3], cells [m, 3 or 4]: in place
    result = planish.smooth(mesh)               # a mesh of meshio or pyvista: its points, in place
    result = planish.smooth(points, {"hexahedron": a, "wedge": b})
    print(planish.quality(points, cells).min_angle_deg)
    print(planish.quality(points, {"tetra10": a, "hexahedron": b}).cells.all.n_inverted)

    with planish.Plan(points, cells) as plan:   # once for a connectivity, for many positions
        for points in positions:
            plan.smooth(points)

The library is what the environment variable PLANISH_LIBRARY names; without it, it is looked for beside
the installation that this file is part of, and where the system's linker looks.
"""

from __future__ import annotations

import contextlib
import ctypes
import ctypes.util
import itertools
import operator
import os
import pathlib
import sys
import threading
from ctypes import POINTER, byref, c_char, c_double, c_int, c_int64, c_size_t, c_void_p
from typing import Any, Callable, Iterator, NamedTuple, Optional, Sequence

import numpy as np

__all__ = ["CellMeasures", "CellQuality", "CellValues", "Error", "FitInfo", "Plan", "Progress", "Quality", "Result", "Shape",
           "ShapeDistance", "ShapeInfo", "SizeQuality", "SlideInfo", "Slides", "checksum", "find_layers", "find_sizes",
           "find_slides", "quality", "size_quality", "smooth", "version"]

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
        ("cells", c_void_p),
        ("reference", c_void_p),
        ("is_layer", c_void_p),
        ("size", c_void_p),
        ("metric", c_void_p),
        ("reserved", c_void_p * 2),
    ]


class _CellsOfTypes(ctypes.Structure):
    _fields_ = [("n", c_int64), ("type", c_void_p), ("offset", c_void_p), ("node", c_void_p),
                ("reserved", c_void_p * 4)]


class _CellValues(ctypes.Structure):
    _fields_ = [
        ("state", c_void_p),
        ("is_curved", c_void_p),
        ("aspect_ratio", c_void_p),
        ("scaled_jacobian", c_void_p),
        ("jacobian_ratio", c_void_p),
        ("edge_ratio", c_void_p),
        ("reserved", c_void_p * 4),
    ]


class _Surface(ctypes.Structure):
    _fields_ = [
        ("region", c_void_p),
        ("n_facets", c_int64),
        ("facets", c_void_p),
        ("facet_tag", c_void_p),
        ("n_edges", c_int64),
        ("edges", c_void_p),
        ("edge_tag", c_void_p),
        ("is_inside", c_void_p),
        ("tagged_only", c_int),
        ("slide_interfaces", c_int),
        ("tolerance", c_double),
        ("facet_offset", c_void_p),
        ("shape", c_void_p),
        ("crease_angle", c_double),
        ("reserved", c_void_p * 1),
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
        ("n_inverted", c_int64),
        ("n_below_min_volume", c_int64),
        ("phase", c_int),
        ("visits", c_int64),
        ("seconds", c_double),
        ("elapsed", c_double),
        ("colour_visits", c_int64),
        ("reserved", c_int64 * 3),
    ]


class _CellArray(ctypes.Structure):
    _fields_ = [
        ("name", ctypes.c_char_p),
        ("values", c_void_p),
        ("type", c_int),
        ("is_region", c_int),
        ("reserved", c_void_p * 4),
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
        ("search", c_int),
        ("min_volume", c_double),
        ("min_volume_fraction", c_double),
        ("area_weight", c_double),
        ("lower", c_void_p),
        ("upper", c_void_p),
        ("box_lower", c_double * 3),
        ("box_upper", c_double * 3),
        ("max_displacement", c_double),
        ("rounding", c_double),
        ("displacement_unit", c_int),
        ("precision", c_int),
        ("untangle", c_int),
        ("worst", c_int),
        ("worst_rise", c_double),
        ("max_sweeps", c_int),
        ("tolerance", c_double),
        ("time_limit", c_double),
        ("only_worse_than", c_double),
        ("rings", c_int),
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
        ("curve_quality", c_double),
        ("shape", c_void_p),
        ("surface_tolerance", c_double),
        ("surface_tolerance_unit", c_int),
        ("size_weight", c_double),
        ("reserved", c_void_p * 2),
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


class CellMeasures(_Printed):
    """Measures of elements of one type or of all: planish_cell_measures of planish.h, field by field."""

    _fields_ = [
        ("n_elements", c_int64),
        ("n_inverted", c_int64),
        ("n_uncertified", c_int64),
        ("n_inverted_corners", c_int64),
        ("n_curved", c_int64),
        ("rms_aspect_ratio", c_double),
        ("mean_aspect_ratio", c_double),
        ("max_aspect_ratio", c_double),
        ("worst_element", c_int64),
        ("min_scaled_jacobian", c_double),
        ("min_jacobian_ratio", c_double),
        ("max_edge_ratio", c_double),
        ("reserved", c_double * 4),
    ]


class CellQuality(_Printed):
    """Quality of elements of any types: all are the measures of all elements, by_type those of each
    type by its name. planish_cell_quality of planish.h."""

    _fields_ = [
        ("all", CellMeasures),
        ("_n_types", c_int),
        ("_type", c_int * 16),
        ("_by_type", CellMeasures * 16),
        ("reserved", c_int64 * 8),
    ]

    @property
    def by_type(self) -> dict[str, CellMeasures]:
        """Measures of the elements of each type."""
        return {_KNOWN[self._type[i]].name: self._by_type[i] for i in range(self._n_types)}

    @property
    def counts(self) -> dict[str, int]:
        """Number of elements of each type."""
        return {name: measures.n_elements for name, measures in self.by_type.items()}

    def as_dict(self) -> dict[str, Any]:
        """Its values by name."""
        return {"all": self.all.as_dict(), "by_type": {name: of.as_dict() for name, of in self.by_type.items()}}


class CellValues(NamedTuple):
    """Measures of single elements, arrays [m]: planish_cell_values of planish.h. 0 stands for a
    measure that an element does not have."""

    number: np.ndarray  # place of the element among all cells given, those of lower dimension included
    state: np.ndarray  # 1 valid, 2 inverted, 3 uncertified
    is_curved: np.ndarray
    aspect_ratio: np.ndarray
    scaled_jacobian: np.ndarray
    jacobian_ratio: np.ndarray
    edge_ratio: np.ndarray


class Quality(_Printed):
    """Quality of a mesh: planish_quality of planish.h, field by field. With any elements but triangles or
    tetrahedra AR stands for the radius ratio in these fields, and there are no angles.

    cells is the CellQuality of elements of all types; None for straight simplices alone, of which the
    fields say more, unless elements was asked for: the CellValues. Plan.quality gives neither.
    """

    cells: Optional[CellQuality] = None
    elements: Optional[CellValues] = None

    def as_dict(self) -> dict[str, Any]:
        """Its values by name; arrays as lists."""
        return {**super().as_dict(), **({"cells": self.cells.as_dict()} if self.cells else {})}

    _fields_ = [
        ("n_elements", c_int64),
        ("n_inverted", c_int64),
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
        ("n_fixed_elements", c_int64),
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
        ("n_reversed", c_int64),
        ("reserved", c_int64 * 7),
    ]


class Result(_Printed):
    """What smoothing did: planish_result of planish.h, field by field; of smooth with onto also:"""

    fit: Optional[FitInfo] = None
    fit_distance: Optional[ShapeDistance] = None
    _fields_ = [
        ("_stop", c_int),
        ("sweeps", c_int),
        ("untangling_sweeps", c_int),
        ("worst_sweeps", c_int),
        ("visits", c_int64),
        ("n_moved_nodes", c_int64),
        ("max_displacement", c_double),
        ("n_put_back", c_int64),
        ("n_inverted", c_int64),
        ("rms", c_double),
        ("rms_movable", c_double),
        ("min_volume", c_double),
        ("n_below_min_volume", c_int64),
        ("n_held_outside", c_int64),
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
        ("n_not_enclosed", c_int64),
        ("n_curved", c_int64),
        ("n_inverted_inside", c_int64),
        ("n_refused", c_int64),
        ("n_released_mids", c_int64),
        ("n_hopeless", c_int64),
        ("n_off_shape", c_int64),
        ("reserved", c_int64 * 1),
    ]

    @property
    def stop(self) -> str:
        """Why it ended: converged, max-sweeps, time-limit, interrupted or infeasible."""
        return ("converged", "max-sweeps", "time-limit", "interrupted", "infeasible")[self._stop]


class ShapeInfo(_Printed):
    """What a shape has: planish_shape_info of planish.h, field by field."""

    _fields_ = [
        ("n_nodes", c_int64),
        ("n_facets", c_int64),
        ("n_patches", c_int64),
        ("n_edges", c_int64),
        ("n_creases", c_int64),
        ("n_on_patch", c_int64),
        ("n_on_curve", c_int64),
        ("n_corners", c_int64),
        ("edge_length", c_double),
        ("n_mids", c_int64),
        ("n_open_edges", c_int64),
        ("n_nonmanifold_edges", c_int64),
        ("n_conflict_edges", c_int64),
        ("n_turned", c_int64),
        ("n_flat", c_int64),
        ("reserved", c_int64 * 1),
    ]


class ShapeDistance(_Printed):
    """How far a surface is off its shape: planish_shape_distance of planish.h, field by field."""

    _fields_ = [
        ("distance", c_double),
        ("distance_back", c_double),
        ("in_edges", c_double),
        ("back_in_edges", c_double),
        ("n_unproved", c_int64),
        ("max_bend", c_double),
        ("max_bend_before", c_double),
        ("reserved", c_int64 * 8),
    ]


class FitInfo(_Printed):
    """Nodes that were fitted to another surface: planish_fit_info of planish.h, field by field."""

    _fields_ = [
        ("n_nodes", c_int64),
        ("n_on_patch", c_int64),
        ("n_on_curve", c_int64),
        ("n_on_corner", c_int64),
        ("n_out_of_reach", c_int64),
        ("n_held", c_int64),
        ("n_off", c_int64),
        ("farthest", c_double),
        ("reserved", c_int64 * 8),
    ]


class SlideInfo(_Printed):
    """How many nodes slide: planish_slide_info of planish.h, field by field."""

    _fields_ = [
        ("n_surface", c_int64),
        ("n_on_plane", c_int64),
        ("n_on_line", c_int64),
        ("n_on_patch", c_int64),
        ("n_on_curve", c_int64),
        ("reserved", c_int64 * 2),
    ]


class SizeQuality(_Printed):
    """Sizes of cells against those wanted: planish_size_quality of planish.h, field by field."""

    ratio: Optional[np.ndarray] = None  # [m] size / (factor * wanted), with per_element

    _fields_ = [
        ("n_elements", c_int64),
        ("factor", c_double),
        ("rms_log", c_double),
        ("least", c_double),
        ("most", c_double),
        ("smallest", c_int64),
        ("largest", c_int64),
        ("reserved", c_double * 2),
    ]


class Slides(NamedTuple):
    """Constraints of nodes, 0 to 6: free, fixed, on a plane, on a line, (on a surface,) on a patch, on a curve."""

    constraint: np.ndarray  # [n] of uint8
    direction: np.ndarray  # [n, dim] normals of planes, and directions of lines
    info: SlideInfo


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

_NAME, _VERSION = "libplanish.so.0.2", "0.2."


# How the installed library is reached from this file's folder; cmake --install fills it in.
_BESIDE = ""


def _candidates() -> list[str]:
    if os.environ.get("PLANISH_LIBRARY"):
        return [os.environ["PLANISH_LIBRARY"]]
    beside = [str(pathlib.Path(__file__).resolve().parent / _BESIDE / _NAME)] if _BESIDE else []
    return beside + [_NAME, ctypes.util.find_library("planish") or _NAME]


def _open(path: str) -> ctypes.CDLL:
    """The library at path, if its structures are those of this module: of any 0.2."""
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
_library.planish_options_init_sized.restype = None
_library.planish_plan_destroy.restype = None
_library.planish_plan_destroy.argtypes = [c_void_p]
_library.planish_shape_destroy.restype = None
_library.planish_shape_destroy.argtypes = [c_void_p]
_library.planish_shape_get_classes.restype = None
_library.planish_shape_get_classes.argtypes = [c_void_p, c_void_p]
_library.planish_fit_destroy.restype = None
_library.planish_fit_destroy.argtypes = [c_void_p]
_library.planish_fit_constrain.restype = None
_library.planish_fit_constrain.argtypes = [c_void_p, c_void_p]
_library.planish_plan_get_free.restype = None
_library.planish_plan_get_free.argtypes = [c_void_p, c_void_p]
for _name in ("planish_plan_create", "planish_smooth", "planish_measure", "planish_measure_elements",
              "planish_measure_mesh", "planish_measure_cells", "planish_measure_sizes", "planish_find_sizes", "planish_find_layers", "planish_find_regions",
              "planish_combine_regions", "planish_find_interfaces", "planish_find_slides",
              "planish_shape_create", "planish_measure_shape", "planish_smooth_surface", "planish_measure_surface", "planish_fit_create", "planish_fit_move",
              "planish_fit_measure"):
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
_WORST = {"radius-ratio": 1, "dihedral": 2, "aspect-ratio": 3, "scaled-jacobian": 4}
_NUMBERS = {"int32": 0, "int64": 1, "int8": 2, "int16": 3, "uint8": 4, "uint16": 5, "uint32": 6, "uint64": 7,
            "float32": 8, "float64": 9}  # planish_number


class _Type(NamedTuple):
    """Type of cells that the library knows."""

    number: int  # planish_cell_type
    name: str  # meshio's
    dim: int
    n_nodes: int
    n_corners: int


_TYPES = [_Type(*row) for row in (
    (1, "vertex", 0, 1, 1), (3, "line", 1, 2, 2), (21, "line3", 1, 3, 2),
    (5, "triangle", 2, 3, 3), (22, "triangle6", 2, 6, 3),
    (9, "quad", 2, 4, 4), (23, "quad8", 2, 8, 4), (28, "quad9", 2, 9, 4),
    (10, "tetra", 3, 4, 4), (24, "tetra10", 3, 10, 4),
    (12, "hexahedron", 3, 8, 8), (25, "hexahedron20", 3, 20, 8), (29, "hexahedron27", 3, 27, 8),
    (13, "wedge", 3, 6, 6), (26, "wedge15", 3, 15, 6), (32, "wedge18", 3, 18, 6),
    (14, "pyramid", 3, 5, 5), (27, "pyramid13", 3, 13, 5), (128, "pyramid14", 3, 14, 5))]
_KNOWN: dict[Any, _Type] = {key: kind for kind in _TYPES for key in (kind.number, kind.name)}
_SIMPLICES = {2: (5, 22), 3: (10, 24)}  # straight, second order
_HELD = (27, 128)  # pyramids of second order: their nodes stay
_SIZE_WEIGHT = 0.9  # with sizes, unless said otherwise
_LAYERED = {3: (6, 8), 2: (4,)}  # corners of types whose layers are kept or held unless said otherwise
_KEEP_BY_TYPE = "keep those of some types"
# Other orders of nodes: pixels and voxels by VTK's number or meshio's name, wedges by meshio's name.
_PIXEL, _VOXEL = (_KNOWN["quad"], [0, 1, 3, 2]), (_KNOWN["hexahedron"], [0, 1, 3, 2, 4, 5, 7, 6])
_REORDERED: dict[Any, tuple[_Type, list[int]]] = {
    8: _PIXEL, "pixel": _PIXEL, 11: _VOXEL, "voxel": _VOXEL, "wedge": (_KNOWN["wedge"], [0, 2, 1, 3, 5, 4])}
_POLYVERTEX, _POLYLINE, _STRIP, _POLYGON = 2, 4, 6, 7


def _type_of(name: Any) -> tuple[Optional[_Type], Optional[list[int]]]:
    """The type that meshio's name or VTK's number means, None if the library does not know it, and the
    order of its nodes if it is not VTK's."""
    return _REORDERED.get(name, (_KNOWN.get(name), None))


_WIDTHS = np.zeros(256, dtype=np.int64)  # nodes of cells by VTK's number; 0: any number
for _number in range(256):
    _WIDTHS[_number] = getattr(_type_of(_number)[0], "n_nodes", 0)


class _Block(NamedTuple):
    """Cells of one type, and the values that arrays of cells have there, by the arrays' names."""

    kind: Optional[_Type]  # None: the library does not know it
    name: Any  # meshio's name or VTK's number
    nodes: np.ndarray  # [n, kind.n_nodes] in VTK's order, or all nodes of cells without a kind
    at: np.ndarray  # [n] places among all cells
    data: dict[str, Any]


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


def _block(name: Any, data: Any, at: np.ndarray, values: dict[str, Any]) -> _Block:
    """Cells of a type by its name or number."""
    nodes, (kind, order) = _nodes_of(data), _type_of(name)
    if not nodes.size:
        nodes = nodes.astype(np.int64)
    if nodes.dtype.kind not in "iu":
        raise TypeError(f"cells of type {name} must be integers, not {nodes.dtype}")
    if kind is None:
        return _Block(None, name, nodes.ravel(), at, values)
    if nodes.ndim != 2 or nodes.shape[1] != kind.n_nodes:
        raise ValueError(f"cells of type {name} must be [m, {kind.n_nodes}], not {nodes.shape}")
    return _Block(kind, name, nodes if order is None else nodes[:, order], at, values)


def _blocks_of_pairs(pairs: Any, data: dict[str, Any]) -> list[_Block]:
    """Cells of (type, nodes) pairs; data has one array for each pair, by its name."""
    blocks, n = [], 0
    for i, (name, nodes) in enumerate(pairs):
        if not isinstance(name, (str, int, np.integer)) or not hasattr(nodes, "__len__"):
            raise TypeError(f"cells by type must be meshio's names or VTK's numbers and arrays, not {name!r} and "
                            f"{type(nodes).__name__}")
        at = np.arange(n, n + len(nodes))
        blocks.append(_block(name, nodes, at, {key: values[i] for key, values in data.items()}))
        n += len(nodes)
    return blocks


def _blocks_of_arrays(nodes: np.ndarray, offsets: np.ndarray, types: np.ndarray,
                      data: dict[str, Any]) -> list[_Block]:
    """Cells of VTK's arrays: the nodes of cell i are nodes[offsets[i]:offsets[i + 1]]."""
    widths, blocks = np.diff(offsets), []
    if len(offsets) != len(types) + 1 or offsets[0] != 0 or offsets[-1] != len(nodes) or (widths < 0).any():
        raise ValueError(f"the offsets of {len(types)} cells must be {len(types) + 1} numbers that ascend from 0 to "
                         f"{len(nodes)}, the number of nodes in cells")
    if len(types) and not (0 <= types.min() and types.max() < len(_WIDTHS)):
        raise ValueError("types has a number that is not in 0 .. 255")
    wrong = np.flatnonzero((_WIDTHS[types] != 0) & (_WIDTHS[types] != widths))
    if len(wrong):
        i = wrong[0]
        raise ValueError(f"cell {i} of type {types[i]} has {widths[i]} nodes, not {_WIDTHS[types[i]]}")
    for number in map(int, np.unique(types)):
        is_of = types == number
        of_cells = nodes if is_of.all() else nodes[np.repeat(is_of, widths)]
        at = np.flatnonzero(is_of)
        blocks.append(_block(number, of_cells.reshape(-1, _WIDTHS[number]) if _WIDTHS[number] else of_cells, at,
                             _rows(data, at)))
    return blocks


def _counted(lists: Any, what: str, types: Optional[np.ndarray] = None) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and offsets of VTK's lists: a count, so many nodes, a count, ..."""
    lists = np.zeros(0, dtype=np.int64) if lists is None else np.asarray(lists).ravel()
    if types is not None and len(types) and 0 <= types.min() and types.max() < len(_WIDTHS):
        starts = np.cumsum(_WIDTHS[types] + 1) - _WIDTHS[types] - 1
    else:  # all cells may have as many nodes as the first
        starts = np.arange(0, len(lists), max(int(lists[0]), 0) + 1 if len(lists) else 1)
    ends = lists[starts] + starts + 1 if len(starts) and starts[-1] < len(lists) else starts
    if not np.array_equal(np.append(starts, len(lists)), np.append(0, ends)):
        starts = _walked(lists, what)
    if types is not None and len(starts) != len(types):
        raise ValueError(f"{what} has {len(starts)} cells, but there are {len(types)} types")
    nodes = np.delete(lists, starts)
    return nodes, np.append(starts - np.arange(len(starts)), len(nodes))


def _walked(lists: np.ndarray, what: str) -> np.ndarray:
    """Where the counts of VTK's lists stand."""
    starts, at = [], 0
    while at < len(lists):
        count = int(lists[at])
        if not 0 <= count < len(lists) - at:
            raise ValueError(f"{what} has the count {count} at {at}, which is negative or more than there are nodes "
                             "behind it")
        starts.append(at)
        at += 1 + count
    return np.array(starts, dtype=np.int64)


def _cell_data(mesh: Any) -> dict[str, Any]:
    """Arrays of cells by their names."""
    data = getattr(mesh, "cell_data", None)
    return {str(name): data[name] for name in data.keys()} if hasattr(data, "keys") else {}


def _rows(data: dict[str, Any], rows: Any) -> dict[str, Any]:
    return {name: np.asarray(values)[rows] for name, values in data.items()}


def _blocks_of_surface(mesh: Any) -> list[_Block]:
    """Cells of a PolyData of pyvista: its arrays have points first, then lines, faces and strips."""
    parts, first = [], 0
    for name, usual, other in (("verts", {1: 1}, _POLYVERTEX), ("lines", {2: 3}, _POLYLINE),
                               ("faces", {3: 5, 4: 9}, _POLYGON), ("strips", {}, _STRIP)):
        nodes, offsets = _counted(getattr(mesh, name, None), f"{name} of the mesh")
        types = np.array([usual.get(width, other) for width in np.diff(offsets).tolist()], dtype=np.uint8)
        parts.append((nodes, offsets[:-1] + first, types))
        first += len(nodes)
    nodes, offsets, types = (np.concatenate(arrays) for arrays in zip(*parts))
    return _blocks_of_arrays(nodes, np.append(offsets, first), types, _cell_data(mesh))


def _blocks(mesh: Any) -> list[_Block]:
    """Cells of a mesh of meshio or of pyvista."""
    cells = getattr(mesh, "cells", None)
    if hasattr(mesh, "celltypes"):
        types = np.asarray(mesh.celltypes)
        return _blocks_of_arrays(*_counted(cells, "cells of the mesh", types), types, _cell_data(mesh))
    if isinstance(cells, list):
        return _blocks_of_pairs([(block.type, block.data) for block in cells], _cell_data(mesh))
    if hasattr(mesh, "faces"):
        return _blocks_of_surface(mesh)
    raise TypeError("give points and cells as arrays, or a mesh of meshio or pyvista")


def _is_by_type(cells: Any) -> bool:
    """Whether cells are a dict by types, (type, nodes) pairs, blocks of meshio or VTK's arrays."""
    if isinstance(cells, tuple) and len(cells) in (2, 3) and all(
            isinstance(array, np.ndarray) and array.ndim == 1 for array in cells):
        return len({len(array) for array in cells}) > 1
    return isinstance(cells, dict) or (isinstance(cells, (list, tuple)) and len(cells) > 0 and all(
        hasattr(part, "type") or (isinstance(part, (list, tuple)) and len(part) == 2 and np.ndim(part[0]) == 0
                                  and hasattr(part[1], "__len__")) for part in cells))


def _blocks_by_type(cells: Any) -> list[_Block]:
    """Cells that a caller gives by their types."""
    if isinstance(cells, tuple) and isinstance(cells[0], np.ndarray):
        types = cells[-1]
        if any(array.dtype.kind not in "iu" for array in cells):
            raise TypeError("arrays of cells must be integers")
        taken = _counted(cells[0], "cells", types) if len(cells) == 2 else cells[:2]
        blocks = _blocks_of_arrays(*taken, types, {})
    else:
        pairs = cells.items() if isinstance(cells, dict) else [
            (part.type, part.data) if hasattr(part, "type") else part for part in cells]
        blocks = _blocks_of_pairs(pairs, {})
    if not blocks:
        raise ValueError("cells is empty; give an array of nodes for each type")
    for block in blocks:
        if block.kind is None:
            raise ValueError(f"planish does not know cells of type {block.name!r}; leave them out and give their "
                             f"nodes as fixed. It knows {', '.join(kind.name for kind in _TYPES)}")
    return blocks


def _joined(parts: list[Any]) -> np.ndarray:
    return np.asarray(parts[0]) if len(parts) == 1 else np.concatenate([np.asarray(part) for part in parts])


def _tags(data: dict[str, Any], n: int) -> np.ndarray:
    """One number for each of n cells; cells with the same whole numbers in arrays have the same."""
    tags = np.zeros(n, dtype=np.int64)
    for values in map(np.asarray, data.values()):
        if values.shape == tags.shape and values.dtype.kind in "biuf" and np.all(values == np.floor(values)):
            codes = np.unique(values, return_inverse=True)[1]
            tags = np.unique(tags * (codes.max(initial=0) + 1) + codes, return_inverse=True)[1]
    return tags


def _codes(rows: np.ndarray) -> np.ndarray:
    """One number for each row of nodes; rows with the same nodes, in any order, have the same."""
    rows = np.sort(rows.astype(np.int64), axis=1)
    codes, n = rows[:, 0], rows.max(initial=0) + 1
    for i in range(1, rows.shape[1]):
        codes = np.unique(codes * n + rows[:, i], return_inverse=True)[1].ravel()
    return codes


def _choices(elements: np.ndarray, corners: int) -> np.ndarray:
    """All facets (or edges) of elements, as often as they have them."""
    sets = list(itertools.combinations(range(elements.shape[1]), corners))
    return elements[:, sets].reshape(-1, corners)


def _holders(listed: np.ndarray, tags: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Mask of listed edges or facets that hold their nodes. Where all of the elements' are listed, those
    inside with the tag of most inside hold none, and neither do such edges on the boundary, as in files."""
    holds = np.ones(len(listed), dtype=bool)
    corners, of_element = listed.shape[1], elements.shape[1]
    is_facet = of_element - corners == 1
    least = of_element * len(elements) // 2 if is_facet else len(elements)
    if len(listed) < least:
        return holds
    parts = [listed, _choices(elements, corners)]
    if not is_facet:
        facets = _choices(elements, of_element - 1)
        _, first, count = np.unique(_codes(facets), return_index=True, return_counts=True)
        parts.append(_choices(facets[first[count == 1]], corners))
    codes = np.split(_codes(np.concatenate(parts)), np.cumsum([len(part) for part in parts])[:-1])
    count = np.bincount(codes[1], minlength=max(code.max(initial=0) for code in codes) + 1)
    if not np.isin(codes[1], codes[0]).all():
        return holds
    is_boundary = count[codes[0]] == 1 if is_facet else np.isin(codes[0], codes[2])
    is_inside = (count[codes[0]] > 0) & ~is_boundary
    for there in (is_inside,) if is_facet else (is_inside, is_boundary):
        if there.any():
            holds[there & (tags == np.argmax(np.bincount(tags[there])))] = False
    return holds


def _without_complete(blocks: list[_Block], elements: np.ndarray) -> list[_Block]:
    """Blocks without the edges and facets that are listed only because all are."""
    corners = [getattr(block.kind, "n_corners", 0) for block in blocks]
    kept = [block for block, n in zip(blocks, corners) if n not in (2, 3)]
    for n_corners in (2, 3):
        of_kind = [block for block, n in zip(blocks, corners) if n == n_corners and len(block.nodes)]
        if of_kind:
            names = set.intersection(*(set(block.data) for block in of_kind))
            listed = _joined([block.nodes[:, :n_corners] for block in of_kind])
            tags = _tags({name: _joined([block.data[name] for block in of_kind]) for name in names}, len(listed))
            holds = np.split(_holders(listed, tags, elements), np.cumsum([len(block.nodes) for block in of_kind])[:-1])
            kept += [block._replace(nodes=block.nodes[rows]) for block, rows in zip(of_kind, holds)]
    return kept


def _check_nodes(block: _Block, n_points: int) -> None:
    """Refuse nodes that are none; -1 is a mid that is missing."""
    n_corners = getattr(block.kind, "n_corners", None)
    for nodes, least in ((block.nodes, 0),) if n_corners is None else (
            (block.nodes[:, :n_corners], 0), (block.nodes[:, n_corners:], -1)):
        if nodes.size and not (least <= nodes.min() and nodes.max() < n_points):
            wrong = nodes.max() if nodes.max() >= n_points else nodes.min()
            raise ValueError(f"cells of type {block.name} have node {wrong}, which is not in 0 .. {n_points - 1}")


def _hold(blocks: list[_Block], n_points: int) -> np.ndarray:
    """Which nodes the cells of blocks hold. Points that are all nodes hold none, as in files."""
    held = np.zeros(n_points, dtype=np.uint8)
    for of_points in (True, False):
        for block in blocks:
            if (block.name == _POLYVERTEX or getattr(block.kind, "dim", -1) == 0) == of_points:
                nodes = block.nodes.ravel()
                held[nodes[nodes >= 0]] = 1
        if of_points and held.all():
            held[:] = 0
    return held


def _tag_kind(block: _Block, dim: int) -> Optional[str]:
    """Whether cells are facets or edges of elements of dimension dim."""
    below = dim - getattr(block.kind, "dim", dim)
    return "facets" if below == 1 else "edges" if below == 2 and dim == 3 else None


class _Elements:
    """Elements, which are the cells of the mesh's dimension in the order given, and the nodes that all
    other cells hold.

    Of straight simplices of one type nodes is [m, dim + 1], and types and offsets are None. Else they are
    those of planish_cells. corners [.., dim + 1] are those of simplices, straight or not. at [m] are the
    places of elements among all cells, data arrays [m] by their names.
    """

    def __init__(self, blocks: list[_Block], n_points: int) -> None:
        known = [block for block in blocks if block.kind is not None and len(block.nodes)]
        self.dim = max((block.kind.dim for block in known if block.kind), default=0)
        if self.dim < 2:
            raise ValueError("the mesh has no elements; planish knows "
                             + ", ".join(kind.name for kind in _TYPES if kind.dim >= 2))
        chosen = [block for block in known if block.kind and block.kind.dim == self.dim]
        others = [block for block in blocks if block.kind is None or block.kind.dim < self.dim]
        at = _joined([block.at for block in chosen])
        order = np.argsort(at, kind="stable")
        self.at = at[order]
        self.data = {name: _joined([block.data[name] for block in chosen])
                     for name in chosen[0].data if all(name in block.data for block in chosen)}
        self.data = {name: values[order] if len(values) == len(order) else values for name, values in self.data.items()}
        self.types: Optional[np.ndarray] = None
        self.offsets: Optional[np.ndarray] = None
        self.held: Optional[np.ndarray] = None
        if all(block.kind.number == _SIMPLICES[self.dim][0] for block in chosen if block.kind):
            self.nodes = self.corners = _cells(_joined([block.nodes for block in chosen]))
        else:
            self._lay_out(chosen, order)
        for block in others:
            _check_nodes(block, n_points)
        self.others = _without_complete(others, self.corners) if len(self.corners) else others
        self.held = _hold(self.others, n_points)

    def hold_for_slides(self, n_points: int) -> None:
        """Hold the nodes of other cells, but for facets and edges: these are tags of the surface."""
        if self.held is not None:
            self.held = _hold([block for block in self.others if _tag_kind(block, self.dim) is None], n_points)

    def tagged(self, kind: str) -> Optional[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Facets or edges that are tags of the surface: corners, where those of each begin, and numbers;
        None: there are none."""
        blocks = [block for block in self.others if _tag_kind(block, self.dim) == kind and len(block.nodes)]
        if not blocks:
            return None
        corners = [block.nodes[:, :getattr(block.kind, "n_corners", 0)] for block in blocks]
        names = set.intersection(*(set(block.data) for block in blocks))
        counts = np.concatenate([np.full(len(part), part.shape[1]) for part in corners])
        tags = _tags({name: _joined([block.data[name] for block in blocks]) for name in sorted(names)}, len(counts))
        return (np.concatenate([_narrow(part).ravel() for part in corners]), np.append(0, np.cumsum(counts)),
                tags.astype(np.int32))

    def _lay_out(self, chosen: list[_Block], order: np.ndarray) -> None:
        """Make the arrays of planish_cells."""
        self.types = np.concatenate([np.full(len(block.nodes), block.kind.number, np.uint8) for block in chosen])[order]
        self.offsets = np.append(0, np.cumsum(_WIDTHS[self.types]))
        self.nodes = np.empty(self.offsets[-1], dtype=np.int32)
        rank, first = np.empty(len(order), dtype=np.int64), 0
        rank[order] = np.arange(len(order))
        for block in chosen:
            places = self.offsets[rank[first:first + len(block.nodes)]]
            self.nodes[places[:, None] + np.arange(block.nodes.shape[1])] = _narrow(block.nodes)
            first += len(block.nodes)
        is_simplex = np.isin(self.types, _SIMPLICES[self.dim])
        self.corners = self.nodes[self.offsets[:-1][is_simplex][:, None] + np.arange(self.dim + 1)]

    def has_types(self) -> bool:
        """Whether some are smoothed that are no simplices: aspect ratios stand for radius ratios then."""
        return self.types is not None and not np.isin(self.types, _SIMPLICES[self.dim] + _HELD).all()

    def is_smoothed(self) -> bool:
        """Whether any element is of a type that is smoothed."""
        return self.types is None or not np.isin(self.types, _HELD).all()

    def nodes_of(self, chosen: np.ndarray) -> np.ndarray:
        """Nodes of chosen elements (a mask), as often as these have them."""
        if self.types is None or self.offsets is None:
            return self.nodes[chosen].ravel()
        nodes = self.nodes[np.repeat(chosen, np.diff(self.offsets))]
        return nodes[nodes >= 0]

    @classmethod
    def of_simplices(cls, cells: np.ndarray) -> _Elements:
        """Elements of an array [m, 3 or 4] alone."""
        made = cls.__new__(cls)
        made.nodes = made.corners = _cells(cells)
        made.dim = made.nodes.shape[1] - 1
        made.types = made.offsets = made.held = None
        made.others = []
        made.at, made.data = np.arange(len(made.nodes)), {}
        return made


def _is_in_space(points: np.ndarray) -> bool:
    """Whether points are in no plane of constant z, but for what geometry kernels leave of roundings, as in files."""
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        return False
    noise = 1e-8 if points.dtype.itemsize == 8 else 1e-6
    return not np.ptp(points[:, 2]) <= noise * np.ptp(points[:, :2], axis=0).max()


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
        if dim == 2 and _is_in_space(points):
            raise ValueError("triangles must lie in a plane of constant z; smooth and quality take others, as surfaces")
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


def _narrow(nodes: np.ndarray) -> np.ndarray:
    """Nodes as int32."""
    for node in (nodes.min(initial=0), nodes.max(initial=0)):
        if not -(2**31) <= node < 2**31:
            raise ValueError(f"cells has node {node}, which is out of range")
    return nodes.astype(np.int32, copy=False)


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


class _ByRule:
    """That arrays of cells which look like regions are regions."""

    def __repr__(self) -> str:
        return "by the rule"


_BY_RULE = _ByRule()


def _numbers(values: Any, n: int) -> Optional[np.ndarray]:
    """Values [n] as the library takes them; None if they are not one number for each cell."""
    values = np.asarray(values)
    if values.shape == (n, 1):
        values = values[:, 0]
    if values.shape != (n,) or values.dtype.kind not in "biuf":
        return None
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    native = values.dtype.newbyteorder("=")
    return np.require(values, native if native.name in _NUMBERS else np.float64, "CA")


class _Regions:
    """The arrays of a mesh's cells that tell regions, and what follows from them."""

    def __init__(self, view: _View, data: dict[str, Any], regions: Any) -> None:
        self.view = view
        self.values: list[np.ndarray] = []
        self.names: list[str] = []
        n = view.mesh.n_elements
        wanted = self._wanted(data, regions) if view.elements.is_smoothed() else {}
        for name, values in wanted.items():
            numbers = _numbers(values, n)
            if numbers is not None:
                self.names.append(name)
                self.values.append(numbers)
            elif regions is not _BY_RULE:
                raise ValueError(f"regions: array {name!r} has not one number for each of {n} elements")
        self.arrays = (_CellArray * len(self.names))(*(
            _CellArray(name=name.encode(), values=_address(values), type=_NUMBERS[values.dtype.name], is_region=1)
            for name, values in zip(self.names, self.values)))

    @staticmethod
    def _wanted(data: dict[str, Any], regions: Any) -> dict[str, Any]:
        """The arrays asked for."""
        if regions is None:
            return {}
        if regions is _BY_RULE:
            return data
        names = [regions] if isinstance(regions, str) else regions
        if not isinstance(names, np.ndarray) and all(isinstance(name, str) for name in names):
            for name in names:
                if name not in data:
                    raise ValueError(f"the mesh has no array of cells {name!r}; it has: "
                                     + (", ".join(data) or "none"))
            return {name: data[name] for name in names}
        return {"regions": regions}

    def find(self) -> list[str]:
        """Decide by the rule which arrays tell regions; names of those that do."""
        error = _Error()
        if self.names:
            _check(_library.planish_find_regions(byref(self.view.mesh), self.arrays, c_int(len(self.names)),
                                                 c_int(_threads(self.view.threads)), byref(error)), error)
        return self.used()

    def used(self) -> list[str]:
        """Names of the arrays that tell regions."""
        return [name for name, array in zip(self.names, self.arrays) if array.is_region]

    def combined(self) -> Optional[np.ndarray]:
        """The region [m] of each element; None if there are none."""
        error = _Error()
        if not self.used():
            return None
        region = np.zeros(self.view.mesh.n_elements, dtype=np.int32)
        _check(_library.planish_combine_regions(c_int64(len(region)), self.arrays, c_int(len(self.names)),
                                                c_void_p(_address(region)), None, byref(error)), error)
        return region

    def nodes_between(self) -> Optional[np.ndarray]:
        """Mask [n] of the nodes between regions; None if there are no regions."""
        view, error, region = self.view, _Error(), self.combined()
        if region is None:
            return None
        between = np.zeros(view.n, dtype=np.uint8)
        _check(_library.planish_find_interfaces(byref(view.mesh), c_void_p(_address(region)),
                                                c_int(_threads(view.threads)), c_void_p(_address(between)), None,
                                                byref(error)), error)
        return between.astype(bool)


def _rounding(points: _Points, wanted: Optional[float]) -> float:
    """How far off the middle of a straight edge its mid may be: by default, as in files, by what floats
    leave."""
    if wanted is not None or not points.is_float or not len(points.points):
        return wanted or 0.0
    return max(1e-6 * float(np.linalg.norm(np.ptp(points.array, axis=0))), 2.0**-22 * float(np.abs(points.array).max()))


class _View:
    """A planish_mesh, and the arrays that it points to."""

    def __init__(self, points: Any, cells: Any, fixed: Any, min_volumes: Any, regions: Any = None,
                 threads: int = 0, slides: bool = False) -> None:
        if cells is None:
            blocks: Optional[list[_Block]] = _blocks(points)
            points = points.points
        else:
            blocks = _blocks_by_type(cells) if _is_by_type(cells) else None
        n = len(points) if hasattr(points, "__len__") else 0
        self.elements = _Elements.of_simplices(cells) if blocks is None else _Elements(blocks, n)
        self.dim = self.elements.dim
        self.given = points
        self.points = _Points(points, self.dim)
        self.n = n
        if slides:
            self.elements.hold_for_slides(n)
        held = self.elements.held
        self.constraint = None
        if fixed is not None or (held is not None and held.any()):
            self.constraint = held if held is not None else np.zeros(n, dtype=np.uint8)
            if fixed is not None:
                self.constraint[_nodes(fixed, n, "fixed")] = 1
        self.min_volumes = None
        if min_volumes is not None:
            self.min_volumes = np.require(min_volumes, np.float64, "CA")
            if self.min_volumes.shape != (len(self.elements.at),):
                raise ValueError(f"min_volumes must have one value for each of {len(self.elements.at)} elements")
        wide = self.elements.types is None and self.elements.nodes.dtype == np.int64
        self.mesh = _Mesh(
            dim=self.dim,
            n_nodes=n,
            n_elements=len(self.elements.at),
            coordinates=_address(self.points.array),
            elements64=_address(self.elements.nodes) if wide else None,
            constraint=_address(self.constraint),
            min_volume=_address(self.min_volumes),
            node_stride=self.points.strides[0],
            component_stride=self.points.strides[1],
        )
        if self.elements.types is not None:
            self.cells = _CellsOfTypes(n=len(self.elements.at), type=_address(self.elements.types),
                                       offset=_address(self.elements.offsets), node=_address(self.elements.nodes))
            self.mesh.cells = ctypes.addressof(self.cells)
        elif not wide:
            self.mesh.elements = _address(self.elements.nodes)
        self.threads = threads
        self.region_arrays: list[str] = []
        self.region: Optional[np.ndarray] = None
        self.tagged: list[Any] = []  # arrays of surface()
        self.direction: Optional[np.ndarray] = None
        self.reference: Optional[_Points] = None
        self.is_layer: Optional[np.ndarray] = None
        self.sizes: Optional[np.ndarray] = None
        self._hold_interfaces(self.elements.data, regions, slides)

    def take_reference(self, reference: Any) -> None:
        """Let the elements have the shapes of reference, points or a mesh, as their targets."""
        points = getattr(reference, "points", reference)
        if np.shape(points)[:1] != (self.n,):
            raise ValueError(f"reference must have a row for each of {self.n} points, not the shape {np.shape(points)}")
        self.reference = _Points(points, self.dim, self.points.strides)
        self.mesh.reference = _address(self.reference.array)

    def take_sizes(self, sizes: Any) -> None:
        """Let the elements have these sizes or metrics, given at the points."""
        self.sizes = np.ascontiguousarray(sizes, dtype=float)
        if self.sizes.shape == (self.n,):
            self.mesh.size = _address(self.sizes)
            return
        if self.sizes.shape != (self.n, self.dim, self.dim):
            raise ValueError(f"sizes must have a number or a {self.dim} x {self.dim} matrix for each of {self.n} "
                             f"points, not the shape {self.sizes.shape}")
        off = np.abs(self.sizes - self.sizes.transpose(0, 2, 1)).max(axis=(1, 2))
        if (off > 1e-6 * np.abs(self.sizes).max(axis=(1, 2))).any():
            raise ValueError("sizes that are matrices must be symmetric")
        rows, columns = np.tril_indices(self.dim)
        self.sizes = np.ascontiguousarray(self.sizes[:, rows, columns])
        self.mesh.metric = _address(self.sizes)

    def _hold_interfaces(self, data: dict[str, Any], regions: Any, slides: bool) -> None:
        """Fix the nodes between regions, unless it is to be found which of them slide."""
        found = _Regions(self, data, regions)
        self.region_arrays = found.find() if regions is _BY_RULE else found.used()
        if slides:
            self.region = found.combined()
            return
        between = found.nodes_between()
        if between is None or not between.any():
            return
        if self.constraint is None:
            self.constraint = np.zeros(self.n, dtype=np.uint8)
        self.constraint[between] = 1
        self.mesh.constraint = _address(self.constraint)

    def surface(self) -> _Surface:
        """What is known of the surface; the view keeps its arrays."""
        made = _Surface(region=_address(self.region))
        facets, edges = self.elements.tagged("facets"), self.elements.tagged("edges")
        self.tagged = [facets, edges]
        if facets:
            made.n_facets, made.facets, made.facet_tag = len(facets[2]), _address(facets[0]), _address(facets[2])
            made.facet_offset = _address(facets[1])
        if edges:
            made.n_edges, made.edges, made.edge_tag = len(edges[2]), _address(edges[0]), _address(edges[2])
        return made

    def find_slides(self, shape: Optional[Shape], slide_interfaces: bool) -> SlideInfo:
        """Let nodes slide: constraint and direction."""
        surface, info, error = self.surface(), SlideInfo(), _Error()
        surface.slide_interfaces = bool(slide_interfaces)
        surface.shape = None if shape is None else shape.pointer()
        constraint = np.zeros(self.n, dtype=np.uint8)
        direction = np.zeros((self.n, self.dim))
        _check(_library.planish_find_slides(byref(self.mesh), byref(surface), c_int(_threads(self.threads)),
                                            c_void_p(_address(constraint)), c_void_p(_address(direction)),
                                            byref(info), byref(error)), error)
        self.constraint, self.direction = constraint, direction
        self.mesh.constraint, self.mesh.direction = _address(constraint), _address(direction)
        return info

    def _states(self) -> np.ndarray:
        """planish_cell_state of each element."""
        state, error, quality = np.zeros(self.mesh.n_elements, dtype=np.uint8), _Error(), CellQuality()
        _check(_library.planish_measure_cells(byref(self.mesh), c_double(_rounding(self.points, None)),
                                              c_int(_threads(self.threads)), byref(quality),
                                              byref(_CellValues(state=_address(state))), byref(error)), error)
        return state

    def hold_layers(self, layers: Optional[str]) -> None:
        """Fix the nodes of boundary layers: hold, ignore, or None: those of some types. keep makes layers targets."""
        if layers not in (None, _KEEP_BY_TYPE, "hold", "keep", "ignore"):
            raise ValueError(f"layers must be hold, keep, ignore or None, not {layers!r}")
        if layers == "keep":
            self._keep_layers()
            return
        if layers == _KEEP_BY_TYPE:
            self._keep_layers_by_type()
            return
        elements = self.elements
        if layers is None and (self.reference is not None or self.mesh.metric):  # layers that are targets survive
            return
        chosen = np.ones(self.mesh.n_elements, dtype=bool)
        if layers is None and elements.types is not None:
            is_simplex = np.isin(elements.types, _SIMPLICES[self.dim])
            chosen = self._is_layered() & ((self.dim == 3) | is_simplex.any())
        if layers == "ignore" or (layers is None and elements.types is None) or not chosen.any():
            return
        chosen &= _find_layers(self, self.threads)
        if not chosen.any():
            return
        held = np.zeros(self.n, dtype=bool)
        held[elements.nodes_of(chosen)] = True
        if elements.has_types():  # none of an element that is not valid: such look thin by chance
            self._free_invalid(held, chosen)
        if self.constraint is None:
            self.constraint = np.zeros(self.n, dtype=np.uint8)
        self.constraint[held] = 1
        self.mesh.constraint = _address(self.constraint)

    def _free_invalid(self, held: np.ndarray, chosen: np.ndarray) -> None:
        """Free the held nodes of elements that are not valid; of all where these are many, as a wall was moved."""
        invalid, elements = self._states() != 1, self.elements
        owner = np.repeat(np.arange(len(invalid)), np.diff(elements.offsets))
        touches = (elements.nodes >= 0) & held[elements.nodes] & invalid[owner]
        if 20 * len(np.unique(owner[touches])) > chosen.sum():
            held[:] = False
        held[elements.nodes_of(invalid)] = False

    def _is_layered(self) -> np.ndarray:
        """Mask of the elements of types whose layers count unless said otherwise."""
        corners = np.array([getattr(_KNOWN.get(i), "n_corners", 0) for i in range(256)])[self.elements.types]
        return np.isin(corners, _LAYERED[self.dim]) & ~np.isin(self.elements.types, _SIMPLICES[self.dim])

    def _keep_layers_by_type(self) -> None:
        """Keep the layers if they have elements of some types; else hold as if nothing were said."""
        can = self.elements.types is not None and self.reference is None and self.sizes is None
        chosen = self._is_layered() if can else np.zeros(0, dtype=bool)
        if not chosen.any():
            self.hold_layers(None)
            return
        found = _find_layers(self, self.threads)
        if (found & chosen).any() and 20 * (self._states() != 1).sum() <= found.sum():  # others are thin by chance
            self.is_layer = found.astype(np.uint8)
            self.mesh.is_layer = _address(self.is_layer)

    def _keep_layers(self) -> None:
        """Let the elements of layers be targets, with the heights that they have."""
        if self.reference is not None or self.sizes is not None:
            raise ValueError(f"give {'sizes' if self.reference is None else 'reference'} or layers='keep', not both")
        self.is_layer = _find_layers(self, self.threads).astype(np.uint8)
        self.mesh.is_layer = _address(self.is_layer)

    def own_cells(self) -> None:
        """Make the elements a copy that nobody changes; of 64 bits the library has its own."""
        if self.elements.types is None and self.elements.nodes.dtype == np.int32:
            self.elements.nodes = self.elements.nodes.copy()
            self.mesh.elements = _address(self.elements.nodes)


# ---- what people call ----------------------------------------------------------------------------


class _Faces:
    """A planish_mesh of triangles or quadrilaterals in space, and the arrays that it points to."""

    def __init__(self, points: np.ndarray, elements: _Elements) -> None:
        self.n = len(points)
        self.elements, self.points = elements, _Points(points, 3)
        types, offsets, nodes = elements.types, elements.offsets, elements.nodes
        if types is None:
            nodes = np.require(nodes, np.int32, "C")
            types = np.full(len(nodes), 5, dtype=np.uint8)
            offsets = np.arange(0, 3 * len(nodes) + 1, 3, dtype=np.int64)
        self.arrays = types, offsets, nodes
        self.cells = _CellsOfTypes(n=len(types), type=_address(types), offset=_address(offsets), node=_address(nodes))
        self.mesh = _Mesh(dim=3, n_nodes=self.n, n_elements=len(types), coordinates=_address(self.points.array),
                          node_stride=self.points.strides[0], component_stride=self.points.strides[1],
                          cells=ctypes.addressof(self.cells))

    @staticmethod
    def surface() -> _Surface:
        """What is known of the surface: nothing."""
        return _Surface()


def _view_of_shape(points: Any, cells: Any, regions: Any, threads: int) -> Any:
    """The mesh that a shape is made of: of solids, or of faces in space."""
    if cells is None:
        given, elements = points.points, _Elements(_blocks(points), len(points.points))
    elif _is_by_type(cells):
        given, elements = points, _Elements(_blocks_by_type(cells), len(points))
    else:
        given, elements = points, _Elements.of_simplices(cells)
    if elements.dim == 2 and getattr(given, "ndim", 0) == 2 and given.shape[1] >= 3:
        return _Faces(given, elements)
    return _View(points, cells, None, None, regions, threads, True)


class Shape:
    """The surface of a mesh of solids, or of triangles and quadrilaterals in space, as it came: patches, curves
    between them, and corners (docs/surfaces.md). It remembers these points, so that it can serve many runs
    without drift.

    points, cells and regions as for Plan; facets and edges among the cells are tags: where they change the
    surface has an edge. crease_angle: facets that turn by more degrees have an edge between them, others
    none but for tags; 0: edges are found. info has counts. To be closed, or used in a with statement.
    """

    def __init__(self, points: Any, cells: Any = None, *, regions: Any = _BY_RULE, crease_angle: float = 0,
                 threads: int = 0) -> None:
        self._shape = c_void_p()
        self._threads = threads
        self.info = ShapeInfo()
        view, error = _view_of_shape(points, cells, regions, threads), _Error()
        self._n = view.n
        surface = view.surface()
        surface.crease_angle = crease_angle
        _check(_library.planish_shape_create(byref(view.mesh), byref(surface), c_int(_threads(threads)),
                                             byref(self._shape), byref(self.info), byref(error)), error)

    def pointer(self) -> int:
        """The library's planish_shape."""
        if not self._shape.value:
            raise ValueError("the shape is closed")
        return self._shape.value

    def classes(self) -> np.ndarray:
        """Class [n] of each node: 0 not on the surface, 1 on a patch, 2 on a curve, 3 a corner."""
        found = np.zeros(self._n, dtype=np.uint8)
        _library.planish_shape_get_classes(self.pointer(), _address(found))
        return found

    def distance(self, points: Any) -> ShapeDistance:
        """How far the surface with its nodes at points [n, 3] (or those of a mesh) is off this one, at
        most, and back: proved for every point, not sampled."""
        points = getattr(points, "points", points)
        taken, found, error = _Points(points, 3), ShapeDistance(), _Error()
        mesh = _Mesh(dim=3, n_nodes=len(points), coordinates=_address(taken.array), node_stride=taken.strides[0],
                     component_stride=taken.strides[1])
        _check(_library.planish_measure_shape(c_void_p(self.pointer()), byref(mesh), c_int(_threads(self._threads)),
                                              byref(found), byref(error)), error)
        return found

    def close(self) -> None:
        """Release what the shape holds. No plan that uses it may be used any more then."""
        shape, self._shape = self._shape, c_void_p()
        if shape:
            _library.planish_shape_destroy(shape)

    def __reduce__(self) -> Any:
        raise TypeError("a shape can be neither copied nor pickled; make another one")

    def __enter__(self) -> Shape:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_shape", None):
            self.close()


def _tolerance(given: Any) -> tuple[float, int]:
    """A length and its unit: a number, or a text such as 0.05h, in edges."""
    if isinstance(given, str):
        try:
            return (float(given[:-1]), 1) if given.endswith("h") else (float(given), 0)
        except ValueError:
            raise ValueError(f"surface_tolerance must be a number, or one and h, such as 0.05h, not {given!r}") from None
    return given, 0


class Plan:
    """Stars, colours and memory of one connectivity, for many positions of its nodes.

    points [n, 2 or 3] is an array of numpy, and cells are one of
    - an array [m, 3 or 4] of triangles or tetrahedra
    - a dict, or pairs, of types and arrays [m, k]: meshio's names ("tetra10") with meshio's order of
      nodes, or VTK's numbers with VTK's
    - a tuple of VTK's arrays, (cells, celltypes) as in pyvista, or (nodes, offsets, types)
    Or points is a mesh of meshio or of pyvista, and cells None. Elements are the cells of the highest
    dimension, 2 or 3, in the order given; [m] below means these. They are smoothed, but for pyramids of
    second order. The mid of an edge follows its ends, and may move by itself where it makes a curved
    triangle or tetrahedron bad; -1 is a mid that is missing. All other cells hold their nodes. With any
    elements but triangles or tetrahedra, ratios are aspect ratios AR of all elements (docs/elements.md).
    fixed: numbers, or a mask, of nodes that stay besides those of the boundary. min_volumes [m]:
    minimum volume of each element, 0 for none. layers: hold the nodes of boundary layers (hold), do not
    (ignore), or let them move along their layers, whose heights stay (keep: ratios are then aspect ratios AR of all
    elements, those of layers against the heights that they had); left out: hold those of wedges and hexahedra, and of quadrilaterals beside triangles,
    but no node of an invalid element (smooth keeps them where it can). rounding: how far off the middle of its edge a mid of a
    straight edge may be, in units of the points; None: what floats leave, if points are floats.
    regions: nodes between regions (materials) are held. Left out: those of all arrays of the mesh's
    cell data that look like regions, by the program's rule (docs/algorithm.md). An array [m] of whole
    numbers, the name or names of arrays of the cell data, or None: let these nodes move. region_arrays
    names the arrays used. threads: 0 as many as there are and the mesh is large enough for; one in a child of
    os.fork (multiprocessing), where those of the parent would be waited for.
    only_worse_than and rings: only nodes of cells whose ratio exceeds it move, and of so
    many rings of cells around. around: only these nodes (numbers) move, and of so many rings;
    qualities and results are then of the cells at these.
    slide: which nodes of the boundary move. None: none; auto: those within planes and straight edges, on these;
    curved: also on curved patches and edges, where the surface stays within surface_tolerance of its
    shape. Facets and edges among the cells do not hold their nodes then: they are tags, as for Shape. Nodes
    between regions slide on planes and lines, on curved interfaces only with slide_interfaces. shape: the
    Shape of an earlier mesh of the same cells, so that runs in a row do not add up; crease_angle as for Shape.
    slides has the numbers.
    onto: the Shape of another surface (docs/surfaces.md, "Another surface"). The plan moves the points given, in
    place, onto it as far as cells stay valid, and nodes slide along it then. fit has the numbers, fit_distance
    measures.
    reference: points [n, 2 or 3], or a mesh, of the same nodes: the target of each element is its shape there
    (docs/targets.md), such as that of the mesh before it was deformed. Layers and gradings survive. Ratios are
    then aspect ratios AR of all elements against their targets, layers are held by layers="hold" alone, and every
    element must be valid there. It may not be together with worst elements or edge ratios. size_weight: 0 .. 1,
    what the sizes of cells count against their shapes; None: 0, with sizes 0.9.
    sizes: the edge lengths [n] that cells are to have at the points given, in relation to one another
    (docs/targets.md); find_sizes has those of a mesh, size_quality measures. Or metrics, symmetric matrices
    [n, 2, 2] or [n, 3, 3]: cells are to be regular, with edges of 1, where lengths are measured by them.

    One plan serves one thread at a time: others wait, and are refused with RuntimeError while it
    smooths. To be closed, or used in a with statement.
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
        rings: int = 0,
        around: Optional[Sequence[int]] = None,
        regions: Any = _BY_RULE,
        rounding: Optional[float] = None,
        layers: Optional[str] = None,
        slide: Optional[str] = None,
        shape: Optional[Shape] = None,
        crease_angle: float = 0,
        slide_interfaces: bool = False,
        onto: Optional[Shape] = None,
        reference: Any = None,
        size_weight: Optional[float] = None,
        sizes: Any = None,
    ) -> None:
        if onto is not None and (slide is not None or around is not None or only_worse_than):
            raise ValueError("onto moves all nodes of the boundary: slide, around and only_worse_than have no place")
        if slide not in (None, "auto", "curved"):
            raise ValueError(f"slide must be auto, curved or None, not {slide!r}")
        if slide != "curved" and (shape is not None or (crease_angle and onto is None) or slide_interfaces):
            raise ValueError("shape, crease_angle and slide_interfaces are for slide='curved'")
        self._plan = c_void_p()
        self._lock = threading.RLock()
        self._depth = 0  # uses within one another, by the thread that has the lock
        self._smoother = 0  # the thread that smooths
        self._fit = c_void_p()
        self._view = _View(points, cells, fixed, min_volumes, regions, threads,
                           slide is not None or onto is not None)
        if reference is not None:
            self._view.take_reference(reference)
        if sizes is not None:
            self._view.take_sizes(sizes)
        self._view.hold_layers(layers)
        self.shape = shape
        if slide == "curved" and shape is None:
            self.shape = Shape(points, cells, regions=regions, crease_angle=crease_angle, threads=threads)
        self.slides = self._view.find_slides(self.shape, slide_interfaces) if slide else SlideInfo()
        self._view.own_cells()  # the plan reads them as long as it lives
        self._options = _Options()
        _library.planish_options_init_sized(byref(self._options), c_size_t(ctypes.sizeof(_Options)))
        self._options.threads = _threads(threads)
        self._options.shape = None if self.shape is None else self.shape.pointer()
        self._process = os.getpid()
        if size_weight and reference is None and sizes is None:
            raise ValueError("size_weight is for plans with a reference or sizes")
        if reference is not None and sizes is not None:
            raise ValueError("give reference or sizes, not both")
        self._options.size_weight = size_weight if size_weight is not None else 0 if sizes is None else _SIZE_WEIGHT
        self._options.only_worse_than = only_worse_than
        self._options.rings = _whole(rings, "rings")
        self._options.rounding = _rounding(self._view.points, rounding)
        self._around = None if around is None else _nodes(around, self._view.n, "around")
        if self._around is not None:
            self._options.around = _address(self._around) or 1
            self._options.n_around = self._around.size
        self.fit: Optional[FitInfo] = None
        if onto is not None:
            self._surfaces = onto, Shape(points, cells, regions=regions, crease_angle=crease_angle, threads=threads)
            self._move_onto()
        error = _Error()
        _check(
            _library.planish_plan_create(
                byref(self._view.mesh), byref(self._options), byref(self._plan), byref(error)
            ),
            error,
        )

    def _move_onto(self) -> None:
        """Move the points onto the other surface, and let nodes slide along it."""
        view, options, error, self.fit = self._view, self._options, _Error(), FitInfo()
        taken = _Points(getattr(view.given, "points", view.given), 3, view.points.strides, writes=True)
        options.precision = taken.is_float
        onto, own = self._surfaces
        _check(_library.planish_fit_create(byref(view.mesh), c_void_p(own.pointer()), c_void_p(onto.pointer()),
                                           c_double(0), byref(options), byref(self._fit), None, byref(error)), error)
        _check(_library.planish_fit_move(self._fit, byref(view.mesh), c_void_p(_address(taken.array)),
                                         byref(options), byref(self.fit), byref(error)), error)
        taken.write_back()
        view.points.array[...] = taken.array
        if view.constraint is None:
            view.constraint = np.zeros(view.n, dtype=np.uint8)
        _library.planish_fit_constrain(self._fit, _address(view.constraint))
        view.mesh.constraint = _address(view.constraint)
        options.project = ctypes.cast(_library.planish_fit_project, c_void_p).value
        options.project_user = self._fit

    def fit_distance(self, points: Any = None) -> ShapeDistance:
        """How far the surface with its nodes at points (None: those given at first) is off that of onto, and that
        one off it: proved for every point."""
        found, error = ShapeDistance(), _Error()
        with self._use(measures=True):
            taken = self._coordinates(points)
            if not self._fit:
                raise ValueError("the plan was made without onto")
            mesh = _Mesh.from_buffer_copy(self._view.mesh)
            mesh.coordinates = _address(taken.array)
            _check(_library.planish_fit_measure(self._fit, byref(mesh), byref(found), byref(error)), error)
        return found

    @contextlib.contextmanager
    def _use(self, measures: bool = False) -> Iterator[None]:
        """No other thread uses the plan meanwhile. measures: what it does may also be done by the
        progress of the thread that smooths, and by handlers of signals."""
        at_work = RuntimeError("the plan is at work, in another thread or in the smooth that calls progress: "
                               "it smooths one mesh at a time")
        if self._smoother not in (0, threading.get_ident()):
            raise at_work
        if not self._lock.acquire(blocking=self._process == os.getpid()):
            raise RuntimeError("the plan was at work when this process was forked; make another one here")
        try:
            if self._depth > 0 and not measures:
                raise at_work
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1
        finally:
            self._lock.release()

    def close(self) -> None:
        """Release what the plan holds. It cannot be used any more then."""
        if not self._plan:
            return
        with self._use():
            plan, self._plan = self._plan, c_void_p()
            if plan:
                _library.planish_plan_destroy(plan)
            fit, self._fit = self._fit, c_void_p()
            if fit:
                _library.planish_fit_destroy(fit)

    @property
    def region_arrays(self) -> list[str]:
        """Names of the arrays of cell data between whose values nodes are held."""
        return list(self._view.region_arrays)

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
        with self._use(measures=True):
            if not self._plan:
                raise ValueError("the plan is closed")
            _library.planish_plan_get_free(self._plan, _address(mask))
        return mask.astype(bool)

    def quality(self, points: Any = None) -> Quality:
        """What points [n, 2 or 3] are worth (None: those given at first)."""
        error, found = _Error(), Quality()
        with self._use(measures=True):
            taken = self._coordinates(points)
            _check(
                _library.planish_measure(
                    self._plan, c_void_p(_address(taken.array)), byref(found), byref(error)
                ),
                error,
            )
        return found

    def radius_ratios(self, points: Any = None) -> np.ndarray:
        """Radius ratio [m] of each element at points (AR of all where some are no triangles or
        tetrahedra, by their corners): 1 is best, 0 inverted or flat; nan of those
        that a plan around some nodes does not know."""
        error, ratios = _Error(), np.zeros(self._view.mesh.n_elements)
        with self._use(measures=True):
            taken = self._coordinates(points)
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
        objective: Optional[str] = None,
        worst_measure: Optional[str] = None,
        worst_rise: float = 0.01,
        min_volume: float = 0,
        min_volume_fraction: float = 0,
        area_weight: float = 0,
        curve_quality: float = 0.3,
        surface_tolerance: Any = 0,
        max_displacement: float = 0,
        untangle: bool = True,
        max_sweeps: int = 200,
        tolerance: float = 1e-5,
        time_limit: float = 0,
        progress: Optional[Callable[[Progress], Any]] = None,
    ) -> Result:
        """Smooth points [n, 2 or 3] (None: those given at first) in place, after untangling them.

        objective: radius-ratio (the default of triangles and tetrahedra alone), mean-ratio (that of other
        meshes), edge-ratio, or worst: the default, and then the worst cells by worst_measure, for which F
        may rise by worst_rise of itself. worst_measure: dihedral (default) or radius-ratio of triangles
        and tetrahedra alone, scaled-jacobian (default) or aspect-ratio in other meshes. curve_quality:
        mids of curved elements whose least Jacobian is below so much of their mean move by themselves;
        0: none. surface_tolerance, with slide="curved": how far the surface may be off its shape, a number, or
        one in mean edges, such as "0.02h"; 0: 0.05h. The other options are those of planish_options in planish.h. progress is called after
        every colour of nodes; if it returns something true, smoothing ends there (it may be called once
        more, for the end of the sweep); what it raises, or a signal's handler meanwhile, is raised here,
        and points are then as good as they had become. Without progress signals wait for the end.
        """
        if objective is not None and objective not in _OBJECTIVES:
            raise ValueError(f"objective must be one of {', '.join(_OBJECTIVES)}, not {objective!r}")
        if worst_measure is not None and worst_measure not in _WORST:
            raise ValueError(f"worst_measure must be one of {', '.join(_WORST)}, not {worst_measure!r}")
        tolerance_of_surface = _tolerance(surface_tolerance)
        has_types = self._view.elements.has_types()
        usual = "scaled-jacobian" if has_types else "dihedral"
        if has_types and objective == "radius-ratio":
            raise ValueError("radius-ratio is of triangles and tetrahedra alone; leave objective out, or give "
                             "edge-ratio")
        if (_WORST[worst_measure or usual] > 2) != has_types:
            raise ValueError(f"worst_measure {worst_measure!r} is of other elements than the mesh has; leave it out")
        with self._use():
            taken = self._coordinates(points, writes=True)
            options, error, result = self._options, _Error(), Result()
            options.objective = _OBJECTIVES[objective or "radius-ratio"]
            options.worst = _WORST[worst_measure or usual] if objective == "worst" else 0
            options.worst_rise = worst_rise
            options.min_volume = min_volume
            options.min_volume_fraction = min_volume_fraction
            options.area_weight = area_weight
            options.curve_quality = curve_quality
            options.surface_tolerance, options.surface_tolerance_unit = tolerance_of_surface
            if self.shape is not None:
                options.shape = self.shape.pointer()
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
            self._smoother = threading.get_ident()
            try:
                status = _library.planish_smooth(
                    self._plan, c_void_p(_address(taken.array)), byref(options), byref(result), byref(error)
                )
            finally:
                self._smoother = 0
                if sys.unraisablehook is note:
                    sys.unraisablehook = hook
                options.progress = _PROGRESS()
            _check(status, error)
            taken.write_back()
            if raised:
                raise raised[0]
            return result


_OF_PLAN = ("fixed", "min_volumes", "threads", "only_worse_than", "rings", "around", "regions", "rounding",
            "layers", "slide", "shape", "crease_angle", "slide_interfaces", "onto", "reference", "size_weight", "sizes")


_OF_FACES = ("fixed", "threads", "only_worse_than", "rings", "shape", "crease_angle", "objective", "worst_measure",
             "worst_rise", "surface_tolerance", "max_displacement", "max_sweeps", "tolerance", "time_limit", "progress")


class _Surface3D:
    """Triangles and quadrilaterals in space, in no plane of constant z, with the shape of their surface."""

    def __init__(self, view: _Faces, given: tuple[Any, Any], fixed: Any, threads: int, shape: Optional[Shape] = None,
                 crease_angle: float = 0) -> None:
        self.view, self.threads = view, threads
        held = view.elements.held
        self.constraint = np.zeros(view.n, dtype=np.uint8) if held is None else held.astype(np.uint8)
        if fixed is not None:
            self.constraint[_nodes(fixed, view.n, "fixed")] = 1
        view.mesh.constraint = _address(self.constraint)
        self.shape = shape or Shape(*given, crease_angle=crease_angle, threads=threads)

    @staticmethod
    def of(points: Any, cells: Any, **options: Any) -> Optional[_Surface3D]:
        """The surface that points and cells are, or None."""
        given = getattr(points, "points", None) if cells is None else points
        if not isinstance(given, np.ndarray) or not _is_in_space(given):
            return None
        if cells is not None and not _is_by_type(cells) and np.ndim(cells) == 2 and np.shape(cells)[1] != 3:
            return None
        view = _view_of_shape(points, cells, None, options.get("threads", 0))
        return _Surface3D(view, (points, cells), **options) if isinstance(view, _Faces) else None

    def smooth(self, points: np.ndarray, chosen: dict[str, Any]) -> Result:
        """Smooth points in place."""
        has_quads = not np.isin(self.view.arrays[0], _SIMPLICES[2]).all()
        worst = chosen.pop("worst_measure", None) or ("scaled-jacobian" if has_quads else "dihedral")
        objective, progress = chosen.pop("objective", None), chosen.pop("progress", None)
        usual = "mean-ratio" if has_quads else "radius-ratio"
        if objective not in (None, "worst", usual) or worst not in _WORST:
            raise ValueError(f"objective must be {usual} or worst, and worst_measure one of {', '.join(_WORST)}")
        options, error, result, raised = _Options(), _Error(), Result(), []
        _library.planish_options_init_sized(byref(options), c_size_t(ctypes.sizeof(_Options)))
        taken = _Points(points, 3, self.view.points.strides, writes=True)
        options.threads, options.shape = _threads(self.threads), self.shape.pointer()
        options.precision = taken.is_float
        options.worst = _WORST[worst] if objective == "worst" else 0
        tolerance = _tolerance(chosen.pop("surface_tolerance", 0))
        options.surface_tolerance, options.surface_tolerance_unit = tolerance
        for name, value in chosen.items():
            setattr(options, name, value)

        def call(seen: Any, _user: Any) -> int:
            try:
                return bool(raised or progress(Progress.from_buffer_copy(seen.contents)))
            except BaseException as exception:  # pylint: disable=broad-except
                raised.append(exception)
                return 1

        options.progress = _PROGRESS(call) if progress is not None else _PROGRESS()
        _check(_library.planish_smooth_surface(byref(self.view.mesh), c_void_p(_address(taken.array)), byref(options),
                                               byref(result), byref(error)), error)
        taken.write_back()
        if raised:
            raise raised[0]
        return result

    def quality(self, per_element: bool) -> Quality:
        """What the surface is worth."""
        found, cells, error = Quality(), CellQuality(), _Error()
        m = self.view.mesh.n_elements if per_element else 0
        arrays = CellValues(self.view.elements.at, *(np.zeros(m, dtype) for dtype in (np.uint8, np.uint8) + 4 * (float,)))
        values = _CellValues(**{name: _address(array) for name, array in arrays._asdict().items() if name != "number"})
        _check(_library.planish_measure_surface(
            c_void_p(self.shape.pointer()), byref(self.view.mesh), c_int(_threads(self.threads)), byref(found), None,
            byref(cells), byref(values) if per_element else None, byref(error)), error)
        if per_element:
            found.elements = arrays._replace(is_curved=arrays.is_curved.astype(bool))
        if per_element or not np.all(self.view.arrays[0] == 5):
            found.cells = cells
        return found


def _smooth_faces(points: Any, cells: Any, options: dict[str, Any]) -> Optional[Result]:
    """Smooth a mesh that is a surface in space; None: it is none."""
    of_shape = {name: options[name] for name in ("threads", "shape", "crease_angle") if name in options}
    surface = _Surface3D.of(points, cells, fixed=options.get("fixed"), **{"threads": 0, **of_shape})
    if surface is None:
        return None
    strange = [name for name in options if name not in _OF_FACES and options[name] is not None
               and (name, options[name]) not in (("slide", "curved"), ("layers", "ignore"))]
    if strange:
        raise ValueError(f"{strange[0]} is not for surfaces in space")
    chosen = {name: value for name, value in options.items()
              if name in _OF_FACES and name not in ("fixed", "threads", "shape", "crease_angle")}
    return surface.smooth(getattr(points, "points", points), chosen)


def smooth(points: Any, cells: Any = None, **options: Any) -> Result:
    """Smooth a mesh in place: points and cells as for Plan, options those of Plan and Plan.smooth. With onto the
    result has fit and fit_distance. layers left out: those of wedges, hexahedra and quadrilaterals are kept, where
    neither objective, reference nor sizes speak against it; else they are held as by Plan."""
    known = {*_OF_PLAN, *Plan.smooth.__kwdefaults__}
    if not known.issuperset(options):
        raise TypeError(f"{min(set(options) - known)} is no option of smooth: {', '.join(sorted(known))}")
    of_surface = _smooth_faces(points, cells, options)
    if of_surface is not None:
        return of_surface
    of_plan = {name: options.pop(name) for name in _OF_PLAN if name in options}
    if of_plan.get("layers") is None and options.get("objective") in (None, "mean-ratio"):
        of_plan["layers"] = _KEEP_BY_TYPE
    with Plan(points, cells, **of_plan) as plan:
        result = plan.smooth(**options)
        if plan.fit is not None:
            result.fit, result.fit_distance = plan.fit, plan.fit_distance()
        return result


def quality(points: Any, cells: Any = None, *, fixed: Any = None, regions: Any = _BY_RULE,
            rounding: Optional[float] = None, per_element: bool = False, reference: Any = None,
            sizes: Any = None) -> Quality:
    """Quality of a mesh: points, cells, fixed, regions, rounding and reference as for Plan. Its cells tell of
    elements of all types, or against the reference; per_element gives it elements, the measures of each one, too.
    With sizes that are metrics, as for Plan, given where the points are at reference, AR is that in these.
    Triangles and quadrilaterals in space, in no plane of constant z, are measured each in its own plane."""
    surface = _Surface3D.of(points, cells, fixed=fixed, threads=0)
    if surface is not None and (reference is not None or sizes is not None):
        raise ValueError(f"{'reference is' if sizes is None else 'sizes are'} not for surfaces in space")
    if surface is not None:
        return surface.quality(per_element)
    view, error, found, options = _View(points, cells, fixed, None, regions), _Error(), Quality(), _Options()
    _library.planish_options_init_sized(byref(options), c_size_t(ctypes.sizeof(_Options)))
    options.threads = _threads(0)
    if reference is not None and sizes is None:
        view.take_reference(reference)
    is_simple = view.elements.types is None and reference is None and sizes is None
    if view.elements.is_smoothed():
        _check(_library.planish_measure_mesh(byref(view.mesh), byref(options), byref(found), byref(error)), error)
    if sizes is not None:
        view.take_sizes(sizes)
        if reference is not None:
            view.take_reference(reference)
    if per_element or not is_simple:
        _measure_cells(view, rounding, per_element, found)
    return found


def _measure_cells(view: _View, rounding: Optional[float], per_element: bool, found: Quality) -> None:
    """Measure elements of all types."""
    m, error = view.mesh.n_elements if per_element else 0, _Error()
    arrays = CellValues(view.elements.at, *(np.zeros(m, dtype) for dtype in (np.uint8, np.uint8) + 4 * (float,)))
    values = _CellValues(**{name: _address(array) for name, array in arrays._asdict().items() if name != "number"})
    found.cells = CellQuality()
    _check(_library.planish_measure_cells(byref(view.mesh), c_double(_rounding(view.points, rounding)),
                                          c_int(_threads(0)), byref(found.cells),
                                          byref(values) if per_element else None, byref(error)), error)
    if per_element:
        found.elements = arrays._replace(is_curved=arrays.is_curved.astype(bool))


def find_slides(points: Any, cells: Any = None, *, fixed: Any = None, regions: Any = _BY_RULE,
                shape: Optional[Shape] = None, slide_interfaces: bool = False, threads: int = 0) -> Slides:
    """Which nodes slide on planes, straight edges and, with shape, on its patches and curves: points, cells,
    fixed, regions and slide_interfaces as for Plan."""
    view = _View(points, cells, fixed, None, regions, threads, True)
    info = view.find_slides(shape, slide_interfaces)
    return Slides(view.constraint, view.direction, info)


def find_sizes(points: Any, cells: Any = None, *, threads: int = 0) -> np.ndarray:
    """Sizes [n] that a mesh has: at each point the mean of its cells', as edge lengths of ideal ones. As sizes of
    Plan they are kept. points and cells as for Plan."""
    view, error = _View(points, cells, None, None), _Error()
    sizes = np.zeros(view.n)
    _check(_library.planish_find_sizes(byref(view.mesh), c_int(_threads(threads)), c_void_p(_address(sizes)),
                                       byref(error)), error)
    return sizes


def size_quality(points: Any, cells: Any = None, *, sizes: Any, start: Any = None, per_element: bool = False,
                 threads: int = 0) -> SizeQuality:
    """Sizes of the cells against sizes or metrics, as of Plan, given where the points are at start (None: now).
    per_element: with ratio [m]."""
    view, error, found = _View(points, cells, None, None), _Error(), SizeQuality()
    view.take_sizes(sizes)
    if start is not None:
        view.take_reference(start)
    ratio = np.zeros(view.mesh.n_elements if per_element else 0)
    _check(_library.planish_measure_sizes(byref(view.mesh), c_int(_threads(threads)), byref(found),
                                          c_void_p(_address(ratio)) if per_element else None, byref(error)), error)
    found.ratio = ratio if per_element else None
    return found


def find_layers(points: Any, cells: Any = None, *, threads: int = 0) -> np.ndarray:
    """Mask [m] of the elements that are thin in layers, as those of a boundary layer: smoothing would
    make them regular, unless their nodes are fixed. points and cells as for Plan."""
    return _find_layers(_View(points, cells, None, None), threads)


def _find_layers(view: _View, threads: int) -> np.ndarray:
    """find_layers of a view."""
    error = _Error()
    mask = np.zeros(view.mesh.n_elements, dtype=np.uint8)
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
