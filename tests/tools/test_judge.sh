#!/usr/bin/env bash
# The judge of bench/public: no fault in pairs that planish has smoothed, and every kind of fault in spoiled ones.
set -u
source_folder=${PLANISH_SOURCE:?} program=${PLANISH_PROGRAM:?}
python=/usr/bin/python3 # the one that Debian's packages are for
"$python" -c "import numpy, meshio" 2>/dev/null || { echo "skipped: no numpy or meshio"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PYTHONDONTWRITEBYTECODE=1 OPENBLAS_NUM_THREADS=1
export PYTHONPATH=$source_folder/bench/public:$source_folder/bench:$source_folder/tests/tools
"$python" "$source_folder/tests/tools/judge_validity.py" || exit 1
"$python" "$source_folder/tests/tools/judge_pairs.py" "$program" "$work" || exit 1

# The bench as a whole, on a folder with a mesh, a mesh in gzip, one that is damaged, and a file of another kind.
mkdir "$work/meshes"
cp "$source_folder/tests/data/square.msh" "$work/meshes/"
gzip -c "$source_folder/tests/data/ascii22.msh" >"$work/meshes/packed.msh.gz"
head -c 300 "$source_folder/tests/data/ascii41.msh" >"$work/meshes/damaged.msh"
echo "int main;" >"$work/meshes/other.c"
run() {
    "$python" "$source_folder/bench/public/run.py" "$program" "$work/results" "$work/meshes" -j 1 >"$work/table" 2>"$work/log"
}
run || { echo "FAILED: a fault, or no run"; cat "$work/table" "$work/log"; exit 1; }
grep -q '^| \*\*all\*\* | 3 | 2 | no option | 2 | 2 |' "$work/table" || { echo "FAILED: the table"; cat "$work/table"; exit 1; }
grep -q '^| refused | files |' "$work/table" || { echo "FAILED: nothing refused"; cat "$work/table"; exit 1; }
# Again: nothing is done twice.
cp "$work/results/results.jsonl" "$work/before"
run || { echo "FAILED: another end"; exit 1; }
cmp -s "$work/before" "$work/results/results.jsonl" || { echo "FAILED: work was done again"; exit 1; }
# A program that changes a byte that is no coordinate.
cat >"$work/liar" <<'END'
#!/usr/bin/env bash
case $1 in
    smooth) "$PLANISH_PROGRAM" "$@"; status=$?; sed -i 's/^\(\$MeshFormat\)/ \1/' "$4"; exit $status ;;
    *) exec "$PLANISH_PROGRAM" "$@" ;;
esac
END
chmod +x "$work/liar"
rm -r "$work/results"
"$python" "$source_folder/bench/public/run.py" "$work/liar" "$work/results" "$work/meshes" -j 1 --ways default >"$work/table" 2>&1 &&
    { echo "FAILED: no fault of a program that lies"; exit 1; }
grep -q "bytes: " "$work/table" || { echo "FAILED: changed bytes were not found"; cat "$work/table"; exit 1; }
echo ok
