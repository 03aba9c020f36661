#!/usr/bin/env bash
# planish advise: what smoothing would give is what it gives, and nothing is written.
. "$(dirname "$0")/common.sh"

cp "$sample" a.msh
expect_status 0 "$program" a.msh -j 2
mv out advice
expect_status 0 "$program" advise a.msh -j 1
# Trials end after half a minute, which is too short on a busy machine.
if grep -q "^  stopped after" advice out; then
    echo "skipped: the machine is too busy for the trials"
    exit 77
fi
cmp <(sed 's/ *[^ ]*$//' advice) <(sed 's/ *[^ ]*$//' out) || fail "planish IN is not planish advise IN"
expect_status 0 "$program" quality a.msh
cmp out <(head -n "$(wc -l <out)" advice) || fail "advise does not begin with what quality prints"
[ "$(ls)" = "$(printf 'a.msh\nadvice\nerr\nout')" ] || fail "files were made: $(ls)"
cmp a.msh "$sample" || fail "the mesh was changed"
[ ! -s err ] || fail "messages: $(cat err)"

# The figures of each way are those of its run.
same_figures() { # LABEL OPTION...
    local label=$1
    shift
    "$program" smooth a.msh -o smoothed.msh -q --json report.json "$@" || fail "smooth $*"
    python3 - "$label" <<'PY' || fail "figures of '$label': $(grep -e "^ *$label" advice)"
import json, sys
after = json.load(open("report.json"))["after"]
row = [line for line in open("advice") if line.strip().startswith(sys.argv[1] + " ")]
assert len(row) == 1, row
found = row[0].replace(sys.argv[1], "").split()[:4]
wanted = [after["inverted"], after["max_radius_ratio"], after["min_dihedral_deg"], after["rms_radius_ratio"]]
assert found == [f"{value:.4g}" for value in wanted], (found, wanted)
PY
}
same_figures smoothed
same_figures "with --slide auto" --slide auto
same_figures "with --best" --best
[ "$(tail -n 1 advice)" = "Run: planish smooth a.msh OUT --best" ] || fail "advice: $(tail -n 1 advice)"

# What is advised is worth it, and can be typed.
cp smoothed.msh "it's smooth.msh"
expect_status 0 "$program" "it's smooth.msh"
tail -n 1 out | grep -qx "Smoothing would improve this mesh little." || fail "a smooth mesh: $(tail -n 1 out)"
cp a.msh "it's.msh"
expect_status 0 "$program" "it's.msh" --fix skin --layers ignore
tail -n 1 out | grep -q "^Run: planish smooth 'it'\\\\''s.msh' OUT .*--fix skin --layers ignore$" ||
    fail "a name with a quote: $(tail -n 1 out)"
names=($'line\nand \033[31m.msh')
[ -n "${PLANISH_QUICK-}" ] || names+=(./-a.msh)
for name in "${names[@]}"; do
    cp a.msh "$name"
    expect_status 0 "$program" advise -- "${name#./}"
    tail -n 1 out | sed 's/^Run: planish smooth/printf "%s\\n"/; s/ OUT.*//' >line
    [ "$(bash ./line)" = "$name" ] || fail "'$name' cannot be typed: $(tail -n 1 out)"
    ! grep -q "$(printf '\033')" out || fail "a name reaches the terminal as it is"
done

# A mesh that is as good as perfect is left alone.
python3 - <<'PY' || fail "perfect.mesh is made"
n = 8
with open("perfect.mesh", "w") as mesh:
    mesh.write("MeshVersionFormatted 2\nDimension 2\nVertices %d\n" % ((n + 1) ** 2))
    for j in range(n + 1):
        for i in range(n + 1):
            inner = 0 < i < n and 0 < j < n
            mesh.write("%.17g %.17g 0\n" % (i + j / 2 + inner * 1e-3 * (i * 7 % 3 - 1), j * 0.75 ** 0.5))
    mesh.write("Triangles %d\n" % (2 * n * n))
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i + 1
            mesh.write("%d %d %d 0\n%d %d %d 0\n" % (a, a + 1, a + n + 1, a + 1, a + n + 2, a + n + 1))
    mesh.write("End\n")
PY
expect_status 0 "$program" perfect.mesh
tail -n 1 out | grep -qx "Smoothing would improve this mesh little." || fail "a perfect mesh: $(tail -n 5 out)"

# With a mesh to become like, and with kept layers, --best is no way.
cp a.msh before.msh
python3 - <<'PY' || fail "deformed.msh is made"
nodes = False
with open("deformed.msh", "w") as out:
    for line in open("a.msh"):
        nodes = line.startswith("$Nodes") or nodes and not line.startswith("$EndNodes")
        words = line.split()
        if nodes and len(words) == 3:
            line = "%s %s %r\n" % (words[0], words[1], 1.5 * float(words[2]))
        out.write(line)
PY
! cmp -s deformed.msh a.msh || fail "nothing was deformed"
expect_status 0 "$program" deformed.msh --like before.msh
[ ! -s err ] || fail "messages with --like: $(cat err)"
tail -n 1 out | grep -q "^Run: planish smooth deformed.msh OUT .*--like before.msh$\|improve this mesh little" ||
    fail "advice with --like: $(tail -n 1 out)"
! grep -q -e "--best" out || fail "--best with --like"
cp out liked
expect_status 0 "$program" smooth deformed.msh -o smoothed.msh -q --json report.json --like before.msh
python3 - <<'PY' || fail "figures with --like: $(grep smoothed liked)"
import json
after = json.load(open("report.json"))["after"]
row = [line.split() for line in open("liked") if line.startswith("smoothed ")]
assert len(row) == 1 and row[0][4] == "%.4g" % after["rms_aspect_ratio"], (row, after)
PY
expect_status 0 "$program" a.msh --layers keep
! grep -q "^planish: " err || fail "messages with --layers keep: $(cat err)"

# --slide-tolerance is advised with nodes that slide alone.
python3 "$cli/make_mesh.py" 4 0.2 coarse.mesh || exit 1
expect_status 0 "$program" advise coarse.mesh --slide-tolerance 1e-5
grep -qx "Run: planish smooth coarse.mesh OUT" out || fail "advice without sliding: $(tail -n 2 out)"

# Each option that the help lists goes by itself, and what is advised then can be typed.
cp "$source_folder/tests/data/ascii41.msh" coarse.msh
given=("--like coarse.msh" "--format gmsh" "--fix skin" "--layers keep" "--layers hold" "--layers ignore" "--regions none" \
    --fix-layers --ignore-regions "--slide-tolerance 1e-5" "-j 1" "--threads 1" "--bind none")
mapfile -t options < <(some "${given[@]}")
for option in "${options[@]}"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" advise coarse.msh $option
    ! grep -v '^note: ' err || fail "messages with $option: $(cat err)"
    advice=$(sed -n 's/^Run: planish \(smooth coarse.msh\) OUT/\1 -o advised.msh/p' out)
    # shellcheck disable=SC2086
    [ -z "$advice" ] || expect_status 0 "$program" $advice -q
done
"$program" advise --help | grep -oE '^ +(-[a-z], )?--[a-z-]+' | grep -oE -- '--[a-z-]+' | while read -r option; do
    [[ "$option" =~ ^--(help|version)$ || " ${given[*]} " == *" $option "* ]] || echo "$option"
done >untested
[ ! -s untested ] || fail "options of advise: $(cat untested)"

# In a plane nothing is curved; of other elements aspect ratios count.
python3 "$cli/folder_meshes.py" mixed 3 ring
expect_status 0 "$program" ring
grep -q "^what smoothing would give  inverted    worst AR    least SJ" out || fail "columns of other elements"

# Errors.
expect_status 64 "$program" nowhere.msh
expect_text "'nowhere.msh' is neither a file nor a command"
expect_one_line
expect_status 2 "$program" advise nowhere.msh
expect_one_line
expect_status 64 "$program" advise a.msh a.msh
expect_one_line
expect_status 64 "$program" a.msh --tolerance 0
expect_text "planish advise has no option --tolerance"
mkfifo pipe
expect_status 2 timeout 20 "$program" pipe
expect_text "pipe: is not a regular file"
expect_one_line
if [ -e /dev/full ]; then
    "$program" a.msh >/dev/full 2>err </dev/null
    [ $? = 2 ] && [ "$(wc -l <err)" = 1 ] || fail "a full disk: $(cat err)"
fi
echo "no mesh" >wrong
expect_status 2 "$program" wrong
expect_one_line
finish
