#!/usr/bin/env bash
# Dependencies point one way (docs/architecture.md): no file includes what its folder must not know.
set -u
cd "$(dirname "$0")/../.." || exit 1
bad=0

# refuse FOLDER-OR-FILES PATTERN WHY
refuse() {
    local found
    found=$(grep -nE "$2" $1 2>/dev/null)
    if [ -n "$found" ]; then
        echo "$3:"
        echo "$found"
        bad=1
    fi
}

others() { # all folders of src but those named
    local pattern
    pattern=$(printf '%s|' "$@")
    for folder in src/*/; do
        folder=${folder#src/}
        [[ "${folder%/}" =~ ^(${pattern%|})$ ]] || printf '%s|' "${folder%/}"
    done | sed 's/|$//'
}

includes() { echo "^ *# *include *\"($1)/"; }

refuse "src/base/*" "$(includes "$(others base)")" "base knows nobody"
refuse "src/geometry/*" "$(includes "$(others base geometry)")" "geometry knows base only"
refuse "src/topology/*" "$(includes "$(others base geometry topology)")" "topology knows base and geometry"
refuse "src/star/*" "$(includes "$(others base geometry star)")" "star knows base and geometry"
refuse "src/quality/*" "$(includes "$(others base geometry quality)")" "quality knows base and geometry"
refuse "src/shape/*" "$(includes "$(others base geometry topology shape)")" "shape knows base, geometry and topology"
refuse "src/sweep/*" "$(includes "io|shape")" "sweep knows neither io nor shape"
refuse "src/io/*" "$(includes "$(others base io)")" "io knows base only"
refuse "$(ls tools/*.[ch] | grep -v -e tools/output.c -e tools/worst_place.c)" "$(includes "$(others base)")" \
    "the program knows public headers and base, io's output to write its reports, geometry for angles"
refuse "$(ls tools/report/*.[ch] | grep -v -e surface.c -e markup.c)" "$(includes "$(others base)")" \
    "a report knows public headers and base, its surface topology's facets, its markup io's base64"
refuse "$(ls src/*/* tools/*.[ch] tools/report/*.[ch] | grep -v src/base/parallel.c)" "omp\.h|# *pragma *omp" "OpenMP belongs in src/base/parallel.c"
refuse "$(ls src/*/* tools/*.[ch] tools/report/*.[ch] | grep -v src/plan/placement.c)" "hwloc\.h" "hwloc belongs in src/plan/placement.c"
refuse "$(ls src/*/* tools/*.[ch] tools/report/*.[ch] include/planish/*.h)" '^ *# *include *[<"](mpi|petsc)' \
    "MPI and PETSc belong in mpi/"
refuse "$(ls mpi/* | grep -v -e plexrows.c -e plexfile.h)" "$(includes "$(others base topology)")" \
    "planish-mpi knows public headers, base, and topology's facets, its plexfile io's output and HDF5"
refuse "tools/mpi/plexrows.c tools/mpi/plexfile.h" "$(includes "$(others base io)")" "plexfile knows io's output and HDF5"

[ $bad = 0 ] && echo "includes point one way"
exit $bad
