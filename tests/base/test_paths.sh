#!/usr/bin/env bash
# Every file that a document, a script or a source names by its path in the project is there.
set -u
cd "$(dirname "$0")/../.." || exit 1
folders='(bench|docs|include|packaging|src|tests|tools)'

# Without files that a build or a run has put there.
named() {
    find README.md CMakeLists.txt .ci bench docs include packaging src tests tools -type f \
        ! -path '*/__pycache__/*' ! -name '*.svg' -print0 |
        xargs -0 grep -IhoE "(^|[^A-Za-z0-9_./-])$folders/[A-Za-z0-9_./-]*\.[A-Za-z0-9]+" |
        grep -oE "$folders/.*" | sort -u
}

count=0
missing=0
while read -r path; do
    count=$((count + 1))
    [ -e "$path" ] && continue
    echo "$path is not there; these name it:"
    grep -rIl -F "$path" README.md CMakeLists.txt .ci bench docs include packaging src tests tools
    missing=1
done < <(named)
[ "$count" -gt 100 ] || { echo "only $count files are named: the pattern is wrong"; exit 1; }
exit $missing
