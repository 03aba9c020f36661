#!/usr/bin/env bash
# quality of several files: a row each, those that cannot be measured left out with a message.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 4 0.2 pushed.mesh
python3 "$cli/make_mesh.py" 4 0.9 tangled.mesh
cp "$sample" bracket.msh
cp "$source_folder/tests/data/square.msh" .
meshes=(bracket.msh pushed.mesh square.msh tangled.mesh)

expect_status 0 "$program" quality "${meshes[@]}" --json report.json
[ ! -s err ] || fail "messages: $(cat err)"
[ "$(awk 'NR > 2 { print $1 }' out | tr '\n' ' ')" = "${meshes[*]} " ] || fail "a row for each: $(cat out)"
cp out rows
for mesh in "${meshes[@]}"; do
    expect_status 0 "$program" quality "$mesh" --json "$mesh.json" -q
done
python3 - "${meshes[@]}" <<'END' || fail "the comparison differs from the files one by one"
import json, sys
many = json.load(open("report.json"))
assert list(many) == ["meshes"] and len(many["meshes"]) == len(sys.argv) - 1 == 4
rows = [line.split() for line in open("rows")][2:]
for name, one, row in zip(sys.argv[1:], many["meshes"], rows):
    assert one == json.load(open(name + ".json")) and one["input"] == name
    q = one["quality"]
    told = [one["mesh"]["elements"], q["inverted"], q["max_radius_ratio"], q["min_dihedral_deg"],
            q["rms_radius_ratio"], q["mean_radius_ratio"]]
    assert row == [name] + ["%.4g" % x if isinstance(x, float) else str(x) for x in told], (row, told)
assert many["meshes"][3]["quality"]["inverted"] > 0
END

# One after another goes wrong: the others go on.
head -c 200 bracket.msh >cut.msh
expect_status 2 "$program" quality absent.msh pushed.mesh cut.msh square.msh --json report.json
[ "$(wc -l <err)" -eq 2 ] && [ "$(grep -c '^planish: ' err)" -eq 2 ] || fail "two messages: $(cat err)"
expect_text "absent.msh"
expect_text "cut.msh"
[ "$(tail -n +3 out | wc -l)" -eq 2 ] || fail "two rows: $(cat out)"
expect_json "[m['input'] for m in r['meshes']] == ['pushed.mesh', 'square.msh']"
expect_status 2 "$program" quality absent.msh gone.msh
[ ! -s out ] && [ "$(wc -l <err)" -eq 2 ] || fail "no file at all"

# Options hold for all of them; a group that one lacks is that one's error.
expect_status 2 "$program" quality bracket.msh square.msh --fix bracket --json report.json
expect_text "square.msh"
expect_json "[m['mesh']['free_nodes'] for m in r['meshes']] == [0]"
expect_status 0 "$program" quality bracket.msh pushed.mesh --min-volume 1e-3 --json report.json
sed -n 1,2p out | tr '\n' ' ' | grep -q "below .* minimum" || fail "no column for minimum volumes: $(cat out)"
expect_json "r['meshes'][1]['quality']['below_min_volume'] > 0"
[ "$(awk '/^pushed/ { print $4 }' out)" = \
    "$(python3 -c "import json; print(json.load(open('report.json'))['meshes'][1]['quality']['below_min_volume'])")" ] ||
    fail "elements below their minimum volume: $(cat out)"

# What is odd about a mesh is a note with its name, behind the table; nothing is odd about the others.
cp "$source_folder"/tests/data/tetgen.node cut.node
head -c -1 "$source_folder/tests/data/tetgen.ele" >cut.ele
cp pushed.mesh twice.mesh
python3 - <<'END'
lines = open("twice.mesh").read().split("\n")
begin = next(i for i, line in enumerate(lines) if line.startswith("Tetrahedra"))
at = begin if len(lines[begin].split()) > 1 else begin + 1
words = lines[at].split()
lines[at] = " ".join(words[:-1] + [str(int(words[-1]) + 1)])
lines.insert(at + 1, lines[at + 1])
open("twice.mesh", "w").write("\n".join(lines))
END
expect_status 0 "$program" quality ./cut.node "$work/square.msh" ./twice.mesh
[ "$(cat err)" = "$(
    echo "note: ./cut.node: the last line of ./cut.ele has no line end; if the file was cut there, the last number may be wrong"
    "$program" quality ./twice.mesh 2>&1 >/dev/null | sed 's|^note: |note: ./twice.mesh: |'
)" ] || fail "notes of several: $(cat err)"
grep -q "twice.mesh: 1 element has the nodes of another element; it is held" err || fail "a copy: $(cat err)"
"$program" quality ./cut.node ./twice.mesh 2>&1 | tail -n 1 | grep -q "^note: ./twice" || fail "notes behind the table"
expect_status 0 "$program" quality ./cut.node ./twice.mesh -q
[ ! -s err ] || fail "notes with -q"

# The folder that all are in is left out, whole folders alone; in a pipe nothing is cut.
mkdir -p some/run1 some/run2 some/run1/deep
cp square.msh some/run1/wing.msh
cp square.msh some/run2/wing.msh
cp square.msh some/run1/deep/wing.msh
names() {
    expect_status 0 "$program" quality "$@"
    awk 'NR > 2 { print $1 }' out | tr '\n' ' '
}
[ "$(names "$PWD/some/run1/wing.msh" "$PWD/some/run2/wing.msh")" = "run1/wing.msh run2/wing.msh " ] || fail "folders"
[ "$(names some/run1/wing.msh some/run1/deep/wing.msh)" = "wing.msh deep/wing.msh " ] || fail "a folder below"
[ "$(names some/run1/wing.msh square.msh)" = "some/run1/wing.msh square.msh " ] || fail "no common folder"
[ "$(names some/run1/wing.msh some/run1/wing.msh)" = "wing.msh wing.msh " ] || fail "twice the same"

# Names of any length, and of any characters: nothing of them reaches a terminal but what can be seen.
long=begin$(printf 'x%.0s' $(seq 150))end.msh
cp square.msh "$long"
odd=$(printf 'bell\a.msh')
cp square.msh "$odd"
c1=$(printf 'c\xc2\x9b31m\x9b\xc3\xa9.msh')
cp square.msh "$c1"
expect_status 0 "$program" quality "$long" "$odd" "$c1" tangled.mesh --worst 1
grep -q "^$long " out || fail "a long name: $(cat out)"
grep -q "^bell?.msh " out && grep -q "^bell?.msh:" out || fail "a name with a control character"
grep -q "^c?31m?$(printf '\xc3\xa9').msh " out || fail "a name with characters of C1: $(cat -v out)"
! grep -q ' $' out || fail "trailing blanks"
for name in "$odd" "$c1"; do
    cp cut.ele "${name%.msh}.ele"
    cp cut.node "${name%.msh}.node"
    for command in "quality ${name%.msh}.node" "quality no$name" "quality $name --fix $name" \
        "quality $name square.msh --worst 1" "quality ${name%.msh}.node square.msh" "smooth $name -o out.msh"; do
        # shellcheck disable=SC2086
        "$program" $command >told 2>&1 </dev/null
        ! LC_ALL=C grep -q "$(printf '[\a\x9b]')" told || fail "$command: $(cat -v told)"
    done
done
rm -f out.msh

# -q and a report on standard output; the input is not written over.
expect_status 0 "$program" quality square.msh pushed.mesh -q
[ ! -s out ] && [ ! -s err ] || fail "-q should print nothing"
expect_status 0 "$program" quality square.msh pushed.mesh --json -
python3 -c "import json; assert len(json.load(open('out'))['meshes']) == 2" || fail "--json - of two"
expect_text "pushed.mesh"
expect_status 64 "$program" quality bracket.msh square.msh --json ./square.msh
expect_text "would overwrite"
expect_status 64 "$program" quality bracket.msh square.msh --report page.html
expect_one_line
expect_status 64 "$program" quality bracket.msh --report ./bracket.msh
expect_status 64 "$program" quality bracket.msh --report - --json -
expect_one_line
expect_status 64 "$program" quality bracket.msh --report page --json ./page
expect_status 64 "$program" smooth bracket.msh -o out.msh --report ./out.msh
expect_no_file out.msh page page.html
cmp bracket.msh "$sample" && cmp square.msh "$source_folder/tests/data/square.msh" || fail "an input was changed"
finish
