#!/usr/bin/env bash
# Elements of all types as VTK and meshio write them: the nodes of each are read in the right order, and
# VTK finds the same elements in a copy for viewing. Needs python3-vtk9 and meshio.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules meshio vtk || { echo "skipped: no meshio or VTK"; exit 77; }
if lacks "$source_folder/tests/data/ascii.vtu"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi
pairs=()
for dim in 2 3; do
    "$python" "$cli/cell_types.py" write "$dim" >names || fail "no files"
    while read -r name n; do
        expect_status 0 "$program" quality "$name" --json report.json -q
        expect_json "sum(r['quality']['counts'].values()) == $n"
        expect_json 'r["quality"]["inverted"] == r["quality"]["uncertified"] == r["quality"]["corner_inverted"] == 0'
        [ "${name##*.}" = vtu ] && copy=$name.copy.vtk || copy=$name.copy.vtu
        expect_status 0 "$program" smooth "$name" -o "$copy"
        expect_text "it lacks parameters and comments"
        # VTK is not everywhere built with its reader of XDMF.
        [ "${name##*.}" = xdmf ] && name=${name%%.*}.vtu
        pairs+=("$name" "$copy")
    done <names
    [ "$(wc -l <names)" = 9 ] || fail "not all files"
done
"$python" "$cli/cell_types.py" compare "${pairs[@]}" || fail "copies for viewing"

# The measures in a copy are those of the report; a copy is no mesh with regions.
"$python" "$cli/types_mesh.py" types.vtk types.json tetrahedra.vtk || fail "no mesh"
for copy in types.vtu types.copy.vtk; do
    expect_status 0 "$program" quality types.vtk --json report.json -o "$copy" -q
    [ ! -s err ] || fail "notes of -q: $(cat err)"
    "$python" "$cli/cell_types.py" measures "$copy" report.json || fail "measures in $copy"
    expect_status 0 "$program" quality "$copy" --json again.json -q
    python3 -c 'import json; assert json.load(open("again.json"))["mesh"]["region_arrays"] == ["number"]' ||
        fail "a measure in $copy is taken for regions"
done
finish
