#!/usr/bin/env bash
# docs/examples/distributed.c: the same checksum with any number of processes, one line of error where
# there are more than planes.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
fail() { echo "example.sh: $*" >&2; exit 1; }

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
run() { timeout 200 mpirun --oversubscribe -n "$1" "$PLANISH_DISTRIBUTED" "$2"; }

for n in 1 2 3 4 5; do
    run $n 6 >"$work/$n" 2>"$work/err" || fail "$n processes: $(cat "$work/err")"
    grep -q "^$n processes: RMS 1\.[0-9]* after [0-9]* sweeps" "$work/$n" || fail "$n processes print $(cat "$work/$n")"
    sed 's/.*checksum//' "$work/$n" >>"$work/sums"
    sed 's/.*\(RMS.*sweeps\).*/\1/' "$work/$n" >>"$work/results"
done
[ "$(sort -u "$work/sums" | wc -l)" = 1 ] || fail "the checksums differ: $(cat "$work/sums")"
[ "$(sort -u "$work/results" | wc -l)" = 1 ] || fail "the results differ: $(cat "$work/results")"
run 7 6 >/dev/null 2>&1 || fail "a plane each"
run 8 6 >/dev/null 2>&1 && fail "8 processes for 7 planes"
exit 0
