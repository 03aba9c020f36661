#!/usr/bin/env bash
# Minimum volumes: reached where they can be, only where they are asked for, and where not: who, and why.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 6 0.2 even.mesh
python3 "$cli/grade_mesh.py" even.mesh cube.mesh
python3 "$cli/make_slow_mesh.py" 12 even.mesh
python3 "$cli/grade_mesh.py" even.mesh square.mesh
cp "$source_folder/tests/data/ascii22.msh" .

# check IN OUT DELTA [REGION]: elements (of the region) are as large as the report says.
check() {
    python3 - "$@" <<'END' || fail "volumes: $*"
import json, math, sys
import mesh_file
report = json.load(open("report.json"))
delta, region = float(sys.argv[3]), int((sys.argv + [0])[4])
numbers = {}
for state, path in zip(("before", "after"), sys.argv[1:3]):
    mesh = mesh_file.read(path)
    numbers[state] = [number for v, number, tag in
                      zip(mesh_file.volumes(mesh), mesh.numbers, mesh.regions)
                      if v < 0.997 * delta and region in (0, tag)]
    assert report[state]["below_min_volume"] == len(numbers[state]), state
assert report["below_min"] == numbers["after"] and set(report["unfixable"]) <= set(numbers["after"])
sweeps = report["sweeps"]
assert sweeps[-1]["below_min_volume"] == len(numbers["after"])
begin = [sweep["phase"] for sweep in sweeps].index("smooth") if not numbers["after"] else len(sweeps)
way = [sweep["objective"] for sweep in sweeps[begin:]]
assert all(b <= a * (1 + 1e-12) for a, b in zip(way, way[1:])), "F rises"
END
}

# Raised above what the input has, and above what smoothing alone gives.
for mesh in cube square; do
    expect_status 0 "$program" smooth $mesh.mesh -o plain.mesh --json report.json -q
    expect_json "r['min_volume'] is None and r['below_min'] == r['unfixable'] == []"
    delta=$(python3 -c "import json; print(1.3 * json.load(open('report.json'))['after']['min_volume'])")
    expect_status 0 "$program" smooth $mesh.mesh -o out.mesh --min-volume "$delta" --json report.json -q
    check $mesh.mesh out.mesh "$delta"
    expect_json "r['before']['below_min_volume'] > 0 and r['after']['below_min_volume'] == 0"
    expect_json "r['min_volume'] == $delta and r['stop'] == 'converged' and r['reason'] == ''"
    expect_json "r['sweeps'][0]['phase'] == 'untangle' and r['sweeps'][-1]['phase'] == 'smooth'"
    expect_json "r['kkt']['active'] > 0 and r['kkt']['max_multiplier'] > 0"
    # Begun where it is met, F never rises.
    expect_status 0 "$program" smooth out.mesh -o again.mesh --min-volume "$delta" --json report.json -q
    expect_json "all(s['phase'] == 'smooth' for s in r['sweeps']) and r['before']['below_min_volume'] == 0"
    check out.mesh again.mesh "$delta"
done

# A fraction is of the volume of all elements; both mean the same.
expect_status 0 "$program" smooth cube.mesh -o out.mesh --min-volume-fraction 1.8e-4 --json report.json -q
expect_json "abs(r['min_volume'] / 1.8e-4 - 1) < 1e-12"
check cube.mesh out.mesh 1.8e-4
expect_status 0 "$program" smooth square.mesh -o out.mesh --min-volume-fraction 1e-9 -q
expect_status 0 "$program" smooth square.mesh -o plain.mesh -q
cmp out.mesh plain.mesh || fail "a minimum volume that is far away changes the mesh"

# By region: only there. The second half of the cube has the larger elements.
awk '/^Tetrahedra/ { inside = 1; getline; half = $1 / 2; print "Tetrahedra"; print; next }
    inside && n++ >= half && NF == 5 { $5 = 2 }
    { print }' cube.mesh >parts.mesh
expect_status 0 "$program" smooth parts.mesh -o plain.mesh --ignore-regions -q
for part in 1 2; do
    delta=$(python3 -c "
import mesh_file
mesh = mesh_file.read('plain.mesh')
print(1.15 * min(v for v, tag in zip(mesh_file.volumes(mesh), mesh.regions) if tag == $part))")
    expect_status 0 "$program" smooth parts.mesh -o out.mesh --min-volume $part="$delta" \
        --ignore-regions --json report.json -q
    check parts.mesh out.mesh "$delta" $part
    expect_json "r['min_volume'] is None and r['after']['below_min_volume'] == 0"
    expect_json "r['before']['below_min_volume'] > 0"
    expect_status 0 "$program" quality out.mesh --min-volume $part="$delta" --json report.json -q
    expect_json "r['quality']['below_min_volume'] == 0"
done
expect_status 0 "$program" quality out.mesh --min-volume 1="$delta" --json report.json -q
expect_json "r['quality']['below_min_volume'] == len(r['below_min']) > 0"
name=("lower part=3.2e-4" "upper part=2.6e-4")
expect_status 0 "$program" smooth ascii22.msh -o named.msh --min-volume "${name[0]}" \
    --min-volume "${name[1]}" -q
expect_status 0 "$program" smooth ascii22.msh -o numbered.msh --min-volume 3:1=3.2e-4 \
    --min-volume 2.6e-4 --json report.json -q
cmp named.msh numbered.msh || fail "the same volumes by name and by number"
expect_json "r['min_volume'] == 2.6e-4"

# More than there is room for: a usable mesh, who is below, and who could not be helped.
expect_status 1 "$program" smooth ascii22.msh -o out.msh --min-volume 3e-3 --json report.json -q
expect_one_line
expect_text "below the minimum volume"
check ascii22.msh out.msh 3e-3
expect_json "r['stop'] == 'infeasible' and r['certified'] and len(r['unfixable']) > 0"
expect_json "'%d elements are below' % len(r['below_min']) in r['reason']"
expect_json "'%d of these cannot' % len(r['unfixable']) in r['reason']"
python3 - <<'END' || fail "an element all of whose nodes are fixed cannot be helped"
import json
import mesh_file
report, mesh = json.load(open("report.json")), mesh_file.read("out.msh")
held = mesh_file.boundary(mesh)
stuck = [number for nodes, number, v in zip(mesh.elements, mesh.numbers, mesh_file.volumes(mesh))
         if v < 0.997 * 3e-3 and held.issuperset(nodes)]
assert stuck and set(stuck) <= set(report["unfixable"])
END
expect_status 1 "$program" smooth ascii22.msh -o out.msh --min-volume 3e-3 -v
expect_text "below their minimum volume: elements"
expect_text "cannot reach it by moving free nodes: elements"
[ "$(grep '^below their' err | tr ',' '\n' | wc -l)" -eq 11 ] || fail "ten elements and dots expected"
grep -q "^elements below minimum volume" out || fail "no row of elements below"
grep -q "^sweep .* below .* phase$" err || fail "no column for what is below"

# quality counts and lists, and that is no failure.
expect_status 0 "$program" quality ascii22.msh --min-volume-fraction 2e-3 --json report.json
expect_text "below their minimum volume: elements"
grep -q "^elements below minimum volume" out || fail "no row of elements below"
python3 - <<'END' || fail "quality: elements below"
import json
import mesh_file
report, mesh = json.load(open("report.json")), mesh_file.read("ascii22.msh")
below = [n for n, v in zip(mesh.numbers, mesh_file.volumes(mesh)) if v < 0.997 * 2e-3]
assert below == report["below_min"] and len(below) == report["quality"]["below_min_volume"] > 10
assert abs(report["min_volume"] / 2e-3 - 1) < 1e-12
END
expect_status 0 "$program" quality ascii22.msh --json report.json
expect_json "r['min_volume'] is None and r['below_min'] == [] == r['unfixable']"
! grep -q "below" out err || fail "elements below nothing"

# Inverted elements are below any volume: they are brought back.
python3 "$cli/make_mesh.py" 6 0.4 tangled.mesh
expect_status 0 "$program" smooth tangled.mesh -o out.mesh --min-volume 1e-5 --json report.json -q
expect_json "r['before']['inverted'] > 0 and r['after']['inverted'] == 0"
check tangled.mesh out.mesh 1e-5
finish
