#!/usr/bin/env bash
# Triangles of one plane, whichever it is, in many formats: smoothed in it.
. "$(dirname "$0")/common.sh"

mesh=$cli/plane_mesh.py
kinds="msh mesh 1.mesh vtk f.vtk b.vtk fb.vtk vtu off inp bdf vol"

# make KIND PLANE [OFFSET]: PLANE.KIND, where planish was built with what that needs.
make() {
    python3 "$mesh" make 10 "$2" "$2.$1" "${3:-0}" || fail "$2.$1 is made"
    ! lacks "$2.$1"
}

# Planes across an axis: the bits of the same mesh in the plane of x and y; the third column stays.
for kind in $kinds; do
    make "$kind" xy || continue
    expect_status 0 "$program" smooth "xy.$kind" -o "xy-out.$kind" -q
    for plane in yz zx; do
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
expect_json "r['mesh']['plane'] == {'normal': [1, 0, 0], 'directions': [[0, 1, 0], [0, 0, 1]]}"
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
expect_status 0 "$program" smooth zx.msh -o zx-view.vtk -q
grep -aq "DATASET UNSTRUCTURED_GRID" zx-view.vtk || fail "conversion"
python3 - <<'END' || fail "conversion: places"
import struct
data = open("zx-view.vtk", "rb").read()
at = data.index(b"\n", data.index(b"POINTS")) + 1
values = struct.unpack(">363d", data[at:at + 363 * 8])
assert all(y == 0.1 for y in values[1::3]) and max(values[0::3]) == 10 == max(values[2::3])
END

# Triangles that lie in no plane.
printf 'OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >space.off
expect_status 2 "$program" smooth space.off -o out.off
expect_one_line
expect_text "surfaces cannot"
expect_no_file out.off
finish
