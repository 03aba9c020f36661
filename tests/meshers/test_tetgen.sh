#!/usr/bin/env bash
# After TetGen, whose neighbours planish gets, too.
. "$(dirname "$0")/common.sh"
needs /usr/include/tetgen.h libtet1.5-dev
build c++ after_tetgen.cpp -ltet
cat >"$work/cube.stl" <<'STL'
solid cube
facet normal 0 0 0 outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 1 0
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 0 0
vertex 1 1 0
vertex 1 0 0
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 0 1
vertex 1 0 1
vertex 1 1 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 0 1
vertex 1 1 1
vertex 0 1 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 0 0
vertex 1 0 0
vertex 1 0 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 0 0
vertex 1 0 1
vertex 0 0 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 1 0 0
vertex 1 1 0
vertex 1 1 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 1 0 0
vertex 1 1 1
vertex 1 0 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 1 1 0
vertex 0 1 0
vertex 0 1 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 1 1 0
vertex 0 1 1
vertex 1 1 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 1 0
vertex 0 0 0
vertex 0 0 1
endloop endfacet
facet normal 0 0 0 outer loop
vertex 0 1 0
vertex 0 0 1
vertex 0 1 1
endloop endfacet
endsolid cube
STL
for switches in "" pq1.3a0.001; do
    # shellcheck disable=SC2086
    "$work/after_tetgen" "$work/cube.stl" "$work/out" ${switches:-pq1.4a0.002O9/7} \
        >"$work/out.log" 2>&1 || fail "after_tetgen"
    expect_better "$work/out.node"
done
"$work/after_tetgen" "$work/none.stl" "$work/other" >"$work/out.log" 2>&1 &&
    fail "a missing file passes"
echo ok
