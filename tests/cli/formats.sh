#!/usr/bin/env bash
# One mesh in every format: each comes back in its own bytes with nothing but coordinates changed,
# and all of them become as good.
. "$(dirname "$0")/common.sh"

data=$source_folder/tests/data
cp "$data"/*.* .

names=()
for file in ascii22.msh binary22.msh ascii41.msh binary41.msh medit.mesh ascii.vtk binary.vtk \
    ascii.vtu base64.vtu raw.vtu zlib.vtu medit.meshb netgen.vol abaqus.inp nastran.bdf \
    nastran_long.bdf cube.med cube.vtkhdf cube.h5 cube.cgns tetgen.node square.msh square.off \
    square.obj square.ply square.stl cube.mfem cube.exo cube.avs cube.su2 cube.unv cube.xdmf; do
    ! lacks $file || continue
    out=smooth.$file
    expect_status 0 "$program" smooth $file -o "$out" --json $file.json -q
    [ "$file" != tetgen.node ] || cmp tetgen.ele smooth.tetgen.ele || fail "the companion of $file"
    # Smooth already: read again, nothing is inverted and next to nothing can be won.
    expect_status 0 "$program" smooth "$out" -o "again.$file" --json again.$file.json -q
    names+=("$file")
done
python3 - "${names[@]}" <<'END' || fail "what was written"
import json, sys, traceback


def check(name):
    report = json.load(open(name + ".json"))
    before, after = report["before"], report["after"]
    assert report["stop"] == "converged" and report["certified"] and report["moved_nodes"] > 0
    assert report["mesh"]["dimension"] == (2 if name.startswith("square") else 3)
    assert after["rms_radius_ratio"] < before["rms_radius_ratio"]
    assert abs(after["total_volume"] / before["total_volume"] - 1) < 1e-12
    old, new = open(name, "rb").read(), open("smooth." + name, "rb").read()
    assert old != new
    if name in ("base64.vtu", "zlib.vtu"):  # tests/io/test_vtu.c, tests/cli/vtu.sh
        assert name == "zlib.vtu" or len(old) == len(new)
    elif name.startswith(("binary", "raw")) or name.endswith((".meshb", ".med", ".cgns", ".vtkhdf", ".h5", ".exo")):
        changed = [i for i in range(len(old)) if old[i] != new[i]]
        assert len(old) == len(new) and len(changed) <= 24 * report["moved_nodes"]
    elif name == "ascii.vtu":  # two points a line
        old, new = old.split(), new.split()
        changed = [i for i in range(len(old)) if old[i] != new[i]]
        assert len(old) == len(new) and len(changed) <= 3 * report["moved_nodes"]
    else:
        old, new = old.split(b"\n"), new.split(b"\n")
        changed = [i for i in range(len(old)) if old[i] != new[i]]
        lines = len(changed) / report["moved_nodes"]
        if name.endswith(".stl"):  # a line for each facet of a node
            assert 3 < lines < 7 and all(b"vertex" in line for line in (new[i] for i in changed))
            lines = 1
        assert len(old) == len(new) and (1 <= lines <= 2 if "long" in name else lines == 1)
        assert name.startswith("nastran") or all(len(old[i].split()) == len(new[i].split()) for i in changed)
    again = json.load(open(f"again.{name}.json"))["after"]
    assert 0.999 < again["rms_radius_ratio"] / after["rms_radius_ratio"] <= 1


failed = 0
for name in sys.argv[1:]:
    try:
        check(name)
    except Exception:
        traceback.print_exc()
        print("FAILED:", name)
        failed = 1
sys.exit(failed)
END

# Parameters of the geometry stay: those of nodes that may move are told of.
cat >parametric.txt <<'MSH'
$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
2 5 1 5
1 1 1 4
1
2
3
4
0 0 0 0
1 0 0 1
1 1 0 2
0 1 0 3
2 1 1 1
5
.3 .6 0 -.2 .1
$EndNodes
$Elements
1 4 1 4
2 1 2 4
1 1 2 5
2 2 3 5
3 3 4 5
4 4 1 5
$EndElements
MSH
expect_status 0 "$program" smooth parametric.txt -o parametric_smooth.txt --json report.json
expect_json "r['mesh']['nodes_with_parameters'] == 1"
expect_text "note: 1 movable node has geometry parameters"
grep -q '0 -\.2 \.1$' parametric_smooth.txt || fail "parameters are not what they were"
expect_status 0 "$program" quality parametric.txt --json report.json
expect_json "r['mesh']['nodes_with_parameters'] == 1"
! grep -q parameters err || fail "a note where nothing moves"
expect_status 0 "$program" smooth ascii41.msh -o parametric_smooth.msh --json report.json
expect_json "r['mesh']['nodes_with_parameters'] == 0"
! grep -q parameters err || fail "parameters that are not there"

# All names of a format.
for pair in nastran.bdf:nas nastran.bdf:fem cube.med:mmed cube.med:rmed cube.vtkhdf:hdf \
    $(unless_quick nastran.bdf:bdf cube.med:med cube.vtkhdf:vtkhdf); do
    ! lacks "${pair%:*}" || continue
    expect_status 0 "$program" smooth "${pair%:*}" -o "another.${pair#*:}" -q --max-sweeps 1
    expect_status 0 "$program" quality "another.${pair#*:}" -q
done

# A point element, before the others, for every node whose number is a multiple of the argument.
add_points() {
    awk -v every="$1" '
    $0 == "$Nodes" { getline; n_nodes = $1; print "$Nodes" }
    $0 == "$Elements" {
        getline
        added = int(n_nodes / every)
        print "$Elements"
        print $1 + added
        for (i = 1; i <= added; i++)
            print 100000 + i, 15, 2, 0, i, i * every
        next
    }
    { print }' ascii22.msh
}

# Mmg writes a point for every vertex, which hold nothing then; points for some hold these.
add_points 1 >every_point.msh
add_points 3 >some_points.msh
for file in ascii22 every_point some_points; do
    expect_status 0 "$program" smooth $file.msh -o $file.smooth.msh -q --json report.json
    python3 -c "import json; print(json.load(open('report.json'))['mesh']['free_nodes'])" >$file.free
done
cmp ascii22.free every_point.free || fail "points for every node hold some"
[ "$(cat some_points.free)" -lt "$(cat ascii22.free)" ] || fail "points for some nodes do not hold them"

# How elements are numbered is no inversion, but told of.
python3 - <<'END'
words = open("medit.mesh").read().split("\n")
at = words.index(" Tetrahedra") + 2
for i in range(at, at + 5):
    a, b, *rest = words[i].split()
    words[i] = " ".join([b, a, *rest])
open("mixed.mesh", "w").write("\n".join(words))
END
expect_status 0 "$program" quality mixed.mesh --json report.json
expect_json "r['quality']['inverted'] == 0 and r['mesh']['reversed_elements'] in (5, r['mesh']['elements'] - 5)"
expect_text "their nodes in the opposite order"
expect_status 0 "$program" quality medit.mesh --json report.json
! grep -q "other way round" err || fail "a note on elements that are all numbered alike"

# Editors begin text with a byte order mark: it stays, and nothing else is different.
mkdir marked
tr -d '\n' <<<' ' | cat - medit.mesh | sed '1s/^ *//' >first.mesh
printf '\xef\xbb\xbf' | cat - tetgen.ele >marked/tetgen.ele
marked=()
for file in *.{msh,mesh,vtk,vtu,vol,inp,bdf,off,obj,ply,stl,mfem,node} cube.avs cube.su2 cube.unv cube.xdmf; do
    case $file in smooth.* | again.*) continue ;; esac
    marked+=("$file")
done
for file in $(some "${marked[@]}"); do
    ! lacks "$file" || continue
    printf '\xef\xbb\xbf' | cat - "$file" >"marked/$file"
    expect_status 0 "$program" smooth "$file" -o "plain.${file##*.}" -q --max-sweeps 2
    expect_status 0 "$program" smooth "marked/$file" -o "marked/result.${file##*.}" -q --max-sweeps 2
    printf '\xef\xbb\xbf' | cat - "plain.${file##*.}" | cmp - "marked/result.${file##*.}" || fail "a byte order mark in $file"
done
for file in ascii22.msh abaqus.inp square.off; do
    iconv -f ASCII -t UTF-16 $file >marked/$file
    expect_status 2 "$program" quality marked/$file
    expect_one_line
    expect_text "UTF-16; convert it first: iconv"
done

python3 - <<'END' || fail "the formats differ"
import json
import os
names = ("ascii22.msh binary22.msh ascii41.msh binary41.msh medit.mesh ascii.vtk binary.vtk "
         "ascii.vtu base64.vtu raw.vtu zlib.vtu medit.meshb netgen.vol abaqus.inp nastran.bdf "
         "nastran_long.bdf cube.med cube.mfem").split()
names = [name for name in names if os.path.exists(name + ".json")]
reports = [json.load(open(name + ".json")) for name in names]
for name, report in zip(names, reports):
    for state in ("before", "after"):
        ratio = report[state]["rms_radius_ratio"] / reports[0][state]["rms_radius_ratio"]
        assert abs(ratio - 1) < 1e-4, (name, state, ratio)
    assert report["mesh"]["free_nodes"] == reports[0]["mesh"]["free_nodes"], name
END

# What has no mark at its end may be cut short, and nobody can tell: that is said.
head -c -1 tetgen.ele >cut.ele
cp tetgen.node cut.node
expect_status 0 "$program" quality cut.node
expect_text "note: the last line of cut.ele has no line end"
expect_status 0 "$program" quality tetgen.node
[ ! -s err ] || fail "$(cat err)"

# Of .node and .ele none is replaced that nobody named; with the other one both are.
mkdir alone other
echo notes >alone/y.ele
cp cut.node alone/x.node
expect_status 2 "$program" smooth tetgen.node alone/y.node
expect_text "alone/y.ele: is there without alone/y.node, and would be overwritten"
expect_status 2 "$program" smooth tetgen.node -o alone/x.ele
expect_text "alone/x.node: is there without alone/x.ele"
[ "$(cat alone/y.ele)" = notes ] && cmp cut.node alone/x.node && [ "$(ls alone | wc -l)" = 2 ] || fail "alone: $(ls alone)"
expect_status 0 "$program" smooth tetgen.node -q -o alone/y.ele
expect_status 0 "$program" smooth tetgen.node -q -o alone/y.node
cp tetgen.node tetgen.ele other
expect_status 64 "$program" smooth tetgen.node other/tetgen.ele --output-dir smoothed
expect_text "would get the same name in --output-dir"

# Five gigabytes of data that are not needed are not read: they are a hole behind the mesh.
if ! lacks raw.vtu && python3 - <<'END'; then
import struct
source, size = open("raw.vtu", "rb").read(), 5 << 30
begin = source.index(b"_", source.index(b"<AppendedData")) + 1
end = source.index(b"\n  </AppendedData>")
array = b'<DataArray type="Float64" Name="large" format="appended" offset="%d"/>' % (end - begin)
place = source.index(b"</PointData>")
with open("large.vtu", "wb") as file:
    file.write(source[:place] + array + source[place:end])
    file.write(struct.pack("<Q", size))
    file.seek(size, 1)
    file.write(source[end:])
END
    expect_status 0 "$program" smooth large.vtu -o /dev/null --json report.json -q
    expect_json 'r["moved_nodes"] > 0 and r["certified"] and r["peak_memory_bytes"] < 1 << 30'
    rm large.vtu
fi

# A format that is named is the one that is read.
expect_status 0 "$program" quality medit.mesh --format medit -q
expect_status 2 "$program" quality medit.mesh --format gmsh -q
expect_one_line
cp medit.mesh no_extension
expect_status 0 "$program" quality no_extension -q
finish
