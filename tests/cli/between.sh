#!/usr/bin/env bash
# planish compare: of two files what smooth says of before and after; they must have the same elements.
. "$(dirname "$0")/common.sh"

cp "$sample" before.msh
expect_status 0 "$program" smooth before.msh after.msh --slide auto --json smoothed.json
cp out smoothed
"$program" convert after.msh after.vtu -q || fail "convert"
for after in after.msh after.vtu; do
    expect_status 0 "$program" compare before.msh $after --json report.json
    [ ! -s err ] || fail "messages: $(cat err)"
    # The rows of the measures and the histogram are those of smooth, but for elements that it holds.
    cmp <(grep -v "^ \| nodes differ" out) <(grep -v "^ " smoothed | head -n "$(grep -vc "^ \| nodes differ" out)") ||
        fail "the table for $after"
    python3 - <<'PY' || fail "the report for $after"
import json
found, wanted = json.load(open("report.json")), json.load(open("smoothed.json"))
assert found["sweeps"] == [] and found["stop"] is None and found["input"] == wanted["input"]
assert abs(found["max_displacement"] / wanted["max_displacement"] - 1) < 1e-12
for key in ("input_checksum", "checksum", "moved_nodes"):
    assert found[key] == wanted[key], (key, found[key], wanted[key])
for state in ("before", "after"):  # which nodes are movable is another matter
    for key in wanted[state]:
        assert "movable" in key or key == "worst_elements" or found[state][key] == wanted[state][key], (state, key)
PY
done

# The other way round everything is worse, and inverted elements are counted.
expect_status 0 "$program" compare after.msh before.msh
grep -q "^worst radius ratio .* worse$" out || fail "worse: $(grep '^worst' out)"
expect_status 0 "$program" compare before.msh after.msh --report page.html -q
grep -q "<h2>The mesh</h2>" page.html || fail "no page"
expect_status 0 "$program" compare before.msh before.msh
grep -q "^0 of 2153 nodes differ" out || fail "the same file: $(tail -n 1 out)"

# A second mesh that is larger than the first is not cut off in the picture.
python3 - <<'END'
for size, name in (1, "base"), (1.5, "large"):
    places = [(size * x, size * y, size * z) for z in (0, 1, 2) for y in (0, 1, 2) for x in (0, 1, 2)]
    corners = [a + 3 * b + 9 * c for c in (0, 1) for b in (0, 1) for a in (0, 1)]
    with open(name + ".vtk", "w") as file:
        print("# vtk DataFile Version 3.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 27 double", file=file)
        for place in places:
            print(*place, file=file)
        print("CELLS 8 72", file=file)
        for at in corners:
            print(8, *(at + k for k in (0, 1, 4, 3, 9, 10, 13, 12)), file=file)
        print("CELL_TYPES 8\n12 12 12 12 12 12 12 12", file=file)
END
expect_status 0 "$program" compare base.vtk large.vtk --json report.json --report page.html -q
python3 - <<'END' || fail "the picture has all of both meshes"
import base64
import json
import re
import struct
picture = json.loads(re.search(r'id="picture-data">\n(.*?)\n</script>', open("page.html").read(), re.S)[1])
assert picture["low"] == [0, 0, 0] and picture["high"] == [3, 3, 3], picture["high"]
highest = []
for state in picture["states"]:
    points = base64.b64decode(state["points"])
    highest.append(max(struct.unpack(f"<{len(points) // 2}H", points)))
assert highest == [43690, 65535], highest
END
expect_status 0 "$program" report report.json -o again.html
cmp page.html again.html || fail "the page of meshes of two sizes"

# In single precision, and in a tilted plane, where each file has a frame of its own, nodes that nobody has
# moved are not elsewhere; the page is drawn again from its JSON.
for plane in xy tilt; do
    python3 "$cli/plane_mesh.py" make 10 $plane $plane.vtk || fail "$plane.vtk is made"
    expect_status 0 "$program" smooth $plane.vtk $plane-out.vtk --json smoothed.json
    sed 's/ double$/ float/' $plane-out.vtk >$plane-float.vtk
    ! cmp -s $plane-out.vtk $plane-float.vtk || fail "$plane.vtk has single precision"
    for after in $plane-out.vtk $plane-float.vtk; do
        expect_status 0 "$program" compare $plane.vtk $after --json report.json --report page.html
        expect_json "r['moved_nodes'] == json.load(open('smoothed.json'))['moved_nodes']"
        expect_status 0 "$program" report report.json -o again.html
        [ ! -s err ] || fail "messages on the report of $after: $(cat err)"
        [ $after = tilt-float.vtk ] || cmp page.html again.html || fail "the page for $after"
    done
done

# States in different planes have no coordinates to compare.
for after in xy tilt; do
    for before in yz tilt xy; do
        [ -e $before.vtk ] || python3 "$cli/plane_mesh.py" make 10 $before $before.vtk || fail "$before.vtk is made"
        [ $before != $after ] || continue
        expect_status 2 "$program" compare $before.vtk $after.vtk
        expect_text "$after.vtk lies in another plane than $before.vtk"
        expect_one_line
    done
done

# AFTER is read: it may be a folder.
python3 "$cli/folder_meshes.py" mixed 3 ring
expect_status 0 "$program" smooth ring smoothed-ring -q
expect_status 0 "$program" compare ring smoothed-ring
tail -n 1 out | grep -q "^[1-9][0-9]* of .* differ" || fail "folders: $(tail -n 1 out)"

# Other elements, and what is no mesh.
awk '/^\$Elements/ { inside = 1 } /^\$EndElements/ { inside = 0 }
    inside && NF == 5 && !done { $0 = $1 " " $3 " " $2 " " $4 " " $5; done = 1 } { print }' before.msh >turned.msh
! cmp -s turned.msh before.msh || fail "no element was turned"
expect_status 2 "$program" compare before.msh turned.msh
expect_text "of turned.msh has other nodes than element"
expect_one_line
"$program" smooth before.msh -o moved.mesh -q
awk '/^Vertices/ { getline; print "Vertices"; print $1 + 1; print "0 0 0 0"; next } { print }' moved.mesh >more.mesh
expect_status 2 "$program" compare before.msh more.mesh
expect_text "more.mesh has 2154 nodes, before.msh has 2153; for meshes of different sizes use: planish quality A B"
expect_status 64 "$program" compare before.msh
expect_text "give BEFORE and AFTER"
expect_status 64 "$program" compare before.msh after.msh after.msh
expect_one_line
expect_status 2 "$program" compare before.msh nowhere.msh
expect_one_line
echo "no mesh" >wrong
expect_status 2 "$program" compare before.msh wrong
expect_one_line
finish
