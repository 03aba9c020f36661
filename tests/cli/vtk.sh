#!/usr/bin/env bash
# All measures of `planish quality` against VTK's mesh quality. Needs python3-vtk9 and numpy.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import numpy, vtk" 2>/dev/null || { echo "skipped: no numpy or VTK"; exit 77; }

# compare FILE: what planish says of it and what VTK says.
compare() {
    expect_status 0 "$program" quality "$1" --json quality.json -q
    "$python" "$cli/vtk_quality.py" "$1" quality.json || fail "$1"
}

# flat_mesh N FILE.mesh: a square of triangles of many shapes, nodes on a curved grid.
flat_mesh() {
    awk -v n="$1" 'BEGIN {
        print "MeshVersionFormatted 2\nDimension 2\nVertices\n" (n + 1) ^ 2
        for (j = 0; j <= n; j++)
            for (i = 0; i <= n; i++)
                printf "%.17g %.17g 0\n", i / n + 0.3 * sin(3 * j / n), (j / n) ^ 3 + 0.02 * j
        print "Triangles\n" 2 * n ^ 2
        for (j = 0; j < n; j++)
            for (i = 1; i <= n; i++) {
                a = i + (n + 1) * j
                print a, a + 1, a + n + 2, 1
                print a, a + n + 2, a + n + 1, 1
            }
        print "End"
    }' >"$2"
}

python3 "$cli/make_mesh.py" 5 0.2 pushed.mesh
compare pushed.mesh
expect_status 0 "$program" smooth pushed.mesh -o smooth.mesh -q
compare smooth.mesh
flat_mesh 12 flat.mesh
compare flat.mesh
if [ -n "${PLANISH_MESHES-}" ]; then
    compare "$PLANISH_MESHES/msq_tire.vtk"
    compare "$PLANISH_MESHES/part_100k.mesh"
fi
# Elements of every type, and triangles and quadrilaterals in one plane: what VTK has of each. Of hexahedra VTK also
# looks at the centre, which is better here.
"$python" "$cli/types_mesh.py" types.vtk types.json tetrahedra.vtk
"$python" - flat.vtk <<'END'
import math, random, sys
random.seed(51)
n, cells = 12, []
print("# vtk DataFile Version 3.0\nflat\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", (n + 1) ** 2, "double",
      file=(out := open(sys.argv[1], "w")))
for j in range(n + 1):
    for i in range(n + 1):
        print(repr(i / n + 0.2 * math.sin(j / n)), repr(((j + 2) / n) ** 2 + random.uniform(0, 0.3) / n), 0, file=out)
for a in (i + (n + 1) * j for j in range(n) for i in range(n)):
    ring = [a, a + 1, a + n + 2, a + n + 1]
    cells += [ring] if a % 3 else [ring[:3], ring[:1] + ring[2:]]
print("CELLS", len(cells), sum(len(c) + 1 for c in cells), file=out)
for c in cells:
    print(len(c), *c, file=out)
print("CELL_TYPES", len(cells), *(9 if len(c) == 4 else 5 for c in cells), sep="\n", file=out)
END
for mesh in types flat; do
    expect_status 0 "$program" quality $mesh.vtk --json quality.json -q
    "$python" - $mesh.vtk quality.json <<'END' || fail "$mesh.vtk: measures of each type"
import json, math, sys, vtk
NAMES = {vtk.VTK_TRIANGLE: ("triangle", "Triangle"), vtk.VTK_QUAD: ("quadrilateral", "Quad"),
         vtk.VTK_TETRA: ("tetrahedron", "Tet"), vtk.VTK_HEXAHEDRON: ("hexahedron", "Hex")}
reader = vtk.vtkUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid, found = reader.GetOutput(), json.load(open(sys.argv[2]))["quality"]["by_type"]
by_type = {}
for i in range(grid.GetNumberOfCells()):
    by_type.setdefault(grid.GetCellType(i), []).append(i)
n = 0
for number, (name, prefix) in NAMES.items():
    measures = [("min_scaled_jacobian", "ScaledJacobian", min), ("max_edge_ratio", "EdgeRatio", max)]
    if number in (vtk.VTK_TRIANGLE, vtk.VTK_TETRA):
        measures.append(("max_aspect_ratio", "AspectFrobenius", max))
    for key, measure, choose in measures if number in by_type else ():
        of_cell = getattr(vtk.vtkMeshQuality, prefix + measure)
        value = choose(of_cell(grid.GetCell(i)) for i in by_type[number])
        assert math.isclose(found[name][key], value, rel_tol=1e-10), (name, key, found[name][key], value)
        n += 1
assert n == 5, n
END
done
finish
