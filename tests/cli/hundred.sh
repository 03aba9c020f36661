#!/usr/bin/env bash
# Files of the formats that came last, made from arrays (hundred_files.py): the elements and volumes that numpy finds. Needs
# python3-vtk9, python3-meshio, python3-h5py and Gmsh's module; a hundred files of each with PLANISH_LONG.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import gmsh, h5py, meshio, numpy, vtk" 2>/dev/null || { echo "skipped: no gmsh, h5py, meshio or vtk"; exit 77; }
for name in zlib.vtu cube.h5; do
    if lacks "$source_folder/tests/data/$name"; then
        echo "skipped: planish was built without Expat, zlib or HDF5"
        exit 77
    fi
done
"$python" "$cli/hundred_files.py" "$program" files "$([ -n "${PLANISH_LONG-}" ] && echo 100 || echo 13)" >out 2>err ||
    fail "files that are read wrongly: $(cat out err)"
sed 's/^/figure: /' out
finish
