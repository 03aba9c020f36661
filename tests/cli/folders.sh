#!/usr/bin/env bash
# Meshes that are folders: which folders are meshes, what OUT may be and what it has, that nothing is left
# behind where a run fails or is ended.
. "$(dirname "$0")/common.sh"

data=$source_folder/tests/data
cp -r "$data/elmer" "$data/openfoam" .
mesh=openfoam/constant/polyMesh
mkdir $mesh/sets
echo a set >$mesh/sets/cells
echo not ours >elmer/result.vtu

# expect_moved OLD NEW N: lines differ in coordinates of N nodes.
expect_moved() {
    python3 - "$@" <<'END' || fail "$1 and $2"
import re, sys
(old, new), n = (open(name).read().split("\n") for name in sys.argv[1:3]), int(sys.argv[3])
changed = [i for i in range(len(old)) if old[i] != new[i]]
assert len(old) == len(new) and len(changed) == n > 0, (len(changed), n)
for i in changed:
    a, b = (re.findall(r"[^ ()]+", line) for line in (old[i], new[i]))
    assert len(a) == len(b) and a[:-3] == b[:-3]
END
}

moved() {
    python3 -c "import json; print(json.load(open('$1'))['moved_nodes'])"
}

# ---- a new folder -------------------------------------------------------------------------------

expect_status 0 "$program" smooth elmer -o smooth/ --json r.json --report r.html -q
[ "$(ls smooth)" = "$(ls "$data/elmer")" ] || fail "the files of a mesh of Elmer: $(ls smooth)"
for name in header elements boundary names; do
    cmp elmer/mesh.$name smooth/mesh.$name || fail "mesh.$name"
done
expect_moved elmer/mesh.nodes smooth/mesh.nodes "$(moved r.json)"
expect_status 0 "$program" report r.json -o again.html
cmp r.html again.html || fail "the page finds the mesh again"
expect_status 0 "$program" quality elmer smooth openfoam
[ "$(grep -c 'elmer\|smooth\|openfoam' out)" -ge 3 ] || fail "three meshes are compared"

expect_status 0 "$program" smooth openfoam -o smooth_case --json r.json -q --fix zone1
(cd openfoam && find . -type f | sort) >names_old
(cd smooth_case && find . -type f | sort) >names_new
cmp names_old names_new || fail "the files of a mesh of OpenFOAM"
while read -r name; do
    [ "$name" = ./constant/polyMesh/points ] || cmp "openfoam/$name" "smooth_case/$name" || fail "$name"
done <names_old
expect_moved $mesh/points smooth_case/constant/polyMesh/points "$(moved r.json)"
grep -q "the mesh alone" err && fail "a note with --quiet, or on what is no case"
mkdir openfoam/system
expect_status 0 "$program" smooth openfoam noted --fix zone1
expect_text "note: noted has the mesh alone: to run the case, copy it, and smooth the copy with --in-place"
[ ! -e noted/system ] || fail "OUT has more than the mesh"
cp -r openfoam run
for out in "run -o run" "$mesh -o polymesh" "openfoam -o case.vtu"; do
    # shellcheck disable=SC2086 # these are words
    expect_status 0 "$program" smooth $out --fix zone1
    ! grep -q "the mesh alone" err || fail "a note on 'smooth $out'"
done
rmdir openfoam/system
rm -r noted run polymesh case.vtu
expect_status 0 "$program" smooth $mesh -o alone --fix all -q
[ "$(ls alone)" = "$(ls $mesh)" ] || fail "the folder polyMesh alone"
expect_status 0 "$program" smooth openfoam -o view.vtu -q
expect_status 0 "$program" quality elmer -o view.vtk -q
[ -s view.vtu ] && [ -s view.vtk ] || fail "copies for viewing"

# ---- in place -----------------------------------------------------------------------------------

cp -r openfoam inplace
expect_status 0 "$program" smooth inplace -o ./inplace/ -q
(cd inplace && find . -type f | sort) >names_new
cmp names_old names_new || fail "the files of a mesh that is replaced"
expect_status 0 "$program" smooth openfoam -o reference -q
cmp inplace/constant/polyMesh/points reference/constant/polyMesh/points || fail "in place as in a new folder"
mkdir inplace_elmer
cp elmer/mesh.* inplace_elmer
mkdir inplace_elmer/partitioning.4
expect_status 2 "$program" smooth inplace_elmer -o inplace_elmer -q
expect_one_line
expect_text partitioning.4
cmp elmer/mesh.nodes inplace_elmer/mesh.nodes || fail "what cannot be replaced stays"

# Packed files: the same content, packed again; as they were where nothing moves.
python3 "$cli/folder_meshes.py" foam "$data/medit.mesh" packed gz
if "$program" quality packed -q 2>err; then
    expect_status 0 "$program" smooth packed -o smooth_packed -q
    zcat smooth_packed/points.gz >points
    cmp points reference/constant/polyMesh/points || fail "packed points"
    cmp packed/faces.gz smooth_packed/faces.gz || fail "packed faces"
    expect_status 0 "$program" smooth packed -o same_packed -q --max-sweeps 0 --no-untangle
    cmp packed/points.gz same_packed/points.gz || fail "packed points that stay"
    head -c 500 packed/points.gz >packed/cut
    mv packed/cut packed/points.gz
    expect_status 2 "$program" quality packed
    expect_one_line
    expect_text "cannot be unpacked"
else
    grep -q "without zlib" err || fail "packed files: $(cat err)"
fi

# ---- what is refused ----------------------------------------------------------------------------

# refused STATUS TEXT ARGUMENT...: one line with that text, and nothing made.
refused() {
    local status=$1 text=$2
    shift 2
    rm -f err out
    find . | sort >../before.$$
    expect_status "$status" "$program" "$@"
    expect_text "$text"
    [ "$status" -eq 64 ] || expect_one_line
    rm -f err out
    find . | sort | diff ../before.$$ - || fail "left behind: $*"
    rm -f ../before.$$
}
mkdir empty several several/constant several/constant/{a,b}
cp -r $mesh several/constant/a/
cp -r $mesh several/constant/b/
touch plain
refused 2 "is a folder without a mesh" quality empty
refused 2 "several/constant/a/polyMesh, several/constant/b/polyMesh" smooth several -o new -q
refused 2 "give the folder" quality $mesh/points
refused 2 "give the folder" quality elmer/mesh.nodes
refused 2 "exists already" smooth elmer -o empty -q
refused 2 "exists already" smooth elmer -o plain -q
refused 2 "cannot write to its folder" smooth elmer -o none/new -q
refused 2 "is a folder" smooth "$sample" -o empty -q
refused 64 "name of a file" smooth elmer -o new.cgns -q
expect_status 0 "$program" convert elmer converted.msh
expect_status 0 "$program" quality converted.msh -q
rm converted.msh
refused 64 "name of a file" smooth elmer -o new.node -q
refused 64 "would overwrite the mesh" smooth elmer -o new --json elmer/mesh.nodes -q
refused 2 "'gmsh' are files" smooth elmer -o new --format gmsh -q

# ---- nothing is left behind -----------------------------------------------------------------------

for blocks in 1 4 8; do
    (ulimit -f $blocks && exec "$program" smooth elmer -o new -q 2>err)
    [ $? -eq 2 ] || fail "files of $blocks kB: $(cat err)"
    expect_no_file new*
done
chmod a-r elmer/mesh.names
if [ ! -r elmer/mesh.names ]; then
    expect_status 2 "$program" smooth elmer -o new -q
    expect_no_file new*
fi
chmod a+r elmer/mesh.names

# Ended while a large file is copied.
cp -r elmer large
if truncate -s 30G large/mesh.large 2>/dev/null; then
    env --default-signal=TERM "$program" smooth large -o new -q 2>err &
    run=$!
    for ((i = 0; i < 500; i++)); do
        compgen -G "new.planish-*/mesh.large" >/dev/null && break
        sleep 0.01
    done
    compgen -G "new.planish-*/mesh.large" >/dev/null || fail "no large file is written"
    kill -TERM $run 2>/dev/null
    sleep 0.05
    kill -TERM $run 2>/dev/null
    wait $run
    [ $? -ne 0 ] || fail "the run should have been ended"
    expect_no_file new*
fi
finish
