#!/usr/bin/env bash
# --slide curved: nodes of a half ball slide on its dome, in its base and around its rim, within a tolerance
# that is proved, and planish says so.
. "$(dirname "$0")/common.sh"

# A half ball of N cells across, a box whose rays are shortened; inner nodes are off their places. regions: the
# elements below half of the height are of another one, with a curved interface.
cat >half_ball.py <<'END'
import itertools
import random
import sys

n, regions = int(sys.argv[1]), len(sys.argv) > 2
random.seed(7)
node, x = {}, []
for i, j, k in itertools.product(range(2 * n + 1), range(2 * n + 1), range(n + 1)):
    p = [i / n - 1, j / n - 1, k / n]
    length = sum(c * c for c in p) ** 0.5
    largest = max(map(abs, p))
    p = [c * largest / length for c in p] if length else p
    if 0 < k and largest < 1 and not (regions and largest == 0.5):
        p = [c + random.uniform(-0.04, 0.04) / n for c in p]
    node[i, j, k] = len(x) + 1
    x.append(p)
elements = []
for i, j, k in itertools.product(range(2 * n), range(2 * n), range(n)):
    inside = max(abs(i - n + 0.5), abs(j - n + 0.5), k + 0.5) < n / 2
    for order in itertools.permutations(range(3)):
        at, corners = [i, j, k], [node[i, j, k]]
        for d in order:
            at[d] += 1
            corners.append(node[tuple(at)])
        if order in ((0, 2, 1), (1, 0, 2), (2, 1, 0)):
            corners[:2] = corners[1::-1]
        elements.append((corners, 2 if regions and inside else 1))
print("MeshVersionFormatted 2\nDimension 3\nVertices", len(x))
for p in x:
    print("%.9f %.9f %.9f 0" % tuple(p))
print("Tetrahedra", len(elements))
for corners, region in elements:
    print(*corners, region)
print("End")
END
python3 half_ball.py 5 >ball.mesh
python3 half_ball.py 4 >other.mesh
python3 half_ball.py 5 >small.mesh
python3 half_ball.py 4 regions >regions.mesh

expect_status 0 "$program" smooth ball.mesh -o flat.mesh --slide auto --json flat.json -q
expect_status 0 "$program" smooth ball.mesh -o curved.mesh --slide curved --json curved.json --report curved.html
for text in "nodes in planes" "on patches" "on curves" "surface moved by at most" "(certified)" "volume changed by"; do
    tr '\n' ' ' <out | grep -qF "$text" || fail "the table says '$text'"
done
python3 - <<'END' || fail "nodes slide on the dome, in the base and around the rim"
import json
import math
flat, curved = json.load(open("flat.json")), json.load(open("curved.json"))
s = curved["surface"]
assert flat["surface"] is None and s["original"] is None and s["tolerance"] == 0.05 and s["tolerance_unit"] == "h"
assert s["on_patches"] > 150 and s["on_curves"] > 30 and s["on_planes"] > 50, s
assert s["on_lines"] == 0 and s["corners"] == 0 and s["creases"] > 0
assert 0 < s["distance_in_edges"] <= 0.05 and 0 < s["distance_back_in_edges"] < 0.2
assert s["distance"] > 0 and s["unproved_facets"] == 0 and s["max_bend_deg"] < 40
assert curved["fixed"]["count"] < flat["fixed"]["count"]
assert curved["after"]["max_radius_ratio"] < flat["after"]["max_radius_ratio"]
assert curved["after"]["rms_radius_ratio"] < flat["after"]["rms_radius_ratio"]
(volume,) = s["volumes"]
assert abs(volume["after"] / volume["before"] - 1) < 0.02
assert abs(volume["after"] / curved["after"]["total_volume"] - 1) < 1e-12


def read(name):
    lines = open(name).read().split("\n")
    begin = next(i for i, line in enumerate(lines) if line.startswith("Vertices")) + 1
    return [tuple(map(float, line.split()[:3])) for line in lines[begin:begin + int(lines[begin - 1].split()[1])]]


moved = 0
for a, b in zip(read("ball.mesh"), read("curved.mesh")):
    if abs(math.hypot(*a) - 1) < 1e-6:
        assert abs(math.hypot(*b) - 1) < 0.02, b
        moved += a != b
    if a[2] == 0:
        assert b[2] == 0
assert moved > 100
END
grep -q 'id="surface"' curved.html || fail "the page has the surface"
grep -q "mean edges" curved.html || fail "the page has distances"
cp curved.html first.html
expect_status 0 "$program" report curved.json
cmp curved.html first.html || fail "the same page from the JSON"

# quality measures the same, and draws features.
expect_status 0 "$program" quality curved.mesh --surface-of ball.mesh --json quality.json --report quality.html
grep -q "(certified)" out || fail "quality tells the distance"
python3 - <<'END' || fail "quality measures the same distance"
import json
a, b = (json.load(open(name))["surface"] for name in ("curved.json", "quality.json"))
for key in ("distance", "distance_back", "distance_in_edges", "max_bend_deg", "patches", "feature_edges"):
    assert a[key] == b[key], key
assert b["original"] == "ball.mesh" and "on_planes" not in b
page = open("quality.html").read()
assert '"features":' in page and 'class="features"' in page or "three.js" in page
END
expect_status 0 "$program" quality ball.mesh --json report.json -q
expect_json "r['surface'] is None"

# Tolerances: absolute, in edges; five runs in a row do not add up.
expect_status 0 "$program" smooth ball.mesh -o out.mesh --slide curved --surface-tolerance 0.002 --json report.json -q
expect_json "0 < r['surface']['distance'] <= 0.002 and r['surface']['tolerance_unit'] == 'mesh'"
expect_status 0 "$program" smooth ball.mesh -o out.mesh --slide curved --surface-tolerance 0.01h --json report.json -q
expect_json "0 < r['surface']['distance_in_edges'] <= 0.01"
expect_status 0 "$program" smooth ball.mesh -o out.mesh --slide curved --surface-tolerance 0.005h --json report.json -q
expect_json "0 < r['surface']['distance_in_edges'] <= 0.005 and r['surface']['distance_back_in_edges'] < 0.007"
cp ball.mesh again.mesh
for _ in 1 2 3; do
    expect_status 0 "$program" smooth again.mesh -o again.mesh --slide curved --surface-of ball.mesh \
        --surface-tolerance 0.01h --json report.json -q
    expect_json "r['surface']['distance_in_edges'] <= 0.01"
done
expect_json "r['surface']['original'] == 'ball.mesh' and 0 < r['surface']['input']['distance_in_edges'] <= 0.01"

# What is farther off than the tolerance stays, and the worst elements there say so.
expect_status 0 "$program" smooth ball.mesh -o off.mesh --slide curved --surface-tolerance 0.3h -q
expect_status 0 "$program" smooth off.mesh -o out.mesh --slide curved --surface-of ball.mesh --surface-tolerance 0.002h \
    --objective worst --json report.json --report report.html -q
python3 - <<'END' || fail "worst elements that the tolerance holds"
import json
import mesh_file
before, after = (mesh_file.read(name).points for name in ("off.mesh", "out.mesh"))
report = json.load(open("report.json"))
listed = [e for state in ("before", "after") for e in report[state]["worst_elements"]]
held = [e for e in listed if e["held"]]
assert len(held) > 3 and report["moved_nodes"] > 200, (len(held), report["moved_nodes"])
for element in held:
    assert element["movable"] and element["held"] == "tolerance"
    assert all(before[n - 1] == after[n - 1] for n in element["nodes"])
assert open("report.html").read().count("yes, but held by the surface&#39;s tolerance") == len(held)
END

# Creases of one's own; interfaces.
expect_status 0 "$program" smooth ball.mesh -o out.mesh --slide curved --crease-angle 179 --json report.json -q
expect_json "r['surface']['feature_edges'] == 0 and r['surface']['on_curves'] == 0"
expect_status 0 "$program" smooth regions.mesh -o out.mesh --slide curved --json first.json -q
expect_status 0 "$program" smooth regions.mesh -o out.mesh --slide curved --slide-interfaces --json report.json
grep -q "regions: 3:" out || fail "volumes of regions"
python3 - <<'END' || fail "nodes of interfaces slide when they are asked to"
import json
a, b = (json.load(open(name))["surface"] for name in ("first.json", "report.json"))
assert a["on_patches"] < b["on_patches"] and a["on_curves"] <= b["on_curves"]
assert [v["region"] for v in b["volumes"]] == ["3:1", "3:2"]
END

# Groups that are held, only the worse elements, bounds, the smallest angle: all go with curves.
expect_status 0 "$program" smooth regions.mesh -o held.mesh --slide curved --slide-interfaces --fix 3:2 --json held.json -q
expect_status 0 "$program" smooth regions.mesh -o few.mesh --slide curved --only-worse-than 4 --rings 0 --json few.json -q
expect_status 0 "$program" smooth ball.mesh -o near.mesh --slide curved --max-displacement 0.01 -q
expect_status 0 "$program" smooth small.mesh -o floor.mesh --slide curved --min-volume 4e-5 -q
expect_status 0 "$program" smooth ball.mesh -o worst.mesh --slide curved --objective worst --json worst.json -q
expect_status 0 "$program" smooth small.mesh -o small.out.mesh --slide curved -q
python3 - <<'END' || fail "options go with curves"
import json
import math


def read(name, what="Vertices"):
    lines = open(name).read().split("\n")
    begin = next(i for i, line in enumerate(lines) if line.startswith(what)) + 1
    return [tuple(map(float, line.split())) for line in lines[begin:begin + int(lines[begin - 1].split()[1])]]


def moved(a, b):
    return {i + 1 for i, (p, q) in enumerate(zip(read(a), read(b))) if p[:3] != q[:3]}


def is_on_dome(p):
    return abs(math.hypot(*p[:3]) - 1) < 1e-6


def volumes(name):
    x = read(name)
    for e in read(name, "Tetrahedra"):
        a, b, c = ([x[int(i) - 1][d] - x[int(e[0]) - 1][d] for d in range(3)] for i in e[1:4])
        yield (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6


given, elements = read("regions.mesh"), read("regions.mesh", "Tetrahedra")
inner = {int(i) for e in elements if e[4] == 2 for i in e[:4]}
dome = {i + 1 for i, p in enumerate(given) if is_on_dome(p)}
held, few = moved("regions.mesh", "held.mesh"), moved("regions.mesh", "few.mesh")
assert len(inner) > 50 and not held & inner and len(held & dome) > 50
assert 0 < len(few & dome) < len(dome) / 2, (few, dome)
for name in ("held", "few", "worst"):
    assert 0 < json.load(open(name + ".json"))["surface"]["distance_in_edges"] <= 0.05 * 1.2, name
assert any(is_on_dome(p) and p != q for p, q in zip(read("ball.mesh"), read("near.mesh")))
assert all(math.dist(p[:3], q[:3]) <= 0.01 + 1e-9 for p, q in zip(read("ball.mesh"), read("near.mesh")))
assert min(volumes("small.out.mesh")) < 3.8e-5 < 3.99e-5 < min(volumes("floor.mesh"))
plain, worst = (json.load(open(name + ".json"))["after"]["min_dihedral_deg"] for name in ("curved", "worst"))
assert worst > plain
END

# What cannot be, in one line each.
refuse() { # TEXT ARGUMENT...
    local text=$1
    shift
    expect_status 2 "$program" smooth "$@" -o refused.mesh
    expect_one_line
    expect_text "$text"
    expect_no_file refused.mesh
}
refuse "has 405 nodes" ball.mesh --slide curved --surface-of other.mesh
refuse "No such file" ball.mesh --slide curved --surface-of none.mesh
sed 's/^\(Tetrahedra .*\)/\1/; /^Tetrahedra/{n;s/^\([0-9]*\) \([0-9]*\)/\2 \1/}' ball.mesh >swapped.mesh
refuse "element 1 of swapped.mesh has other nodes than element 1 of ball.mesh; --surface-of" ball.mesh --slide curved --surface-of swapped.mesh
sed '4s/^[^ ]*/nan/' ball.mesh >nan.mesh
refuse "nan.mesh:4" ball.mesh --slide curved --surface-of nan.mesh
python3 "$cli/make_slow_mesh.py" 6 square.mesh
refuse "a mesh in a plane" square.mesh --slide curved
for option in "--surface-tolerance 0.1h" --slide-interfaces "--surface-of other.mesh" "--crease-angle 20"; do
    # shellcheck disable=SC2086
    expect_status 64 "$program" smooth ball.mesh -o out.mesh --slide auto $option
    expect_text "no effect without --slide curved"
done
expect_status 64 "$program" smooth ball.mesh -o out.mesh --slide curved --surface-tolerance -1h
expect_text "a distance above 0"
expect_status 64 "$program" quality ball.mesh other.mesh --surface-of other.mesh
expect_text "takes one mesh"
finish
