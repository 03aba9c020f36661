#!/usr/bin/env bash
# Elements that are reversed in the order in which the file lists their nodes: counted, listed, told of,
# and a reason for status 1 where smoothing has made new ones.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 4 0 cube.mesh
# reorder.py IN OUT HOW: folded pulls a node through its neighbours and renumbers the elements that are
# inverted by that, so that each is positive; mixed renumbers three elements, mirrored all of them.
cat >reorder.py <<'END'
import sys
import mesh_file
mesh = mesh_file.read(sys.argv[1])
how, points, elements = sys.argv[3], mesh.points, mesh.elements


def volume(element):
    a, b, c, d = (points[i] for i in element)
    u, v, w = ([q[i] - a[i] for i in range(3)] for q in (b, c, d))
    return sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3])
               for i in range(3))


if how in ("folded", "tangled"):
    middle = min(range(len(points)), key=lambda i: sum((x - 0.5)**2 for x in points[i]))
    points[middle] = [points[middle][0] + 0.33, points[middle][1] + 0.02, points[middle][2] + 0.03]
for i, element in enumerate(elements):
    if (how == "mirrored" or (how == "mixed" and 10 <= i < 13)
            or (how == "folded" and volume(element) < 0)):
        element[0], element[1] = element[1], element[0]
with open(sys.argv[2], "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
    for p in points:
        file.write("%r %r %r 0\n" % tuple(p))
    file.write("Tetrahedra\n%d\n" % len(elements))
    for e in elements:
        file.write("%d %d %d %d 1\n" % tuple(n + 1 for n in e))
    file.write("End\n")
negative = sum(volume(e) < 0 for e in elements)
print(min(negative, len(elements) - negative))
END
reorder() { python3 reorder.py cube.mesh "$1.mesh" "$1" || fail "reorder.py $1"; }

# Repaired, and negative to a solver: never silent.
[ "$(reorder folded)" = 0 ] || fail "folded.mesh has reversed elements"
expect_status 1 "$program" smooth folded.mesh -o out.mesh --json report.json --report page.html
expect_text "reversed in the file's order of nodes"
expect_text "does not renumber"
grep -q "reversed in the file's order  *0  *[1-9]" out || fail "the table has no row"
grep -q "reversed in the file's order" page.html || fail "the page has no row"
expect_json "r['after']['inverted'] == 0 and r['before']['inverted'] > 0"
expect_json "r['before']['reversed_elements'] == r['mesh']['reversed_elements'] == 0"
expect_json "len(r['reversed']) == r['after']['reversed_elements'] == r['before']['inverted']"
expect_json "'%d elements are reversed' % len(r['reversed']) in r['reason']"
python3 - <<'END' || fail "the listed elements are not those that are negative"
import json
import mesh_file
mesh = mesh_file.read("out.mesh")
wanted = []
for number, element in zip(mesh.numbers, mesh.elements):
    a, b, c, d = (mesh.points[i] for i in element)
    u, v, w = ([q[i] - a[i] for i in range(3)] for q in (b, c, d))
    if sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3])
           for i in range(3)) < 0:
        wanted.append(number)
assert json.load(open("report.json"))["reversed"] == wanted != []
END
expect_status 1 "$program" smooth folded.mesh -o out.mesh -q
expect_one_line

# The result again: they are no new ones.
expect_status 0 "$program" quality out.mesh --json report.json
expect_json "len(r['reversed']) == r['quality']['reversed_elements'] == r['mesh']['reversed_elements'] > 0"
grep -q "reversed in the file's order  *[1-9]" out || fail "quality: the table has no row"
expect_text "their nodes in the opposite order"
expect_status 0 "$program" smooth out.mesh -o again.mesh --json report.json
expect_json "r['before']['reversed_elements'] == r['after']['reversed_elements'] > 0 and r['reason'] == ''"

# Tangled without renumbering: what is repaired is so in the file's order, too.
[ "$(reorder tangled)" -gt 0 ] || fail "tangled.mesh is not tangled"
expect_status 0 "$program" smooth tangled.mesh -o out.mesh --json report.json
expect_json "r['before']['reversed_elements'] == r['before']['inverted'] > 0"
expect_json "r['after']['reversed_elements'] == 0 and r['reversed'] == []"
grep -q "reversed in the file's order  *[1-9][0-9]*  *0 " out || fail "the table does not tell that they are gone"

# Three elements in the other order: that is told of, and no reason for another status.
[ "$(reorder mixed)" = 3 ] || fail "mixed.mesh"
expect_status 0 "$program" smooth mixed.mesh -o out.mesh --json report.json
expect_json "r['reversed'] == [11, 12, 13] and r['after']['reversed_elements'] == 3"
expect_text "3 elements list their nodes in the opposite order"

# A mesh that is mirrored as a whole, as some formats' are, has none: no row, no word.
for name in cube mirrored; do
    [ $name = cube ] || reorder mirrored >/dev/null
    expect_status 0 "$program" smooth $name.mesh -o out.mesh --json report.json --report page.html
    expect_json "r['reversed'] == [] and r['mesh']['reversed_elements'] == 0"
    ! grep -q "reversed\|other way round" out err page.html || fail "$name: a word on reversed elements"
done

finish
