#!/usr/bin/env bash
# UNV, SU2 and AVS UCD files that Gmsh and meshio write: read as others read them, smoothed, and read by
# others again. Needs gmsh, python3-meshio and python3-vtk9.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules meshio numpy vtk || { echo "skipped: no meshio or vtk"; exit 77; }
command -v gmsh >/dev/null || { echo "skipped: no gmsh"; exit 77; }

# Tetrahedra, wedges and hexahedra with curved sides, in which another order of nodes would show.
cat >disk.geo <<'END'
SetFactory("OpenCASCADE");
Mesh.MeshSizeMax = 0.45;
Mesh.SecondOrderIncomplete = 1;
Mesh.SaveGroupsOfElements = 1;
For kind In {0:2}
  Disk(1) = {0, 0, 0, 1};
  If (kind == 0)
    Extrude {0, 0.3, 1} { Surface{1}; }
  Else
    Extrude {0, 0.3, 1} { Surface{1}; Layers{3}; Recombine; }
  EndIf
  If (kind == 2)
    Recombine Surface{:};
  EndIf
  Physical Volume("body") = {1};
  Physical Surface("round") = {2};
  Mesh 3;
  Save Sprintf("linear%g.msh", kind);
  Save Sprintf("linear%g.su2", kind);
  SetOrder 2;
  Save Sprintf("curved%g.msh", kind);
  Save Sprintf("curved%g.unv", kind);
  Delete Model;
EndFor
END
# With nodes in the middle of faces, too.
cat >full.geo <<'END'
Mesh.SecondOrderIncomplete = 0;
For kind In {0:2}
  Merge Sprintf("linear%g.msh", kind);
  SetOrder 2;
  Save Sprintf("full%g.msh", kind);
  Save Sprintf("full%g.unv", kind);
  Delete Model;
EndFor
END
cat >back.geo <<'END'
For kind In {0:2}
  Merge Sprintf("out%g.unv", kind);
  Save Sprintf("back%g.msh", kind);
  Delete Model;
EndFor
END

# same_quality FILE FILE WHAT: planish measures the same in both.
same_quality() {
    expect_status 0 "$program" quality "$1" --json a.json -q
    expect_status 0 "$program" quality "$2" --json b.json -q
    python3 - <<'END' || fail "$3"
import json
a, b = (json.load(open(name))["quality"] for name in ("a.json", "b.json"))
for key, value in a.items():
    if isinstance(value, (int, float)) and "element" not in key:
        assert abs(value - b[key]) <= 1e-9 * abs(value), (key, value, b[key])
END
}

gmsh -v 0 disk.geo - >/dev/null || fail "gmsh"
gmsh -v 0 full.geo - >/dev/null || fail "gmsh, complete elements"
for kind in 0 1 2; do
    same_quality curved$kind.msh curved$kind.unv "curved$kind as MSH and as UNV"
    same_quality full$kind.msh full$kind.unv "full$kind as MSH and as UNV"
    expect_status 0 "$program" smooth curved$kind.unv -o out$kind.unv --max-sweeps 3 --json report.json -q
    expect_json 'r["moved_nodes"] > 0'
    python3 - curved$kind.unv out$kind.unv <<'END' || fail "curved$kind.unv: columns"
import sys
old, new = (open(name).read().split("\n") for name in sys.argv[1:])
assert len(old) == len(new)
for a, b in zip(old, new):
    assert a == b or (len(a) == len(b) == 75 and
                      all(b[i] == " " and float(b[i:i + 25].replace("D", "E")) < 2 for i in (0, 25, 50)))
END
    same_quality linear$kind.msh linear$kind.su2 "linear$kind as MSH and as SU2"
    expect_status 0 "$program" smooth linear$kind.su2 -o out$kind.su2 --max-sweeps 3 -q
    ! cmp -s linear$kind.su2 out$kind.su2 || fail "linear$kind.su2 is as before"
done
gmsh -v 0 back.geo - >/dev/null || fail "gmsh reads UNV"
"$python" -c '
import meshio
for kind in range(3):
    mesh = meshio.read("out%d.su2" % kind)
    solid = [block for block in mesh.cells if block.type in ("tetra", "wedge", "hexahedron")]
    meshio.write("back%d.vtk" % kind, meshio.Mesh(mesh.points, solid))' >/dev/null 2>err ||
    fail "meshio reads SU2: $(tail -n 1 err)"
for kind in 0 1 2; do
    same_quality out$kind.unv back$kind.msh "out$kind.unv as Gmsh reads it"
    same_quality out$kind.su2 back$kind.vtk "out$kind.su2 as meshio reads it"
done

# Cells of all types, text and binary: meshio writes the text, and VTK reads both.
cat >cells.py <<'END'
import struct
import sys
import meshio
import numpy as np
import vtk

# Numbers of types, and orders of nodes.
NUMBERS = {"pyramid": (5, [4, 0, 1, 2, 3]), "wedge": (6, [3, 4, 5, 0, 1, 2]),
           "hexahedron": (7, [4, 5, 6, 7, 0, 1, 2, 3])}


def write():
    """Write a box of 4 x 4 x 4 places: of a hexahedron, two wedges, or six pyramids each."""
    rng = np.random.default_rng(1)
    n, points, number = 4, [], {}
    for at in np.ndindex(n + 1, n + 1, n + 1):
        number[at] = len(points)
        inside = all(0 < c < n for c in at)
        points.append(np.array(at, float) + inside * rng.uniform(-0.2, 0.2, 3))
    cells = {name: [] for name in NUMBERS}
    for x, y, z in np.ndindex(n, n, n):
        c = [number[x + a, y + b, z + d] for a, b, d in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                                                         (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
        if z == 0:
            cells["hexahedron"].append(c)
        elif z == 1:
            cells["wedge"] += [[c[0], c[1], c[2], c[4], c[5], c[6]], [c[0], c[2], c[3], c[4], c[6], c[7]]]
        else:
            points.append(np.mean([points[i] for i in c], 0))
            tip = len(points) - 1
            for face in ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)):
                cells["pyramid"].append([c[i] for i in face] + [tip])
    points = np.array(points)
    blocks = [(name, np.array(block)) for name, block in cells.items() if block]
    mesh = meshio.Mesh(points, blocks, cell_data={"m": [np.full(len(block), 3) for _, block in blocks]})
    meshio.write("cells.vtk", mesh)
    meshio.write("cells.avs", mesh, "avsucd")
    words = []
    for name, block in blocks:
        words += [(name, row[NUMBERS[name][1]] + 1) for row in block]
    with open("cells.ucd", "wb") as out:
        out.write(b"\7" + struct.pack(">6i", len(points), len(words), 0, 0, 0, sum(len(r) for _, r in words)))
        for i, (name, row) in enumerate(words):
            out.write(struct.pack(">4i", i + 1, 3, len(row), NUMBERS[name][0]))
        out.write(np.concatenate([row for _, row in words]).astype(">i4").tobytes())
        out.write(points.T.astype(">f4").tobytes())


def read(path):
    reader = vtk.vtkAVSucdReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    points = np.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())])
    cells = [[grid.GetCell(i).GetPointId(k) for k in range(grid.GetCell(i).GetNumberOfPoints())]
             for i in range(grid.GetNumberOfCells())]
    return points, cells


def compare():
    for path in ("cells.avs", "cells.ucd"):
        before, after = read(path), read("out" + path[5:])
        assert before[1] == after[1] and len(before[1]) > 100
        moved = np.any(before[0] != after[0], axis=1)
        assert 0 < moved.sum() <= 27 + 64


write() if sys.argv[1] == "write" else compare()
END
"$python" cells.py write >/dev/null 2>err || fail "meshio: $(tail -n 1 err)"
same_quality cells.vtk cells.avs "cells as VTK and as UCD"
for extension in avs ucd; do
    expect_status 0 "$program" smooth cells.$extension -o out.$extension --max-sweeps 3 -q
done
"$python" cells.py compare >/dev/null 2>err || fail "what VTK reads: $(tail -n 1 err)"

finish
