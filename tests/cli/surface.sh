#!/usr/bin/env bash
# A mesh of triangles or quadrilaterals that lie in no plane is a surface in space: its nodes move on it, within
# a tolerance that is proved, in every format; planish says what the surface is like, and never makes it worse.
. "$(dirname "$0")/common.sh"
export OMP_NUM_THREADS=1 # small meshes, many runs

# KIND FORMAT [MANY]: a torus, a tube that is open at both ends, or a cube, with nodes that are off their places.
cat >make.py <<'END'
import math
import random
import struct
import sys

kind, form, many = sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 36
random.seed(5)
x, faces = [], []
if kind == "cube":
    n, number = many // 4, {}
    for i in range(n):
        for j in range(n):
            for face in range(6):
                corners = []
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                    p = [a, b, n * (face % 2)]
                    p = p[face // 2:] + p[:face // 2]
                    corners.append(number.setdefault(tuple(p), len(number)))
                faces.append(corners if face % 2 else corners[::-1])
    for p in number:
        inside = [0 < c < n for c in p]
        x.append([c + (random.uniform(-0.35, 0.35) if inside[d] and sum(inside) == 2 else 0) for d, c in enumerate(p)])
else:
    m = many // 2
    rows = m if kind == "torus" else m - 1
    for i in range(many):
        for j in range(m):
            border = kind == "tube" and j in (0, m - 1)
            u = 2 * math.pi * (i + (0 if border else random.uniform(-0.2, 0.2))) / many
            v = 2 * math.pi * (j + (0 if border else random.uniform(-0.2, 0.2))) / m
            r = 3 + math.cos(v) if kind == "torus" else 3
            x.append([r * math.cos(u), r * math.sin(u), math.sin(v) if kind == "torus" else v])
    for i in range(many):
        for j in range(rows):
            a, b = i * m + j, (i + 1) % many * m + j
            c, d = (i + 1) % many * m + (j + 1) % m, i * m + (j + 1) % m
            faces.append([a, b, c, d])
if form != "quads":
    faces = [t for f in faces for t in (f[:3], [f[0], f[2], f[3]])]
out = sys.stdout
number = lambda p: "%.7g %.7g %.7g" % tuple(p)
if form in ("off", "quads"):
    print("OFF\n%d %d 0" % (len(x), len(faces)))
    for p in x:
        print(number(p))
    for f in faces:
        print(len(f), *f)
elif form == "obj":
    for p in x:
        print("v", number(p))
    for f in faces:
        print("f", *(k + 1 for k in f))
elif form == "ply":
    print("ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
          "element face %d\nproperty list uchar int vertex_indices\nend_header" % (len(x), len(faces)))
    for p in x:
        print(number(p))
    for f in faces:
        print(len(f), *f)
elif form == "mesh":
    print("MeshVersionFormatted 2\nDimension 3\nVertices", len(x))
    for p in x:
        print(number(p), 0)
    print("Triangles", len(faces))
    for f in faces:
        print(*(k + 1 for k in f), 7)
    print("End")
elif form == "ascii":
    print("solid s")
    for f in faces:
        print("facet normal 0 0 0\nouter loop")
        for k in f:
            print("vertex", number(x[k]))
        print("endloop\nendfacet")
    print("endsolid s")
elif form == "stl":
    data = struct.pack("<80sI", b"binary", len(faces))
    for f in faces:
        data += struct.pack("<12fH", 0, 0, 1, *(c for k in f for c in x[k]), 0)
    out.buffer.write(data)
END

# Every format; the same nodes give the same result, to the digits.
for form in ascii stl obj ply off mesh; do
    name=torus-$form.$form
    [ $form = ascii ] && name=torus-ascii.stl
    python3 make.py torus $form >"$name"
    case $form in stl | off) ;; *) [ -z "${PLANISH_QUICK-}" ] || continue ;; esac
    expect_status 0 "$program" smooth "$name" -o "out-$name" --json report.json
    expect_json "r['mesh']['in_space'] and r['mesh']['dimension'] == 2 and r['mesh']['sliding_nodes'] == 648"
    expect_json "r['after']['max_radius_ratio'] < 0.7 * r['before']['max_radius_ratio']"
    expect_json "r['after']['min_dihedral_deg'] > r['before']['min_dihedral_deg'] + 5"
    expect_json "r['after']['rms_radius_ratio'] < r['before']['rms_radius_ratio']"
    expect_json "r['after']['inverted'] == 0 and r['surface']['open_edges'] == 0"
    expect_json "0 < r['surface']['distance_in_edges'] <= 0.0525 and r['surface']['unproved_facets'] == 0"
    expect_status 0 "$program" quality "out-$name" -q --json report.json --surface-of "$name"
    expect_json "0 < r['surface']['distance_in_edges'] <= 0.0525"
    expect_json "r['quality']['max_radius_ratio'] < 2"
    mv report.json "$form.json"
done
python3 - <<'END' || fail "formats of the same digits give the same surface"
import json
import os
names = [f + ".json" for f in ("ascii", "stl", "obj", "ply", "off", "mesh")]
worst = [json.load(open(name))["quality"]["max_radius_ratio"] for name in names if os.path.exists(name)]
assert len(worst) in (2, 6)
assert max(worst) - min(worst) < 1e-3 * max(worst), worst
END
expect_status 0 "$program" smooth torus-ply.ply -o out.ply
tr '\n' ' ' <out >text
for text in "648 of 648 nodes move on the surface" "surface in space, closed" "on patches" \
    "surface moved by at most" "(certified)"; do
    grep -qF "$text" text || fail "the table says '$text'"
done

# Same bits on any number of threads.
expect_status 0 "$program" smooth torus-off.off -o one.off -q -j 1
expect_status 0 "$program" smooth torus-off.off -o three.off -q -j 3
cmp one.off three.off || fail "threads change the result"

# A smaller tolerance is kept; runs in a row with the first surface do not add up.
expect_status 0 "$program" smooth torus-off.off -o out.off -q --surface-tolerance 0.02h --json report.json
expect_json "0 < r['surface']['distance_in_edges'] <= 0.021 and r['surface']['tolerance'] == 0.02"
cp torus-off.off now.off
for run in 1 2 $(unless_quick 3); do
    expect_status 0 "$program" smooth now.off -o now.off -q --surface-of torus-off.off --json report.json
done
expect_json "r['surface']['distance_in_edges'] <= 0.0525 and r['surface']['original'] == 'torus-off.off'"

# Open borders are curves, which --slide none holds; a cube keeps edges and corners to the bit.
python3 make.py tube off >tube.off
expect_status 0 "$program" smooth tube.off -o out.off --json report.json
tr '\n' ' ' <out | grep -qF "surface in space, open at 72 edges" || fail "the table says open"
expect_json "r['surface']['open_edges'] == 72 and r['surface']['on_curves'] == 72"
expect_status 0 "$program" smooth tube.off -o out.off --slide none --json report.json -q
expect_json "r['surface']['on_curves'] == 0 and r['moved_nodes'] > 500"
python3 make.py cube off 40 >cube.off
for how in $(some curved auto); do
    expect_status 0 "$program" smooth cube.off -o out.off -q --slide $how --json report.json
    expect_json "r['surface']['on_planes'] == 486 and r['surface']['on_lines'] == 108 and r['surface']['corners'] == 8"
    expect_json "r['surface']['distance'] < 1e-6 and r['after']['rms_radius_ratio'] < r['before']['rms_radius_ratio']"
done

# Quadrilaterals, by aspect ratios.
python3 make.py torus quads >quads.off
expect_status 0 "$program" smooth quads.off -o out.off --json report.json
expect_json "r['after']['max_aspect_ratio'] < r['before']['max_aspect_ratio'] and r['after']['inverted'] == 0"
expect_json "r['after']['min_scaled_jacobian'] > r['before']['min_scaled_jacobian']"
expect_status 0 "$program" quality quads.off
grep -q "quadrilateral" out || fail "quality counts quadrilaterals"
expect_status 0 "$program" quality quads.off -q --json report.json
expect_json "len(r['quality']['worst_elements']) == 10 and r['quality']['counts'] == {'quadrilateral': 648}"
printf '%s\n' OFF '5 5 0' '0 0 0' '2 0 0' '2 2 0' '0 2 0' '1 1 2' '4 3 2 1 0' '3 0 1 4' '3 1 2 4' '3 2 3 4' '3 3 0 4' >pyramid.off
expect_status 0 "$program" quality pyramid.off --json report.json
grep -q '^triangle  *4 ' out && grep -q '^quadrilateral  *1 ' out || fail "quality of triangles with quadrilaterals: $(cat out)"
expect_json "r['quality']['counts'] == {'triangle': 4, 'quadrilateral': 1}"
expect_status 0 "$program" advise pyramid.off

# Options.
expect_status 0 "$program" smooth torus-off.off -o out.off -q --objective worst --json worst.json
expect_status 0 "$program" smooth torus-off.off -o out.off -q --only-worse-than 2 --json report.json
expect_json "0 < r['moved_nodes'] < 648"
expect_status 0 "$program" smooth torus-off.off -o out.off -q --box -5,-5,-5,5,5,0 --json report.json
expect_json "0 < r['moved_nodes'] < 648 and r['held_outside'] > 200"
expect_status 0 "$program" smooth torus-off.off -o out.off -q --max-displacement 0.1h --json report.json
expect_json "0 < r['max_displacement'] < 0.2"
expect_status 0 "$program" smooth torus-mesh.mesh -o out.mesh -q --fix 7 --json report.json
expect_json "r['moved_nodes'] == 0 and r['mesh']['held']['fix'] == 648"
expect_status 1 "$program" smooth torus-off.off -o out.off -q --max-sweeps 1000 --tolerance 0 --time-limit 1e-9
python3 - <<'END' || fail "--objective worst"
import json
r = json.load(open("worst.json"))
assert r["worst"]["after"] >= r["worst"]["before"] and r["after"]["max_radius_ratio"] < 2.2, r["worst"]
END
while IFS='|' read -r options text; do
    # shellcheck disable=SC2086 # words
    expect_status 64 "$program" smooth torus-off.off -o no.off $options
    expect_one_line
    expect_text "$text"
    expect_no_file no.off
done <<'END'
--method laplacian|surface in space: --method has no effect there
--objective edge-ratio|edge-ratio has no effect there
--objective mean-ratio|mean-ratio without quadrilaterals has no effect there
--min-volume 1|a minimum volume has no effect there
--layers hold|--layers hold has no effect there
--layers keep|--layers keep has no effect there
--slide-interfaces|--slide-interfaces has no effect there
--direction fletcher-reeves|--direction has no effect there
--onto torus-ply.ply|--onto has no effect there
--box 0,0,1,1|a surface in space needs 6
END

# Odd surfaces.
awk 'NR == 2 {$2 += 3} {print} END {print "3 0 1 13"; print "3 0 13 1"; print "3 20 21 22"}' torus-off.off >odd.off
expect_status 0 "$program" smooth odd.off -o out.off
expect_text "belong to more than two elements"
sed '1000s/^3 \(.*\) \(.*\) \(.*\)/3 \1 \3 \2/' torus-off.off >turned.off
expect_status 0 "$program" quality turned.off --json report.json
expect_text "1 element is listed in the opposite order to most"
expect_json "r['surface']['turned_elements'] == 1"
expect_status 0 "$program" smooth turned.off -o out.off -q --json report.json
expect_json "r['after']['max_radius_ratio'] < r['before']['max_radius_ratio']"
printf 'OFF\n5 4 0\n0 0 0\n1 0 0\n2 0 0\n0 1 1\n0 -1 2\n3 0 1 2\n3 0 1 3\n3 1 2 3\n3 0 4 2\n' >flat.off
expect_status 1 "$program" smooth flat.off -o out.off
expect_text "without area"
expect_text "1 triangle has no area"
sed '3s/^[^ ]*/nan/' torus-off.off >nan.off
expect_status 2 "$program" smooth nan.off -o no.off
expect_one_line
expect_status 2 "$program" smooth torus-off.off -o no.off --surface-of tube.off
expect_one_line
expect_text "give the mesh that this one was made of"
expect_no_file no.off

# Sheets that face one another hold their nodes, and the list of the worst elements says so.
python3 - <<'END'
lines = open("tube.off").read().split("\n")
n, n_faces = (int(word) for word in lines[1].split()[:2])
with open("sheets.off", "w") as out:
    print("OFF\n%d %d 0" % (2 * n, 2 * n_faces), file=out)
    for factor in (1, 1.002):
        for x, y, z in (map(float, line.split()) for line in lines[2:2 + n]):
            print("%.9g %.9g %.9g" % (factor * x, factor * y, z), file=out)
    for first in (0, n):
        for line in lines[2 + n:2 + n + n_faces]:
            print(3, *(int(k) + first for k in line.split()[1:]), file=out)
END
expect_status 0 "$program" quality sheets.off --worst 4 --json report.json
expect_json "all(e['movable'] and e['held'] == 'sheet' for e in r['quality']['worst_elements'])"
[ "$(tr -s ' \n' ' ' <out | grep -o ', all held near another sheet of the surface' | wc -l)" = 4 ] || fail "table: $(cat out)"
expect_status 0 "$program" quality tube.off --worst 4 --json report.json
expect_json "all(e['movable'] and e['held'] is None for e in r['quality']['worst_elements'])"

# The page has the picture of the surface and its features, the copy for viewing the measures.
expect_status 0 "$program" smooth tube.off -o out.off -q --report report.html
grep -q '"flat":true' report.html || fail "the picture is that of a surface"
grep -q '"features":' report.html || fail "the picture has features"
grep -q '>threads</th>' report.html || fail "the page tells of the machine"
! grep -qE '>(instruction set|colours)</th>' report.html || fail "a surface has neither kernels nor colours"
expect_status 0 "$program" quality tube.off -q --report report.html -o view.vtu --json report.json --worst 3
expect_json "len(r['quality']['worst_elements']) == 3 and r['quality']['worst_elements'][0]['min_angle_deg'] > 0"
expect_json "len(r['quality']['worst_elements'][0]['place']) == 3"
expect_status 0 "$program" quality view.vtu -q --json report.json
expect_json "r['mesh']['in_space'] and r['mesh']['nodes'] == 648"
finish
