#!/usr/bin/env bash
# What examples in Rust, Fortran and Julia declare is what the header says; a header that differs is noticed.
set -u
here=$(cd "$(dirname "$0")" && pwd)
cd "${PLANISH_SOURCE:?}" || exit 1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

compare() { # FOLDER-OF-INCLUDES EXAMPLE...: quiet if all is the same
    local include=$1
    shift
    python3 "$here/layouts.py" "$include/planish/planish.h" "$@" >"$work/check.c" &&
        cc -I"$include" "$work/check.c" -o "$work/check" && "$work/check"
}

# changed PATTERN REPLACEMENT: each example must fail with a header that is so changed.
changed() {
    local example
    mkdir -p "$work/planish"
    sed "s/$1/$2/" include/planish/planish.h >"$work/planish/planish.h"
    ! cmp -s include/planish/planish.h "$work/planish/planish.h" || { echo "$1 is not in the header"; exit 1; }
    for example in "${examples[@]}"; do
        ! compare "$work" "$example" >/dev/null 2>&1 || { echo "$example: $2 is not noticed"; exit 1; }
    done
}

examples=(docs/examples/rust/smooth.rs docs/examples/fortran/smooth.f90 docs/examples/julia/smooth.jl)
compare include "${examples[@]}" || exit 1
changed 'char text\[512\]' 'char text[520]'
changed 'const uint8_t \*is_layer;' 'int more; const uint8_t *is_layer;'
changed 'int64_t n_periodic; ' 'int n_periodic; '
changed 'planish_smooth(planish_plan \*plan, double' 'planish_smooth(planish_plan *plan, int more, double'
echo ok
