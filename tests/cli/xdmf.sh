#!/usr/bin/env bash
# XDMF files by meshio, in all forms, and as DOLFINx writes them: meshio reads what planish has written beside the input, in
# place and in another folder. Needs meshio and python3-h5py.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import meshio, h5py" 2>/dev/null || { echo "skipped: no meshio or h5py"; exit 77; }
if lacks "$source_folder/tests/data/cube.xdmf"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi
"$python" "$cli/xdmf_mesh.py" forms "$source_folder/tests/data/ascii.vtu" >names || fail "no files"
pairs=()
for name in $(cat names); do
    ! lacks "$name" || continue
    mkdir "in.$name" "new.$name"
    cp "${name%.xdmf}"[.0-9]* "in.$name"
    cp "$name" "in.$name/first.xml"
    for out in "out_$name" "in.$name/$name" "new.$name/$name"; do
        in=$name
        [ "${out%%/*}" = "in.$name" ] && in=$out
        expect_status 0 "$program" smooth "$in" -o "$out" --json report.json -q
        expect_json "r['moved_nodes'] > 5 and r['mesh']['region_arrays'] == ['CellEntityIds'] and r['certified']"
        pairs+=("$name" "$out")
    done
    [ "$name" = xml.xdmf ] || cmp "in.$name/$name" "in.$name/first.xml" || fail "the XML of $name has changed"
    [ "$name" = xml.xdmf ] || cmp "new.$name/$name" "$name" || fail "the XML of new.$name has changed"
done
"$python" "$cli/xdmf_mesh.py" same "${pairs[@]}" || fail "the written files are not what they were"

# DOLFINx lists tagged cells again, in another order; a series in time includes the mesh.
"$python" "$cli/xdmf_mesh.py" dolfinx "$source_folder/tests/data/ascii.vtu" tags.xdmf || fail "no file of DOLFINx"
if ! lacks tags.xdmf; then
    expect_status 0 "$program" smooth tags.xdmf -o better.xdmf --json report.json -q
    expect_json "r['mesh']['region_arrays'] == ['cells'] and r['mesh']['held']['faces_inside'] == 15 and r['moved_nodes'] > 5"
    expect_status 0 "$program" quality better.xdmf --json report.json -q
    expect_json "r['mesh']['region_arrays'] == ['cells'] and r['quality']['inverted'] == 0"
    sed 's/tags\.h5/better.h5/g' tags.xdmf | cmp - better.xdmf || fail "the XML has changed elsewhere"
    expect_status 0 "$program" quality tags.xdmf -o tags.vtu --fix 5 -q
    expect_status 2 "$program" smooth tags.xdmf -o /dev/stdout -q
    expect_one_line
    expect_text "cannot be written to a pipe or device"
fi
finish
