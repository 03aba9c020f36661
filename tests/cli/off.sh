#!/usr/bin/env bash
# OFF files as meshio writes them: read back they differ in coordinates alone.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import numpy, meshio" 2>/dev/null || { echo "skipped: no numpy or meshio"; exit 77; }

python3 "$cli/make_slow_mesh.py" 12 square.mesh
"$python" - <<'END' >/dev/null 2>&1 || fail "meshio writes"
import meshio, numpy
mesh = meshio.read("square.mesh")
points = numpy.zeros((len(mesh.points), 3))
points[:, :2] = mesh.points[:, :2]
triangles = [block for block in mesh.cells if block.type == "triangle"]
meshio.Mesh(points, triangles).write("square.off")
END
expect_status 0 "$program" smooth square.off -o smooth.off --json report.json -q
"$python" "$cli/same_mesh.py" square.off smooth.off report.json || fail "meshio reads it back"
[ "$(wc -l <square.off)" = "$(wc -l <smooth.off)" ] || fail "lines"
[ "$(diff square.off smooth.off | grep -c '^>')" = \
    "$(python3 -c "import json; print(json.load(open('report.json'))['moved_nodes'])")" ] ||
    fail "lines that changed"

# The same as from the Medit file, which has the same numbers.
expect_status 0 "$program" smooth square.mesh -o smooth.mesh -q
"$python" - <<'END' 2>/dev/null || fail "OFF and Medit are smoothed alike"
import meshio
assert (meshio.read("smooth.mesh").points[:, :2] == meshio.read("smooth.off").points[:, :2]).all()
END

# A surface in space is refused.
printf 'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >space.off
expect_status 2 "$program" smooth space.off -o out.off
expect_one_line
expect_text "surfaces cannot"
expect_no_file out.off
finish
