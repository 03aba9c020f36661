#!/usr/bin/env bash
# The same bits on any number of threads, and the ways to say how many.
. "$(dirname "$0")/common.sh"

"$program" --version | grep -q "without OpenMP" && has_threads=0 || has_threads=1

# expect_threads N: the last run had so many, or one if there is no more to be had.
expect_threads() {
    [ $has_threads = 1 ] || set -- 1
    expect_json "r['threads'] == $1"
}

expect_status 0 "$program" smooth "$sample" -o one.msh -j 1 -q
for threads in 2 3 4 7; do
    expect_status 0 "$program" smooth "$sample" -o many.msh -j $threads --json report.json -q
    cmp one.msh many.msh || fail "$threads threads give another mesh than 1"
    expect_threads $threads
done

# The report has a number for the bits, which that of the file is.
expect_status 0 "$program" smooth "$sample" -o one.msh -j 1 -q --json one.json
expect_status 0 "$program" smooth "$sample" -o many.msh -j 3 -q --json many.json
expect_status 0 "$program" quality many.msh -q --json read.json
expect_status 0 "$program" quality "$sample" -q --json before.json
python3 - <<'CHECK' || fail "checksums"
import json
one, many, read, before = (json.load(open(f"{name}.json"))["checksum"]
                           for name in ("one", "many", "read", "before"))
assert one == many == read != before and len(one) == 16 and int(one, 16)
CHECK

# OMP_NUM_THREADS is respected, -j wins over it.
expect_status 0 env OMP_NUM_THREADS=3 "$program" smooth "$sample" -o many.msh --json report.json -q
expect_threads 3 # OMP_NUM_THREADS
expect_status 0 env OMP_NUM_THREADS=3 "$program" smooth "$sample" -o many.msh -j 2 \
    --json report.json -q
expect_threads 2 # -j beside OMP_NUM_THREADS

# A system that cannot start so many threads gives fewer; with too little memory for anything it is
# one line and 2, but never a mesh missing after 1. (Sanitizers need more than that for themselves.)
for kilobytes in 20000 60000 120000 250000; do
    if (ulimit -v $kilobytes && "$program" --version) >/dev/null 2>&1; then
        rm -f few.msh
        (ulimit -v $kilobytes && exec "$program" smooth "$sample" -o few.msh -j 64 -q) 2>err
        status=$?
        [ $status -eq 2 ] || { [ $status -eq 0 ] && cmp one.msh few.msh; } ||
            fail "ulimit -v $kilobytes: status $status"
    fi
done

# Binding is left alone where the user has decided.
for setting in OMP_PROC_BIND=close OMP_PLACES=threads OMP_PROC_BIND=false; do
    expect_status 0 env $setting "$program" smooth "$sample" -o many.msh -j 2 -q
    cmp one.msh many.msh || fail "$setting gives another mesh"
done

# --bind says so as well. As many threads as cores are bound, and no other number.
binding() { python3 -c "import json; print(json.load(open('report.json'))['binding'])"; }
cores=$(python3 -c "import os; print(len(os.sched_getaffinity(0)))")
for how in auto none; do
    expect_status 0 "$program" smooth "$sample" -o many.msh --bind $how --json report.json -q
    cmp one.msh many.msh || fail "--bind $how gives another mesh"
    case "$how $(binding)" in
        "auto one thread per core, on CPUs "* | "none not bound") ;;
        "auto not bound") # without hwloc, on one core, or where OpenMP uses fewer threads
            [ "$cores" -eq 1 ] || ! ldd "$program" | grep -q hwloc || [ -n "${OMP_NUM_THREADS-}" ] ||
                fail "--bind auto binds nothing" ;;
        *) fail "--bind $how: $(binding)" ;;
    esac
done
expect_status 0 "$program" smooth "$sample" -o many.msh -j 1 --bind auto --json report.json -q
[ "$(binding)" = "not bound" ] || fail "one thread is bound: $(binding)"
expect_status 64 "$program" smooth "$sample" -o many.msh --bind cores
grep -q -- "--bind.*must be auto or none" err || fail "--bind cores: $(cat err)"

# The other direction is its own method, as deterministic.
expect_status 0 "$program" smooth "$sample" -o fr1.msh --direction fletcher-reeves -j 1 -q
expect_status 0 "$program" smooth "$sample" -o fr3.msh --direction fletcher-reeves -j 3 -q
cmp fr1.msh fr3.msh || fail "Fletcher-Reeves depends on the number of threads"
cmp -s fr1.msh one.msh && fail "both directions give the same mesh"
finish
