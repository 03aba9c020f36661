#!/usr/bin/env bash
# The worst elements, listed and in the reports, against a script that shares no code with planish.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 4 0.25 pushed.mesh
python3 "$cli/make_mesh.py" 4 0.9 tangled.mesh
cp "$sample" bracket.msh
cp "$source_folder"/tests/data/{square,ascii22}.msh .

for mesh in bracket.msh pushed.mesh tangled.mesh square.msh ascii22.msh; do
    for n in 1 7 100000; do
        expect_status 0 "$program" quality $mesh --worst $n --json report.json
        python3 "$cli/worst_elements.py" $mesh $n report.json out || fail "--worst $n of $mesh"
        awk 'length($0) > 80 { exit 1 }' out || fail "--worst $n of $mesh is wider than 80 columns"
        ! grep -q ' $' out || fail "--worst $n of $mesh: trailing blanks"
    done
    expect_status 0 "$program" quality $mesh --json report.json
    expect_json "len(r['quality']['worst_elements']) == 10"
    ! grep -q "^ *element " out || fail "a list that nobody asked for"
    expect_status 0 "$program" quality $mesh --json report.json --threads 3 --worst 20
    cp report.json three.json
    expect_status 0 "$program" quality $mesh --json report.json --threads 1 --worst 20
    cmp report.json three.json || fail "the list of $mesh depends on the threads"
done

# Regions are tags of the file.
expect_status 0 "$program" quality ascii22.msh --worst 3 --json report.json
expect_json "{e['region'] for e in r['quality']['worst_elements']} <= {'upper part', 'lower part'}"
grep -q "in upper part$\|in lower part$" out || fail "no region in the list: $(cat out)"
region=$(python3 -c "import json; print(json.load(open('report.json'))['quality']['worst_elements'][0]['region'])")
expect_status 0 "$program" quality ascii22.msh --fix "$region" --json report.json -q
expect_json "not r['quality']['worst_elements'][0]['movable']"

# Elements of other types have regions, too. quality does not find which of their nodes move.
printf '%s\n' '12 2 0 0 0' '1 0 0 0' '2 1 0 0' '3 2 0 0' '4 0 1 0' '5 1 1 0' '6 2 1.5 0' '7 0 0 1' '8 1 0 1' \
    '9 2 0 1' '10 0 1 1' '11 1 1 1' '12 2 1 1' '1 4 hex 1 2 5 4 7 8 11 10' '2 8 hex 2 3 6 5 8 9 12 11' >two.avs
expect_status 0 "$program" quality two.avs --worst 2 --json report.json
expect_json "[e['region'] for e in r['quality']['worst_elements']] == ['3:8', '3:4']"
expect_json "all(e['movable'] is None for e in r['quality']['worst_elements'])"
grep -q ", in 3:8$" out && ! grep -q "all fixed" out || fail "the list of hexahedra: $(cat out)"

# smooth: before and after are of their own time.
expect_status 0 "$program" quality bracket.msh --json before.json -q
expect_status 0 "$program" smooth bracket.msh -o out.msh --json report.json -q
expect_status 0 "$program" quality out.msh --json after.json -q
for when in before after; do
    expect_json "r['$when']['worst_elements'] == json.load(open('$when.json'))['quality']['worst_elements']"
done
expect_json "r['before']['worst_elements'] != r['after']['worst_elements']"
# Nodes that slide move as well: of a cube of eight, all but the corners.
python3 "$cli/make_mesh.py" 2 0 cube.mesh
expect_status 0 "$program" smooth cube.mesh -o out.mesh --json report.json -q
expect_json "not all(e['movable'] for e in r['before']['worst_elements'])"
expect_status 0 "$program" smooth cube.mesh -o out.mesh --slide auto --json report.json -q
expect_json "all(e['movable'] for e in r['before']['worst_elements'])"

for value in 0 -1 x "" 1.5; do
    expect_status 64 "$program" quality bracket.msh --worst "$value"
    expect_one_line
done
finish
