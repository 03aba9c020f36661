#!/usr/bin/env bash
# After Gmsh, by its own algorithm and by HXT.
. "$(dirname "$0")/common.sh"
needs /usr/include/gmshc.h libgmsh-dev
build cc after_gmsh.c -lgmsh
for algorithm in 1 10; do
    "$work/after_gmsh" "$PLANISH_SOURCE/docs/examples/bracket.geo" "$work/out.msh" 1 $algorithm \
        >"$work/out.log" 2>&1 || fail "after_gmsh"
    expect_better "$work/out.msh"
done
"$work/after_gmsh" "$work/none.geo" "$work/other.msh" >"$work/out.log" 2>&1 &&
    fail "a missing file passes"
echo ok
