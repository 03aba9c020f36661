"""Print a program in C that compares the structures of the Python module with the header's."""

import ctypes

import planish
from planish import _io_structures, _structures

STRUCTURES = {
    "planish_error": _structures.ErrorInfo,
    "planish_mesh": _structures.MeshView,
    "planish_cells": _structures.Cells,
    "planish_cell_measures": planish.CellMeasures,
    "planish_cell_quality": planish.CellQuality,
    "planish_cell_values": _structures.CellValueArrays,
    "planish_cell_array": _structures.CellArray,
    "planish_progress": planish.Progress,
    "planish_options": _structures.Options,
    "planish_spread": planish.Spread,
    "planish_quality": planish.Quality,
    "planish_result": planish.Result,
    "planish_surface": _structures.Surface,
    "planish_slide_info": planish.SlideInfo,
    "planish_shape_info": planish.ShapeInfo,
    "planish_shape_distance": planish.ShapeDistance,
    "planish_fit_info": planish.FitInfo,
    "planish_size_quality": planish.SizeQuality,
    "planish_layer_row": planish.LayerRow,
    "planish_layer_heights": planish.LayerHeights,
    "planish_open_options": _io_structures.OpenOptions,
    "planish_format_info": _io_structures.FormatInfo,
    "planish_file_info": _io_structures.FileInfo,
    "planish_plane": _io_structures.Plane,
    "planish_data_info": _io_structures.DataInfo,
    "planish_data": _io_structures.Data,
    "planish_group": _io_structures.Group,
    "planish_hold": _io_structures.Hold,
    "planish_write_options": _io_structures.WriteOptions,
    "planish_convert_options": _io_structures.ConvertOptions,
}

print("#include <planish/planish_io.h>\n#include <stdio.h>\nint main(void) {\n    int bad = 0;")
for name, structure in STRUCTURES.items():
    checks = [(f"sizeof({name})", ctypes.sizeof(structure))]
    for field, *_ in structure._fields_:
        at = getattr(structure, field)
        c_field = field.lstrip("_")
        checks.append((f"offsetof({name}, {c_field})", at.offset))
        checks.append((f"sizeof((({name} *)0)->{c_field})", at.size))
    for expression, value in checks:
        print(
            f'    if ({expression} != {value}) bad = printf("%s is %zu, not {value}\\n", '
            f'"{expression}", (size_t)({expression}));'
        )
print("    return bad != 0;\n}")
