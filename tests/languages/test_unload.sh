#!/usr/bin/env bash
# A program that loads the library while it runs may unload it after a call with several threads, which outlive it.
set -u
here=$(cd "$(dirname "$0")" && pwd)
[ "$(uname)" = Linux ] || exit 77
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
library=${PLANISH_BUILD:?}/libplanish.so
[ -e "$library" ] || { echo "without shared libraries"; exit 77; }
nm -D "$library" | grep -q ' U __[a-z]*san_' && { echo "sanitizers are to be loaded first"; exit 77; }
cc -I"${PLANISH_SOURCE:?}/include" "$here/unload.c" -o "$work/unload" -ldl || exit 1
"$work/unload" "$library" || { echo "$library: status $?"; exit 1; }
echo ok
