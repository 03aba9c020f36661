#!/usr/bin/env bash
# Meshes as Gmsh and TetGen write them, in every format that both sides know. Needs gmsh and tetgen.
. "$(dirname "$0")/common.sh"

command -v gmsh >/dev/null && command -v tetgen >/dev/null ||
    { echo "skipped: no gmsh or no tetgen"; exit 77; }

# smooth FILE: it becomes better, stays readable, and is written as many bytes say.
smooth() {
    local out=smooth.${1##*.}
    expect_status 0 "$program" smooth "$1" -o "$out" --json report.json -q
    python3 - <<'END' || fail "$1"
import json
r = json.load(open("report.json"))
assert r["stop"] == "converged" and r["certified"] and r["moved_nodes"] > 0
assert r["after"]["rms_radius_ratio"] < r["before"]["rms_radius_ratio"]
END
    expect_status 0 "$program" quality "$out" -q
}

geometry=$source_folder/docs/examples/bracket.geo
generate() {
    gmsh -3 -v 1 -nt 1 "$geometry" "$@" || fail "gmsh $*"
}
generate -format msh22 -o ascii22.msh
generate -format msh22 -bin -o binary22.msh
generate -format msh41 -o ascii41.msh
generate -format msh41 -bin -o binary41.msh
generate -format mesh -o medit.mesh
generate -format vtk -o ascii.vtk
generate -format vtk -bin -o binary.vtk
for file in ascii22.msh binary22.msh ascii41.msh binary41.msh medit.mesh ascii.vtk binary.vtk; do
    smooth $file
done

# What Gmsh wrote in one format it reads back, with as many nodes and elements.
expect_status 0 "$program" smooth binary41.msh -o back.msh -q
gmsh -v 3 -save back.msh -format msh41 -o again.msh >/dev/null && [ -s again.msh ] ||
    fail "gmsh cannot read what was written"

cat >cube.poly <<'END'
8 3 0 0
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
6 1
1 0 1
4 1 2 3 4
1 0 1
4 5 6 7 8
1 0 1
4 1 2 6 5
1 0 1
4 2 3 7 6
1 0 1
4 3 4 8 7
1 0 1
4 4 1 5 8
0
0
END
tetgen -pqa0.005Q cube.poly || fail tetgen
smooth cube.1.node
finish
