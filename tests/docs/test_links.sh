#!/usr/bin/env bash
# Links of documents lead to files and headings that are there; and what is wrong is found.
set -u
here=$(cd "$(dirname "$0")" && pwd)
python3 "$here/links.py" || exit 1

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/tests/docs"
cp "$here/links.py" "$work/tests/docs"
printf '%s\n' '# A (b), c' '# A (b), c' '[1](#a-b-c) [2](#a-b-c-1) `[code](none)`' '[3](no.md)' '[4](#a-b)' >"$work/a.md"
python3 "$work/tests/docs/links.py" >"$work/said" && { echo "broken links are not found"; exit 1; }
grep -q 'a.md:4: no.md: .*no such file' "$work/said" && grep -q 'a.md:5: #a-b: .*no such heading' "$work/said" &&
    grep -q '^1 files, 4 links, 2 broken$' "$work/said" || { cat "$work/said"; exit 1; }

mkdir "$work/site"
echo '<a href="b.html#x">1</a> <a href="#y">2</a> <script src="https://example.org/s.js"></script>' >"$work/site/a.html"
echo '<p id="y">' >"$work/site/b.html"
python3 "$work/tests/docs/links.py" "$work/site" >"$work/said" && { echo "broken links of pages are not found"; exit 1; }
grep -q 'a.html:1: b.html#x: .*no such heading' "$work/said" && grep -q 'a.html:1: #y: .*no such heading' "$work/said" &&
    grep -q 'a.html: script loads https://example.org/s.js$' "$work/said" && grep -q ' 3 broken$' "$work/said" ||
    { cat "$work/said"; exit 1; }
