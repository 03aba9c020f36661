#!/usr/bin/env bash
# Documents are short, their sentences, too, and docs/README.md lists each; and what is wrong is found.
set -u
here=$(cd "$(dirname "$0")" && pwd)
python3 "$here/prose.py" || exit 1

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/tests/docs" "$work/docs"
cp "$here/prose.py" "$work/tests/docs"
cd "$work/docs" || exit 1
echo '[a](a.md)' >README.md
for _ in $(seq 26); do echo word; done >a.md
echo 'Three words here.' >b.md
python3 "$work/tests/docs/prose.py" >"$work/said" && { echo "bad prose is not found"; exit 1; }
grep -q 'does not list b.md$' "$work/said" && grep -q '/a.md: 26 words' "$work/said" &&
    grep -q '^29 words, 2 sentences, 1 of them long$' "$work/said" || { cat "$work/said"; exit 1; }
