#!/usr/bin/env bash
# OpenFOAM's meshes in every encoding: VTK's own reader finds the same cells, with the same sense, and the
# moved points in what planish writes. Needs python3-vtk9.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import vtk" 2>/dev/null || { echo "skipped: no VTK"; exit 77; }
if lacks "$source_folder/tests/data/ascii.vtu"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi

pairs=() n=0
for how in "" "binary" "binary label=64" "binary scalar=32 gz" "gz"; do
    n=$((n + 1))
    # shellcheck disable=SC2086
    python3 "$cli/folder_meshes.py" mixed 3 before$n/constant/polyMesh $how
    if ! "$program" quality before$n -o before$n.vtu -q 2>err; then
        grep -q "without zlib" err || fail "$how: $(cat err)"
        continue
    fi
    expect_status 0 "$program" smooth before$n -o after$n -q
    expect_status 0 "$program" quality after$n -o after$n.vtu -q
    pairs+=(before$n after$n)
    ! cmp -s before$n/constant/polyMesh/points* after$n/constant/polyMesh/points* || fail "'$how': no node has moved"
done
"$python" "$cli/openfoam_cells.py" "${pairs[@]}" || fail "cells as VTK reads them"

# A layer between empty patches is smoothed in its plane, and VTK reads it with both of its sides.
python3 "$cli/folder_meshes.py" layer 8 layer/constant/polyMesh
expect_status 0 "$program" smooth layer -o layer_out --json r.json -q
python3 -c "
import json
r = json.load(open('r.json'))
assert r['mesh']['dimension'] == 2 and r['mesh']['elements'] == 64 and r['mesh']['free_nodes'] == 49
assert r['after']['rms_aspect_ratio'] < r['before']['rms_aspect_ratio']" || fail "a layer"
"$python" "$cli/openfoam_cells.py" --layer layer_out || fail "both sides of a layer"
finish
