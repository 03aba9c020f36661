#!/usr/bin/env bash
# Signals at random moments: tests/faults/interrupt.py. stop.sh has those at moments that are known.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 14 0.2 in.mesh || exit 1
python3 - <<'END' || exit 1
import mesh_file
mesh = mesh_file.read("in.mesh")
with open("in.node", "w") as file:
    print(len(mesh.points), 3, 0, 0, file=file)
    for i, xyz in enumerate(mesh.points):
        print(i, *xyz, file=file)
with open("in.ele", "w") as file:
    print(len(mesh.elements), 4, 0, file=file)
    for i, nodes in enumerate(mesh.elements):
        print(i, *nodes, file=file)
END
python3 "$source_folder/tests/faults/interrupt.py" || fail "what a signal leaves behind"
finish
