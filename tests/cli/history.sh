#!/usr/bin/env bash
# --history: the page has the mesh after some of the sweeps, and is the same otherwise.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 5 0.2 valid.mesh
python3 "$cli/make_mesh.py" 6 0.9 tangled.mesh
cp "$source_folder/tests/data/square.msh" square.msh
mkdir sweeps

# What is no number of states, or has no page.
expect_status 64 "$program" smooth valid.mesh -o x.mesh --history 5
expect_text "give --report FILE.html"
expect_one_line
mapfile -t wrong < <(some 2 -5 5.5 101 many "")
for k in "${wrong[@]}"; do
    expect_status 64 "$program" smooth valid.mesh -o x.mesh --report x.html --history "$k"
    expect_text "must be a whole number from 3 to 100"
done
expect_status 64 "$program" quality valid.mesh --report x.html --history 5
expect_no_file x.mesh x.html

expect_status 0 "$program" smooth valid.mesh -o plain.mesh --report plain.html -q
grep -q "without three.js" plain.html && { echo "built without three.js"; exit 77; }
! grep -qE '"steps"|class="step"' plain.html || fail "states that nobody asked for"

# check_history PAGE JSON K [FOLDER]
check_history() {
    python3 "$cli/check_history.py" "$@" >list || fail "the steps of $1"
}

# Each state is the mesh that so many sweeps alone make, in space and in the plane; few and many of them.
for k in $(some 6 3 20 100); do
    for mesh in valid.mesh square.msh; do
        expect_status 0 "$program" smooth $mesh -o with.msh --tolerance 1e-7 --history $k --report page.html --json page.json -q
        expect_status 0 "$program" smooth $mesh -o without.msh --tolerance 1e-7 -q
        cmp with.msh without.msh || fail "the result with --history"
        check_history page.html page.json $k
        for sweep in $(cat list); do
            [ $k -gt 6 ] || expect_status 0 "$program" smooth $mesh -o "sweeps/$sweep.mesh" --tolerance 1e-7 --max-sweeps "$sweep" -q
        done
        [ $k -gt 6 ] || check_history page.html page.json $k sweeps
    done
done

# Of a large mesh the worst elements are drawn: they are those of the whole mesh after that sweep.
python3 "$cli/make_mesh.py" 14 0.2 large.mesh
expect_status 0 "$program" smooth large.mesh -o large_out.mesh --history 4 --report large.html --json large.json -q
check_history large.html large.json 4
for sweep in $(cat list); do
    expect_status 0 "$program" smooth large.mesh -o "sweeps/$sweep.mesh" --max-sweeps "$sweep" -q
done
check_history large.html large.json 4 sweeps

# The same on any number of threads; with sweeps that untangle, nodes that slide, the worst elements, and what a
# trial leaves as it is only once.
steps_of() {
    sed -n '/"sweeps":[0-9]*,"steps"/,$p' "$1" | sed '/<\/script>/,$d'
}
expect_status 0 "$program" smooth tangled.mesh -o out.mesh --best --slide auto --history 30 --report one.html --json one.json -q -j 1
check_history one.html one.json 30
for j in $(some 3 2); do
    expect_status 0 "$program" smooth tangled.mesh -o other.mesh --best --slide auto --history 30 --report more.html -q -j $j
    cmp out.mesh other.mesh || fail "the result on $j threads"
    [ -n "$(steps_of one.html)" ] && [ "$(steps_of one.html)" = "$(steps_of more.html)" ] || fail "the steps on $j threads"
done
python3 - one.html <<'END' || fail "a state twice"
import json, sys
text = open(sys.argv[1]).read()
text = text[text.index('id="picture-data">') + len('id="picture-data">'):]
steps = [dict(step, sweep=0) for step in json.loads(text[:text.index("</script>")])["steps"]]
assert all(a != b for a, b in zip(steps, steps[1:]))
END

# A surface in space, and elements of every type of second order.
python3 - >bump.obj <<'END'
import math
n = 12
for j in range(n + 1):
    for i in range(n + 1):
        inside = 0 < i < n and 0 < j < n
        x, y = i + (0.3 * math.sin(7 * i + 3 * j) if inside else 0), j + (0.3 * math.cos(5 * i + j) if inside else 0)
        print("v", x, y, 3 * math.exp(-((x - 6) ** 2 + (y - 6) ** 2) / 12))
for j in range(n):
    for i in range(n):
        a = j * (n + 1) + i + 1
        print("f", a, a + 1, a + n + 2)
        print("f", a, a + n + 2, a + n + 1)
END
expect_status 0 "$program" smooth bump.obj -o smooth.obj --tolerance 1e-7 --history 8 --report bump.html --json bump.json -q
check_history bump.html bump.json 8

# Where 3 MB have no room for all states there are fewer, and a note says so.
python3 - >flat.mesh <<'END'
n = 150
print("MeshVersionFormatted 2 Dimension 2 Vertices", (n + 1) ** 2)
for j in range(n + 1):
    for i in range(n + 1):
        inside = 0 < i < n and 0 < j < n
        print((i + (0.3 if inside and j % 3 else 0)) / n, (j + (0.2 if inside and i % 2 else 0)) / n, 0)
print("Triangles", 2 * n * n)
for j in range(n):
    for i in range(n):
        a = j * (n + 1) + i + 1
        print(a, a + 1, a + n + 2, 1, a, a + n + 2, a + n + 1, 1)
print("End")
END
expect_status 0 "$program" smooth flat.mesh -o flat_out.mesh --max-sweeps 40 --tolerance 0 --history 20 --report flat.html
expect_text "of the 20 states of --history"
[ "$(wc -c <flat.html)" -lt 3000000 ] || fail "a page of $(wc -c <flat.html) bytes"
kept=$(grep -o '"sweep":[0-9]*' flat.html | wc -l)
[ "$kept" -gt 0 ] && grep -q "flat.html has $((kept + 2)) of the 20 states" err || fail "$kept states, and: $(cat err)"

# The page of the JSON does not play.
expect_status 0 "$program" report one.json -o again.html -q
! grep -q '"steps"' again.html || fail "steps of a JSON"
finish
