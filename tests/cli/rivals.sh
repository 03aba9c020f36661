#!/usr/bin/env bash
# The Laplacian methods do what their names say, guard against nothing, and say so.
. "$(dirname "$0")/common.sh"

# Four triangles around a free node in the tip of an arrow, whose kernel has no mean of the corners in it,
# however weighted.
printf '%s\n' 'MeshVersionFormatted 2' 'Dimension 2' Vertices 5 '3 0 0' '-10 5 0' '0 0 0' '-10 -5 0' '1.5 0 0' \
    Triangles 4 '1 2 5 1' '2 3 5 1' '3 4 5 1' '4 1 5 1' End >arrow.mesh
python3 "$cli/make_slow_mesh.py" 12 square.mesh
python3 "$cli/make_mesh.py" 6 0.2 cube.mesh
methods=(laplacian area-laplacian length-laplacian)

# One free node: where it goes is known, and it is outside of the arrow.
for method in "${methods[@]}"; do
    expect_status 1 "$program" smooth arrow.mesh -o out.mesh --method "$method" --max-sweeps 1 \
        --json report.json -q
    expect_one_line
    expect_text "inverted"
    expect_text "$method"
    expect_json "r['method'] == '$method' and r['kkt'] is None and not r['certified']"
    expect_json "r['before']['inverted'] == 0 and r['after']['inverted'] == r['sweeps'][-1]['inverted'] > 0"
    expect_json "'%d element' % r['after']['inverted'] in r['reason']"
    python3 - "$method" <<'END' || fail "$method: where the node goes"
import math, sys
import mesh_file
*link, node = mesh_file.read("arrow.mesh").points
triangles = [[link[i], link[(i + 1) % 4], node] for i in range(4)]
if sys.argv[1] == "area-laplacian":
    points = [[sum(x) / 3 for x in zip(*t)] for t in triangles]
    weights = [mesh_file.volume(t) for t in triangles]
else:
    points = link
    weights = [math.dist(p, node) if sys.argv[1] == "length-laplacian" else 1 for p in link]
mean = [sum(w * p[d] for w, p in zip(weights, points)) / sum(weights) for d in (0, 1)]
assert math.dist(mean, mesh_file.read("out.mesh").points[4]) < 1e-12, mean
END
done
expect_status 0 "$program" smooth arrow.mesh -o out.mesh -q

# Meshes without re-entrant corners become better, and other than by one another.
for mesh in square.mesh cube.mesh; do
    for method in planish "${methods[@]}"; do
        expect_status 0 "$program" smooth $mesh -o "$method.mesh" --method "$method" \
            --json report.json -q
        expect_json "r['method'] == '$method' and r['stop'] == 'converged' and r['certified']"
        expect_json "r['after']['rms_radius_ratio'] < r['before']['rms_radius_ratio']"
        expect_json "r['moved_nodes'] == r['mesh']['free_nodes']"
        for other in planish "${methods[@]}"; do
            [ "$other" != "$method" ] || break
            ! cmp -s "$method.mesh" "$other.mesh" || fail "$mesh: $method and $other are the same"
        done
    done
done
expect_status 0 "$program" smooth square.mesh -o default.mesh -q
expect_status 0 "$program" smooth square.mesh -o planish.mesh --method planish -q
cmp default.mesh planish.mesh || fail "planish is the default method"

# At the limit every free node is the mean of its neighbours, up to moves that are not worth making.
expect_status 0 "$program" smooth square.mesh -o limit.mesh --method laplacian --tolerance 0 \
    --max-sweeps 500 -q
python3 - <<'END' || fail "the limit of the Laplacian"
import math
import mesh_file
mesh = mesh_file.read("limit.mesh")
held = mesh_file.boundary(mesh)
around = [set() for _ in mesh.points]
for element in mesh.elements:
    for node in element:
        around[node].update(n for n in element if n != node)
for node, neighbours in enumerate(around):
    mean = [sum(mesh.points[n][d] for n in neighbours) / len(neighbours) for d in (0, 1)]
    assert node in held or math.dist(mean, mesh.points[node]) < 1e-4, node
END

# Fixed nodes are fixed for them, too, and a minimum volume is looked after.
expect_status 0 "$program" smooth square.mesh -o out.mesh --method laplacian --fix 1 -q
cmp square.mesh out.mesh || fail "--fix does not hold with a Laplacian method"
expect_status 1 "$program" smooth square.mesh -o out.mesh --method laplacian --min-volume 1 \
    --json report.json -q
expect_json "r['after']['below_min_volume'] == r['mesh']['elements'] == len(r['below_min'])"
finish
