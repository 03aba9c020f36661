#!/usr/bin/env bash
# Triangles of one plane, whichever it is, in many formats: smoothed in it.
. "$(dirname "$0")/common.sh"

mesh=$cli/plane_mesh.py
kinds=$(some vtk mesh 1.mesh f.vtk msh b.vtk vtu fb.vtk off bdf inp vol)

# make KIND PLANE [OFFSET]: PLANE.KIND, where planish was built with what that needs.
make() {
    python3 "$mesh" make 10 "$2" "$2.$1" "${3:-0}" || fail "$2.$1 is made"
    ! lacks "$2.$1"
}

# Planes across an axis: the bits of the same mesh in the plane of x and y; the third column stays.
for kind in $kinds; do
    make "$kind" xy || continue
    expect_status 0 "$program" smooth "xy.$kind" -o "xy-out.$kind" -q
    planes="yz zx"
    [ -z "${PLANISH_QUICK-}" ] || [ $kind = vtk ] || planes=zx
    for plane in $planes; do
        make "$kind" "$plane"
        expect_status 0 "$program" smooth "$plane.$kind" -o "$plane-out.$kind" -q --threads 2
        python3 "$mesh" same "$plane" "xy-out.$kind" "$plane-out.$kind" ||
            fail "$kind: other bits in the plane of $plane"
        python3 "$mesh" judge "$plane.$kind" "$plane-out.$kind" 0 >judged || { cat judged; fail "$kind $plane"; }
        case $kind in
        b.vtk | fb.vtk | vtu) ;;
        *) [ "$(diff "$plane.$kind" "$plane-out.$kind" | grep -c '^>')" = 81 ] || fail "$plane.$kind: lines" ;;
        esac
    done
done

# Noise across the plane stays as it is; a mesh thicker than noise is refused.
awk '/^[0-9.]/ && NF == 3 {$1 = $1 + 1e-9 * (NR % 3)} {print}' OFMT=%.17g CONVFMT=%.17g yz.vtk >noise.vtk
expect_status 0 "$program" smooth noise.vtk -o noise-out.vtk -q --json report.json
diff <(awk 'NF == 3 {print $1}' noise.vtk) <(awk 'NF == 3 {print $1}' noise-out.vtk) || fail "noise"
expect_json "r['mesh']['plane'] == {'normal': [1, 0, 0], 'origin': [0.1, 0, 0],
    'directions': [[0, 1, 0], [0, 0, 1]], 'tilted': False, 'off': 0}"
expect_json "len(r['before']['worst_elements'][0]['place']) == 3"
expect_json "abs(r['before']['worst_elements'][0]['place'][0] - 0.1) < 1e-6"

# Figures of the report, worst elements and bounds are in the file's axes.
expect_status 0 "$program" quality xy.vtk --json report.json -q
python3 - <<'END' || fail "reports"
import json, subprocess, os
program = os.environ["PLANISH_PROGRAM"]
flat = json.load(open("report.json"))
assert flat["mesh"]["plane"] is None
for plane, (p, q, r) in {"yz": (1, 2, 0), "zx": (2, 0, 1)}.items():
    subprocess.run([program, "quality", plane + ".vtk", "--json", "turned.json", "-q"], check=True)
    turned = json.load(open("turned.json"))
    for a, b in zip(flat["quality"]["worst_elements"], turned["quality"]["worst_elements"]):
        assert a["element"] == b["element"] and a["radius_ratio"] == b["radius_ratio"]
        assert a["place"] == [b["place"][p], b["place"][q]] and abs(b["place"][r] - 0.1) < 1e-9
END
expect_status 0 "$program" quality zx.vtk --worst 1
grep -q 'x  *y  *z$' out || fail "columns of the worst elements"
expect_status 0 "$program" smooth xy.vtk -o xy-box.vtk --box 2,3,8,6 -q
expect_status 0 "$program" smooth yz.vtk -o yz-box.vtk --box 2,3,8,6 -q
python3 "$mesh" same yz xy-box.vtk yz-box.vtk || fail "bounds in the plane of y and z"
expect_status 0 "$program" smooth zx.vtk -o zx-box.vtk --box 3,2,6,8 -q # x before z
python3 "$mesh" same zx xy-box.vtk zx-box.vtk || fail "bounds in the plane of z and x"

# Converted, nodes are where they are in the file.
make msh zx
expect_status 0 "$program" smooth zx.msh -o zx-view.vtk -q
grep -aq "DATASET UNSTRUCTURED_GRID" zx-view.vtk || fail "conversion"
python3 - <<'END' || fail "conversion: places"
import struct
data = open("zx-view.vtk", "rb").read()
at = data.index(b"\n", data.index(b"POINTS")) + 1
values = struct.unpack(">363d", data[at:at + 363 * 8])
assert all(y == 0.1 for y in values[1::3]) and max(values[0::3]) == 10 == max(values[2::3])
END

# Tilted planes: nodes land on them, and none of the triangles as written is inverted, seen along the
# axis that is nearest to the normal, by exact signs; the same on any number of threads.
for kind in $kinds; do
    planes=tilt
    [ $kind != vtk ] && [ $kind != f.vtk ] || planes="tilt $(some 345 steep)"
    for plane in $planes; do
        make "$kind" "$plane" || continue
        expect_status 0 "$program" smooth "$plane.$kind" -o "$plane-out.$kind" -q --json report.json
        if [ $plane = tilt ]; then
            expect_status 0 "$program" smooth "$plane.$kind" -o "again.$kind" -q --threads 3
            cmp "$plane-out.$kind" "again.$kind" || fail "$plane.$kind: threads"
        fi
        tolerance=1e-14
        case $kind in
        1.mesh | f.vtk | fb.vtk) tolerance=1e-6 ;;
        bdf) tolerance=1e-5 ;;
        esac
        python3 "$mesh" judge "$plane.$kind" "$plane-out.$kind" $tolerance >judged ||
            { cat judged; fail "$kind $plane"; }
        expect_json "r['mesh']['plane']['tilted'] and r['after']['inverted'] == 0 and r['returned_nodes'] == 0"
        expect_status 0 "$program" quality "$plane-out.$kind" -q --json quality.json
        python3 - "$tolerance" <<'END' || fail "$plane.$kind: what was judged is what was written"
import json, math, sys
report, found = json.load(open("report.json")), json.load(open("quality.json"))["quality"]
wanted, judged = report["after"], open("judged").read()
assert "moved %d " % report["moved_nodes"] in judged, judged
assert found["inverted"] == 0
assert math.isclose(wanted["rms_radius_ratio"], found["rms_radius_ratio"], rel_tol=max(1e-9, float(sys.argv[1])))
END
        case $kind in
        b.vtk | fb.vtk | vtu | bdf) ;;
        *) [ "$(diff "$plane.$kind" "$plane-out.$kind" | grep -c '^>')" = 81 ] || fail "$plane.$kind: lines" ;;
        esac
    done
done

# The page finds its meshes again.
expect_status 0 "$program" smooth tilt.vtk -o tilt-out.vtk -q --json report.json
expect_status 0 "$program" report report.json -o page.html
[ ! -s err ] || { cat err; fail "page of a tilted plane"; }

# Far from the origin, and in doubles of a plane halfway between two axes.
make vtk tilt 1e6
expect_status 0 "$program" smooth tilt.vtk -o tilt-out.vtk -q
python3 "$mesh" judge tilt.vtk tilt-out.vtk 1e-10 >judged || { cat judged; fail "offset"; }
make vtk half
expect_status 0 "$program" smooth half.vtk -o half-out.vtk -q
python3 "$mesh" judge half.vtk half-out.vtk 1e-14 >judged || { cat judged; fail "halfway"; }

# Where rounding to floats would make worse what cannot be better, nodes stay.
python3 "$mesh" make 10 regular regular.f.vtk
expect_status 0 "$program" smooth regular.f.vtk -o regular-out.f.vtk --json report.json
expect_json "r['returned_nodes'] > 0 and r['after']['rms_radius_ratio'] <= r['before']['rms_radius_ratio'] * (1 + 1e-12)"
expect_text "stay where they were"

# Triangles that are flat, or inverted where nothing is free, are counted as they are in the file.
for flat in flat flat345; do
    for kind in vtk mesh; do
        python3 "$mesh" make 9 $flat $flat.$kind
        expect_status 0 "$program" quality $flat.$kind -q --json report.json
        expect_json "r['quality']['inverted'] == $(python3 "$mesh" count $flat.$kind)"
    done
done

# Sliding along the edges of a tilted square; bounds are of the file's axes, which it has none of.
make vtk tilt
expect_status 0 "$program" smooth tilt.vtk -o slid.vtk --slide auto -q --json report.json
expect_json "r['mesh']['sliding_nodes'] == 36"
python3 "$mesh" judge tilt.vtk slid.vtk 1e-14 >judged || { cat judged; fail "slid"; }
expect_status 2 "$program" smooth tilt.vtk -o no.vtk --box 0,0,1,1
expect_one_line
expect_text "tilted plane"
expect_no_file no.vtk

# Off its plane by more than is allowed; the option allows more.
awk '/^[-0-9.]/ && NF == 3 {$3 = $3 + 1e-6 * (NR % 3)} {print}' OFMT=%.17g CONVFMT=%.17g tilt.vtk >rough.vtk
expect_status 0 "$program" smooth rough.vtk -o no.vtk --json report.json
expect_text "times its size off a plane"
expect_text "is a surface in space"
expect_json "r['mesh']['in_space'] and r['mesh']['plane'] is None"
rm no.vtk
expect_status 0 "$program" smooth rough.vtk -o rough-out.vtk --slide-tolerance 1e-6 -q
python3 "$mesh" judge rough.vtk rough-out.vtk 1e-6 >judged || { cat judged; fail "rough"; }
expect_status 0 "$program" quality rough.vtk --slide-tolerance 1e-6 -q
expect_status 64 "$program" smooth xy.vtk -o no.vtk --slide-tolerance 1e-6
expect_no_file no.vtk

# Converted, nodes are on the plane.
make msh 345
expect_status 0 "$program" smooth 345.msh -o view.vtk -q
expect_status 0 "$program" quality view.vtk -q --json report.json
expect_json "r['quality']['inverted'] == 0 and r['mesh']['plane']['tilted']"

# Triangles along a line in space, and such as lie in no plane.
printf 'OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n' >line.off
expect_status 2 "$program" quality line.off
expect_text "near one line"
printf 'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >space.off
expect_status 0 "$program" smooth space.off -o out.off
grep -q "surface in space, closed" out || fail "the table says what the surface is"
cmp space.off out.off || fail "the corners of a tetrahedron have moved"
finish
