#!/usr/bin/env bash
# Documents are short, their sentences, too, and docs/README.md lists each; and what is wrong is found.
set -u
docs=$(cd "$(dirname "$0")" && pwd)
python3 "$docs/prose.py" || exit 1

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/tests/docs" "$work/docs"
cp "$docs/prose.py" "$work/tests/docs"
echo '[a](a.md)' >"$work/docs/README.md"
for _ in $(seq 26); do echo word; done >"$work/docs/a.md"
echo 'Three words here.' >"$work/docs/b.md"
python3 "$work/tests/docs/prose.py" >"$work/said" && { echo "bad prose is not found"; exit 1; }
grep -q '^docs/README.md does not list b.md$' "$work/said" && grep -q '^docs/a.md: 26 words' "$work/said" &&
    grep -q '^29 words, 2 sentences, 1 of them long$' "$work/said" || { cat "$work/said"; exit 1; }
