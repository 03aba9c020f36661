#!/usr/bin/env bash
# By hand: docs/examples/meshers/freecad_smooth.py in FreeCAD. Debian's package freecad (0.20) and gmsh are needed:
# 160 MB to download, 630 MB on disk. PLANISH_BUILD is the folder of a build.
. "$(dirname "$0")/common.sh"
command -v freecadcmd >/dev/null || { echo "without FreeCAD (freecadcmd)"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
PATH=$(cd "$(dirname "$program")" && pwd):$PATH
export OMP_WAIT_POLICY=passive
cd "$work" || exit 1
freecadcmd "$here/freecad_part.py" </dev/null >make.log 2>&1
[ -s part.FCStd ] || fail "FreeCAD makes no part"
cp part.FCStd start.FCStd
freecadcmd part.FCStd "$examples/freecad_smooth.py" </dev/null >smooth.log 2>&1
freecadcmd "$here/freecad_compare.py" </dev/null >compare.log 2>&1
grep -q '^same$' compare.log || fail "the mesh is not the same but for better places"
echo ok
