#!/usr/bin/env bash
# The Python package by tools: types by mypy, docstrings by pydocstyle, as pyproject.toml says; and no
# word that a Python older than the one here would not know.
set -u
source_dir=${PLANISH_SOURCE:?}
python=/usr/bin/python3 # the one that Debian's packages are for
cd "$source_dir" || exit 1
if [ ! -x /usr/bin/mypy ] || [ ! -x /usr/bin/pydocstyle ] || ! $python -c 'import numpy' 2>/dev/null; then
    echo "without mypy, pydocstyle or numpy"
    exit 77
fi
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
/usr/bin/mypy --cache-dir "$cache" || exit 1
/usr/bin/pydocstyle tools/python/planish || exit 1
# A call that is right passes; one that is wrong is found, as the package says that it has types.
cat >"$cache/right.py" <<'END'
import numpy as np
import planish
points, cells = np.zeros((4, 3)), np.zeros((1, 4), dtype=int)
for nodes in np.ones(4, dtype=bool), cells[0]:
    planish.smooth(points, cells, around=nodes, fix=nodes, box=[[0, 0, 0], [1, 1, 1]])
planish.Plan(points, {"tetra": cells}, around=[1, 2], fix={1, 2}).smooth(max_displacement="0.5h", min_volume=1)
planish.smooth(points, cells, around={1}, fix={"wall"}, slide=["auto"], min_volume={"wall": 1.0})
END
MYPYPATH=tools/python /usr/bin/mypy --config-file= --cache-dir "$cache" "$cache/right.py" || exit 1
cat >"$cache/wrong.py" <<'END'
import planish
planish.smooth(1, objective="best")
planish.smooth(1, sweeps=3)
reveal_type(planish.quality(1).n_inverted)
END
MYPYPATH=tools/python /usr/bin/mypy --config-file= --cache-dir "$cache" "$cache/wrong.py" >"$cache/said" && exit 1
for word in 'has incompatible type "Literal' 'Unexpected keyword argument "sweeps"' 'is "builtins.int"'; do
    grep -q "$word" "$cache/said" || {
        cat "$cache/said"
        exit 1
    }
done
$python - <<'END'
import ast
import pathlib

for path in pathlib.Path("tools/python").rglob("*.py"):
    ast.parse(path.read_text(), feature_version=(3, 9))
END
