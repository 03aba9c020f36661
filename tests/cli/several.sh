#!/usr/bin/env bash
# OUT behind IN, several meshes in one run, and the short words for options.
. "$(dirname "$0")/common.sh"

cp "$sample" a.msh
cp "$sample" b.msh
expect_status 0 "$program" smooth a.msh -o wanted.msh -j 1

# OUT behind IN is never there yet: what a pattern of the shell means is never replaced.
expect_status 0 "$program" smooth a.msh behind.msh -j 2
cmp behind.msh wanted.msh || fail "OUT behind IN"
expect_status 64 "$program" smooth a.msh b.msh
cmp b.msh "$sample" || fail "the second mesh of a pattern was replaced"
ln -s nowhere.msh link.msh
expect_status 64 "$program" smooth a.msh link.msh
[ ! -e nowhere.msh ] || fail "a link was followed"

# A folder for all of them, made where it is missing; what exists elsewhere stays.
expect_status 0 "$program" smooth a.msh b.msh --output-dir smoothed
[ "$(grep -c '^[ab]\.msh: gmsh' out)" = 2 ] || fail "not a table for each mesh"
cmp smoothed/a.msh wanted.msh && cmp smoothed/b.msh wanted.msh || fail "--output-dir"
cmp a.msh "$sample" || fail "--output-dir changed an input"
expect_status 0 "$program" smooth a.msh --output-dir smoothed/ --quiet --json result.json
grep -q "\"output\":[[:space:]]*\"smoothed/a.msh\"" result.json || fail "JSON with --output-dir"

# One that cannot be read has its message, and the others go on; the highest status counts.
echo "no mesh" >wrong.msh
expect_status 2 "$program" smooth wrong.msh a.msh --output-dir others -q
expect_one_line
cmp others/a.msh wanted.msh || fail "a wrong mesh kept another one from being smoothed"
[ ! -e others/wrong.msh ] || fail "a wrong mesh has an output"
echo >a_file
expect_status 2 "$program" smooth a.msh --output-dir a_file
expect_text "cannot make this folder"

expect_status 0 "$program" smooth a.msh b.msh --in-place -q
cmp a.msh wanted.msh && cmp b.msh wanted.msh || fail "--in-place"

# A mesh that is a folder keeps its name.
python3 "$cli/folder_meshes.py" mixed 3 ring
expect_status 0 "$program" smooth ring/ --output-dir others -q
[ -d others/ring ] || fail "no folder in --output-dir: $(ls others)"

# Short words are the options that they stand for, and what comes later counts.
cp "$sample" a.msh
same() { # SHORT... -- LONG...
    local short=()
    while [ "$1" != -- ]; do
        short+=("$1")
        shift
    done
    shift
    expect_status 0 "$program" smooth a.msh -o short.msh "${short[@]}"
    expect_status 0 "$program" smooth a.msh -o long.msh "$@"
    cmp short.msh long.msh || fail "${short[*]} is not $*"
}
same --best -- --slide curved --objective worst
same --best --slide auto -- --slide auto --objective worst
same --fast --tolerance 1e-5 -- --tolerance 1e-5
same --fast -- --tolerance 1e-3
! cmp -s short.msh wanted.msh || fail "--fast stops no earlier"
finish
