"""The structures of planish_io.h, field by field."""

from __future__ import annotations

from ctypes import Structure, c_double, c_int
from typing import Annotated, Any

from ._fields import Double, Int, Int64, Pointer, Size, Text, fields
from ._structures import CellValueArrays, Numbers3, Reserved1, Reserved4, Reserved6, Reserved8, Vector


@fields
class OpenOptions(Structure):
    """planish_open_options."""

    format: Text
    threads: Int
    isolated: Int
    plane_tolerance: Double
    reserved: Reserved6


@fields
class FormatInfo(Structure):
    """planish_format_info."""

    name: Text
    title: Text
    extensions: Pointer
    note: Text
    reads: Text
    is_read: Int
    reserved: Reserved4


@fields
class FileInfo(Structure):
    """planish_file_info."""

    format: Text
    precision: Int
    round: Pointer
    round_user: Pointer
    n_other_elements: Int64
    n_lower_elements: Int64
    n_regions: Int64
    bytes: Int64
    is_unterminated: Int
    has_normals: Int
    off_plane: Double
    reserved: Numbers3


@fields
class Plane(Structure):
    """planish_plane."""

    axis: Annotated[Any, c_int * 3]
    is_tilted: Int
    origin: Vector
    direction: Annotated[Any, (c_double * 3) * 2]
    normal: Vector
    off: Double
    reserved: Reserved8


@fields
class DataInfo(Structure):
    """planish_data_info."""

    name: Text
    of_elements: Int
    n_components: Int
    reserved: Reserved4


@fields
class Data(Structure):
    """planish_data."""

    of_elements: Int
    n_components: Int
    n: Int64
    values: Pointer
    reserved: Reserved4


@fields
class Group(Structure):
    """planish_group."""

    tag: Text
    dim: Int
    n: Int64
    reserved: Reserved1


@fields
class Hold(Structure):
    """planish_hold."""

    tags: Pointer
    n_tags: Int
    ignore_regions: Int
    ignore_marked: Int
    slide: Int
    slide_tags: Pointer
    n_slide_tags: Int
    reserved: Reserved4


@fields
class WriteOptions(Structure):
    """planish_write_options."""

    threads: Int
    temporary: Pointer
    temporary_size: Size
    reserved: Reserved4


@fields
class ConvertOptions(Structure):
    """planish_convert_options."""

    format: Text
    constraint: Pointer
    radius_ratio: Pointer
    cells: CellValueArrays
    temporary: Pointer
    temporary_size: Size
    lost: Pointer
    lost_size: Size
    reserved: Reserved4
