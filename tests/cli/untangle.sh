#!/usr/bin/env bash
# Untangling: tangled meshes become valid and as good as if they had never been tangled, whatever cannot
# be repaired is named and does not keep the rest from it, and a run that is cut short makes nothing worse.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_slow_mesh.py" 12 square.mesh
python3 "$cli/make_mesh.py" 6 0.2 cube.mesh
# With bounds there is no help for slow meshes, and it takes seconds.
endless=(--tolerance 0 --max-sweeps 2000000000 -j 1 --box=-9,-9,9,9)

# spoil IN OUT KIND...
spoil() {
    python3 "$cli/tangle_mesh.py" "$@" || fail "tangle_mesh.py $*"
}

# check IN OUT LIKE WHAT: as check_untangled.py says.
check() {
    python3 "$cli/check_untangled.py" report.json "$@" || fail "untangling: $*"
}

# Valid meshes pay nothing.
for mesh in square cube; do
    expect_status 0 "$program" smooth $mesh.mesh -o smooth_$mesh.mesh --json report.json
    ! grep -q untangling out || fail "$mesh: there was nothing to untangle"
    expect_json "r['untangling_sweeps'] == 0 and r['unfixable'] == []"
    expect_json "all(s['phase'] == 'smooth' for s in r['sweeps'])"
    expect_status 0 "$program" smooth $mesh.mesh -o out.mesh --no-untangle -q
    cmp smooth_$mesh.mesh out.mesh || fail "$mesh: --no-untangle changes a valid mesh"
done

# Whatever was done to the nodes, and on any number of threads.
for mesh in square cube; do
    for kind in moved centroid $(unless_quick collapsed thrown doubled); do
        spoil $mesh.mesh $mesh.$kind.mesh $kind
        expect_status 0 "$program" smooth $mesh.$kind.mesh -o out.mesh --json report.json -q -j 2
        check $mesh.$kind.mesh out.mesh smooth_$mesh.mesh solved
        for threads in 1 $(unless_quick 3); do
            expect_status 0 "$program" smooth $mesh.$kind.mesh -o many.mesh -q -j $threads
            cmp out.mesh many.mesh || fail "$mesh, $kind: $threads threads give another mesh than 2"
        done
    done
    expect_status 0 "$program" smooth $mesh.moved.mesh -o out.mesh -v
    expect_text "  untangling"
    grep -q "sweeps ([1-9][0-9]* of them untangling), " out || fail "$mesh: the table does not tell"
done

# Switched off: what is tangled stays so, and the reason says why.
for mesh in square cube; do
    expect_status 1 "$program" smooth $mesh.moved.mesh -o out.mesh --no-untangle --json report.json -q
    expect_one_line
    expect_text "--no-untangle"
    check $mesh.moved.mesh out.mesh smooth_$mesh.mesh left
    expect_json "r['after']['inverted'] == r['before']['inverted'] and r['untangling_sweeps'] == 0"
    expect_json "'%d inverted elements are left' % r['after']['inverted'] in r['reason']"
done

# No sweep of smoothing: it untangles, and that is all.
expect_status 0 "$program" smooth cube.moved.mesh -o out.mesh --max-sweeps 0 --json report.json -q
check cube.moved.mesh out.mesh smooth_cube.mesh left
expect_json "r['after']['inverted'] == 0 and r['stop'] == 'max-sweeps' and r['certified']"
expect_json "len(r['sweeps']) == r['untangling_sweeps'] > 0"

# What cannot be repaired is found and named, and does not keep the rest from it: an element without a free
# node, which is known; and nodes that cannot see all of the fixed boundary around them.
for mesh in square cube; do
    spoil $mesh.mesh flawed.mesh moved ear
    expect_status 1 "$program" smooth flawed.mesh -o out.mesh --json report.json
    check flawed.mesh out.mesh smooth_$mesh.mesh flawed
    expect_json "len(r['unfixable']) == 1 and '1 inverted element is left' in r['reason']"
    expect_text "1 of these cannot be made valid by moving free nodes (element "
    [ $mesh = cube ] && step=curved || step=auto
    expect_text "): try --slide $step, or mesh them again"
    [ "$(grep -c "cannot be made valid" err)" -eq 1 ] || fail "$mesh: one message: $(cat err)"
    python3 - <<'END' || fail "$mesh: all nodes of the unfixable element should be fixed"
import json
import mesh_file
mesh = mesh_file.read("flawed.mesh")
(number,) = json.load(open("report.json"))["unfixable"]
assert mesh_file.boundary(mesh).issuperset(mesh.elements[number - 1])
END

    spoil $mesh.mesh flawed.mesh moved ear islands
    expect_status 1 "$program" smooth flawed.mesh -o out.mesh --json report.json -j 2
    check flawed.mesh out.mesh smooth_$mesh.mesh flawed
    [ "$(grep -o '(elements [^)]*, \.\.\.)' err | tr ',' '\n' | wc -l)" -eq 11 ] || fail "ten elements and dots expected"
    expect_json "'%d of these cannot' % len(r['unfixable']) in r['reason']"
    python3 - $mesh.mesh <<'END' || fail "$mesh: what is unfixable"
import json, sys
import mesh_file
mesh, base = mesh_file.read("flawed.mesh"), mesh_file.read(sys.argv[1])
ear, *walls = json.load(open("report.json"))["unfixable"]
assert ear <= len(base.elements) < min(walls)
assert len(walls) == 12 * (mesh.dim - 1)  # each node does not see one wall: an edge, or two triangles
nodes = {mesh.elements[number - 1][-1] for number in walls}
assert len(nodes) == 12 and nodes.isdisjoint(mesh_file.boundary(mesh))
END
    expect_status 1 "$program" smooth flawed.mesh -o many.mesh -j 3 -q
    expect_one_line
    cmp out.mesh many.mesh || fail "$mesh with flaws: 3 threads give another mesh than 2"
done

# With a minimum volume: valid, and above it.
expect_status 0 "$program" smooth cube.moved.mesh -o out.mesh --min-volume-fraction 2e-4 \
    --json report.json -q
expect_json "r['before']['inverted'] > 0 == r['after']['below_min_volume'] and r['certified']"
python3 -c "
import mesh_file
assert min(mesh_file.volumes(mesh_file.read('out.mesh'))) >= 0.997 * 2e-4" ||
    fail "elements below the minimum volume"

# Within bounds. They matter: without them nodes go farther.
# within IN OUT DISTANCE LOW HIGH: no node has gone farther, and none that was in the box has left it.
within() {
    python3 - "$@" <<'END'
import math, sys
import mesh_file
old, new = mesh_file.read(sys.argv[1]), mesh_file.read(sys.argv[2])
distance, low, high = map(float, sys.argv[3:])
held = mesh_file.boundary(old)


def inside(point):
    return all(low <= x <= high for x in point)


pairs = [(a, b) for i, (a, b) in enumerate(zip(old.points, new.points)) if i not in held]
kept = all(math.dist(a, b) <= distance * (1 + 1e-12) and inside(b) >= inside(a) for a, b in pairs)
sys.exit(0 if pairs and kept else 3)
END
}
for mesh in square cube; do
    expect_status 0 "$program" smooth $mesh.centroid.mesh -o out.mesh -q
    within $mesh.centroid.mesh out.mesh 9 0.2 0.8
    [ $? -eq 3 ] || fail "$mesh: the box does not matter"
    box=0.2,0.2,0.8,0.8
    [ $mesh = square ] || box=0.2,0.2,0.2,0.8,0.8,0.8
    expect_status 0 "$program" smooth $mesh.centroid.mesh -o out.mesh --box $box --json report.json -q
    within $mesh.centroid.mesh out.mesh 9 0.2 0.8 || fail "$mesh: nodes leave the box"
    expect_json "r['after']['inverted'] == 0 < r['untangling_sweeps']"

    expect_status 0 "$program" smooth $mesh.moved.mesh -o out.mesh -q
    within $mesh.moved.mesh out.mesh 0.2 -9 9
    [ $? -eq 3 ] || fail "$mesh: the limit does not matter"
    "$program" smooth $mesh.moved.mesh -o out.mesh --max-displacement 0.2 --json report.json -q 2>err
    within $mesh.moved.mesh out.mesh 0.2 -9 9 || fail "$mesh: nodes go too far"
    expect_json "r['after']['inverted'] < r['before']['inverted'] and r['untangling_sweeps'] > 0"
done

# Single precision: valid as it is written.
for mesh in square cube; do
    spoil $mesh.mesh single.vtk moved float
    expect_status 0 "$program" smooth single.vtk -o out.vtk --json report.json -q
    expect_json "r['before']['inverted'] > 0 == r['after']['inverted'] and r['certified']"
    python3 - <<'END' || fail "$mesh: the file in single precision"
import struct
import mesh_file
words = open("out.vtk").read().split()
at = words.index("POINTS")
assert words[at + 2] == "float"
n = int(words[at + 1])
x = [struct.unpack("f", struct.pack("f", float(w)))[0] for w in words[at + 3:at + 3 + 3 * n]]
at = words.index("CELLS")
corners = int(words[at + 3])
cells = [int(w) for w in words[at + 3:words.index("CELL_TYPES")]]
cells = [cells[i + 1:i + 1 + corners] for i in range(0, len(cells), corners + 1)]
assert len(cells) == int(words[at + 1]) > 0
assert min(mesh_file.volume([x[3 * i:3 * i + corners - 1] for i in cell]) for cell in cells) > 1e-9
END
done

# Cut short: no more inverted than before, the file complete, the status 1.
python3 "$cli/make_slow_mesh.py" 100 slow.mesh # so slow that seconds pass before there is nothing to win
spoil slow.mesh slow.moved.mesh moved
for limit in 1e-9 0.02; do
    rm -f out.mesh report.json
    expect_status 1 "$program" smooth slow.moved.mesh -o out.mesh --time-limit $limit \
        "${endless[@]}" --json report.json -q
    expect_one_line
    expect_text "time limit"
    expect_json "r['stop'] == 'time-limit'"
    check slow.moved.mesh out.mesh slow.mesh left
done
for signal in INT TERM; do
    rm -f out.mesh report.json err
    env --default-signal=INT,TERM "$program" smooth slow.moved.mesh -o out.mesh \
        "${endless[@]}" -v --json report.json >out 2>err &
    run=$!
    wait_for "  untangling" err
    kill -$signal $run
    wait $run
    status=$?
    [ $status -eq 1 ] || fail "SIG$signal: status $status instead of 1"
    expect_json "r['stop'] == 'interrupted' and 'interrupted' in r['reason']"
    check slow.moved.mesh out.mesh slow.mesh left
done

# The interior of a square is mirrored, so that most of the elements are inverted: the boundary tells the
# orientation, not the number of the elements.
python3 - <<'END' || fail "a mirrored interior"
n, width = 12, 13
points = [(i / n, j / n) for j in range(width) for i in range(width)]
points = [(1 - x, y) if 0 < x < 1 and 0 < y < 1 else (x, y) for x, y in points]
corners = [j * width + i for j in range(n) for i in range(n)]
triangles = [t for a in corners for t in ((a, a + 1, a + 14), (a, a + 14, a + 13))]
with open("mirrored.mesh", "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices %d\n" % len(points))
    file.writelines("%r %r 0\n" % p for p in points)
    file.write("Triangles %d\n" % len(triangles))
    file.writelines("%d %d %d 0\n" % tuple(v + 1 for v in t) for t in triangles)
    file.write("End\n")
END
expect_status 0 "$program" smooth mirrored.mesh -o out.mesh --json report.json -q
expect_json "r['before']['inverted'] > 0.7 * r['mesh']['elements'] and r['after']['inverted'] == 0"
expect_json "len(r['sweeps']) <= 4"

# Known tangled meshes, judged by an independent program.
oracle=${PLANISH_MESHES-}/../tools/oracle.py
python=/usr/bin/python3
if [ -z "${PLANISH_MESHES-}" ] || [ ! -f "$oracle" ] ||
    ! "$python" -c "import numpy, meshio" 2>/dev/null; then
    echo "without the known meshes: they, the oracle, numpy or meshio are not here"
    finish
fi

# judge MESH [RMS]: it becomes valid, and as good as the mesh that it was made from.
judge() {
    local out=out.${1##*.}
    rm -f out.* report.json
    expect_status 0 "$program" smooth "$PLANISH_MESHES/$1" -o "$out" --json report.json -q
    "$python" "$oracle" "$out" --ref "$PLANISH_MESHES/$1" --json >oracle.json ||
        { fail "$1: the oracle cannot read the result"; return; }
    "$python" - "$@" <<'END' || fail "$1"
import json, sys
seen, report = json.load(open("oracle.json")), json.load(open("report.json"))
print("%-28s RMS %.5f" % (sys.argv[1], seen["rms_rr"]), *sys.argv[2:])
assert report["before"]["inverted"] > 0 == seen["inverted"] and report["certified"]
assert seen["bnd_moved"] == 0 and seen["conn_exact"]
assert all(abs(seen["rms_rr"] / float(rms) - 1) < 0.01 for rms in sys.argv[2:])
END
}

judge msq2d_tangled_tri.vtk
judge part_10k_tangled10.mesh 1.7292
[ -z "${PLANISH_QUICK-}" ] || finish
judge msq_tet4_tangled.vtk
judge part_10k_tangled1.mesh 1.7292
judge sphere_10k_tangled10.msh 1.6597
judge part_100k_tangled10.mesh 1.3780
finish
