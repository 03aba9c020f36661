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
for out in b.msh link.msh; do
    expect_status 64 "$program" convert a.msh $out
    expect_text "'$out' already exists: -o $out replaces it"
done
expect_status 64 "$program" convert a.msh a.msh
expect_text "the converted copy would overwrite the mesh 'a.msh'"
cmp a.msh "$sample" && cmp b.msh "$sample" && [ ! -e nowhere.msh ] || fail "convert replaced a mesh"
cp b.msh old.msh
expect_status 0 "$program" convert a.msh -o old.msh -q
cp old.msh converted.msh
expect_status 0 "$program" convert a.msh new.msh -q
cmp converted.msh new.msh && ! cmp -s converted.msh b.msh || fail "-o replaces, and gives what OUT behind IN gives"
expect_status 64 "$program" convert a.msh b.msh -o c.msh
expect_text "unexpected argument 'b.msh': give one mesh file"
mkdir a_folder.msh
for command in smooth convert; do
    expect_status 64 "$program" $command a.msh a_folder.msh
    expect_text "the folder 'a_folder.msh' already exists"
done

# Nor what another program makes there meanwhile: a mesh from a pipe is read after the first look.
for command in smooth convert; do
    rm -f pipe.msh late.msh
    mkfifo pipe.msh
    "$program" $command pipe.msh late.msh -q >out 2>err &
    run=$!
    exec 3>pipe.msh
    echo other >late.msh
    cat "$sample" >&3
    exec 3>&-
    wait $run
    [ $? = 2 ] || fail "$command: OUT appears meanwhile"
    expect_text "late.msh: another program created this file meanwhile"
    expect_one_line
    [ "$(cat late.msh)" = other ] || fail "$command: a file was replaced that has appeared meanwhile"
done
rm late.msh pipe.msh

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
for folder in new/deep/est new/deep/other/ ./far//off; do
    expect_status 0 "$program" smooth a.msh b.msh --output-dir $folder -q
    cmp $folder/a.msh wanted.msh && cmp $folder/b.msh wanted.msh || fail "--output-dir $folder"
done
expect_status 2 "$program" smooth a.msh --output-dir a_file/in/it
expect_one_line
expect_text "a_file/in/it: cannot make this folder: Not a directory"
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
# Nor the output before it, as where the system ignores the case of letters.
mkdir -p upper one_file
cp "$sample" upper/A.msh
ln -s A.msh one_file/a.msh
expect_status 2 "$program" smooth upper/A.msh a.msh b.msh --output-dir one_file -q
expect_text "a.msh: not smoothed, as the output would replace that of 'upper/A.msh'"
expect_one_line
cmp one_file/A.msh wanted.msh && cmp one_file/b.msh wanted.msh || fail "an output replaced another one"
# Nor a file that an option reads.
mkdir before
cp "$sample" before/a.msh
for option in --like --surface-of; do
    expect_status 64 "$program" smooth a.msh $option before/a.msh --output-dir before
    expect_text "the output of 'a.msh' would overwrite the file of $option 'before/a.msh'"
    expect_status 64 "$program" smooth a.msh $option before/a.msh --slide curved -o out.msh --json before/../before/a.msh
    expect_text "the report would overwrite the file of $option 'before/../before/a.msh'"
done
expect_status 64 "$program" smooth a.msh before/a.msh --like before/a.msh --in-place
expect_text "the output of 'before/a.msh' would overwrite the file of --like 'before/a.msh'"
cp a.msh itself.msh
expect_status 0 "$program" smooth itself.msh --like itself.msh --in-place -q
cp "$source_folder/tests/data/square.stl" onto.stl
cp onto.stl kept.stl
expect_status 64 "$program" smooth a.msh -o out.msh --onto onto.stl --report onto.stl
expect_text "the report would overwrite the file of --onto 'onto.stl'"
echo sizes >sizes.sol
expect_status 64 "$program" quality a.msh --size-from sizes.sol --json sizes.sol
expect_text "the report would overwrite the file of --size-from 'sizes.sol'"
cmp before/a.msh "$sample" && cmp onto.stl kept.stl && [ "$(cat sizes.sol)" = sizes ] || fail "a file that is read was replaced"
expect_no_file out.msh
ln -s a.msh same.msh
expect_status 64 "$program" smooth a.msh b.msh same.msh --in-place
expect_text "'a.msh' and 'same.msh' are the same mesh: name it once"
cmp a.msh "$sample" && cmp b.msh "$sample" || fail "an input was replaced"
for name in . .. ./ ../. /; do
    expect_status 64 "$program" smooth $name --output-dir named
    expect_text "'$name' has no name that --output-dir can use"
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
