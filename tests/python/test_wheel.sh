#!/usr/bin/env bash
# The wheel: built offline from the files that it needs, listed, installed into an empty environment,
# used without anything of this tree, uninstalled.
set -u
source_dir=${PLANISH_SOURCE:?}
python=/usr/bin/python3 # the one that Debian's packages are for
for module in pip setuptools wheel numpy venv; do
    $python -c "import $module" 2>/dev/null || { echo "without $module"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset PLANISH_LIBRARY PYTHONPATH LD_LIBRARY_PATH
export PYTHONDONTWRITEBYTECODE=1 PIP_NO_INDEX=1 PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_ROOT_USER_ACTION=ignore
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
run() {
    "$@" >"$work/log" 2>&1 || { tail -n 40 "$work/log" >&2; fail "$*"; }
}

# ---- built ----------------------------------------------------------------------------------------
mkdir "$work/source"
cp -r "$source_dir"/{CMakeLists.txt,LICENSE,README.md,pyproject.toml,setup.py,include,src,tools} "$work/source"
find "$work/source" -name __pycache__ -prune -exec rm -r {} +
cd "$work/source" || exit 1
run $python -m pip wheel . --no-build-isolation --no-deps -w "$work"
cd "$work" || exit 1
wheel=$(echo "$work"/planish-*.whl)
[[ $wheel == *-0.2.0-py3-none-linux_*.whl ]] || fail "the wheel is called $wheel"
[ "$(stat -c %s "$wheel")" -lt 4000000 ] || fail "the wheel has $(stat -c %s "$wheel") bytes"

# ---- listed ---------------------------------------------------------------------------------------
run $python -m zipfile -l "$wheel"
cp log list
for name in planish/__init__.py planish/py.typed planish/accessor.py planish/pyvista_plugin.py planish/bin/planish \
    planish/lib/libplanish.so.0.2 planish/lib/libplanish_io.so.0.2 dist-info/.*LICENSE \
    dist-info/entry_points.txt; do
    grep -q "$name" list || fail "the wheel lacks $name"
done
for folder in tests/ src/ __pycache__ _old; do
    grep -q "$folder" list && fail "the wheel has $folder"
done

# ---- installed and used ---------------------------------------------------------------------------
run $python -m venv --system-site-packages --without-pip "$work/env"
own=$work/env/bin/python
run "$own" -m pip install --no-deps "$wheel"
cp "$source_dir/docs/examples/bracket.msh" .
cat >use.py <<'END'
import pathlib
import sys

import planish

planish.smooth(planish.read("bracket.msh"), slide="auto").n_moved_nodes > 0 or sys.exit("no node moved")
mesh = planish.read("bracket.msh")
planish.smooth(mesh, slide="auto")
mesh.write("module.msh")
for line in pathlib.Path("/proc/self/maps").read_text().splitlines():
    if "libplanish" in line and not line.split()[-1].startswith(sys.prefix):
        sys.exit(line)
END
run "$own" use.py
run "$work/env/bin/planish" smooth bracket.msh -o program.msh --slide auto -q
run cmp module.msh program.msh
cmp -s module.msh bracket.msh && fail "nothing was smoothed"
run "$own" -m planish --version
grep -q "planish 0.2.0" log || fail "$(cat log)"
"$work/env/bin/planish" smooth missing.msh -o out.msh >log 2>&1
[ $? = 2 ] || fail "the program's status is lost"

# ---- uninstalled ----------------------------------------------------------------------------------
run "$own" -m pip uninstall -y planish
[ -z "$(find env -iname '*planish*')" ] || fail "left: $(find env -iname '*planish*')"
echo "$(stat -c %s "$wheel") bytes"
