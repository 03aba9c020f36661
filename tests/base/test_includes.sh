#!/usr/bin/env bash
# Dependencies point one way (docs/architecture.md): no file includes or calls what its floor must not
# know (floors.py), and libraries of the system are asked in one place each.
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

everything=$(git ls-files 'src/*.[ch]' 'tools/*.[ch]' 2>/dev/null || find src tools -name '*.[ch]')
but() { grep -v -e "^$1" <<<"$everything"; }
refuse "$(but src/base/parallel.c)" "omp\.h|# *pragma *omp" "OpenMP belongs in src/base/parallel.c"
refuse "$(but src/plan/placement.c)" "hwloc\.h" "hwloc belongs in src/plan/placement.c"
refuse "$(but tools/mpi/) $(ls include/planish/*.h)" '^ *# *include *[<"](mpi|petsc)' \
    "MPI and PETSc belong in tools/mpi"

python=$(command -v python3) || { echo "without python3: calls are not looked at"; exit $bad; }
"$python" tests/base/floors.py "${PLANISH_BUILD:?}" || bad=1

[ $bad = 0 ] && echo "includes and calls point one way"
exit $bad
