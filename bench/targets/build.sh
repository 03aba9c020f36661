# shellcheck shell=bash
# build.sh: for the scripts of this folder, which read it in the project's folder: builds planish, and says where it
# and the modules of Python are.
here=bench/targets
build="build-bench"
results=$build/results
python=/usr/bin/python3 # the one that Debian's packages are for
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH=$here:bench:bench/untangle:bench/fem:tools/python
command -v gmsh >/dev/null || { echo "$here: gmsh is missing: apt install gmsh" >&2; exit 2; }
$python -c 'import numpy' || { echo "$here: apt install python3-numpy" >&2; exit 2; }

mkdir -p $results
cmake -S . -B $build -DCMAKE_BUILD_TYPE=Release -DPLANISH_TESTS=OFF >$build/build.log
cmake --build $build -j "$(nproc)" >>$build/build.log
# A copy, so that another build in the same folder meanwhile does no harm.
programs=$build/programs-targets
mkdir -p $programs
cp -L $build/planish $build/libplanish*.so* $programs/
export LD_LIBRARY_PATH=$PWD/$programs PLANISH_LIBRARY=$PWD/$programs/libplanish.so

# show PART FILE: its table, also in docs/targets.md.
show() {
    $python $here/show.py "$2" "$1" >"$results/targets-$1.md"
    $python bench/between.py docs/targets.md "$1" <"$results/targets-$1.md"
    cat "$results/targets-$1.md"
}
