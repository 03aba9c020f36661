#!/usr/bin/env bash
# A file that lists all edges or facets of its mesh puts no constraint on them by that.
. "$(dirname "$0")/common.sh"

# lists.py DIM FORMAT LIST FILE: a square or cube with what LIST says beside its elements:
#   none; edges, facets: all of them, with one tag; but-one: all edges but one;
#   wall: all facets, those at x = 3 of a tag of their own; half: those at x = 3 alone;
#   three: all facets, of tag 1, 2 or 3 by x and 4 between;
#   ridges: all edges, those on the boundary of tag 2 and those of two sides of tag 3.
cat >lists.py <<'END' || exit 1
import itertools, random, sys
dim, form, wanted, path = int(sys.argv[1]), *sys.argv[2:]
random.seed(5)
N = 6
axes = range(dim)
grid = list(itertools.product(range(N + 1), repeat=dim))
index = {p: i for i, p in enumerate(grid)}
points = [[c + (random.uniform(-.2, .2) if c not in (0, 3, N) else 0) for c in p] for p in grid]
elements = []
for cell in itertools.product(range(N), repeat=dim):
    for order in itertools.permutations(axes):
        at, corners = list(cell), [index[cell]]
        for axis in order:
            at[axis] += 1
            corners.append(index[tuple(at)])
        odd = sum(a > b for a, b in itertools.combinations(order, 2)) % 2
        elements.append(corners[:-2] + corners[:-3:-1] if odd else corners)


def all_of(n):
    return sorted({tuple(sorted(c)) for e in elements for c in itertools.combinations(e, n)})


def on(nodes, axis, *places):
    return any(all(grid[n][axis] == p for n in nodes) for p in places)


def sides(nodes):
    return sum(on(nodes, a, 0, N) for a in axes)


def by_x(nodes):
    x = sorted(grid[n][0] for n in nodes)
    return 4 if x[0] == x[-1] and x[0] in (2, 4) else 1 + (x[-1] > 2) + (x[-1] > 4)


lists = {2: [], 3: []}
if wanted in ("edges", "but-one"):
    lists[2] = [(e, 1) for e in all_of(2)[wanted == "but-one":]]
elif wanted == "facets":
    lists[dim] = [(f, 1) for f in all_of(dim)]
elif wanted == "wall":
    lists[dim] = [(f, 2 if on(f, 0, 3) else 1) for f in all_of(dim)]
elif wanted == "half":
    lists[dim] = [(f, 2) for f in all_of(dim) if on(f, 0, 3)]
elif wanted == "three":
    lists[dim] = [(f, by_x(f)) for f in all_of(dim)]
elif wanted == "ridges":
    lists[2] = [(e, 1 + sides(e)) for e in all_of(2)]
cells = [(c, tag) for n in (2, 3) for c, tag in lists[n]] + [(e, 9) for e in elements]
with open(path, "w") as out:
    if form == "msh":
        print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes", len(points), sep="\n", file=out)
        for i, p in enumerate(points):
            print(i + 1, *map(repr, p + [0] * (3 - dim)), file=out)
        print("$EndNodes\n$Elements", len(cells), sep="\n", file=out)
        for i, (c, tag) in enumerate(cells):
            print(i + 1, {2: 1, 3: 2, 4: 4}[len(c)], 2, tag, tag, *(n + 1 for n in c), file=out)
        print("$EndElements", file=out)
    elif form == "vtk":
        print("# vtk DataFile Version 2.0\nlists\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS",
              len(points), "double", file=out)
        for p in points:
            print(*map(repr, p + [0] * (3 - dim)), file=out)
        print("CELLS", len(cells), sum(1 + len(c) for c, _ in cells), file=out)
        for c, _ in cells:
            print(len(c), *c, file=out)
        print("CELL_TYPES", len(cells), file=out)
        print(*({2: 3, 3: 5, 4: 10}[len(c)] for c, _ in cells), file=out)
        print("CELL_DATA", len(cells), "\nSCALARS region int\nLOOKUP_TABLE default", file=out)
        print(*(tag for _, tag in cells), file=out)
    else:
        print("MeshVersionFormatted 2 Dimension", dim, "\nVertices", len(points), file=out)
        for p in points:
            print(*map(repr, p), 0, file=out)
        for name, n in (("Edges", 2), ("Triangles", 3), ("Tetrahedra", 4)):
            print(name, sum(len(c) == n for c, _ in cells), file=out)
            for c, tag in cells:
                if len(c) == n:
                    print(*(i + 1 for i in c), tag, file=out)
        print("End", file=out)
END

# free DIM FORMAT LIST N [OPTION...]: N nodes of that mesh are free.
free() {
    local dim=$1 form=$2 list=$3 wanted=$4
    shift 4
    python3 lists.py "$dim" "$form" "$list" "mesh.$form" || fail "lists.py $dim $form $list"
    expect_status 0 "$program" smooth "mesh.$form" -o "out.$form" --json report.json -q "$@"
    expect_json "r['mesh']['free_nodes'] == $wanted"
}

for form in msh vtk mesh; do
    for list in none edges facets; do
        free 2 "$form" "$list" 25
    done
    free 3 "$form" edges 125
    free 3 "$form" facets 125
    free 2 "$form" but-one 0
    # What a tag tells apart stays.
    free 2 "$form" wall 20
    free 3 "$form" wall 100
    # Of several tags that of most says nothing.
    free 2 "$form" three 5
done
free 3 mesh none 125
free 3 mesh but-one 0
free 2 mesh half 20
free 3 mesh half 100
free 3 mesh three 25

# same_as DIM LIST LIKE [OPTION...]: what both lists ask for is the same.
same_as() {
    local dim=$1 list=$2 like=$3 mesh
    shift 3
    python3 lists.py "$dim" mesh "$list" a.mesh
    python3 lists.py "$dim" mesh "$like" b.mesh
    for mesh in a b; do
        expect_status 0 "$program" smooth "$mesh.mesh" -o "out-$mesh.mesh" -q "$@"
        sed '/^Edges/,$d' "out-$mesh.mesh" >"$mesh.points"
    done
    cmp -s a.points b.points || fail "$dim: $list is not as $like ($*)"
    cmp -s a.mesh out-a.mesh && fail "$dim: nothing moved"
}
for dim in 2 3; do
    same_as "$dim" edges none --slide auto
    same_as "$dim" facets none --slide auto
    same_as "$dim" wall half --slide auto
done
same_as 3 ridges none --slide auto
same_as 3 facets none --threads 3

# --fix holds what is listed, as ever; and so it is shown.
free 3 msh facets 0 --fix 2:1
free 2 vtk edges 0 --fix 1
python3 lists.py 2 mesh edges mesh.mesh
expect_status 0 "$program" smooth mesh.mesh -o out.vtk -q
[ "$(grep -a '^CELL_TYPES' out.vtk)" = "CELL_TYPES 192" ] || fail "lines are lost in out.vtk"
finish
