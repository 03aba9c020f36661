#!/usr/bin/env bash
# What is minimised: its value against textbook formulas, that it falls, and that each objective is
# best for itself; the same bytes on any number of threads.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_slow_mesh.py" 10 even.mesh
python3 "$cli/grade_mesh.py" even.mesh square.mesh
python3 "$cli/make_mesh.py" 5 0.25 even.mesh
python3 "$cli/grade_mesh.py" even.mesh cube.mesh
objectives=(radius-ratio mean-ratio edge-ratio)

# check IN OUT: the report's F is that of the files, and its way is down.
check() {
    python3 - "$@" <<'END' || fail "F: $*"
import json, math, sys
import mesh_file
report = json.load(open("report.json"))
objective = report["objective"]
ratio, mu = mesh_file.RATIOS[objective["name"]], objective["area_weight"]


def value(path):
    mesh = mesh_file.read(path)
    f = mesh_file.rms(ratio(t) for t in mesh_file.corners(mesh))
    if mu == 0:
        return f
    delta = report["min_volume"]
    return (1 - mu) * f + mu * mesh_file.rms(1 - v / delta for v in mesh_file.volumes(mesh))


for path, f in zip(sys.argv[1:], (objective["before"], objective["after"])):
    assert math.isclose(value(path), f, rel_tol=1e-9), (path, value(path), f)
way = [objective["before"]] + [sweep["objective"] for sweep in report["sweeps"]]
assert all(b <= a * (1 + 1e-12) for a, b in zip(way, way[1:])), way
assert math.isclose(way[-1], objective["after"], rel_tol=1e-12) and way[-1] < way[0]
assert report["stop"] == "converged" and report["certified"] and report["evaluations"] > 0
if objective["name"] == "radius-ratio" and mu == 0:
    assert math.isclose(way[0], report["before"]["rms_radius_ratio"], rel_tol=1e-12)
    assert report["kkt"] is None
elif objective["name"] != "edge-ratio": # which the limit on the worst radius ratio may stop
    assert 0 <= report["kkt"]["rms"] <= report["kkt"]["residual"] < 0.2, report["kkt"]
END
}

for mesh in square cube; do
    for objective in "${objectives[@]}"; do
        expect_status 0 "$program" smooth $mesh.mesh -o "$objective.mesh" --objective "$objective" \
            --json report.json -q
        expect_json "r['objective']['name'] == '$objective' and r['objective']['area_weight'] == 0"
        expect_json "r['min_volume'] is None and r['method'] == 'planish'"
        check $mesh.mesh "$objective.mesh"
    done
    python3 - $mesh "${objectives[@]}" <<'END' || fail "$mesh: an objective is not the best for itself"
import sys
import mesh_file
meshes = {name: mesh_file.corners(mesh_file.read(name + ".mesh")) for name in sys.argv[2:]}
for name in meshes:
    if name == "edge-ratio" and sys.argv[1] == "square":
        continue # there it runs into the limit on the worst radius ratio
    values = {other: mesh_file.rms(map(mesh_file.RATIOS[name], meshes[other])) for other in meshes}
    assert all(values[name] < values[other] for other in meshes if other != name), (name, values)
END
    expect_status 0 "$program" smooth $mesh.mesh -o out.mesh -q
    cmp out.mesh radius-ratio.mesh || fail "radius-ratio is the default"
done

# Fletcher-Reeves has the same aim.
for objective in "${objectives[@]}"; do
    expect_status 0 "$program" smooth cube.mesh -o out.mesh --objective "$objective" \
        --direction fletcher-reeves --json report.json -q
    check cube.mesh out.mesh
done

# With a weight of the volumes: elements become more alike in size, the more so the larger it is.
for mesh in square cube; do
    spread=()
    for weight in 0 0.05 1; do
        expect_status 0 "$program" smooth $mesh.mesh -o out.mesh --area-weight $weight \
            --min-volume-fraction 1e-4 --json report.json -q
        expect_json "r['objective']['area_weight'] == $weight"
        expect_json "abs(r['min_volume'] / (1e-4 * r['before']['total_volume']) - 1) < 1e-12"
        [ $weight = 0 ] || check $mesh.mesh out.mesh
        spread+=("$(python3 -c "
import mesh_file
v = mesh_file.volumes(mesh_file.read('out.mesh'))
print(mesh_file.rms(v) * len(v) / sum(v))")")
    done
    python3 -c "import sys; a, b, c = map(float, sys.argv[1:]); assert a > b > c >= 1" \
        "${spread[@]}" || fail "$mesh: the weight does not make volumes alike: ${spread[*]}"
done

# On the terminal.
expect_status 0 "$program" smooth cube.mesh -o out.mesh --objective mean-ratio -v
grep -q "^sweep .* F .* phase$" err || fail "no column for F"
expect_text "KKT"
grep -q "^F (mean-ratio) " out || fail "no row for the objective"
expect_status 0 "$program" smooth cube.mesh -o out.mesh -v
! grep -q "KKT\|^sweep.* F \|^F " out err || fail "F of the default is the RMS"

# The same bytes on any number of threads, whatever is asked for.
while read -ra options; do
    for threads in 1 2 3; do
        "$program" smooth cube.mesh -o on$threads.mesh -j $threads -q "${options[@]}" ||
            fail "${options[*]} on $threads threads"
    done
    cmp on1.mesh on2.mesh && cmp on1.mesh on3.mesh || fail "${options[*]} depends on the threads"
    ! cmp -s on1.mesh cube.mesh || fail "${options[*]} moves nothing"
done <<'END'
--objective mean-ratio
--objective edge-ratio
--objective mean-ratio --direction fletcher-reeves
--area-weight 0.5 --min-volume 1e-4
--min-volume 3e-4
--objective edge-ratio --area-weight 0.2 --min-volume-fraction 1e-4
--box 0.2,0.2,0.2,0.8,0.8,0.8
--max-displacement 0.1h
--method laplacian
--method area-laplacian
--method length-laplacian
END
finish
