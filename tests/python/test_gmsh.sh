#!/usr/bin/env bash
# planish.gmsh with Gmsh's Python API: the mesh in memory against the program and the same mesh in a file.
set -u
python=/usr/bin/python3 # the one that Debian's packages are for
$python -c 'import numpy, gmsh' 2>/dev/null || { echo "without python3-gmsh"; exit 77; }
export PLANISH_LIBRARY=${PLANISH_BUILD:?}/libplanish.so PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH=${PLANISH_SOURCE:?}/tools/python:${PYTHONPATH-}
exec $python "$(dirname "$0")/in_gmsh.py"
