#!/usr/bin/env bash
# Elements of every type: what quality says of them against formulas of a script, and what smooth does about them.
. "$(dirname "$0")/common.sh"

python3 "$cli/types_mesh.py" types.vtk types.json tetrahedra.vtk || fail "no mesh"
expect_status 0 "$program" quality types.vtk --worst 9 --json report.json --report types.html
cp out table
python3 - <<'END' || fail "figures differ"
import json, math
report, wanted = json.load(open("report.json")), json.load(open("types.json"))
quality = report["quality"]
assert quality["counts"] == wanted["counts"], quality["counts"]
for name, of in [("all", quality)] + list(quality["by_type"].items()):
    expected = wanted["all"] if name == "all" else wanted["by_type"][name]
    for key, value in expected.items():
        assert math.isclose(of[key], value, rel_tol=1e-9), (name, key, of[key], value)
    assert (of["min_jacobian_ratio"] is None) == (of["curved"] == 0), name
    assert of["curved"] == 0 or of["min_jacobian_ratio"] < 0, name
assert list(quality["by_type"]) == list(quality["counts"])
# What simplices alone have is null, and stands beside.
tetrahedra = quality["simplices"]
assert tetrahedra["max_radius_ratio"] >= 1 and tetrahedra["inverted"] == 0
for key in tetrahedra:
    assert key == "inverted" or quality[key] is None, key
# The worst ones: inverted ones first, simplices and then the others, in the file's order.
worst = quality["worst_elements"]
assert len(worst) == 9 and all(e["radius_ratio"] is None for e in worst)
place = [("tetrahedron" not in e["type"], e["element"]) for e in worst]
assert place == sorted(place) and {e["type"] for e in worst} > {"tetrahedron10", "hexahedron", "wedge"}
assert worst[0]["type"] == "tetrahedron10" and worst[0]["aspect_ratio"] is None
assert len(worst[0]["nodes"]) == 10
END
tr '\n' ' ' <table | grep -q ", 8 quadratic hexahedra, 8 triquadratic hexahedra, " || fail "counts: $(cat table)"
grep -q "^hexahedron27  *8  *2 " table || fail "a row for a type: $(cat table)"
grep -q "^tetrahedra alone, by their corners" table || fail "no part for tetrahedra: $(cat table)"
awk 'length($0) > 80 { exit 1 }' table || fail "the table is wider than 80 columns"
! grep -q ' $' table || fail "trailing blanks"
expect_status 0 "$program" report report.json -o again.html
cmp types.html again.html || fail "the page of the JSON is another one"
grep -q "hexahedron27" types.html && grep -q "All tetrahedra alone, by their corners" types.html || fail "the page"

# The tetrahedra alone, by their corners, have the same measures, and no key of elements of other types.
cp report.json all.json
expect_status 0 "$program" quality tetrahedra.vtk --json report.json -q
expect_json "'counts' not in r['quality'] and 'by_type' not in r['quality']"
python3 - <<'END' || fail "simplices differ from the tetrahedra by themselves"
import json
alone, among = json.load(open("report.json"))["quality"], json.load(open("all.json"))["quality"]["simplices"]
assert set(alone) - set(among) == {"worst_elements"} and all(alone[key] == among[key] for key in among)
END

# Nothing to smooth: measured, by itself and beside others, and not smoothed.
python3 - <<'END'
points = [(x, y, z) for z in range(3) for y in range(3) for x in range(3)]
cells = [[p, p + 1, p + 4, p + 3, p + 9, p + 10, p + 13, p + 12] for p in (0, 1, 3, 4, 9, 10, 12, 13)]
with open("hexahedra.vtk", "w") as out:
    print("# vtk DataFile Version 3.0\nhexahedra\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 27 double", file=out)
    for p in points:
        print(*p, file=out)
    print("CELLS 8 72", file=out)
    for cell in cells:
        print(8, *cell, file=out)
    print("CELL_TYPES 8", *[12] * 8, sep="\n", file=out)
with open("squares.vtk", "w") as out:
    print("# vtk DataFile Version 3.0\nsquares\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double", file=out)
    for p in points[:9]:
        print(*p, file=out)
    print("CELLS 4 20", file=out)
    for p in (0, 1, 3, 4):
        print(4, p, p + 1, p + 4, p + 3, file=out)
    print("CELL_TYPES 4", *[9] * 4, sep="\n", file=out)
END
for mesh in hexahedra squares; do
    expect_status 0 "$program" quality $mesh.vtk --json report.json --report $mesh.html --worst 2 --min-volume 0.1
    expect_json "r['quality']['max_aspect_ratio'] == r['quality']['min_scaled_jacobian'] == 1"
    expect_json "r['quality']['simplices'] is None and r['quality']['inverted'] == 0 and r['mesh']['elements'] == 0"
    expect_status 0 "$program" report report.json -o again.html
    [ ! -s err ] || fail "notes of a page without a picture: $(cat err)"
    cmp $mesh.html again.html || fail "the page of the JSON of $mesh"
    expect_status 0 "$program" quality $mesh.vtk --fix-layers -q
    expect_status 2 "$program" smooth $mesh.vtk -o new.vtk --json new.json
    expect_one_line
    expect_text "planish quality"
    expect_no_file new.vtk new.json
done
# Second order: the corners are smoothed and the mids follow; elements that mids have inverted are listed.
for case in "2 plain" "2 folded" "2 tilted" "3 plain" "3 folded"; do
    # shellcheck disable=SC2086
    python3 "$cli/types_mesh.py" second $case second.vtk || fail "no mesh"
    status=0
    [ "${case#* }" = folded ] && status=1
    for slide in none auto; do
        expect_status $status "$program" smooth second.vtk -o new.vtk --slide $slide --json report.json --report new.html
        python3 "$cli/types_mesh.py" check second.vtk new.vtk report.json || fail "$case, --slide $slide"
        grep -q "^[0-9]* quadratic t.*, [0-9]* curved; mid-side nodes follow" out || fail "counts: $(cat out)"
        grep -q "^least Jacobian / mean, curved " out || fail "no least Jacobian: $(cat out)"
        [ $status = 0 ] || grep -q "^inverted inside, though their corners are right: elements 0, " err ||
            fail "inverted ones are not listed: $(cat err)"
        [ $status = 0 ] || expect_text "moving corners alone did not repair them"
        expect_status 0 "$program" report report.json -o again.html
        [ "$case" = "2 tilted" ] || cmp new.html again.html || fail "the page of the JSON of $case"
        grep -q "with mid-side nodes" new.html || fail "the page does not tell of mids"
    done
    # In place, by several threads, and a copy for viewing have the same places.
    cp second.vtk place.vtk
    expect_status $status "$program" smooth place.vtk -o place.vtk --slide auto -j 3 -q
    cmp place.vtk new.vtk || fail "$case in place"
    expect_status $status "$program" smooth second.vtk -o view.vtu --slide auto -q
    # Without sweeps nothing changes; quality has the same figures of what was written.
    expect_status $status "$program" smooth second.vtk -o held.vtk --max-sweeps 0 -q
    cmp second.vtk held.vtk || fail "nothing was asked for: $case"
    mv report.json smoothed.json
    expect_status 0 "$program" quality new.vtk --json report.json
    expect_json "r['quality']['counts'] == json.load(open('smoothed.json'))['after']['counts']"
    expect_json "abs(r['quality']['min_jacobian_ratio'] - json.load(open('smoothed.json'))['after']['min_jacobian_ratio']) < 1e-12"
    expect_json "r['quality']['inverted'] == json.load(open('smoothed.json'))['after']['inverted']"
    expect_json "r['checksum'] == json.load(open('smoothed.json'))['checksum']"
done
# In a tilted plane rounding inverts some elements of these meshes: their nodes go back.
for seed in 3 16; do
    python3 "$cli/types_mesh.py" second 2 rough rough.bdf $seed || fail "no mesh"
    expect_status 0 "$program" quality rough.bdf --worst 98 --json before.json -q
    expect_status 1 "$program" smooth rough.bdf -o new.bdf --json report.json
    expect_text "nodes stay where they were"
    expect_status 0 "$program" quality new.bdf --worst 98 --json after.json -q
    python3 - <<'END' || fail "rounding has inverted elements"
import json
before, after = ({e["element"] for e in json.load(open(name))["quality"]["worst_elements"] if e["aspect_ratio"] is None}
                 for name in ("before.json", "after.json"))
r = json.load(open("report.json"))
assert after < before and after == set(r["inverted_inside"]) and len(before) == r["before"]["inverted"]
assert r["returned_nodes"] > 0
END
done
expect_status 0 "$program" quality hexahedra.vtk
grep -q "^hexahedra.vtk: vtk, 8 hexahedra, 27 nodes" out || fail "counts: $(cat out)"
expect_status 0 "$program" quality hexahedra.vtk tetrahedra.vtk types.vtk
[ "$(awk 'NR > 2 { print $2 }' out | tr '\n' ' ')" = "8 12 62 " ] || fail "elements: $(cat out)"
grep -q "^tetrahedra.vtk  *12  *0 .* -  *-$" out || fail "simplices beside others: $(cat out)"
finish
