#!/usr/bin/env bash
# OFF, STL, OBJ and PLY files as meshio writes them: read back they differ in coordinates alone.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import numpy, meshio" 2>/dev/null || { echo "skipped: no numpy or meshio"; exit 77; }

python3 "$cli/make_slow_mesh.py" 12 square.mesh
"$python" - <<'END' >/dev/null 2>&1 || fail "meshio writes"
import meshio, numpy
mesh = meshio.read("square.mesh")
points = numpy.zeros((len(mesh.points), 3))
points[:, :2] = mesh.points[:, :2]
triangles = [("triangle", block.data) for block in mesh.cells if block.type == "triangle"]
for name, how in (("square.off", {}), ("square.obj", {}), ("text.ply", {"binary": False}), ("little.ply", {}),
                  ("text.stl", {"binary": False}), ("binary.stl", {"binary": True})):
    meshio.Mesh(points, triangles).write(name, **how)
END
# The same as from the Medit file, which has the same numbers.
expect_status 0 "$program" smooth square.mesh -o smooth.mesh -q
for file in square.off square.obj text.ply little.ply; do
    expect_status 0 "$program" smooth $file -o "smooth_$file" --json report.json -q
    "$python" "$cli/same_mesh.py" $file "smooth_$file" report.json || fail "meshio reads $file back"
    "$python" - "smooth_$file" <<'END' 2>/dev/null || fail "$file and Medit are smoothed alike"
import meshio, sys
assert (meshio.read("smooth.mesh").points[:, :2] == meshio.read(sys.argv[1]).points[:, :2]).all()
END
    [ $file != little.ply ] || continue
    [ "$(wc -l <$file)" = "$(wc -l <"smooth_$file")" ] || fail "lines of $file"
    [ "$(diff $file "smooth_$file" | grep -c '^>')" = \
        "$(python3 -c "import json; print(json.load(open('report.json'))['moved_nodes'])")" ] ||
        fail "lines of $file that changed"
done

# STL in a tilted plane: points stay together, moved facets have their normal, others keep their bytes.
"$python" - <<'END' || fail "tilted squares"
import re
import struct
facets = []
for line in open("text.stl"):
    if "facet normal" in line:
        facets.append([])
    if "vertex" in line:
        x, y, z = map(float, line.split()[1:])
        facets[-1].append((x, y, 2 * x))
with open("tilted.stl", "w") as out:
    out.write("solid a tilted square\n")
    for f in facets:
        out.write("facet normal -2 0 1\nouter loop\n" + "".join("vertex %r %r %r\n" % p for p in f) +
                  "endloop\nendfacet\n")
    out.write("endsolid\n")
open("tilted_binary.stl", "wb").write(
    b"solid or not".ljust(80) + struct.pack("<I", len(facets)) +
    b"".join(struct.pack("<12fH", 2, 0, -1, *(x for p in f for x in p), i % 9) for i, f in enumerate(facets)))
END
for file in tilted.stl tilted_binary.stl text.stl binary.stl; do
    expect_status 0 "$program" smooth $file -o "smooth_$file" --json report.json -q
    python3 - $file <<'END' || fail "points and normals of $file"
import json
import struct
import sys


def read(name):
    data = open(name, "rb").read()
    if len(data) == 84 + 50 * struct.unpack("<I", data[80:84])[0]:
        return [(data[:84], struct.unpack("<9f", data[at + 12:at + 48]), struct.unpack("<3f", data[at:at + 12]),
                 data[at + 48:at + 50]) for at in range(84, len(data), 50)]
    words = data.split()
    return [(words[:4], tuple(float(words[i + k]) for k in (7, 8, 9, 11, 12, 13, 15, 16, 17)),
             tuple(float(w) for w in words[i + 1:i + 4]), words[i + 4:i + 6])
            for i in range(len(words)) if words[i] == b"normal"]


old, new = read(sys.argv[1]), read("smooth_" + sys.argv[1])
place, n_renewed = {}, 0
for a, b in zip(old, new, strict=True):
    assert a[0] == b[0] and a[3] == b[3]
    for k in (0, 3, 6):
        assert place.setdefault(a[1][k:k + 3], b[1][k:k + 3]) == b[1][k:k + 3]
    n_renewed += a[2] != b[2]
    u, v = ([b[1][d + k] - b[1][d] for d in range(3)] for k in (3, 6))
    normal = [u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3] for d in range(3)]
    length = sum(x * x for x in normal) ** 0.5
    side = 1 if sum(x * y for x, y in zip(normal, a[2])) > 0 else -1
    if a[1] == b[1]:
        assert a[2] == b[2]
    else:
        assert all(abs(side * x / length - y) < 1e-4 for x, y in zip(normal, b[2])), (normal, b[2])
moved = sum(a != b for a, b in place.items())
assert moved == json.load(open("report.json"))["moved_nodes"] > 0
assert len(set(place.values())) == len(place)
assert (n_renewed > 0) == sys.argv[1].startswith("tilted")
END
done

# Normals of nodes go stale, which a note says.
sed 's/^v .*/&\nvn 0 0 1/' square.obj >normals.obj
expect_status 0 "$program" smooth normals.obj -o out.obj
expect_text "normals of nodes"
expect_status 0 "$program" smooth square.obj -o out.obj
! grep -q "normals of nodes" err || fail "a note on normals that are not there"
rm out.obj

# A surface in space is smoothed as one: the corners of a tetrahedron stay.
printf 'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >space.off
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >space.obj
for extension in off obj; do
    expect_status 0 "$program" smooth space.$extension -o out.$extension --json report.json
    expect_text "no node is free to move: 4 nodes are at corners"
    expect_json "r['mesh']['in_space'] and r['mesh']['dimension'] == 2 and r['moved_nodes'] == 0"
    cmp space.$extension out.$extension || fail "$extension: bytes differ"
    rm out.$extension
done
finish
