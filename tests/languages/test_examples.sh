#!/usr/bin/env bash
# Examples in Rust, Fortran and Julia: each is built, smooths its mesh, and says the same as the others.
set -u
source_dir=${PLANISH_SOURCE:?}
build=${PLANISH_BUILD:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PLANISH_LIBRARY=$build/libplanish.so LD_LIBRARY_PATH=$build

build_rust() { rustc -O "$source_dir/docs/examples/rust/smooth.rs" -L "$build" -l planish -o "$work/rust"; }
build_fortran() {
    (cd "$work" && gfortran -Wall -Wextra -Werror -std=f2018 "$source_dir/docs/examples/fortran/smooth.f90" \
        -L"$build" -lplanish -o fortran)
}
build_julia() { printf '#!/bin/sh\njulia %s/docs/examples/julia/smooth.jl\n' "$source_dir" >"$work/julia" && chmod +x "$work/julia"; }

missing=0
for language in rust:rustc fortran:gfortran julia:julia; do
    compiler=${language#*:} language=${language%:*}
    if ! command -v "$compiler" >/dev/null; then
        echo "without $compiler: the example in $language is not run"
        [ "$language" = julia ] || missing=1 # Debian 12 has none
        continue
    fi
    "build_$language" >"$work/log" 2>&1 && "$work/$language" >"$work/$language.out" 2>&1 ||
        { cat "$work/log" "$work/$language.out"; exit 1; }
    echo "$language: $(cat "$work/$language.out")"
done
# The worst is halved at least, and all say the same.
for out in "$work"/*.out; do
    cmp "$out" "$(find "$work" -name '*.out' | head -n 1)" || exit 1
    awk '/^worst radius ratio [0-9.]+ -> [0-9.]+$/ { good = $6 < $4 / 2 && $6 >= 1 } END { exit !good }' "$out" ||
        { echo "$out: it is not smoothed"; exit 1; }
done
[ $missing = 0 ] || exit 77
echo ok
