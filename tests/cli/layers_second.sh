#!/usr/bin/env bash
# Kept layers of second order, where a few elements are invalid inside: nodes are held for their heights as in a valid mesh,
# but not where more elements would stay invalid.
. "$(dirname "$0")/common.sh"

# ---- elements that are repaired though nodes are held

python3 "$cli/layers_second.py" 3 1 >bent.vtk
expect_status 0 "$program" smooth bent.vtk -o out.vtk --json report.json -j 1
expect_json 'r["before"]["inverted"] == len(r["before"]["worst_elements"][:4]) == 4 and r["after"]["inverted"] == 0'
expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1 and r["layer_heights"]["held_nodes"] > 50'
# Mids whose ends are held are held for that, and not because the file would ask for it.
expect_json 'r["mesh"]["held"]["layers"] > 0 and r["mesh"]["held"]["required"] == 0'
! grep -q "heights of layers are" err || fail "there is nothing to note: $(cat err)"

# ---- elements that need the heights beside them: the others are kept

python3 "$cli/layers_second.py" 3 1.5 >bent.vtk
expect_status 0 "$program" smooth bent.vtk -o out.vtk --json report.json -j 1
expect_json 'r["before"]["inverted"] == 4 and r["after"]["inverted"] == 0 and r["layer_heights"]["held_nodes"] > 50'
expect_json 'r["layer_heights"]["rows"][0]["max"] > 1.5'
expect_json 'all(0.9 < h["min"] and h["max"] < 1.1 for h in r["layer_heights"]["rows"][8:])'
expect_text "most in row 1: with their nodes held 4 more elements would stay inverted"
expect_status 0 "$program" smooth bent.vtk -o told.vtk -q -j 2
cmp -s out.vtk told.vtk || fail "what is told, and threads, change the bits"

# ---- heights that cannot be kept at all: the first result stands

python3 "$cli/layers_second.py" 2 20 >bent.vtk
expect_status 0 "$program" smooth bent.vtk -o out.vtk --json report.json --report page.html --history 8 -j 1
expect_json 'r["before"]["inverted"] == 2 and r["after"]["inverted"] == 0 and r["layer_heights"]["held_nodes"] == 0'
expect_json 'r["mesh"]["held"]["layers"] == 0 and r["layer_heights"]["max"] > 10'
# The sweeps are those of that result, and not of rounds that were given up.
expect_json 'abs(r["sweeps"][-1]["objective"] / r["objective"]["after"] - 1) < 1e-9'
expect_text "with their nodes held 2 more elements would stay inverted"
expect_status 0 "$program" smooth bent.vtk -o told.vtk -q -j 2
cmp -s out.vtk told.vtk || fail "what is told, and threads, change the bits of the first result"

finish
