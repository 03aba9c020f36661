#!/usr/bin/env bash
# Files for Abaqus and Nastran that Gmsh and meshio write: smoothed, and read by both again. Needs
# gmsh and python3-meshio.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules meshio numpy || { echo "skipped: no meshio"; exit 77; }
command -v gmsh >/dev/null || { echo "skipped: no gmsh"; exit 77; }

cat >boxes.geo <<'END'
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {1, 0, 0, 1, 1, 1};
Coherence;
Physical Volume("left") = {1};
Physical Volume("right") = {2};
Physical Volume("both") = {1, 2};
Physical Surface("skin") = {1, 2, 3};
Mesh.MeshSizeMax = 0.3;
Mesh 3;
Save "boxes.msh";
Save "gmsh.inp";
For kind In {0:2}
  Mesh.BdfFieldFormat = kind;
  Save Sprintf("gmsh%g.bdf", kind);
EndFor
END
gmsh boxes.geo - -v 0 >/dev/null || fail "gmsh"
# meshio wants to be told where bulk data begin.
sed -i '1i BEGIN BULK' gmsh?.bdf
"$python" - <<'END' || fail "meshio"
import meshio
mesh = meshio.read("boxes.msh")
cells = [(block.type, block.data) for block in mesh.cells if block.type in ("triangle", "tetra")]
bare = meshio.Mesh(mesh.points, cells)
bare.write("meshio.inp")
for width in ("small", "large"):
    meshio.nastran.write(f"meshio_{width}.bdf", bare, point_format=f"fixed-{width}",
                         cell_format="fixed-small")
END

for file in gmsh.inp gmsh0.bdf gmsh2.bdf meshio_small.bdf $(unless_quick meshio.inp gmsh1.bdf meshio_large.bdf); do
    out=out_$file
    expect_status 0 "$program" smooth $file -o $out --json report.json -q
    expect_json 'r["certified"] and r["moved_nodes"] > 0 and r["after"]["inverted"] == 0'
    expect_json 'r["after"]["rms_radius_ratio"] < r["before"]["rms_radius_ratio"]'
    "$python" "$cli/compare_decks.py" $file $out out.mesh >comparison 2>&1 ||
        { fail "$file"; tail -n 2 comparison; }
    # As planish reads what it wrote, and as meshio reads it: as good as the report says.
    expect_status 0 "$program" quality $out --json written.json -q
    expect_status 0 "$program" quality out.mesh --json read.json -q
    python3 - <<'END' || fail "$file is not what the report says"
import json
report, written, read = (json.load(open(name + ".json")) for name in ("report", "written", "read"))
wanted = report["after"]["rms_radius_ratio"]
for other in (written, read):
    state = other["quality"]
    assert abs(state["rms_radius_ratio"] / wanted - 1) < 1e-12
    assert state["inverted"] == 0
END
    # And as Gmsh reads what it wrote.
    [[ $file == gmsh?.bdf ]] || continue
    gmsh $out -0 -o gmsh_read.msh -v 0 >gmsh.log 2>&1 || fail "gmsh cannot read $out"
    grep -q Error gmsh.log && fail "gmsh on $out"
    expect_status 0 "$program" quality gmsh_read.msh -q
done

# Groups: what is held stays.
expect_status 0 "$program" smooth gmsh.inp -o held.inp --fix left --ignore-regions --json report.json -q
cp report.json left.json
expect_status 0 "$program" smooth gmsh.inp -o held.inp --fix both --json report.json -q
expect_json 'r["moved_nodes"] == 0'
cmp -s gmsh.inp held.inp || fail "nothing moved, but the file is another"
expect_status 0 "$program" smooth boxes.msh -o held.msh --fix left --ignore-regions --json report.json -q
expect_json 'r["moved_nodes"] == __import__("json").load(open("left.json"))["moved_nodes"]'
expect_status 64 "$program" smooth gmsh.inp -o held.inp --fix nothing -q
expect_text "skin, left, right, both"
finish
