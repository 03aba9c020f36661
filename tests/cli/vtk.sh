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
# Hexahedra among elements of every type: corners alone where VTK also looks at the centre, which is better here.
"$python" "$cli/types_mesh.py" types.vtk types.json tetrahedra.vtk
expect_status 0 "$program" quality types.vtk --json quality.json -q
"$python" - <<'END' || fail "scaled Jacobians of hexahedra"
import json, math, vtk
reader = vtk.vtkUnstructuredGridReader()
reader.SetFileName("types.vtk")
reader.Update()
grid, least = reader.GetOutput(), math.inf
for i in range(grid.GetNumberOfCells()):
    if grid.GetCellType(i) == vtk.VTK_HEXAHEDRON:
        least = min(least, vtk.vtkMeshQuality.HexScaledJacobian(grid.GetCell(i)))
found = json.load(open("quality.json"))["quality"]["by_type"]["hexahedron"]["min_scaled_jacobian"]
assert math.isclose(found, least, rel_tol=1e-10), (found, least)
END
finish
