#!/usr/bin/env bash
# The code in README.md and documents: each piece in C and C++ is compiled as it stands, those with a main
# and those in Python are run.
set -u
source_dir=${PLANISH_SOURCE:?}
build=${PLANISH_BUILD:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $*" >&2
    exit 1
}

awk -v folder="$work" '
    /^```(c|cpp|python)$/ { n++; kind = substr($0, 4); sub("python", "py", kind)
        name = sprintf("%s/%02d.%s", folder, n, kind); next }
    /^```/ { name = "" }
    name { print > name }' "$source_dir/README.md" "$source_dir"/docs/{embedding,python,targets}.md
ran=0
for piece in "$work"/*.c "$work"/*.cpp; do
    compile=(cc -std=c11)
    [ "${piece##*.}" = c ] || compile=(c++ -std=c++11)
    "${compile[@]}" -Wall -Wextra -Werror -I"$source_dir/include" -c "$piece" -o "$piece.o" ||
        fail "$(basename "$piece"): $(head -n 3 "$piece")"
    grep -q '^int main' "$piece" || continue
    "${compile[0]}" "$piece.o" -o "$piece.run" -L"$build" -lplanish -Wl,-rpath,"$build" || fail "$piece"
    "$piece.run" >"$work/out" 2>&1 || fail "$(cat "$work/out")"
    # What it prints is in the text.
    grep -qF "    $(cat "$work/out")" "$source_dir/docs/embedding.md" || fail "it prints $(cat "$work/out")"
    ran=$((ran + 1))
done
[ "$(find "$work" -name '*.c' | wc -l)" -ge 7 ] && [ $ran -ge 2 ] || fail "the code was not found"
if /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
    cd "$work" || fail "$work"
    mkdir -p docs && ln -sfn "$source_dir/docs/examples" docs/examples
    for piece in "$work"/*.py; do
        PLANISH_LIBRARY=$build/libplanish.so PYTHONPATH=$source_dir/tools/python \
            PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 "$piece" >out || fail "$piece"
    done
    cmp -s out.msh docs/examples/bracket.msh && fail "docs/python.md smooths nothing"
fi
echo "$(find "$work" -name '*.c' -o -name '*.cpp' -o -name '*.py' | wc -l) pieces"
