"""Whether a mesh that was smoothed is the one it was but for coordinates, as meshio reads them.

    same_mesh.py BEFORE AFTER REPORT.json
"""
import contextlib
import io
import json
import sys

import meshio
import numpy

before_name, after_name, report_name = sys.argv[1:]
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    before, after = meshio.read(before_name), meshio.read(after_name)
report = json.load(open(report_name))


def same(a, b):
    return set(a) == set(b) and all(numpy.array_equal(a[name], b[name]) for name in a)


assert before.points.dtype == after.points.dtype and before.points.shape == after.points.shape
assert [block.type for block in before.cells] == [block.type for block in after.cells]
for old, new in zip(before.cells, after.cells):
    assert numpy.array_equal(old.data, new.data), old.type
assert same(before.point_data, after.point_data)
assert set(before.cell_data) == set(after.cell_data)
for name, blocks in before.cell_data.items():
    assert all(numpy.array_equal(a, b) for a, b in zip(blocks, after.cell_data[name])), name
assert same(before.field_data, after.field_data)
moved = numpy.any(before.points != after.points, axis=1)
assert moved.sum() == report["moved_nodes"] > 0, (moved.sum(), report["moved_nodes"])
