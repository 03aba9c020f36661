#!/usr/bin/env bash
# Known meshes, judged by an independent program: RMS radius ratio at convergence, nothing inverted,
# boundary unmoved, connectivity the same, F falling. Needs PLANISH_MESHES, the oracle beside it
# and numpy.
. "$(dirname "$0")/common.sh"

oracle=${PLANISH_MESHES-}/../tools/oracle.py
python=/usr/bin/python3
if [ -z "${PLANISH_MESHES-}" ] || [ ! -f "$oracle" ]; then
    echo "skipped: the meshes or the oracle are not here"
    exit 77
fi
"$python" -c "import numpy, meshio" 2>/dev/null || { echo "skipped: no numpy or meshio"; exit 77; }

# judge MESH RMS: smooth it with the defaults.
judge() {
    local out=out.${1##*.}
    rm -f out.*
    expect_status 0 "$program" smooth "$PLANISH_MESHES/$1" -o "$out" --json report.json -q
    "$python" "$oracle" "$out" --ref "$PLANISH_MESHES/$1" --json >oracle.json ||
        { fail "$1: the oracle cannot read the result"; return; }
    "$python" - "$1" "$2" <<'END' || fail "$1"
import json, sys
name, bound = sys.argv[1], float(sys.argv[2])
seen, report = json.load(open("oracle.json")), json.load(open("report.json"))
print("%-26s RMS %.5f (at most %g), max %.4g, smallest angle %.4g" %
      (name, seen["rms_rr"], bound, seen["max_rr"], seen["min_ang"]))
assert seen["inverted"] == 0 and report["certified"]
assert seen["rms_rr"] <= bound
assert seen["bnd_moved"] == 0 and seen["conn_exact"]
assert report["stop"] == "converged"
assert abs(report["after"]["rms_radius_ratio"] / seen["rms_rr"] - 1) < 1e-6
assert report["after"]["max_radius_ratio"] <= report["before"]["max_radius_ratio"]
rms = [report["before"]["rms_radius_ratio"]] + [s["rms"] for s in report["sweeps"]]
assert all(b <= a * (1 + 1e-12) for a, b in zip(rms, rms[1:]))
END
}

judge paper_c_cubeincube.msh 1.4405
judge part_10k.msh 1.7305
judge part_10k_tg.mesh 1.5215
judge part_100k.mesh 1.3785
judge part_100k_pert.mesh 1.3785
judge msq_tire.vtk 1.6240
judge stellar_house2.node 1.5225
finish
