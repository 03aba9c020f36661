"""Print a program in C that compares the structures of the Python module with the header's."""

import ctypes

import planish

STRUCTURES = {
    "planish_error": planish._Error,
    "planish_mesh": planish._Mesh,
    "planish_cells": planish._CellsOfTypes,
    "planish_cell_measures": planish.CellMeasures,
    "planish_cell_quality": planish.CellQuality,
    "planish_cell_values": planish._CellValues,
    "planish_cell_array": planish._CellArray,
    "planish_progress": planish.Progress,
    "planish_options": planish._Options,
    "planish_spread": planish.Spread,
    "planish_quality": planish.Quality,
    "planish_result": planish.Result,
    "planish_surface": planish._Surface,
    "planish_slide_info": planish.SlideInfo,
    "planish_shape_info": planish.ShapeInfo,
    "planish_shape_distance": planish.ShapeDistance,
    "planish_fit_info": planish.FitInfo,
    "planish_size_quality": planish.SizeQuality,
}

print("#include <planish/planish.h>\n#include <stdio.h>\nint main(void) {\n    int bad = 0;")
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
