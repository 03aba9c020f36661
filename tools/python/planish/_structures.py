"""Structures of planish.h for this package, field by field."""

from __future__ import annotations

import ctypes
from ctypes import Structure, c_char, c_double, c_int64, c_void_p
from typing import Annotated, Any

from ._fields import Double, Int, Int64, Pointer, Size, Text, fields

Reserved1 = Annotated[Any, c_void_p * 1]
Reserved4 = Annotated[Any, c_void_p * 4]
Reserved6 = Annotated[Any, c_void_p * 6]
Reserved8 = Annotated[Any, c_void_p * 8]
Numbers2 = Annotated[Any, c_int64 * 2]
Numbers3 = Annotated[Any, c_int64 * 3]
Numbers7 = Annotated[Any, c_int64 * 7]
Vector = Annotated[Any, c_double * 3]


@fields
class ErrorInfo(Structure):
    """planish_error."""

    code: Int
    element: Int64
    node: Int64
    text: Annotated[bytes, c_char * 512]


@fields
class MeshView(Structure):
    """planish_mesh."""

    dim: Int
    n_nodes: Int64
    n_elements: Int64
    coordinates: Pointer
    elements: Pointer
    constraint: Pointer
    direction: Pointer
    n_periodic: Int64
    periodic: Pointer
    min_volume: Pointer
    elements64: Pointer
    node_stride: Int64
    component_stride: Int64
    neighbours: Pointer
    neighbours64: Pointer
    part: Pointer
    cells: Pointer
    reference: Pointer
    is_layer: Pointer
    size: Pointer
    metric: Pointer
    reserved: Reserved8


@fields
class Cells(Structure):
    """planish_cells."""

    n: Int64
    type: Pointer
    offset: Pointer
    node: Pointer
    reserved: Reserved4


@fields
class CellValueArrays(Structure):
    """planish_cell_values."""

    state: Pointer
    is_curved: Pointer
    aspect_ratio: Pointer
    scaled_jacobian: Pointer
    jacobian_ratio: Pointer
    edge_ratio: Pointer
    reserved: Reserved4


@fields
class Surface(Structure):
    """planish_surface."""

    region: Pointer
    n_facets: Int64
    facets: Pointer
    facet_tag: Pointer
    n_edges: Int64
    edges: Pointer
    edge_tag: Pointer
    is_inside: Pointer
    tagged_only: Int
    slide_interfaces: Int
    tolerance: Double
    facet_offset: Pointer
    shape: Pointer
    crease_angle: Double
    reserved: Reserved4


@fields
class CellArray(Structure):
    """planish_cell_array."""

    name: Text
    values: Pointer
    type: Int
    is_region: Int
    reserved: Reserved4


@fields
class ProgressFields(Structure):
    """planish_progress."""

    sweep: Int
    colour: Int
    n_colours: Int
    sweep_done: Int
    rms: Double
    rms_movable: Double
    objective: Double
    n_inverted: Int64
    n_below_min_volume: Int64
    phase: Int
    visits: Int64
    seconds: Double
    elapsed: Double
    colour_visits: Int64
    _positions: Pointer
    reserved: Numbers2


PROGRESS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ProgressFields), c_void_p)


@fields
class Options(Structure):
    """planish_options."""

    struct_size: Size
    threads: Int
    bind: Int
    isa: Int
    method: Int
    objective: Int
    search: Int
    min_volume: Double
    min_volume_fraction: Double
    area_weight: Double
    lower: Pointer
    upper: Pointer
    box_lower: Vector
    box_upper: Vector
    max_displacement: Double
    rounding: Double
    displacement_unit: Int
    precision: Int
    untangle: Int
    worst: Int
    worst_rise: Double
    max_sweeps: Int
    tolerance: Double
    time_limit: Double
    only_worse_than: Double
    rings: Int
    n_around: Int64
    around: Pointer
    around_elements: Pointer
    progress: Annotated[Any, PROGRESS]
    progress_user: Pointer
    project: Pointer
    project_user: Pointer
    allocator: Pointer
    parallel: Pointer
    parallel_user: Pointer
    log: Pointer
    log_user: Pointer
    round: Pointer
    round_user: Pointer
    curve_quality: Double
    shape: Pointer
    surface_tolerance: Double
    surface_tolerance_unit: Int
    size_weight: Double
    reserved: Reserved8
