#!/usr/bin/env bash
# Exodus files of every type of element, classic and in HDF5: VTK's reader finds the same elements with the same
# nodes, and reads what planish has written, anew (convert) or in place. Needs python3-vtk9; without python3-h5py no file is in HDF5.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules vtk || { echo "skipped: no VTK"; exit 77; }
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
for name in ascii41.msh ascii.vtk $(unless_quick abaqus.inp square.msh square.off medit.mesh); do
    expect_status 0 "$program" convert "$source_folder/tests/data/$name" "$name.vtu" -q
    expect_status 0 "$program" convert "$source_folder/tests/data/$name" "$name.e" -q
    "$python" "$cli/exodus_mesh.py" compare "$name.e" "$name.vtu" || fail "$name: VTK reads other elements"
done
# All faces of a solid of each type, which share no nodes; all edges of flat elements, in a plane and in space.
cat >solids.mesh <<'END'
MeshVersionFormatted 2
Dimension 3
Vertices 23
0 0 0 0  1 0 0 0  1 1 0 0  0 1 0 0  0.5 0.5 1 0
2 0 0 0  3 0 0 0  2 1 0 0  2 0 1 0  3 0 1 0  2 1 1 0
4 0 0 0  5 0 0 0  5 1 0 0  4 1 0 0  4 0 1 0  5 0 1 0  5 1 1 0  4 1 1 0
6 0 0 0  7 0 0 0  6 1 0 0  6 0 1 0
Pyramids 1
1 2 3 4 5 1
Prisms 1
6 7 8 9 10 11 1
Hexahedra 1
12 13 14 15 16 17 18 19 2
Tetrahedra 1
20 21 22 23 2
Triangles 10
1 2 5 1  2 3 5 2  3 4 5 3  4 1 5 4  6 7 8 5  9 10 11 6  20 21 22 7  20 21 23 8  21 22 23 9  22 20 23 10
Quadrilaterals 10
1 2 3 4 11  6 7 10 9 12  7 8 11 10 13  8 6 9 11 14  12 13 14 15 15
16 17 18 19 16  12 13 17 16 17  13 14 18 17 18  14 15 19 18 19  15 12 16 19 20
End
END
for height in 0 1; do
    printf '%s\n' 'MeshVersionFormatted 2' 'Dimension 3' 'Vertices 5' "0 0 0 0  1 0 $height 0  2 0 0 0  1 1 0 0  0 1 0 0" \
        'Triangles 1' '2 3 4 1' 'Quadrilaterals 1' '1 2 4 5 1' 'Edges 6' \
        '1 2 1  2 4 2  4 5 3  5 1 4  2 3 5  3 4 6' End >flat$height.mesh
done
for name in solids flat0 flat1; do
    expect_status 0 "$program" convert $name.mesh $name.vtu -q
    expect_status 0 "$program" convert $name.mesh $name.e -q
done
"$python" "$cli/exodus_mesh.py" sides ascii41.msh.e ascii41.msh.vtu solids.e solids.vtu flat0.e flat0.vtu flat1.e flat1.vtu ||
    fail "VTK reads other sides"
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
