#!/usr/bin/env bash
# docs/tutorial.md: each of its commands runs, and prints the lines that are there.
. "$(dirname "$0")/common.sh"

mkdir bin case
ln -s "$program" bin/planish
ln -s "$source_folder" case/planish
cd case || exit 1

# Commands and lines are compared; a figure that is wrong is found.
PATH=$work/bin:$PATH python3 "$cli/tutorial.py" "$source_folder/docs/tutorial.md" ||
    fail "docs/tutorial.md"
sed 's/worst radius ratio   *98.386$/worst radius ratio 98.385/' "$source_folder/docs/tutorial.md" >wrong.md
cmp -s wrong.md "$source_folder/docs/tutorial.md" && fail "the first figure of the tutorial was not found"
mkdir again
ln -s "$source_folder" again/planish
(cd again && PATH=$work/bin:$PATH python3 "$cli/tutorial.py" ../wrong.md 4 >out) &&
    fail "a wrong figure was not found"
grep -q 98.385 again/out || fail "another line was found wrong: $(cat again/out)"
finish
