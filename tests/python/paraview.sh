#!/usr/bin/env bash
# By hand: the plugin of ParaView, loaded as ParaView loads it, and the tests of the filter with
# ParaView's VTK. Debian's packages paraview, python3-paraview and (for the picture) xvfb are needed:
# 80 MB to download, 800 MB on disk; they replace python3-vtk9. PLANISH_BUILD is the folder of a
# build, PICTURE a folder for a picture.
set -u
cd "$(dirname "$0")/../.." || exit 1
command -v pvpython >/dev/null || { echo "without ParaView (pvpython)"; exit 77; }
export PLANISH_LIBRARY=${PLANISH_BUILD:?}/libplanish.so
export PYTHONDONTWRITEBYTECODE=1 OMP_WAIT_POLICY=passive
export PYTHONPATH=$PWD/tools/python:${PYTHONPATH-}
pvpython --force-offscreen-rendering tests/python/in_vtk.py &&
    pvpython --force-offscreen-rendering tests/python/in_paraview.py || exit 1
[ -z "${PICTURE-}" ] || xvfb-run -a pvpython tests/python/in_paraview.py "$PICTURE"
