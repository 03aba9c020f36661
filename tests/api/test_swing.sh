#!/usr/bin/env bash
# docs/examples/swing.c: steps turn elements over, no call leaves one, and the mesh comes out the same on
# one thread and on two.
set -u
example=${PLANISH_SOURCE:?}/docs/examples/swing.c
build=${PLANISH_BUILD:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $*" >&2
    exit 1
}

cc -std=c11 -Wall -Wextra -Werror -I"$PLANISH_SOURCE/include" "$example" -o "$work/swing" -L"$build" \
    -lplanish -lm -Wl,-rpath,"$build" || fail "it does not build"
for threads in 1 2; do
    OMP_NUM_THREADS=$threads "$work/swing" 12 48 >"$work/$threads.csv" || fail "$threads threads"
    cut -d, -f1-6 "$work/$threads.csv" >"$work/$threads"
done
cmp "$work/1" "$work/2" || fail "one thread and two differ"
awk -F, 'NR > 1 { turned += $2; left += $3; if ($4 < 1 || $4 > 50) bad++ }
         END { exit !(NR == 14 && turned > 50 && left == 0 && bad == 0) }' "$work/1" ||
    fail "$(cat "$work/1")"
"$work/swing" 0 2>"$work/err" && fail "no steps"
grep -q '^usage: swing' "$work/err" || fail "$(cat "$work/err")"
exit 0
