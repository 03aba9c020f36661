#!/usr/bin/env bash
# Bad command lines: status 64, one line, a hint to the help, nothing read or written.
. "$(dirname "$0")/common.sh"

cp "$sample" in.msh
bad() {
    expect_status 64 "$program" "$@"
    expect_one_line
    expect_text "--help"
    expect_no_file out.msh
}

bad
bad polish
bad --frobnicate
bad smooth
bad smooth in.msh
bad smooth -o out.msh
bad smooth in.msh second.msh -o out.msh
bad smooth "" -o out.msh
bad smooth in.msh -o ""
for command in smooth convert; do
    bad $command in.msh ""
    expect_text "the name of the output file is empty"
done
bad compare in.msh ""
expect_text "the name of the second mesh file is empty"
bad convert in.msh out.med
expect_text "no extension of a format that planish converts to: give --to NAME"
bad smooth in.msh -o
bad smooth in.msh -o out.msh --frobnicate
bad smooth in.msh -o out.msh -Z
bad smooth in.msh -o out.msh --ignore-regions=1
bad smooth in.msh -o out.msh --max-sweeps
bad --generate
bad --generate html
bad --generate man more
bad quality
bad quality in.msh -o out.msh
expect_text "must end in .vtu or .vtk"
bad quality in.msh in.msh -o view.vtu
expect_text "takes one mesh"
cp in.msh in.vtk
bad quality in.vtk --format gmsh -o ./in.vtk
expect_text "would overwrite the mesh"
rm in.vtk
bad quality in.msh -v

# The line says what is wrong and what to do.
while IFS='|' read -r arguments text; do
    # shellcheck disable=SC2086
    bad $arguments
    expect_text "$text"
done <<'LINES'
|no command is named: smooth, quality, compare, advise, groups, convert or report
smoth in.msh -o out.msh|did you mean smooth?
polish|unknown command 'polish'; it must be smooth, quality, compare, advise, groups, convert or report
--smooth in.msh -o out.msh|name a command first: smooth, quality, compare, advise, groups, convert or report
smooth|no mesh file is named
smooth in.msh|give -o OUT
smooth in.msh in.msh|-o in.msh replaces it
smooth in.msh b.msh c.msh|to smooth several meshes, give --output-dir DIR or --in-place
smooth in.msh -o out.msh --in-place|give --output or --in-place, not both
smooth in.msh -o out.msh --output-dir .|give --output or --output-dir, not both
smooth in.msh --in-place --output-dir .|give --in-place or --output-dir, not both
smooth in.msh --output-dir .|is in the folder of --output-dir: give --in-place
smooth in.msh ./in.msh --output-dir smoothed|would get the same name
smooth in.msh in.msh --in-place --json -|--json takes one mesh, but 2 are named
smooth in.msh -o out.msh --best --like in.msh|leave out --best
smooth in.msh -o out.msh --max-sweeps|option --max-sweeps needs a value (N)
smooth in.msh -o out.msh --max-sweep|unknown option '--max-sweep'; did you mean --max-sweeps?
smooth in.msh -o out.msh --max-sweeps x|--max-sweeps 'x' must be a whole number, 0 or more
smooth in.msh -o out.msh --tolerence 0|unknown option '--tolerence'; did you mean --tolerance?
smooth in.msh -o out.msh --objective best|must be radius-ratio, mean-ratio, edge-ratio or worst
smooth in.msh -o out.msh --rings 2|--rings has no effect without --only-worse-than
smooth in.msh -o out.msh --fix wall|there is no group 'wall' to hold; the file has: skin, bracket
smooth in.msh -o out.msh --fix skn|there is no group 'skn' to hold; did you mean 'skin'? Try 'planish smooth --help'
smooth in.msh -o out.xyz|and no extension of a format that planish converts to
smooth - -o out.msh|standard input is /dev/stdin
smooth in.msh -o out.msh --slide curved --crease-angle 0|--crease-angle '0' must be a number of degrees above 0, up to 180
quality in.msh --surface-of in.msh --crease-angle 180.1|must be a number of degrees above 0, up to 180
quality in.msh --crease-angle 10|--crease-angle has no effect without --surface-of or --report; try 'planish quality --help'
quality in.msh --rings 2|planish quality has no option --rings
advise in.msh --fix wall|try 'planish advise --help'
in.msh --slide-tolerance 1|--slide-tolerance '1' must be a fraction above 0
LINES

# Values: the whole word, in range, finite.
mapfile -t values < <(some "1 " x 1x -1 " 1" "" 99999999999999999999 +1 1.5 0x10)
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --only-worse-than 2 --rings "$value"
    bad smooth in.msh -o out.msh --max-sweeps "$value"
    bad smooth in.msh -o out.msh --threads "$value"
done
bad smooth in.msh -o out.msh -j 0
mapfile -t values < <(some nan x 1x "1 " " 1" "" 1e999 inf 0x1p3 1,5)
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --tolerance "$value"
    bad smooth in.msh -o out.msh --time-limit "$value"
    bad smooth in.msh -o out.msh --only-worse-than "$value"
done
bad smooth in.msh -o out.msh --tolerance -1e-9
bad smooth in.msh -o out.msh --time-limit 0
bad smooth in.msh -o out.msh --only-worse-than 0.5
bad smooth in.msh -o out.msh --rings 1
bad smooth in.msh -o out.msh --only-worse-than 2 --rings 101
for arguments in "--layers 1" --layers=1; do
    # shellcheck disable=SC2086
    bad smooth in.msh -o out.msh --only-worse-than 2 $arguments
    expect_text "give --rings"
done
mapfile -t values < <(some "hold " none holds "")
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --layers "$value"
    expect_text "hold, keep or ignore"
done
bad smooth in.msh -o out.msh --layers
bad smooth in.msh -o out.msh --layers ignore --fix-layers
expect_text "not both"
bad smooth in.msh -o out.msh --layers keep --fix-layers
expect_text "give --fix-layers or --layers keep, not both"
bad smooth in.msh -o out.msh --layers keep --like in.msh
expect_text "give --like or --layers keep, not both"
bad smooth in.msh -o out.msh --layers keep --objective worst
expect_text "--layers keep minimises the mean-ratio"
mapfile -t values < <(some nan x -1 1.5 "" inf 0x1)
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --curve-quality "$value"
done
bad smooth in.msh -o out.msh --curve-quality 0.5 --method laplacian
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --like in.msh --size-weight "$value"
done
bad smooth in.msh -o out.msh --size-weight 0.5
expect_text "without --like"
mapfile -t values < <(some "--size h" "--size-from in.sol" --keep-sizes)
for sizes in "${values[@]}"; do
    bad smooth in.msh -o out.msh --like in.msh $sizes
    expect_text "not both"
    bad smooth in.msh -o out.msh $sizes --objective radius-ratio
    expect_text "minimises the mean-ratio"
    bad smooth in.msh -o out.msh $sizes --method laplacian
done
bad smooth in.msh -o out.msh --size h --size-from in.sol
expect_text "give --size or --size-from, not both"
bad smooth in.msh -o out.msh --size ""
bad quality in.msh --keep-sizes
bad quality in.msh in.msh --size h
expect_text "takes one mesh"
for measure in aspect-ratio scaled-jacobian; do
    bad smooth in.msh -o out.msh --objective worst --worst-measure $measure
    expect_text "choose dihedral or radius-ratio"
done
bad smooth in.msh -o out.msh --direction south
bad smooth in.msh -o out.msh --format step
bad smooth in.msh -o out.msh --fix ""
bad smooth in.msh -o out.msh --fix "no such group"

mapfile -t values < <(some nan x inf 0 1e999 0x1p3 "1 " " 1" 1,5 -1 "" 1x)
for value in "${values[@]}"; do
    bad smooth in.msh -o out.msh --min-volume "$value"
    bad smooth in.msh -o out.msh --min-volume "bracket=$value"
    bad smooth in.msh -o out.msh --min-volume-fraction "$value"
    bad smooth in.msh -o out.msh --max-displacement "$value"
    bad smooth in.msh -o out.msh --max-displacement "${value}h"
    [ "$value" = 0 ] || bad smooth in.msh -o out.msh --area-weight "$value" --min-volume 1
    bad smooth in.msh -o out.msh --box "$value"
    [ "${value#[0-]}" != "$value" ] || bad smooth in.msh -o out.msh --box "0,0,0,1,1,$value"
    bad quality in.msh --min-volume "$value"
done
bad smooth in.msh -o out.msh --min-volume
bad smooth in.msh -o out.msh --min-volume =1
bad smooth in.msh -o out.msh --min-volume 1=
bad smooth in.msh -o out.msh --min-volume 1 --min-volume 2
bad smooth in.msh -o out.msh --min-volume 1 --min-volume-fraction 0.1
bad smooth in.msh -o out.msh --min-volume-fraction 1
bad smooth in.msh -o out.msh --min-volume "no such group=1"
expect_text "bracket"
bad quality in.msh --min-volume 2:1=1
expect_text "solid elements"
bad smooth in.msh -o out.msh --area-weight 0.5
bad smooth in.msh -o out.msh --area-weight 1.5 --min-volume 1
bad smooth in.msh -o out.msh --max-displacement 1hh
bad smooth in.msh -o out.msh --max-displacement 1m
bad smooth in.msh -o out.msh --max-displacement h
bad smooth in.msh -o out.msh --box 0,0,1,1
expect_text "needs 6"
bad smooth in.msh -o out.msh --box 0,0,0,1,1
bad smooth in.msh -o out.msh --box 0,0,0,1,1,1,1
bad smooth in.msh -o out.msh --box 0,0,0,1,1,1,
bad smooth in.msh -o out.msh --box 0,0,0,1,-1,1
bad smooth in.msh -o out.msh --objective best
bad smooth in.msh -o out.msh --method smart-laplacian
for option in $(some --objective --method --box --max-displacement --area-weight); do
    bad quality in.msh $option 1
done

# Options without any effect.
for method in $(some laplacian area-laplacian length-laplacian); do
    bad smooth in.msh -o out.msh --method $method --objective radius-ratio
    bad smooth in.msh -o out.msh --direction newton --method $method
    bad smooth in.msh -o out.msh --method $method --only-worse-than 2
    bad smooth in.msh -o out.msh --method $method --min-volume 1 --area-weight 0.5
    expect_text "no effect"
done

bad quality in.msh --worst 3 -q
expect_text "no effect"
expect_status 0 "$program" quality in.msh --worst 3 -q --json worst.json

# Where a region has a volume and another has none, there is nothing to weigh.
cp "$source_folder/tests/data/ascii22.msh" parts.msh
bad smooth parts.msh -o out.msh --min-volume "upper part=1e-3" --area-weight 0.5
expect_text "element "
cp "$source_folder/tests/data/square.msh" square.msh
bad smooth square.msh -o out.msh --box 0,0,0,1,1,1
expect_text "needs 4"
bad smooth square.msh -o out.msh --min-volume edge=1
expect_text "plate"

# Values for options without one, options of another command.
bad smooth in.msh -o out.msh --no-untangle=1
bad quality in.msh --no-untangle

# Outputs that make no sense.
bad smooth in.msh -o out.xyz
bad smooth in.msh -o out
expect_no_file out.xyz
bad smooth in.msh -o out.msh --json out.msh
bad smooth in.msh -o out.msh --json in.msh
bad quality in.msh --json in.msh
bad smooth in.msh -o /dev/stdout --json -

# TetGen's mesh is several files; the report may be none of them, neither read nor written.
cp "$source_folder"/tests/data/tetgen.* .
for report in $(some tetgen.ele tetgen.node tetgen.face other.node other.ele other.edge); do
    bad smooth tetgen.node -o other.node --json $report
    bad smooth tetgen.ele -o other.ele --json $report
done
bad quality tetgen.node --json tetgen.ele
expect_no_file other.node other.ele
cmp tetgen.ele "$source_folder/tests/data/tetgen.ele" || fail "the elements were changed"
cmp in.msh "$sample" || fail "the input was changed"

# Help and version go to standard output and need nothing else.
mapfile -t values < <(some --help "smooth --help" "quality --help" --version "smooth --version" "smooth nothing.msh --help")
for arguments in "${values[@]}"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" $arguments
    [ -s out ] && [ ! -s err ] || fail "$arguments: output expected, and no message"
    expect_status 2 bash -c "exec \"$program\" $arguments >/dev/full"
done
expect_status 0 "$program" --version
grep -q '^planish [0-9]*\.[0-9]*\.[0-9]*$' out || fail "version line"
awk 'length($0) > 80 { exit 1 }' out || fail "version wider than 80 columns"

# A reader that has seen enough is no error to be told: the pipe is closed when the program comes to it.
for arguments in --help "smooth --help" "--generate bash" "--generate man" --version "quality $sample"; do
    mkfifo closed
    # shellcheck disable=SC2086
    (exec 3>closed && read -r _ <gone && exec "$program" $arguments >&3 2>err) &
    mkfifo gone
    : <closed
    echo >gone
    wait $!
    [ $? -eq 2 ] && [ ! -s err ] || fail "$arguments to a closed pipe: $(cat err)"
    rm closed gone
done
expect_status 0 "$program" smooth --help
awk 'length($0) > 80 { exit 1 }' out || fail "help wider than 80 columns"
finish
