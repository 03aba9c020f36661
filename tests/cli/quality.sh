#!/usr/bin/env bash
# What planish says of a mesh against figures of a script that shares no code with it.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 5 0.2 pushed.mesh
python3 "$cli/make_mesh.py" 5 0.9 tangled.mesh
cp "$sample" bracket.msh
expect_status 0 "$program" smooth bracket.msh -o smooth.msh -q
expect_status 0 "$program" smooth pushed.mesh -o smooth.mesh -q
for mesh in bracket.msh smooth.msh pushed.mesh smooth.mesh tangled.mesh; do
    expect_status 0 "$program" quality $mesh --json quality.json -q
    python3 "$cli/measure.py" $mesh quality.json || fail "$mesh: figures differ"
done

# Over no valid element there is no ratio and no angle.
printf '%s\n' "MeshVersionFormatted 2 Dimension 3 Vertices 4" "0 0 0 0" "1 0 0 0" "0 1 0 0" "1 1 0 0" \
    "Tetrahedra 1" "1 2 3 4 0" "End" >flat.mesh
expect_status 0 "$program" quality flat.mesh --json report.json -q
expect_json "r['quality']['inverted'] == 1 and r['quality']['max_radius_ratio'] is None"
expect_json "set(r['quality']['scaled_jacobian'].values()) == {None}"

expect_status 0 "$program" quality flat.mesh
grep -q "^smallest dihedral angle  *-\$" out || fail "no angle: $(cat out)"
grep -q "^inverted  *1 #" out || fail "inverted elements in the histogram: $(cat out)"
expect_status 0 "$program" quality bracket.msh
! grep -q "^inverted  " out || fail "a row for nothing"
expect_status 0 "$program" smooth tangled.mesh -o untangled.mesh
grep -q "^inverted  *[1-9][0-9]* #.* 0\$" out || fail "inverted before: $(cat out)"

# Fixing things holds them.
expect_status 0 "$program" smooth pushed.mesh -o held.mesh --fix 1 -q
cmp pushed.mesh held.mesh || fail "--fix 1 should hold the whole mesh"
expect_status 0 "$program" smooth bracket.msh -o held.msh --fix bracket -q
cmp bracket.msh held.msh || fail "--fix NAME should hold the whole mesh"
expect_status 0 "$program" smooth bracket.msh -o held.msh --only-worse-than 1e6 -q
cmp bracket.msh held.msh || fail "no element is worse than a million"
finish
