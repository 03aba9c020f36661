#!/usr/bin/env bash
# Another extension for the output: a copy for viewing with what planish understands; what is left out
# is said.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
data=$source_folder/tests/data

if lacks "$data/ascii.vtu"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi
# What is written is read again: the same mesh, with the same nodes to move.
for out in view.vtu view.vtk VIEW.VTU; do
    expect_status 0 "$program" smooth "$data/binary41.msh" -o $out --json report.json
    expect_text "note: $out is converted; it lacks parameters and comments"
    expect_status 0 "$program" quality $out --json quality.json -q
    python3 - <<'END' || fail "$out"
import json
r, q = json.load(open("report.json")), json.load(open("quality.json"))
assert r["moved_nodes"] > 0
for name in ("elements", "nodes", "free_nodes", "dimension"):
    assert r["mesh"][name] == q["mesh"][name], name
assert r["after"]["rms_radius_ratio"] == q["quality"]["rms_radius_ratio"]
END
done
cmp -s view.vtu VIEW.VTU || fail "two conversions differ"
expect_status 0 "$program" smooth "$data/binary41.msh" -o back.msh -q

# Nodes of order 2 that are left out: those of elements that have not all of their mids, and those in the base of pyramids.
{
    echo "BEGIN BULK"
    awk 'BEGIN { split("0 1 0 0", x, " "); split("0 0 1 0", y, " "); split("0 0 0 1", z, " "); split("1 2 3 1 2 3", a, " ");
        split("2 3 1 4 4 4", b, " ")
        for (i = 1; i <= 4; i++) printf "GRID,%d,,%.1f,%.1f,%.1f\n", i, x[i], y[i], z[i]
        for (i = 1; i <= 6; i++) printf "GRID,%d,,%.1f,%.1f,%.1f\n", i + 4, (x[a[i]] + x[b[i]]) / 2,
            (y[a[i]] + y[b[i]]) / 2, (z[a[i]] + z[b[i]]) / 2 }'
    printf 'CTETRA,1,1,1,2,3,4,5,%s,+\n+,7,8,9,10\n' ''
    echo ENDDATA
} >lacks.bdf
sed 's/,4,5,,+/,4,5,6,+/' lacks.bdf >whole.bdf
sed 's/,4,5,,+/,4,,,+/; s/^+,7,8,9,10/+,,,,/' lacks.bdf >straight.bdf
expect_status 0 "$program" convert lacks.bdf -o out.msh
expect_text "lacks mids of 1 elements that have not all of them"
for name in whole straight; do
    expect_status 0 "$program" convert $name.bdf -o out.msh
    ! grep -q "mids of" err || fail "$name.bdf: no mid is left out: $(cat err)"
done
cat >pyramid.mesh <<'END'
MeshVersionFormatted 2 Dimension 3 Vertices 14
-1 -1 0 0  1 -1 0 0  1 1 0 0  -1 1 0 0  0 0 1 0  0 -1 0 0  1 0 0 0  0 1 0 0  -1 0 0 0
-0.5 -0.5 0.5 0  0.5 -0.5 0.5 0  0.5 0.5 0.5 0  -0.5 0.5 0.5 0  0 0 0 0
PyramidsP2 1
1 2 3 4 5 6 7 8 9 10 11 12 13 14 1
End
END
for out in out.vtu out.vtk; do
    expect_status 0 "$program" convert pyramid.mesh -o $out
    expect_text "lacks nodes in the base of 1 pyramids"
done

# From any format; of a plane mesh, its z.
for in in medit.mesh tetgen.node square.msh binary22.msh zlib.vtu binary.vtk; do
    for out in out.vtk out.vtu; do
        [ "${in##*.}" != "${out##*.}" ] || continue
        expect_status 0 "$program" smooth "$data/$in" -o $out -q
        expect_status 0 "$program" quality $out -q
    done
done
awk 'NR > 4 && NF == 3 && $3 == "0.0" { $3 = "0.75" } { print }' "$data/square.off" >lifted.off
expect_status 0 "$program" smooth lifted.off -o lifted.vtu -q
expect_status 0 "$program" smooth "$data/square.off" -o flat.vtu -q
# Coordinates of version 1 are floats, and stay floats.
sed 's/MeshVersionFormatted *2/MeshVersionFormatted 1/' "$data/medit.mesh" >float.mesh
expect_status 0 "$program" smooth float.mesh -o float.vtu -q
expect_status 0 "$program" smooth "$data/medit.mesh" -o double.vtu -q
python3 - <<'END' || fail "points of copies for viewing"
import re, struct
def points(path):
    """Of a file with its arrays as they are behind the mark."""
    data = open(path, "rb").read()
    kind, offset = re.search(rb'<Points>\s*<DataArray type="(\w+)"[^>]*offset="(\d+)"', data).groups()
    at = data.index(b"_", data.index(b"<AppendedData")) + 1 + int(offset)
    size = struct.unpack_from("<Q", data, at)[0]
    letter, width = {b"Float32": ("f", 4), b"Float64": ("d", 8)}[kind]
    return kind, struct.unpack_from("<%d%s" % (size // width, letter), data, at + 8)
assert points("float.vtu")[0] == b"Float32" and points("double.vtu")[0] == b"Float64"
assert set(points("lifted.vtu")[1][2::3]) == {0.75} and set(points("flat.vtu")[1][2::3]) == {0}
assert points("lifted.vtu")[1][0::3] == points("flat.vtu")[1][0::3]
END

# Names of groups of any kind: markup, bytes that are no UTF-8, one name twice, and very long.
sed 's/"skin"/"a<b> \& c"/; s/"lower part"/"Fronti\xe8re"/; s/"upper part"/"a<b> \& c"/' \
    "$data/ascii41.msh" >names.msh
cmp -s names.msh "$data/ascii41.msh" && fail "the names were to be changed"
expect_status 0 "$program" smooth names.msh -o names.vtu -q
expect_status 0 "$program" quality names.vtu -q
long=$(printf 'x%.0s' {1..120})
sed "s/\"skin\"/\"$long\"/; s/\"lower part\"/\"y$long\"/; s/\"upper part\"/\"z$long\"/" \
    "$data/ascii41.msh" >long.msh
expect_status 0 "$program" smooth long.msh -o long.vtk
expect_text "names of groups (there are too many)"
expect_status 0 "$program" quality long.vtk -q

# No conversion to others, none to a pipe; an error leaves what is there.
expect_status 64 "$program" smooth "$data/medit.mesh" -o out.cgns -q
expect_text "and no extension of a format that planish converts to"
expect_status 64 "$program" smooth "$data/medit.mesh" -o out.xyz -q
expect_no_file out.cgns out.xyz
echo old >kept.vtu
expect_status 2 "$program" smooth missing.mesh -o kept.vtu -q
[ "$(cat kept.vtu)" = old ] || fail "kept.vtu was touched"
if [ -e /dev/full ]; then
    expect_status 2 "$program" smooth "$data/medit.mesh" -o /dev/full -q
fi

"$python" -c "import meshio, numpy, vtk" 2>/dev/null || finish
# VTK and meshio see what was in the file.
"$python" - "$data/binary41.msh" <<'END' || fail "as others read it"
import sys
import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

before = meshio.read(sys.argv[1])
smooth = meshio.read("back.msh")
regions = np.concatenate([r for c, r in zip(before.cells, before.cell_data["gmsh:geometrical"])
                          if c.type == "tetra"])
groups = np.concatenate([r for c, r in zip(before.cells, before.cell_data["gmsh:physical"])
                         if c.type == "tetra"])
tetrahedra = np.concatenate([c.data for c in before.cells if c.type == "tetra"])
for name in "view.vtu", "view.vtk":
    mesh = meshio.read(name)
    assert (mesh.points == smooth.points).all(), name
    assert mesh.cells[0].type == "tetra" and (mesh.cells[0].data == tetrahedra).all(), name
    flat = {key: np.asarray(values[0]).ravel() for key, values in mesh.cell_data.items()}
    assert (flat["region"] == regions).all() and (flat["group"] == groups).all(), name
    assert (flat["radius_ratio"] >= 1).all() and len(set(flat["radius_ratio"])) > 100, name
    assert set(np.asarray(mesh.point_data["fixed"]).ravel()) == {0, 1}, name
    reader = vtk.vtkXMLUnstructuredGridReader() if name == "view.vtu" else \
        vtk.vtkUnstructuredGridReader()
    reader.SetFileName(name)
    if name == "view.vtk":
        reader.ReadAllFieldsOn()
    reader.Update()
    grid = reader.GetOutput()
    quality = vtk.vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetTetQualityMeasureToRadiusRatio()
    quality.Update()
    theirs = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))
    ours = vtk_to_numpy(grid.GetCellData().GetArray("radius_ratio"))
    tetra = vtk_to_numpy(grid.GetCellTypesArray()) == 10
    assert np.allclose(theirs[tetra], ours[tetra], rtol=1e-9), name
    assert np.isnan(ours[~tetra]).all(), name
reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName("names.vtu")
reader.Update()
fields = reader.GetOutput().GetFieldData()
found = {fields.GetArrayName(i): [int(x) for x in vtk_to_numpy(fields.GetArray(i))]
         for i in range(fields.GetNumberOfArrays())}
assert reader.GetOutput().GetNumberOfCells() > 800
assert sorted(found.values()) == [[1, 3], [2, 3], [3, 2]], found
assert "Frontière" in found and len(found) == 3 and any("a<b> & c " in n for n in found), found
names = {name: list(value) for name, value in meshio.read("view.vtu").field_data.items()}
assert names == {name: list(value) for name, value in before.field_data.items()}, names
assert b"3:1 lower part" in open("view.vtk", "rb").read().split(b"\n")[1]
END
if command -v gmsh >/dev/null; then
    gmsh -v 1 -save view.vtk -format msh41 -o again.msh >/dev/null
    "$python" -c "
import meshio
a, b = meshio.read('view.vtk'), meshio.read('again.msh')
count = lambda m: sum(len(c.data) for c in m.cells if c.type == 'tetra')
assert len(a.points) == len(b.points) and count(a) == count(b) > 0" || fail "gmsh reads view.vtk"
fi

# Gmsh and meshio have each group by its name, with as many elements as planish counts in the input.
"$python" - "$program" "$data" <<'END' || fail "groups in files of Gmsh's"
import contextlib
import io
import os
import re
import subprocess
import sys

import meshio

try:
    import gmsh
except ImportError:
    sys.exit(0)
program, data = sys.argv[1:]
words = {1: "lines", 2: "faces", 3: "solids"}
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
with open("g.obj", "w") as file:
    file.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\ng wall all\nf 1 2 3\ng inlet all\nf 1 3 4\n")


def run(*arguments):
    result = subprocess.run([program, *arguments], capture_output=True, text=True)
    return None if result.returncode else result.stdout


def told(path):
    """Groups of elements that have some, by their words and names, as `planish groups` tells them."""
    rows = re.findall(r"^(lines|faces|solids) +([1-9]\d*)  (.*)$", run("groups", path), re.M)
    return {(word, name): int(n) for word, n, name in rows}


for name in "cube.cgns", "cube.h5", "openfoam", "abaqus.inp", "g.obj", "netgen.vol", "cube.exo":
    path = name if os.path.exists(name) else os.path.join(data, name)
    if run("groups", path) is None:
        continue  # this planish has no HDF5
    expected = told(path)
    assert run("convert", path, "-o", "groups.msh", "-q") is not None
    gmsh.open("groups.msh")
    found = {}
    for dim, tag in gmsh.model.getPhysicalGroups():
        key = words[dim], gmsh.model.getPhysicalName(dim, tag)
        assert key not in found, (name, key)
        found[key] = sum(len(numbers) for entity in gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
                         for numbers in gmsh.model.mesh.getElements(dim, entity)[1])
    assert found == expected, (name, found, expected)
    assert told("groups.msh") == expected, name
    with contextlib.redirect_stdout(io.StringIO()):
        fields = meshio.read("groups.msh").field_data
    assert {(words[dim], key) for key, (_, dim) in fields.items()} == set(expected), (name, fields)
    assert run("convert", path, "-o", "groups.msh", "--to", "gmsh22", "-q") is not None
    with contextlib.redirect_stdout(io.StringIO()):
        fields = meshio.read("groups.msh").field_data
    assert {(words[dim], key) for key, (_, dim) in fields.items()} == set(expected), (name, fields)
    gmsh.open("groups.msh")
    for dim, tag in gmsh.model.getPhysicalGroups():
        assert (words[dim], gmsh.model.getPhysicalName(dim, tag)) in expected, (name, dim, tag)
END
finish
