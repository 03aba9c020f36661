#!/usr/bin/env bash
# planish-mpi: on 1, 2, 3 and more processes the file, checksum and exit status of `planish smooth`, with
# its options; and what goes wrong is told once, and ends all processes.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
fail() { echo "program.sh: $*" >&2; exit 1; }

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# together N ARGUMENT...: planish-mpi in N processes, and its exit status.
together() {
    local n=$1
    shift
    timeout 250 mpirun --oversubscribe -n "$n" "$PLANISH_MPI_PROGRAM" "$@"
}

# compare FILE HOW OPTION...: HOW: what the processes are to do: parts or alone; pieces: parts of a file that no
# process has all of.
compare() {
    local file=$1 how=$2 extension=${1##*.} n status expected
    shift 2
    "$PLANISH_PROGRAM" smooth "$file" -o "$work/0.$extension" -q -j 1 --json "$work/0.json" "$@" 2>"$work/0.err"
    expected=$?
    for n in 1 2 3 5; do
        rm -f "$work/n.$extension"
        together $n "$file" -o "$work/n.$extension" -q -j 1 --json "$work/n.json" "$@" 2>"$work/n.err"
        status=$?
        [ $status = $expected ] || fail "$file $*: status $status, not $expected: $(cat "$work/n.err")"
        cmp "$work/0.$extension" "$work/n.$extension" || fail "$file $*: other bytes with $n processes"
        python3 "$PLANISH_SOURCE/tests/mpi/compare.py" "$work/0.json" "$work/n.json" $n $how ||
            fail "$file $*: another report with $n processes"
    done
}

sample=$PLANISH_SOURCE/docs/examples/bracket.msh
python3 "$PLANISH_SOURCE/tests/cli/make_mesh.py" 6 0.9 "$work/tangled.mesh" || fail "no mesh"
python3 "$PLANISH_SOURCE/tests/cli/make_mesh.py" 9 0.15 "$work/valid.mesh" || fail "no mesh"
compare "$sample" parts
compare "$sample" parts --slide auto
cp "$work/n.msh" "$work/auto.msh"
compare "$sample" parts --min-volume-fraction 1e-6 --area-weight 0.2 --objective mean-ratio
compare "$sample" parts --objective worst
compare "$work/valid.mesh" parts --report "$work/report.html"
compare "$work/valid.mesh" parts --box 0.1,0.1,0.1,0.9,0.9,0.9 --direction fletcher-reeves
compare "$work/valid.mesh" parts --method laplacian
compare "$work/valid.mesh" parts --only-worse-than 1.7
compare "$work/tangled.mesh" parts --only-worse-than 2 --rings 2
compare "$work/tangled.mesh" parts
awk '/^Tetrahedra/ { t = 1 } t && NF == 5 && ++n % 3 == 0 { a = $1; $1 = $2; $2 = a } { print }' \
    "$work/tangled.mesh" >"$work/mixed.mesh"
compare "$work/mixed.mesh" parts
compare "$PLANISH_SOURCE/tests/data/square.msh" parts
compare "$PLANISH_SOURCE/tests/data/nastran.bdf" alone
# Hexahedra: one process keeps their layers as planish does, and says why it is one.
python3 - "$work/layers.vtk" <<'LAYERS' || fail "no mesh of layers"
import itertools, sys
heights = [0, 0.01, 0.02, 0.03, 0.3, 0.7, 1]
nodes = list(itertools.product(range(7), repeat=3))
number = {at: i for i, at in enumerate(nodes)}
bottom = [(0, 0), (1, 0), (1, 1), (0, 1)]
cells = [[number[i + a, j + b, k + c] for c in (0, 1) for a, b in bottom]
         for i, j, k in itertools.product(range(6), repeat=3)]
with open(sys.argv[1], "w") as file:
    print("# vtk DataFile Version 3.0\nlayers\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 343 double", file=file)
    for i, j, k in nodes:
        shift = 0.01 * ((7 * i + 3 * j + k) % 5 - 2) * (0 < min(i, j) and max(i, j) < 6)
        print(i / 6 + shift, j / 6 - shift, heights[k], file=file)
    print("CELLS 216", 9 * 216, file=file)
    for cell in cells:
        print(8, *cell, file=file)
    print("CELL_TYPES 216\n", "12 " * 216, file=file)
LAYERS
compare "$work/layers.vtk" alone
grep -q '"kept_layer_elements":[[:space:]]*[1-9]' "$work/n.json" || fail "no layers are kept"
compare "$work/layers.vtk" alone --slide auto --layers hold
together 2 "$work/layers.vtk" -o "$work/n.vtk" 2>"$work/err" >/dev/null
grep -q "one process of 2 does it all: its elements are not all straight simplices" "$work/err" ||
    fail "hexahedra: $(cat "$work/err")"
# Curved surfaces: one process lets nodes slide there, and says so.
compare "$sample" alone --slide curved
grep -q '"sliding_nodes":[[:space:]]*0' "$work/n.json" && fail "nothing slides"
cmp -s "$work/n.msh" "$work/auto.msh" && fail "bracket.msh has no curved surface"
compare "$sample" alone --slide curved --surface-tolerance 0.02
compare "$sample" alone --best
compare "$sample" parts --best --slide auto
together 2 "$sample" -o "$work/n.msh" --best 2>"$work/err" >/dev/null
[ "$(grep -c '^note: .*one process of 2 does it all: --best .*--slide auto' "$work/err")" = 1 ] ||
    fail "no note of --best: $(cat "$work/err")"
# Mid-side nodes: one process lets them follow. There is no .h5 of them.
python3 "$PLANISH_SOURCE/tests/cli/types_mesh.py" second 3 plain "$work/second.vtk" || fail "no mesh with mid-side nodes"
compare "$work/second.vtk" alone
together 2 "$work/second.vtk" -o "$work/second.h5" 2>"$work/err"
[ $? = 64 ] || fail "a .h5 of second order"
grep -q "and no extension of a format that planish converts to" "$work/err" || fail "a .h5 of second order: $(cat "$work/err")"
# Periodic sides: one process moves them.
python3 - "$work/valid.mesh" "$work/periodic.msh" <<'PERIODIC' || fail "no periodic mesh"
import sys
words = open(sys.argv[1]).read().split()
at, to = words.index("Vertices") + 2, words.index("Tetrahedra") + 2
nodes = [words[i : i + 3] for i in range(at, to - 2, 4)]
cells = [words[i : i + 4] for i in range(to, len(words) - 1, 5)]
n = round(len(nodes) ** (1 / 3))  # a row
with open(sys.argv[2], "w") as file:
    print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes", len(nodes), sep="\n", file=file)
    for i, x in enumerate(nodes, 1):
        print(i, *x, file=file)
    print("$EndNodes\n$Elements", len(cells), sep="\n", file=file)
    for i, c in enumerate(cells, 1):
        print(i, "4 2 1 1", *c, file=file)
    print("$EndElements\n$Periodic\n1\n2 2 1", n * n, sep="\n", file=file)
    for i in range(1, n**3, n):
        print(i + n - 1, i, file=file)
    print("$EndPeriodic", file=file)
PERIODIC
compare "$work/periodic.msh" parts
compare "$work/periodic.msh" alone --slide auto
[ -s "$work/report.html" ] || fail "no report"

# More processes than elements, and nodes of no element.
cat >"$work/one.mesh" <<'MESH'
MeshVersionFormatted 2
Dimension 3
Vertices
5
0 0 0 1
7 7 7 1
1 0 0 1
0 1 0 1
0 0 1 1
Tetrahedra
1
1 3 4 5 1
End
MESH
compare "$work/one.mesh" parts

# One line of error, of one process, and its status in all.
for n in 1 3; do
    together $n "$work/none.mesh" -o "$work/out.mesh" 2>"$work/err"
    [ $? = 2 ] || fail "a missing file"
    [ "$(grep -c '^planish: .*none.mesh' "$work/err")" = 1 ] || fail "a missing file: $(cat "$work/err")"
    together $n "$work/one.mesh" -o "$work/out.mesh" --wrong 2>"$work/err"
    [ $? = 64 ] || fail "a wrong option"
    [ "$(grep -c '^planish: unknown option' "$work/err")" = 1 ] || fail "a wrong option: $(cat "$work/err")"
    together $n "$work/one.mesh" -o /dev/full 2>"$work/err"
    [ $? = 2 ] || fail "a full disk"
done
together 2 --version >"$work/out" || fail "--version"
grep -q "^planish-mpi [0-9]" "$work/out" || fail "--version: $(cat "$work/out")"
together 2 --help | grep -q "mpirun -n 4 planish-mpi IN -o OUT" || fail "--help"

# PETSc's own files: as any other, and, in parts, without a process that has all of them.
python=python3 # the one that has h5py
$python -c "import h5py" 2>/dev/null || python=/usr/bin/python3
$python -c "import h5py" || fail "python3-h5py is needed"
awk '/Tetrahedra/ { t = 1 } t && NF == 5 && ++n > 2187 { $5 = 2 } { print }' "$work/valid.mesh" >"$work/regions.mesh"
together 2 "$work/regions.mesh" -o "$work/valid.h5" -q --max-sweeps 0 2>"$work/err" || fail "no .h5: $(cat "$work/err")"
"$PLANISH_PROGRAM" smooth "$work/regions.mesh" -o "$work/0.mesh" -q --json "$work/0.json" || fail "valid.mesh"
[ "$("$PLANISH_PROGRAM" smooth "$work/regions.mesh" --ignore-regions -o "$work/n.mesh" -q --json - | grep free_nodes)" != \
    "$(grep free_nodes "$work/0.json")" ] || fail "no nodes between regions"
timeout 100 mpirun --oversubscribe -n 2 "$PLANISH_WRITE_PLEX" "$work/valid.h5" "$work/faces.h5" ||
    fail "no faces"
PETSC_OPTIONS="-dm_plex_view_hdf5_storage_version 2.1.0" timeout 100 mpirun --oversubscribe -n 1 "$PLANISH_WRITE_PLEX" \
    "$work/valid.h5" "$work/second.h5" || fail "no second form"
timeout 100 mpirun --oversubscribe -n 3 "$PLANISH_WRITE_PLEX" "$PLANISH_SOURCE/tests/data/ascii22.msh" "$work/labels.h5" ||
    fail "no labels"
"$PLANISH_PROGRAM" smooth "$work/faces.h5" -o "$work/n.h5" -q --json "$work/n.json" || fail "faces.h5"
$python "$PLANISH_SOURCE/tests/mpi/compare_h5.py" "$work/0.json" "$work/n.json" "$work/0.mesh" "$work/n.h5" ||
    fail "faces.h5 is not regions.mesh"
for name in valid faces second labels; do
    compare "$work/$name.h5" parts
done
compare "$work/faces.h5" parts --fix "Cell Sets:2" --min-volume "Cell Sets:1=1e-5" --fix-layers --slide auto
compare "$work/labels.h5" parts --slide "Face Sets"
together 1 "$work/tangled.mesh" -o "$work/tangled.h5" -q --max-sweeps 0 --no-untangle 2>/dev/null
[ $? = 1 ] || fail "tangled.mesh as .h5"
export PETSC_OPTIONS=-planish_load_in_parts
for name in valid faces second labels; do # labels says more than the parts understand
    compare "$work/$name.h5" "$([ $name = labels ] && echo parts || echo pieces)"
    compare "$work/$name.h5" "$([ $name = labels ] && echo parts || echo pieces)" --slide auto
done
compare "$work/faces.h5" pieces --slide auto --ignore-regions
compare "$work/faces.h5" alone --slide curved
compare "$work/faces.h5" alone --best
# An element in two regions, and what PETSc would loop or crash on: the first process sees that.
$python - "$work/faces.h5" "$work" <<'DAMAGE'
import shutil, sys, h5py
def change(name, edit):
    path = f"{sys.argv[2]}/{name}.h5"
    shutil.copy(sys.argv[1], path)
    with h5py.File(path, "r+") as file:
        edit(file)
def twice(file):
    file["labels/Cell Sets/3/indices"] = file["labels/Cell Sets/2/indices"][:50]
def cone(file):
    file["topology/cells"][0] = file["topology/cells"][-1]
def label(file):
    file["labels/Cell Sets/1/indices"][3] = 10**8
def order(file):
    file["topology/order"][5] = -7
def minus(file): # a region of the number that DMPlex has for none, beside elements in none
    del file["labels/Cell Sets/1"]
    file.move("labels/Cell Sets/2", "labels/Cell Sets/-1")
for edit in twice, cone, label, order, minus:
    change(edit.__name__, edit)
DAMAGE
compare "$work/minus.h5" parts
compare "$work/twice.h5" parts
together 2 "$work/twice.h5" -o "$work/n.h5" 2>"$work/err" >/dev/null
grep -q "^note: .*twice.h5: one process has all of the mesh: it has labels" "$work/err" || fail "no note: $(cat "$work/err")"
for name in cone label order; do
    together 2 "$work/$name.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] && [ "$(grep -c '^planish: .*point' "$work/err")" = 1 ] || fail "$name.h5: $(cat "$work/err")"
done
compare "$work/tangled.h5" pieces --no-untangle
compare "$work/valid.h5" pieces --min-volume 1
compare "$work/valid.h5" parts --fix "Cell Sets"
# Of such a file only the coordinates change, however they stand there; where they are packed, the first
# process does it.
$python - "$work/valid.h5" "$work" <<'ROWS'
import shutil, sys, h5py
for name, storage in ("more", None), ("whole", {}), ("chunks", {"chunks": (64, 3)}), (
    "packed", {"chunks": (64, 3), "compression": "gzip"}):
    path = f"{sys.argv[2]}/{name}.h5"
    shutil.copy(sys.argv[1], path)
    with h5py.File(path, "r+") as file:
        file["mine"] = [1.5, 2.5]
        if storage is not None:
            x = file["geometry/vertices"][:]
            del file["geometry/vertices"]
            file.create_dataset("geometry/vertices", data=x, **storage)
ROWS
for name in more whole chunks packed; do
    compare "$work/$name.h5" "$([ $name = packed ] && echo parts || echo pieces)"
    [ $name = packed ] || $python "$PLANISH_SOURCE/tests/mpi/only_rows.py" "$work/$name.h5" "$work/n.h5" ||
        fail "$name.h5: more than rows"
done
# On a full disk nothing of it stays.
on_full_disk() {
    timeout 100 unshare -rm bash -c '
        mount -t tmpfs -o size=100k none "$0" || exit 99
        mpirun --oversubscribe -n 2 "$@"
        status=$?
        [ -z "$(ls -A "$0")" ] || exit 98
        exit $status' "$work/full" "$PLANISH_MPI_PROGRAM" "$@"
}
mkdir "$work/full"
if unshare -rm mount -t tmpfs none "$work/full" 2>/dev/null; then
    for file in valid.h5 valid.mesh; do
        on_full_disk "$work/$file" -o "$work/full/n.h5" -q 2>"$work/err"
        status=$?
        [ $status = 2 ] && [ "$(grep -c '^planish: .*n.h5: cannot be written: No space' "$work/err")" = 1 ] ||
            fail "a full disk, with .h5 of $file: $status $(cat "$work/err")"
    done
else
    echo "not tried: a full disk (mount)"
fi
cp "$work/more.h5" "$work/n.h5" # in its own place, as a link
ln -s n.h5 "$work/link.h5"
chmod 600 "$work/n.h5"
together 2 "$work/link.h5" -o "$work/link.h5" -q && [ -L "$work/link.h5" ] || fail "a link"
$python "$PLANISH_SOURCE/tests/mpi/only_rows.py" "$work/more.h5" "$work/n.h5" || fail "in its own place"
[ "$(stat -c %a "$work/n.h5")" = 600 ] || fail "the mode of the file that was replaced"
# A link that leads nowhere yet, and one to another file system; for .h5 of other files, too.
for file in more.h5 valid.mesh; do
    rm -f "$work/new.h5" "$work/away.h5"
    ln -s new.h5 "$work/away.h5"
    together 2 "$work/$file" -o "$work/away.h5" -q 2>"$work/err" && [ -L "$work/away.h5" ] && [ -s "$work/new.h5" ] ||
        fail "$file: a link that leads nowhere: $(cat "$work/err")"
    elsewhere=$(mktemp -p /dev/shm planish-XXXXXX.h5) || continue
    ln -sf "$elsewhere" "$work/away.h5"
    together 2 "$work/$file" -o "$work/away.h5" -q 2>"$work/err" && [ -L "$work/away.h5" ] &&
        [ "$(stat -c %s "$elsewhere")" = "$(stat -c %s "$work/new.h5")" ]
    status=$?
    rm "$elsewhere"
    [ $status = 0 ] || fail "$file: a link to another file system: $(cat "$work/err")"
done
mkfifo "$work/pipe.h5"
together 2 "$work/more.h5" -o "$work/pipe.h5" -q 2>"$work/err" <>"$work/pipe.h5"
[ $? = 2 ] && [ -p "$work/pipe.h5" ] && [ "$(grep -c '^planish: .*pipe' "$work/err")" = 1 ] || fail "a pipe: $(cat "$work/err")"
# Bound where the user has not said where threads belong.
for variable in NOTHING=1 OMP_PROC_BIND=true; do
    env "$variable" mpirun --oversubscribe --bind-to none -n 1 "$PLANISH_MPI_PROGRAM" "$work/more.h5" -o "$work/n.h5" -j 2 -v \
        >"$work/out" 2>&1
    grep -q "2 threads (one thread per core" "$work/out"
    [ $? = "$([ $variable = NOTHING=1 ]; echo $?)" ] || fail "$variable: $(cat "$work/out")"
done
# A node of no element stays where it is.
together 2 "$work/one.mesh" -o "$work/one.h5" -q --max-sweeps 0 || fail "one element as .h5"
$python - "$work/valid.h5" "$work/wrong.h5" <<'WRONG'
import shutil, sys, h5py
shutil.copy(*sys.argv[1:])
with h5py.File(sys.argv[2], "r+") as file:
    file["topology/cells"][100] = 10**7
WRONG
$python - "$work/valid.h5" "$work/nan.h5" <<'NAN'
import shutil, sys, h5py
shutil.copy(*sys.argv[1:])
with h5py.File(sys.argv[2], "r+") as file:
    file["geometry/vertices"][777, 1] = float("nan")
NAN
$python - "$work/faces.h5" "$work/face.h5" <<'FACE'
import shutil, sys, h5py
shutil.copy(*sys.argv[1:])
with h5py.File(sys.argv[2], "r+") as file:
    cells = file["topology/cells"]
    cells[1:4] = cells[0]
FACE
$python - "$work/valid.h5" "$work/plain.h5" <<'PLAIN'
import shutil, sys, h5py
shutil.copy(*sys.argv[1:])
with h5py.File(sys.argv[2], "r+") as file:
    del file["labels"]
PLAIN
for n in 1 2; do
    together $n "$work/plain.h5" -o "$work/n.h5" -q 2>"$work/err" || fail ".h5 without labels: $(cat "$work/err")"
    together $n "$work/one.h5" -o "$work/n.h5" -q || fail "one element from .h5"
    $python -c 'import sys, h5py; x = h5py.File(sys.argv[1])["geometry/vertices"][:].tolist()
assert sorted(x)[-1] == [7, 7, 7] and len(x) == 5, x' "$work/n.h5" || fail "a node of no element"
    together $n "$work/valid.h5" -o "$work/n.h5" --min-volume 1 --json "$work/n.json" >/dev/null 2>&1
    [ $? = 1 ] && [ -s "$work/n.json" ] || fail "volumes that cannot be met, with .h5"
    together $n "$work/wrong.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] && [ "$(grep -c '^planish: ' "$work/err")" = 1 ] || fail "a wrong .h5: $(cat "$work/err")"
    together $n "$work/face.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] && [ "$(grep -c '^planish: .*faces' "$work/err")" = 1 ] || fail "an element of one face: $(cat "$work/err")"
    together $n "$work/nan.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] && [ "$(grep -c '^planish: .*node 777 of the whole mesh' "$work/err")" = 1 ] ||
        fail "a .h5 with a node that is nowhere: $(cat "$work/err")"
    together $n "$work/none.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] || fail "a missing .h5"
    head -c 20000 "$work/valid.h5" >"$work/cut.h5"
    together $n "$work/cut.h5" -o "$work/n.h5" 2>"$work/err"
    [ $? = 2 ] && [ "$(grep -c '^planish: ' "$work/err")" = 1 ] || fail "a .h5 that was cut: $(cat "$work/err")"
    grep -q "HDF5-DIAG" "$work/err" && fail "a page of HDF5's"
    together $n "$work/valid.h5" -o "$work/n.h5" --slide name 2>"$work/err"
    [ $? = 64 ] || fail "--slide NAME with .h5"
done

# A process that dies ends the others; nothing is left half written.
python3 "$PLANISH_SOURCE/tests/cli/make_mesh.py" 64 0.2 "$work/large.mesh" || fail "no mesh"
mkdir "$work/end"
for signal in KILL TERM; do
    together 3 "$work/large.mesh" -o "$work/end/out.mesh" -v -j 1 --tolerance 1e-13 --max-sweeps 100000 \
        >/dev/null 2>"$work/err" &
    run=$!
    for _ in $(seq 600); do # until they are at it
        grep -q "smoothing" "$work/err" && break
        sleep 0.1
    done
    if [ $signal = KILL ]; then
        pkill -KILL -n -f "^$PLANISH_MPI_PROGRAM $work/large.mesh"
    else
        pkill -TERM -f "^mpirun .*$work/large.mesh"
    fi
    wait $run
    status=$?
    [ $status != 0 ] && [ $status != 124 ] || fail "a process that is ended by $signal: status $status"
    sleep 1
    pgrep -f "^$PLANISH_MPI_PROGRAM $work/large.mesh" >/dev/null && fail "processes stay after $signal"
    [ -z "$(find "$work/end" -type f ! -name out.mesh)" ] || fail "half written after $signal: $(ls -A "$work/end")"
done
exit 0
