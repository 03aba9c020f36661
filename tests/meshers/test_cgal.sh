#!/usr/bin/env bash
# After CGAL's Mesh_3, which has perturbed and exuded slivers.
. "$(dirname "$0")/common.sh"
[ -z "${PLANISH_QUICK-}" ] || { echo "left to tools/check --full: it takes a minute to build"; exit 77; }
needs /usr/include/CGAL/make_mesh_3.h libcgal-dev
build c++ after_cgal.cpp -O1 -lgmp -lmpfr
"$work/after_cgal" "$work/out.mesh" >"$work/out.log" 2>&1 || fail "after_cgal"
expect_better "$work/out.mesh"
echo ok
