#!/usr/bin/env bash
# Node by node as good as all nodes at once by IPOPT (bench/paper/global.c), from the same start, with
# the minimum volume far away and with many elements on it.
. "$(dirname "$0")/common.sh"

[ -x "${PLANISH_GLOBAL:-}" ] || { echo "paper_global was not built: IPOPT is missing"; exit 77; }
python3 "$cli/make_mesh.py" 4 0.25 even.mesh
python3 "$cli/grade_mesh.py" even.mesh cube.mesh

for fraction in 0.0006 0.001 0.0012; do
    "$PLANISH_GLOBAL" cube.mesh global.mesh --min-volume-fraction $fraction >global.json 2>err ||
        fail "the global solver, $fraction"
    expect_status 0 "$program" smooth cube.mesh -o out.mesh --min-volume-fraction $fraction \
        --json report.json -q
    expect_json "r['after']['below_min_volume'] == 0"
    expect_json "r['kkt']['residual'] < 0.01 and (r['kkt']['active'] > 0) == ($fraction > 0.0008)"
    python3 - <<'END' || fail "node by node and all at once differ at $fraction"
import json
report, reference = json.load(open("report.json")), json.load(open("global.json"))
assert reference["status"] == 0, reference
ours, theirs = report["objective"]["after"], reference["objective"]["after"]
assert abs(ours / theirs - 1) < 5e-4, (ours, theirs)
END
done
finish
