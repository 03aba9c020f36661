#!/usr/bin/env bash
# The Python module, with the library that has been built. Needs python3-numpy; meshio if it is
# there.
set -u
python=/usr/bin/python3 # the one that Debian's packages are for
$python -c 'import numpy' 2>/dev/null || { echo "without numpy"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PLANISH_LIBRARY=${PLANISH_BUILD:?}/libplanish.so PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH=${PLANISH_SOURCE:?}/tools/python
$python "$here/layout.py" >"$work/layout.c" &&
    cc -I"$PLANISH_SOURCE/include" "$work/layout.c" -o "$work/layout" && "$work/layout" &&
    for test in module elements reference sizes interface files; do
        $python "$here/$test.py" || exit 1
    done
