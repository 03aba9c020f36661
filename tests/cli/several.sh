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
"$program" smooth a.msh /dev/stdout -q 2>err | cmp - wanted.msh || fail "OUT that is a pipe: $(cat err)"

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

ln -s nowhere leads_nowhere
expect_status 2 "$program" smooth a.msh --output-dir leads_nowhere
expect_text "cannot make this folder: File exists"

# No output replaces another input, nor a folder above.
mkdir linked
ln -s ../b.msh linked/a.msh
expect_status 64 "$program" smooth a.msh b.msh --output-dir linked
expect_text "the output of 'a.msh' is a link to 'b.msh', another input"
expect_no_file linked/b.msh
expect_status 64 "$program" smooth b.msh a.msh --output-dir .
expect_text "'b.msh' is in the folder of --output-dir: give --in-place"
ln -s a.msh same.msh
expect_status 64 "$program" smooth a.msh b.msh same.msh --in-place
expect_text "'a.msh' and 'same.msh' are one mesh: name it once"
cmp a.msh "$sample" && cmp b.msh "$sample" || fail "an input was replaced"
for name in . .. ./ ../. /; do
    expect_status 64 "$program" smooth $name --output-dir named
    expect_text "'$name' gives no name in --output-dir"
done
expect_no_file named

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
