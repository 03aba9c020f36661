#!/usr/bin/env bash
# docs/examples/meshers/salome_smooth.py with stand-ins for Salome's modules, which Debian does not have.
. "$(dirname "$0")/common.sh"
"$program" quality "$PLANISH_SOURCE/tests/data/cube.med" >/dev/null 2>&1 ||
    { echo "without HDF5 (MED files)"; exit 77; }
PATH=$(cd "$(dirname "$program")" && pwd):$PATH
mkdir -p "$work/salome/smesh"
touch "$work/salome/__init__.py" "$work/salome/smesh/__init__.py"
cat >"$work/salome/smesh/smeshBuilder.py" <<'END'
class Mesh:
    def __init__(self, path):
        self.content = open(path, "rb").read()

    def ExportMED(self, path):
        with open(path, "wb") as file:
            file.write(self.content)


class New:
    def CreateMeshesFromMED(self, path):
        return [Mesh(path)], None
END
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$work:$examples python3 - "$PLANISH_SOURCE/tests/data/cube.med" "$work/out.med" \
    >"$work/out.log" 2>&1 <<'END' || fail "salome_smooth"
import sys
from salome.smesh.smeshBuilder import Mesh
from salome_smooth import smooth
given = Mesh(sys.argv[1])
open(sys.argv[2], "wb").write(smooth(given, "--slide", "auto").content)
try:
    smooth(given, "--nothing")
except RuntimeError:
    sys.exit(0)
sys.exit("a wrong option passes")
END
"$program" smooth "$PLANISH_SOURCE/tests/data/cube.med" -o "$work/expected.med" --slide auto >"$work/smooth.log" 2>&1
cmp "$work/out.med" "$work/expected.med" || fail "another mesh"
cmp -s "$work/out.med" "$PLANISH_SOURCE/tests/data/cube.med" && fail "the mesh is as it was"
echo ok
