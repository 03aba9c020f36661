#!/usr/bin/env bash
# The filter of planish.paraview with VTK alone; with ParaView, too, if it is there (see paraview.sh).
set -u
python=/usr/bin/python3 # the one that Debian's packages are for
$python -c 'import numpy, vtk' 2>/dev/null || { echo "without python3-vtk9"; exit 77; }
export PLANISH_LIBRARY=${PLANISH_BUILD:?}/libplanish.so PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH=${PLANISH_SOURCE:?}/tools/python:${PYTHONPATH-}
exec $python "$(dirname "$0")/in_vtk.py"
