#!/usr/bin/env bash
# Exodus files of every type of element, classic and in HDF5: VTK's reader finds the same elements with the same
# nodes, and reads what planish has written, anew (convert) or in place. Needs python3-vtk9; without python3-h5py no file is in HDF5.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import vtk" 2>/dev/null || { echo "skipped: no VTK"; exit 77; }
if lacks "$source_folder/tests/data/ascii.vtu"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi
mesh=$source_folder/tests/data/ascii22.msh
"$python" "$cli/exodus_mesh.py" types . >names || fail "no files"
cp "$source_folder/tests/data/cube.exo" .
echo cube.exo >>names
pairs=()
converted=()
[ "$(wc -l <names)" -ge 17 ] || fail "not all files"
for name in $(some $(cat names)); do
    ! lacks "$name" || continue
    expect_status 0 "$program" quality "$name" -o "$name.vtu" --json report.json -q
    expect_json "r['quality']['inverted'] == 0 and not r['quality'].get('uncertified')"
    pairs+=("$name" "$name.vtu")
    expect_status 0 "$program" convert "$name" "$name.again" --to exodus -q
    converted+=("$name.again" "$name.vtu")
done
"$python" "$cli/exodus_mesh.py" compare "${pairs[@]}" || fail "VTK reads other elements"
"$python" "$cli/exodus_mesh.py" compare "${converted[@]}" || fail "VTK reads other elements in converted files"

# Whatever format a mesh is from; blocks and side sets, as the libraries of Exodus and netCDF read them, too.
for name in ascii41.msh abaqus.inp square.msh square.off ascii.vtk medit.mesh; do
    expect_status 0 "$program" convert "$source_folder/tests/data/$name" "$name.vtu" -q
    expect_status 0 "$program" convert "$source_folder/tests/data/$name" "$name.e" -q
    "$python" "$cli/exodus_mesh.py" compare "$name.e" "$name.vtu" || fail "$name: VTK reads other elements"
done
expect_status 0 "$program" smooth "$source_folder/tests/data/ascii41.msh" -o smooth.e -q
expect_status 0 "$program" smooth "$source_folder/tests/data/ascii41.msh" -o smooth.vtu -q
"$python" "$cli/exodus_mesh.py" compare smooth.e smooth.vtu || fail "VTK reads another smoothed mesh"
"$python" "$cli/exodus_mesh.py" written ascii41.msh.e ascii.vtk.e || fail "sets and data of converted files"

files=(cube.exo)
if "$python" "$cli/exodus_mesh.py" netcdf4 "$mesh" plain.e packed.e 2>/dev/null && ! lacks plain.e; then
    files+=(plain.e packed.e)
fi
written=()
for file in "${files[@]}"; do
    expect_status 0 "$program" smooth "$file" -o "better.$file" --json report.json -q
    expect_json "r['moved_nodes'] > 5 and r['mesh']['held']['interface'] == 15"
    written+=("$file" "better.$file")
done
"$python" "$cli/exodus_mesh.py" same "${written[@]}" || fail "the written files are not what they were"
finish
