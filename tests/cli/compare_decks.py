"""Compare an Abaqus or Nastran file with what planish made of it: compare_decks.py BEFORE AFTER
[MESH]. Only lines of nodes may differ, meshio reads the same cells and sets, and the points it reads
are written to MESH (.mesh), in all digits."""
import sys

import meshio
import numpy

before_name, after_name = sys.argv[1:3]
before, after = (open(name, "rb").read().splitlines(True) for name in (before_name, after_name))
assert len(before) == len(after), "lines were added or removed"
changed = [i for i in range(len(before)) if before[i] != after[i]]
assert changed, "nothing was moved"
if before_name.endswith(".inp"):
    first = next(i for i, line in enumerate(before) if line.upper().startswith(b"*NODE"))
    last = next(i for i in range(first + 1, len(before)) if before[i].startswith(b"*"))
    assert first < changed[0] and changed[-1] < last, "a line that is no node was changed"
else:
    assert all(before[i].startswith((b"GRID", b"*")) for i in changed), "a card that is no GRID"
    if not any(b"," in line for line in before):
        assert all(len(before[i]) == len(after[i]) for i in changed), "columns were moved"

old, new = meshio.read(before_name), meshio.read(after_name)
assert old.points.shape == new.points.shape
assert 0 < numpy.abs(old.points - new.points).max() < 1
assert len(old.cells) == len(new.cells)
for a, b in zip(old.cells, new.cells):
    assert a.type == b.type and (a.data == b.data).all()
assert old.cell_sets.keys() == new.cell_sets.keys()
for name in old.cell_data:
    for a, b in zip(old.cell_data[name], new.cell_data[name]):
        assert (a == b).all()
if len(sys.argv) > 3:
    tetrahedra = [("tetra", block.data) for block in new.cells if block.type == "tetra"]
    meshio.Mesh(new.points, tetrahedra).write(sys.argv[3], file_format="medit", float_fmt=".17g")
