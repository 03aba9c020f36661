#!/usr/bin/env bash
# Graded meshes keep their grading: sizes from 1 to 10^4, the boundary held and sliding.
. "$(dirname "$0")/common.sh"

# Sectors of shells whose elements grow with the radius, straight and disturbed: straightD.mesh and
# gradedD.mesh.
python3 - <<'END' || exit 1
import itertools
import math
import random
GROWTH = math.log(1e4)


def place(u, dim, layers):
    """The cell coordinates u, the first one that of the layer, in space."""
    radius = math.exp(GROWTH * u[0] / layers)
    if dim == 2:
        angle = GROWTH / layers * u[1]
        return [radius * math.cos(angle), radius * math.sin(angle)]
    across = [1] + [1.2 * GROWTH / layers * (c - 2.5) for c in u[1:]]
    return [radius * c / math.hypot(*across) for c in across]


def write(path, dim, points, elements):
    with open(path, "w") as out:
        print(f"MeshVersionFormatted 2\nDimension {dim}\nVertices\n{len(points)}", file=out)
        for p in points:
            print(*map(repr, p), 0, file=out)
        print("Tetrahedra" if dim == 3 else "Triangles", len(elements), sep="\n", file=out)
        for e in elements:
            print(*(n + 1 for n in e), 0, file=out)
        print("End", file=out)


random.seed(5)
for dim, cells in ((2, (60, 10)), (3, (40, 5, 5))):
    index, straight, graded = {}, [], []
    for u in itertools.product(*(range(n + 1) for n in cells)):
        index[u] = len(straight)
        inside = all(0 < c < n for c, n in zip(u, cells))
        far = 0.25 if dim == 2 else 0.13
        moved = [c + (random.uniform(-far, far) if inside else 0) for c in u]
        straight.append(place(u, dim, cells[0]))
        graded.append(place(moved, dim, cells[0]))
    elements = []
    for u in itertools.product(*(range(n) for n in cells)):
        for path in itertools.permutations(range(dim)):
            at, corners = list(u), [index[u]]
            for axis in path:
                at[axis] += 1
                corners.append(index[tuple(at)])
            odd = sum(path[i] > path[j] for j in range(dim) for i in range(j)) % 2
            elements.append(corners[:-2] + corners[:-3:-1] if odd else corners)
    write(f"straight{dim}.mesh", dim, straight, elements)
    write(f"graded{dim}.mesh", dim, graded, elements)
END

# check DIM OUT: no element has left its size by much, while most are better.
check() {
    python3 - "$@" <<'END' || fail "$*"
import math, sys
import mesh_file
dim = sys.argv[1]
straight, graded, new = (mesh_file.read(name) for name in
                         (f"straight{dim}.mesh", f"graded{dim}.mesh", sys.argv[2]))
sizes = [mesh_file.volumes(mesh) for mesh in (straight, graded, new)]
assert min(map(min, sizes)) > 0
change = [math.log(b / a) / int(dim) for a, b in zip(sizes[0], sizes[2])]
spread = math.sqrt(sum(c * c for c in change) / len(change))
assert max(map(abs, change)) < math.log(2) and spread < 0.3, (max(map(abs, change)), spread)
edge = [(abs(s)) ** (1 / int(dim)) for s in sizes[2]]
assert max(edge) / min(edge) > 5e3, max(edge) / min(edge)
ratio = [mesh_file.rms(map(mesh_file.radius_ratio, mesh_file.corners(m))) for m in (graded, new)]
assert ratio[1] < 0.97 * ratio[0], ratio
END
}

for dim in 2 3; do
    for more in "" "--slide auto" "--only-worse-than 1.2" "--objective mean-ratio"; do
        # shellcheck disable=SC2086 # an option and its value
        expect_status 0 "$program" smooth graded$dim.mesh -o out.mesh $more --json report.json
        check $dim out.mesh
        [ "$more" != "--slide auto" ] || expect_json "r['mesh']['sliding_nodes'] > 0"
    done
    # Sizes of 10^8 times as much, or as little, give the same: a power of two to the bit.
    for scale in 0x1p40 0x1p-40; do
        python3 - graded$dim.mesh scaled.mesh $scale <<'END'
import sys
source, path, scale = sys.argv[1:]
lines = open(source).read().split("\n")
begin = lines.index("Vertices") + 2
for i in range(begin, begin + int(lines[begin - 1])):
    *x, tag = lines[i].split()
    lines[i] = " ".join(["%r" % (float(c) * float.fromhex(scale)) for c in x] + [tag])
open(path, "w").write("\n".join(lines))
END
        expect_status 0 "$program" smooth scaled.mesh -o scaled_out.mesh --slide auto -q
        expect_status 0 "$program" smooth graded$dim.mesh -o out.mesh --slide auto -q
        python3 - out.mesh scaled_out.mesh $scale <<'END' || fail "scaled by $scale"
import sys
import mesh_file
a, b = (mesh_file.read(name) for name in sys.argv[1:3])
scale = float.fromhex(sys.argv[3])
assert all([c * scale for c in p] == q for p, q in zip(a.points, b.points))
END
    done
done

finish
