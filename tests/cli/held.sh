#!/usr/bin/env bash
# Why nodes do not move: counted by reason, each node once, in the report and with -v; and where no
# node can move, one line says why.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 4 0 cube.mesh
python3 - <<'END'
import mesh_file
cube = mesh_file.read("cube.mesh")
N = 4


def write(name, points, elements, sections=(), regions=None, references=None):
    with open(name, "w") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
        for i, p in enumerate(points):
            file.write("%r %r %r %d\n" % (*p, references[i] if references else 0))
        file.write("Tetrahedra\n%d\n" % len(elements))
        for i, e in enumerate(elements):
            file.write("%d %d %d %d %d\n" % (*(n + 1 for n in e), regions[i] if regions else 1))
        for name, rows in sections:
            file.write("%s\n%d\n" % (name, len(rows)))
            file.writelines(" ".join(str(v) for v in row) + "\n" for row in rows)
        file.write("End\n")


points, elements = list(cube.points), list(cube.elements)
node = {tuple(round(N * c) for c in p): i for i, p in enumerate(points)}
at = lambda *c: node[c] + 1

# Two regions, halves in x: 9 of the 27 inner nodes are between them. A line inside, of which one
# node is between the regions. A required vertex, an inner triangle, a node of no element.
regions = [1 + (sum(points[n][0] for n in e) > 2) for e in elements]
sections = [("Edges", [(at(1, 1, 1), at(2, 1, 1), 9)]),
            ("Triangles", [(at(1, 2, 2), at(1, 1, 2), at(1, 2, 3), 8)]),
            ("RequiredVertices", [(at(3, 3, 3),)])]
references = [0] * (len(points) + 1)
references[node[3, 1, 1]] = 77
write("all.mesh", points + [(9.0, 9.0, 9.0)], elements, sections, regions, references)

# Each element has its own points; and all inner nodes in one group.
own = [points[n] for e in elements for n in e]
write("own.mesh", own, [(4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3) for i in range(len(elements))])
inner = [0 < min(p) and max(p) < 1 for p in points]
write("group.mesh", points, elements, (), None, [5 if i else 0 for i in inner])
lines = [(at(x, y, z), at(x + 1, y, z), 9) for x in (1, 2) for y in (1, 2, 3) for z in (1, 2, 3)]
write("lines.mesh", points, elements, [("Edges", lines)])

# Halves of the cube side by side, each with the nodes between them.
half = lambda h: [e for e, r in zip(elements, regions) if r == h]
copy = {n: len(points) + i for i, n in enumerate(
    n for n in range(len(points)) if points[n][0] == 0.5)}
write("halves.mesh", points + [points[n] for n in copy],
      half(1) + [tuple(copy.get(n, n) for n in e) for e in half(2)])
END

# identity: each node of report.json is counted once.
identity() {
    expect_json "sum(r['mesh']['held'].values()) + r['mesh']['free_nodes'] + r['mesh']['sliding_nodes'] + r['mesh']['unused_nodes'] == r['mesh']['nodes']"
}

# held KEY=N...: of report.json, and nothing else is held.
held() {
    local wanted
    wanted=$(printf "'%s'," "$@")
    expect_json "sorted('%s=%d' % i for i in r['mesh']['held'].items() if i[1]) == sorted([$wanted])"
    identity
}

keys="['boundary', 'lines_and_points', 'faces_inside', 'interface', 'other_elements', 'periodic', 'fix', 'required', 'doubled_points', 'nonmanifold', 'layers', 'wrapped', 'not_chosen']"
for threads in 1 4; do
    expect_status 0 "$program" smooth all.mesh -o out.mesh --threads $threads --json report.json -v \
        --max-sweeps 1 --fix 77
    expect_json "list(r['mesh']['held']) == $keys"
    held boundary=98 lines_and_points=2 faces_inside=3 interface=8 fix=1 required=1
    expect_json "r['mesh']['unused_nodes'] == 1 and r['mesh']['doubled_nodes'] == 0"
    tr '\n' ' ' <err >text
    grep -qF "held: 98 nodes are on the boundary, 2 on lines or points of the file, 3 on faces that the file lists inside the mesh, 8 between regions, 1 in groups of --fix, 1 required by the file; 1 more node is in no element" text ||
        fail "-v says why: $(cat text)"
done
expect_status 0 "$program" smooth all.mesh -o out.mesh --json report.json --max-sweeps 1 --ignore-regions
held boundary=98 lines_and_points=2 faces_inside=3 required=1
expect_status 0 "$program" smooth all.mesh -o out.mesh --json report.json --max-sweeps 1 --slide auto
expect_json "r['mesh']['sliding_nodes'] > 20"
identity
expect_status 0 "$program" quality all.mesh --json report.json
held boundary=98 lines_and_points=2 faces_inside=3 interface=8 required=1
expect_status 0 "$program" smooth cube.mesh -o out.mesh --json report.json --only-worse-than 100
held boundary=98 not_chosen=27
expect_text "no node is free to move: 98 nodes are on the boundary, 27 not chosen by --only-worse-than"
expect_status 0 "$program" smooth all.mesh -o out.mesh -q
[ ! -s err ] || fail "-q should be quiet"

# The page has the same.
expect_status 0 "$program" quality all.mesh --report page.html -q
grep -qF '<th scope="row">between regions</th><td>8</td>' page.html || fail "the page should say why"
! grep -qF "in groups of --fix" page.html || fail "reasons that no node has are left out"

# Nothing can move: why, and what to do.
expect_status 0 "$program" smooth own.mesh -o out.mesh --json report.json
held boundary=1536
expect_json "r['mesh']['doubled_nodes'] == 1536 and 'merge equal points' in r['reason']"
expect_text "no node is free to move: 1536 nodes are on the boundary; 1536 of them are at the place of other nodes (each element has its own points): merge equal points first"
expect_status 0 "$program" quality own.mesh
expect_text "note: no node is free to move: 1536 nodes are on the boundary; 1536"
expect_status 0 "$program" smooth group.mesh -o out.mesh --fix 5 --json report.json
held boundary=98 fix=27
expect_text "no node is free to move: 98 nodes are on the boundary, 27 in groups of --fix"
expect_status 0 "$program" smooth lines.mesh -o out.mesh --json report.json
held boundary=98 lines_and_points=27
expect_text "no node is free to move: 98 nodes are on the boundary, 27 on lines or points of the file"

# Parts side by side: their nodes count as those of the boundary, and are told of.
expect_status 0 "$program" smooth halves.mesh -o out.mesh --json report.json -v --max-sweeps 1
held boundary=132
expect_json "r['mesh']['doubled_nodes'] == 50"
tr '\n' ' ' <err >text
grep -qF "held: 132 nodes are on the boundary; 50 of them are at the place of other nodes " text ||
    fail "doubled nodes: $(cat text)"
finish
