# shellcheck shell=bash
# common: build an example of docs/examples/meshers with the library as built, run it, and look at
# what it says and writes. Sourced.
set -u
examples=${PLANISH_SOURCE:?}/docs/examples/meshers
program=${PLANISH_PROGRAM:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "FAILED: $*" >&2
    cat "$work"/*.log >&2
    exit 1
}

# needs FILE PACKAGE: the test is skipped without.
needs() {
    [ -e "$1" ] || { echo "without $2 (no $1)"; exit 77; }
}

# build COMPILER EXAMPLE OPTION...
build() {
    local compiler=$1 example=$2 name
    shift 2
    name=${example%.*}
    "$compiler" -Wall -I"$PLANISH_SOURCE/include" "$examples/$example" -o "$work/$name" \
        -L"${PLANISH_BUILD:?}" -lplanish "$@" -Wl,-rpath,"$PLANISH_BUILD" >"$work/build.log" 2>&1 ||
        fail "$example does not build"
    [ "$(wc -l <"$examples/$example")" -lt 80 ] || fail "$example is too long to be read"
}

# expect_better OUT: what the example printed last into $work/out.log, and the file that it wrote.
expect_better() {
    local out=$1 before after
    before=$(sed -n 's/^before.*RMS of RR \([0-9.]*\),.*/\1/p' "$work/out.log")
    after=$(sed -n 's/^after.*RMS of RR \([0-9.]*\),.*/\1/p' "$work/out.log")
    echo "$before $after" | awk '{ exit !(NF == 2 && $2 < $1 && $2 > 1) }' ||
        fail "RMS $before -> $after"
    "$program" quality "$out" >"$work/quality.log" 2>&1 || fail "$out cannot be read"
    grep -q "inverted elements *0$" "$work/quality.log" || fail "$out has inverted elements"
    awk -v after="$after" '/RMS radius ratio/ { off = $NF - after; same = off < 2e-4 && off > -2e-4 }
        END { exit !same }' "$work/quality.log" ||
        fail "$out is not the mesh that was smoothed to $after"
}
