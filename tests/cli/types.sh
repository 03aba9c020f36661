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

# Meshes made after public reports: averages tangle them, or they came inverted.
for kind in bent projected wall; do
    python3 "$cli/types_mesh.py" block $kind 8 0 block.vtk || fail "no mesh"
    expect_status 0 "$program" smooth block.vtk -o new.vtk --json report.json -q
    python3 "$cli/types_mesh.py" judge block.vtk new.vtk report.json || fail "$kind"
    expect_json "(r['before']['inverted'] == 0) == ('$kind' == 'bent') and r['after']['inverted'] == 0"
done
python3 "$cli/types_mesh.py" block bent 8 0 block.vtk || fail "no mesh"
"$program" smooth block.vtk -o new.vtk --method laplacian --json report.json -q >out 2>&1
expect_json "r['after']['inverted'] > 0"

# Every type of first order: smoothed, untangled, with layers, stopped.
for kind in $(some hexahedron wedge pyramid quadrilateral mixed flat); do
    n=4
    case $kind in quadrilateral | flat) n=9 ;; esac
    for amount in 0.2 0.7; do
        python3 "$cli/types_mesh.py" block $kind $n $amount block.vtk || fail "no mesh"
        expect_status 0 "$program" smooth block.vtk -o new.vtk --json report.json --report new.html
        cp out table
        python3 "$cli/types_mesh.py" judge block.vtk new.vtk report.json || fail "$kind pushed by $amount"
        expect_json "(r['before']['inverted'] > 0) == ($amount > 0.5) and r['after']['inverted'] == 0"
        expect_json "len(r['after']['worst_elements']) == 10 and r['after']['worst_elements'][0]['aspect_ratio'] == r['after']['max_aspect_ratio']"
        grep -q "^least scaled Jacobian (SJ) " table && grep -q "^aspect ratio *before *after" table &&
            grep -q "worst aspect ratio (AR)" table || fail "the table: $(cat table)"
        ! grep -q "worst radius ratio\|smallest\|dihedral" table || fail "a table with radius ratios or angles: $(cat table)"
        awk 'length($0) > 80 { exit 1 }' table || fail "the table is wider than 80 columns"
        grep -q "worst aspect ratio of elements with a movable node" new.html && grep -q "least scaled Jacobian" new.html ||
            fail "the page of $kind"
        expect_status 0 "$program" report report.json -o again.html
        cmp new.html again.html || fail "the page of the JSON of $kind"
        cp block.vtk place.vtk
        expect_status 0 "$program" smooth place.vtk -o place.vtk -j 3 -q
        cmp new.vtk place.vtk || fail "$kind: other bits by three threads, in place"
    done
    # Two types have a line each.
    [ $kind != flat ] || tr '\n' ' ' <table | grep -q "do not compare AR with radius ratios" || fail "the measure: $(cat table)"
    case $kind in mixed | flat) grep -q "^before, after *elements " table && grep -q "^least scaled" table || fail "no lines by type: $(cat table)" ;; esac
    for objective in mean-ratio edge-ratio "worst --worst-measure aspect-ratio" worst; do
        # shellcheck disable=SC2086
        expect_status 0 "$program" smooth block.vtk -o new.vtk --objective $objective --json report.json
        expect_json "r['after']['inverted'] == 0 and r['objective']['name'] == '${objective%% *}'.replace('worst', 'mean-ratio')"
        case $objective in worst*) expect_json "(r['worst'] or {'measure': 'aspect-ratio'})['measure'] in '$objective aspect-ratio scaled-jacobian'" ;; esac
    done
    expect_status 64 "$program" smooth block.vtk -o no.vtk --objective radius-ratio
    expect_one_line
    expect_text "choose mean-ratio or edge-ratio"
    expect_status 64 "$program" smooth block.vtk -o no.vtk --objective worst --worst-measure dihedral
    expect_one_line
    expect_text "choose scaled-jacobian or aspect-ratio"
    expect_no_file no.vtk
    # Stopped at once: what is there is no worse.
    expect_status 1 "$program" smooth block.vtk -o new.vtk --time-limit 1e-9 --json report.json
    expect_json "r['stop'] == 'time-limit' and r['after']['inverted'] <= r['before']['inverted']"
    expect_status 0 "$program" smooth block.vtk -o view.vtu -q
    # Few of them, around the bad ones.
    expect_status 0 "$program" smooth block.vtk -o new.vtk --only-worse-than 3 --json report.json -q
    expect_json "r['after']['inverted'] == 0"
done
# Interrupted: the mesh is written, and no worse. A busy machine may let the run end before the signal comes.
python3 "$cli/types_mesh.py" block hexahedron 18 0.3 block.vtk || fail "no mesh"
for _ in 1 2 3 4 5; do
    env --default-signal=INT "$program" smooth block.vtk -o new.vtk --json report.json -v --tolerance 0 \
        --max-sweeps 1000000 -j 1 --box=-9,-9,-9,9,9,9 >out 2>err &
    run=$!
    wait_for "  smoothing" err
    kill -INT $run 2>/dev/null
    wait $run
    status=$?
    [ "$status" -eq 0 ] || break
done
[ "$status" -eq 1 ] || fail "interrupted: $(tail -n 3 err)"
python3 "$cli/types_mesh.py" judge block.vtk new.vtk report.json || fail "interrupted"
expect_json "r['stop'] == 'interrupted' and r['certified']"
# Layers of hexahedra keep their heights, unless they are to be held or ignored; --fix-layers is the same as hold.
python3 "$cli/types_mesh.py" block layered 8 0.2 block.vtk || fail "no mesh"
for option in "" "--layers hold" --fix-layers "--layers ignore"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" smooth block.vtk -o new.vtk --json report.json $option
    python3 "$cli/types_mesh.py" judge block.vtk new.vtk report.json || fail "layers: $option"
    if [ "$option" = "--layers ignore" ]; then
        expect_json "r['mesh']['held']['layers'] == 0 and r['mesh']['layer_elements'] is None"
        ! cmp -s new.vtk held.vtk || fail "layers are held though they are to be ignored"
    elif [ -z "$option" ]; then
        expect_json "r['mesh']['kept_layer_elements'] == r['mesh']['layer_elements'] == 192 and r['mesh']['held']['layers'] == 0"
        expect_json "r['target'] == 'layers' and r['mesh']['held_layer_elements'] == r['mesh']['free_layer_elements'] == 0"
        grep -q "192 elements .* are thin in layers, and keep their heights; --layers hold holds their nodes" err ||
            fail "no note of layers: $(cat err)"
    else
        expect_json "r['mesh']['held_layer_elements'] == r['mesh']['layer_elements'] == 192 and r['mesh']['held']['layers'] == 147"
        [ "$option" = --fix-layers ] || cp new.vtk held.vtk
        cmp new.vtk held.vtk || fail "other bits with $option"
        grep -q "thin in layers" err || fail "no note of layers: $(cat err)"
    fi
done
# They are held where heights cannot be kept, and the note says why.
for option in "--objective worst" "--objective edge-ratio" "--method laplacian"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" smooth block.vtk -o new.vtk --json report.json --report page.html $option
    expect_json "r['target'] == 'regular' and r['mesh']['held']['layers'] == 147"
    expect_json "r['mesh']['held_layer_elements'] == 192 and r['mesh']['kept_layer_elements'] == 0"
    [ "${option%% *}" = --objective ] && named=$option || named=--method
    expect_json "r['mesh']['layers_not_kept_with'] == '$named'"
    grep -q "147 nodes are held there, as heights cannot be kept with $named; --layers ignore lets them move" err ||
        fail "no advice: $(cat err)"
    grep -q "held their nodes, because it cannot keep heights with $named" page.html || fail "the page does not say it"
done
# A fold is held by nothing: no node of an inverted element is held as one of a layer.
python3 - <<'END' || fail "no mesh"
words = open("block.vtk").read().split("\n")
first = next(i for i, line in enumerate(words) if line.startswith("POINTS")) + 1
for i in range(first, first + 9 ** 3):
    x, y, z = map(float, words[i].split())
    if 0 < x < 1 and 0 < y < 1 and 0.03 < z < 0.04:  # the top of the layers, put below the ground
        words[i] = f"{x} {y} {-z}"
open("folded.vtk", "w").write("\n".join(words))
END
expect_status 0 "$program" smooth folded.vtk -o new.vtk --json report.json
expect_json "r['before']['inverted'] > 30 and r['after']['inverted'] == 0"

# Measured by themselves and beside others.
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
    [ ! -s err ] || fail "notes of the page: $(cat err)"
    cmp $mesh.html again.html || fail "the page of the JSON of $mesh"
    expect_status 0 "$program" quality $mesh.vtk --fix-layers -q
    # Nothing can get better: the mesh is written as it is.
    expect_status 0 "$program" smooth $mesh.vtk -o new.vtk -q
    cmp new.vtk $mesh.vtk || fail "a perfect mesh changed"
done
# Quadratic pyramids by themselves are not smoothed.
python3 - <<'END'
corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]
points = corners + [tuple((a + b) / 2 for a, b in zip(corners[i], corners[j])) for i, j in pairs]
with open("pyramid.vtk", "w") as out:
    print("# vtk DataFile Version 3.0\npyramid\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 13 double", file=out)
    for p in points:
        print(*p, file=out)
    print("CELLS 1 14\n13", *range(13), file=out)
    print("CELL_TYPES 1\n27", file=out)
END
expect_status 2 "$program" smooth pyramid.vtk -o no.vtk --json no.json
expect_one_line
expect_text "planish quality"
expect_no_file no.vtk no.json
# Second order: the corners are smoothed and the mids follow; elements that mids have inverted are listed.
some "2 folded" "2 plain" "2 tilted" "3 folded" "3 plain" >cases
while read -r case; do
    # shellcheck disable=SC2086
    python3 "$cli/types_mesh.py" second $case second.vtk || fail "no mesh"
    status=0
    [ "${case#* }" = folded ] && status=1
    # Mids that make elements bad move by themselves, unless they are to follow.
    for slide in none auto; do
        expect_status "$status" "$program" smooth second.vtk -o new.vtk --slide $slide --curve-quality 0 --json report.json -q
        python3 "$cli/types_mesh.py" check second.vtk new.vtk report.json || fail "$case, --slide $slide, mids follow"
        expect_json "r['released_mids'] == 0 and (r['after']['inverted'] > 0) == ($status > 0)"
        "$program" smooth second.vtk -o new.vtk --slide $slide -q --json report.json 2>err
        [ $? -le $status ] || fail "$case, --slide $slide: $(cat err)"
        python3 "$cli/types_mesh.py" check second.vtk new.vtk report.json || fail "$case, --slide $slide, mids may move"
        expect_json "($status > 0) == (r['released_mids'] > 0 or r['after']['inverted'] > 0)"
        expect_json "r['infeasible_curved'] == 0 or r['unfixable'] == r['inverted_inside']"
    done
    for slide in none auto; do
        expect_status $status "$program" smooth second.vtk -o new.vtk --slide $slide --curve-quality 0 --json report.json --report new.html
        python3 "$cli/types_mesh.py" check second.vtk new.vtk report.json || fail "$case, --slide $slide"
        grep -q "^[0-9]* quadratic t.*, [0-9]* curved; mid-side nodes follow" out || fail "counts: $(cat out)"
        grep -q "^least Jacobian / mean, curved " out || fail "no least Jacobian: $(cat out)"
        [ $status = 0 ] || grep -q "^inverted inside, though their corners are right: elements 0, " err ||
            fail "inverted ones are not listed: $(cat err)"
        [ $status = 0 ] || expect_text "inverted inside by mid-side nodes"
        expect_status 0 "$program" report report.json -o again.html
        [ "$case" = "2 tilted" ] || cmp new.html again.html || fail "the page of the JSON of $case"
        grep -q "with mid-side nodes" new.html || fail "the page does not tell of mids"
    done
    # In place, by several threads, and a copy for viewing have the same places.
    cp second.vtk place.vtk
    expect_status $status "$program" smooth place.vtk -o place.vtk --slide auto --curve-quality 0 -j 3 -q
    cmp place.vtk new.vtk || fail "$case in place"
    expect_status $status "$program" smooth second.vtk -o view.vtu --slide auto --curve-quality 0 -q
    # Without sweeps nothing changes; quality has the same figures of what was written.
    expect_status $status "$program" smooth second.vtk -o held.vtk --max-sweeps 0 --curve-quality 0 -q
    cmp second.vtk held.vtk || fail "nothing was asked for: $case"
    mv report.json smoothed.json
    expect_status 0 "$program" quality new.vtk --json report.json
    expect_json "r['quality']['counts'] == json.load(open('smoothed.json'))['after']['counts']"
    expect_json "abs(r['quality']['min_jacobian_ratio'] - json.load(open('smoothed.json'))['after']['min_jacobian_ratio']) < 1e-12"
    expect_json "r['quality']['inverted'] == json.load(open('smoothed.json'))['after']['inverted']"
    expect_json "r['checksum'] == json.load(open('smoothed.json'))['checksum']"
done <cases
# In a tilted plane rounding inverts some elements of these meshes: their nodes go back.
for seed in 3 16; do
    python3 "$cli/types_mesh.py" second 2 rough rough.bdf $seed || fail "no mesh"
    expect_status 0 "$program" quality rough.bdf --worst 98 --json before.json -q
    expect_status 1 "$program" smooth rough.bdf -o new.bdf --curve-quality 0 --json report.json
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
# Ratios of movable elements are of the valid ones, as those of all are: here the worst element is inverted inside.
python3 - <<'END' >inside.vtk || fail "no mesh"
import itertools

X, Y = (0, 1, 2, 4), (0, 0.2, 1.2, 2.2)
points = {}


def node(x, y):
    return points.setdefault((x, y), len(points))


cells = []
for (x, right), (y, top) in itertools.product(zip(X, X[1:]), zip(Y, Y[1:])):
    corners = [(x, y), (right, y), (right, top), (x, top)]
    mids = [tuple((a + b) / 2 for a, b in zip(p, q)) for p, q in zip(corners, corners[1:] + corners[:1])]
    cells.append([node(*p) for p in corners + mids])
places = [(x, 0.3 if (x, y) == (3, 0) else y) for x, y in points]
print("# vtk DataFile Version 3.0\ngrid\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS %d double" % len(places))
for x, y in places:
    print(x, y, 0)
print("CELLS %d %d" % (len(cells), 9 * len(cells)))
for cell in cells:
    print(8, *cell)
print("CELL_TYPES %d" % len(cells), *[23] * len(cells), sep="\n")
END
expect_status 0 "$program" smooth inside.vtk -o new.vtk --max-sweeps 0 --curve-quality 0 --report new.html --json report.json -q
expect_json "r['mesh']['fixed_elements'] == 0 and r['before']['inverted'] == r['before']['inverted_inside'] == 1"
expect_json "r['before']['max_aspect_ratio_movable'] == r['before']['max_aspect_ratio'] < 2.7"
expect_json "abs(r['before']['rms_aspect_ratio_movable'] - r['before']['rms_aspect_ratio']) < 1e-14"
expect_status 0 "$program" quality hexahedra.vtk
grep -q "^hexahedra.vtk: vtk, 8 hexahedra, 27 nodes" out || fail "counts: $(cat out)"
expect_status 0 "$program" quality hexahedra.vtk tetrahedra.vtk types.vtk
[ "$(awk 'NR > 2 { print $2 }' out | tr '\n' ' ')" = "8 12 62 " ] || fail "elements: $(cat out)"
grep -q "^tetrahedra.vtk  *12  *0 .* -  *-$" out || fail "simplices beside others: $(cat out)"
# Hexahedra below wedges whose triangles lie on the hexahedra's faces: a note counts them. Wedges on wedges are joined.
cat >stacked.py <<'END2'
import itertools
import sys
import box_file

N = 4
number = {at: i + 1 for i, at in enumerate(itertools.product(range(N + 1), repeat=3))}
below = {(x, y, z): number[x, y, z] for x, y, z in number if z <= N // 2}
above = {(x, y, z - N // 2): number[x, y, z] for x, y, z in number if z >= N // 2}
sides = N, N, N // 2
parts = box_file.elements(sys.argv[1], sides, below), box_file.elements("prisms", sides, above)
print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d" % len(number))
for at, i in number.items():
    print(i, *at)
print("$EndNodes\n$Elements\n%d" % sum(map(len, parts)))
for i, e in enumerate(parts[0] + parts[1]):
    print(i + 1, 5 if len(e) == 8 else 6, 2, 1, 1, *e)
print("$EndElements")
END2
python3 stacked.py hexes >stacked.msh || fail "stacked.msh"
python3 stacked.py prisms >joined.msh || fail "joined.msh"
for threads in 1 2; do
    expect_status 0 "$program" smooth stacked.msh -o out.msh -j $threads --json report.json
    expect_text "note: 16 quadrilateral faces lie against two triangles each: their 25 nodes stay as on the boundary; pyramids"
    expect_json "r['mesh']['free_nodes'] == 2 * 9"
done
expect_status 0 "$program" smooth stacked.msh -o out.msh -q
[ ! -s err ] || fail "notes with -q: $(cat err)"
expect_status 0 "$program" smooth joined.msh -o out.msh --json report.json
expect_json "r['mesh']['free_nodes'] == 3 * 9"
! grep -q "quadrilateral faces" err || fail "wedges on wedges are joined: $(cat err)"
finish
