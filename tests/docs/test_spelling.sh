#!/usr/bin/env bash
# Words of documents, headers, help texts and docstrings are spelt well; and those that are not are found.
set -u
here=$(cd "$(dirname "$0")" && pwd)
{ command -v aspell && command -v codespell && aspell dicts | grep -qx en_GB-ise; } >/dev/null ||
    { echo "without aspell, its British English (aspell-en) or codespell"; exit 77; }
python3 "$here/spelling.py" || exit 1

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/tests/docs" "$work/src"
cp "$here/spelling.py" "$here/words.txt" "$work/tests/docs"
printf '%s\n' 'Good words, `badd code`.' 'A tetrahedra of badd color.' >"$work/a.md"
echo '/* seperate */' >"$work/src/a.c"
python3 "$work/tests/docs/spelling.py" >"$work/said" 2>&1 && { echo "mistakes are not found"; exit 1; }
grep -q '^a.md:2: badd: ' "$work/said" && grep -q '^a.md:2: color: ' "$work/said" && grep -q 'seperate ==> separate' "$work/said" &&
    grep -q '^7 words, 2 unknown$' "$work/said" || { cat "$work/said"; exit 1; }
