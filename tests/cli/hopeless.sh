#!/usr/bin/env bash
# Meshes that cannot be made valid: what the boundary proves is said at once, and untangling that was in
# vain leaves nothing worse than it was.
. "$(dirname "$0")/common.sh"

# A closed surface laid flat: an octahedron, refined; half of its triangles lie the other way round.
python3 - <<'END' || fail "the surface"
points, number = [], {}
def node(p):
    r = sum(x * x for x in p) ** 0.5
    p = tuple(round(x / r, 12) for x in p)
    if p not in number:
        number[p] = len(points) + 1
        points.append((p[0] + 0.3 * p[2], p[1]))
    return number[p], p
def split(a, b, c, n):
    if n == 0:
        return [(node(a)[0], node(b)[0], node(c)[0])]
    ab, bc, ca = (tuple((x + y) / 2 for x, y in zip(p, q)) for p, q in ((a, b), (b, c), (c, a)))
    return sum((split(*t, n - 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))), [])
triangles = []
for x in (1, -1):
    for y in (1, -1):
        for z in (1, -1):
            corners = [(x, 0, 0), (0, y, 0), (0, 0, z)]
            triangles += split(*(corners if x * y * z > 0 else corners[::-1]), 4)
with open("flat.mesh", "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices %d\n" % len(points))
    file.writelines("%.17g %.17g 0\n" % p for p in points)
    file.write("Triangles %d\n" % len(triangles))
    file.writelines("%d %d %d 0\n" % t for t in triangles)
    file.write("End\n")
END
expect_status 1 "$program" smooth flat.mesh -o out.mesh --json report.json -q
expect_text "boundary encloses no positive area"
expect_json "r['untangling_sweeps'] == 0 and r['after']['inverted'] == r['before']['inverted'] > 0"
expect_json "len(r['unfixable']) == r['after']['inverted']"

# Nodes of one side are moved through the mesh and out of the other side, and of other parts nothing is
# proved. Whatever is left inverted, there is not more of it, and not where nothing was won.
python3 "$cli/make_slow_mesh.py" 12 square.mesh
python3 - <<'END' || fail "the spoilt square"
lines = open("square.mesh").read().split("\n")
at = next(i for i, line in enumerate(lines) if line.startswith("Vertices"))
count = int(lines[at].split()[1]) if len(lines[at].split()) > 1 else int(lines[at + 1])
first = at + 1 if len(lines[at].split()) > 1 else at + 2
points = [list(map(float, lines[first + i].split()[:2])) for i in range(count)]
low, high = min(p[0] for p in points), max(p[0] for p in points)
size = high - low
edge = [i for i in range(count) if points[i][0] == low and 0.3 < (points[i][1] - low) / size < 0.7]
for k, i in enumerate(edge):
    points[i][0] += 1.5 * size
for i in range(count):
    lines[first + i] = "%.17g %.17g 0" % tuple(points[i])
open("spoilt.mesh", "w").write("\n".join(lines))
END
for threads in 1 2; do
    expect_status 1 "$program" smooth spoilt.mesh -o out$threads.mesh --json report.json -q -j $threads
    expect_json "0 < r['after']['inverted'] <= r['before']['inverted']"
done
cmp out1.mesh out2.mesh || fail "two threads give another mesh than one"

finish

# Two squares apart: nodes inside one of them are thrown about, and of the other one a node of the boundary
# is moved through the mesh and out of it. The first is repaired; in the second untangling is in vain, so its
# nodes are where they were, although the mesh as a whole has won.
python3 - <<'END' || fail "two squares"
n, width = 8, 9
square = [(i / n, j / n) for j in range(width) for i in range(width)]
one, other = list(square), [(x + 3, y) for x, y in square]
for node, dx, dy in ((20, 0.4, 0.3), (33, -0.35, 0.2), (50, 0.3, -0.4), (60, -0.3, -0.3)):
    one[node] = (square[node][0] + dx, square[node][1] + dy)
other[n // 2] = (3.5, 1.2)
corners = [j * width + i for j in range(n) for i in range(n)]
triangles = [t for a in corners for t in ((a, a + 1, a + 10), (a, a + 10, a + 9))]
with open("apart.mesh", "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices %d\n" % (2 * len(square)))
    file.writelines("%r %r 0\n" % p for p in one + other)
    file.write("Triangles %d\n" % (2 * len(triangles)))
    file.writelines("%d %d %d 0\n" % tuple(v + 1 + base for v in t)
                    for base in (0, len(square)) for t in triangles)
    file.write("End\n")
END
expect_status 1 "$program" smooth apart.mesh -o out.mesh --json report.json -q
expect_json "r['before']['inverted'] > r['after']['inverted'] == 2 and r['moved_nodes'] > 0"
cmp <(sed -n '85,165p' apart.mesh) <(sed -n '85,165p' out.mesh) || fail "nodes did not return"
