#!/usr/bin/env bash
# Files of the formats that came last, made from arrays (hundred_files.py): the elements and volumes that numpy finds. Needs
# python3-vtk9, python3-meshio, python3-h5py and Gmsh's module; a hundred files of each with PLANISH_LONG.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules gmsh h5py meshio numpy vtk || { echo "skipped: no gmsh, h5py, meshio or vtk"; exit 77; }
for name in zlib.vtu cube.h5; do
    if lacks "$source_folder/tests/data/$name"; then
        echo "skipped: planish was built without Expat, zlib or HDF5"
        exit 77
    fi
done
numbers=$(seq 0 12)
[ -z "${PLANISH_QUICK-}" ] || numbers="1 3 5 8 10 12" # solid and flat ones, of both orders
[ -z "${PLANISH_LONG-}" ] || numbers=$(seq 0 99)
# shellcheck disable=SC2086
"$python" "$cli/hundred_files.py" "$program" files $numbers >out 2>err ||
    fail "files that are read wrongly: $(cat out err)"
sed 's/^/figure: /' out
finish
