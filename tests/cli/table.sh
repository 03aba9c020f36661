#!/usr/bin/env bash
# What the table says of changes: ratios of other elements are not compared, and figures can be read.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 5 0.9 tangled.mesh
python3 "$cli/make_mesh.py" 5 0.15 valid.mesh
expect_status 0 "$program" smooth tangled.mesh -o out.mesh
grep -q "^Ratios and angles are those of the valid elements, [0-9]* before and 750" out ||
    fail "the table should say what its ratios are of"
! grep -E "^(worst|RMS|mean|smallest dihedral|largest dihedral|  of elements).*(better|worse|%)" out ||
    fail "ratios of other elements should not be compared"
grep -q "^inverted elements .* better" out || fail "counts are compared"
grep -q "^smallest volume .* better" out || fail "volumes are of all elements"
expect_status 0 "$program" smooth valid.mesh -o out.mesh
grep -q "^RMS radius ratio .* better" out || fail "ratios of a valid mesh are compared"
! grep -q "Ratios and angles are those" out || fail "all elements were valid"
grep -qE "[1-9][0-9][0-9][0-9.]* %" out && fail "no percentage above 100"

# The RMS falls by nearly all of it while the worst are improved.
python3 - <<'END'
import mesh_file
mesh = mesh_file.read("valid.mesh")
with open("flat.mesh", "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(mesh.points))
    file.writelines("%r %r %r 0\n" % (x, y, z / 5 + (z / 2) ** 9) for x, y, z in mesh.points)
    file.write("Tetrahedra\n%d\n" % len(mesh.elements))
    file.writelines("%d %d %d %d 1\n" % tuple(n + 1 for n in e) for e in mesh.elements)
    file.write("End\n")
END
for file in tangled flat; do
    expect_status 0 "$program" smooth $file.mesh -o out.mesh --objective worst --max-sweeps 0
    tr '\n' ' ' <out >text
    grep -qE "while the RMS (went from [0-9.]+ to [0-9.]+|(fell|rose) by [0-9]([.0-9]*)|fell by [0-4][0-9]) ?" text ||
        fail "what the worst cost should be told: $(tail -3 out)"
    ! grep -qE "e[+][0-9]+ %" out || fail "percentages should be such that they can be read"
done
finish
