#!/usr/bin/env bash
# The worst elements become better, at a price that is bounded and told; nothing becomes worse.
. "$(dirname "$0")/common.sh"

# check IN OUT [LIMIT]: by measures of our own the worst radius ratio and the smallest dihedral angle of
# OUT are no worse than those of IN, nodes and elements are as many, and the RMS is at most LIMIT.
check() {
    python3 - "$@" <<'END' || fail "worse: $*"
import math, sys
import mesh_file
old, new = (mesh_file.read(name) for name in sys.argv[1:3])


def angle(t):
    """The smallest dihedral angle of a tetrahedron."""
    smallest = math.inf
    for i, j, k, l in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)):
        e, u, v = ([b - a for a, b in zip(t[i], t[m])] for m in (j, k, l))
        u, v = ([a - mesh_file.dot(w, e) / mesh_file.dot(e, e) * b for a, b in zip(w, e)] for w in (u, v))
        cosine = mesh_file.dot(u, v) / math.sqrt(mesh_file.dot(u, u) * mesh_file.dot(v, v))
        smallest = min(smallest, math.acos(cosine))
    return smallest


def measures(mesh):
    corners = list(mesh_file.corners(mesh))
    ratios = [mesh_file.radius_ratio(t) for t in corners]
    return max(ratios), min(map(angle, corners)), mesh_file.rms(ratios)


assert old.elements == new.elements and min(mesh_file.volumes(new)) > 0
(ratio, smallest, _), (new_ratio, new_smallest, rms) = measures(old), measures(new)
assert new_ratio <= ratio * (1 + 1e-12) and new_smallest >= smallest - 1e-12
assert len(sys.argv) < 4 or rms <= float(sys.argv[3]) * (1 + 1e-9), rms
END
}

cp "$sample" bracket.msh
slide=(--slide auto) # or the worst of them all could not move
expect_status 0 "$program" smooth bracket.msh -o plain.msh "${slide[@]}" --json report.json
expect_json "r['worst'] is None and r['put_back'] == 0"
cp report.json plain.json
rms=$(python3 -c "import json; print(json.load(open('report.json'))['after']['rms_radius_ratio'])")
for measure in dihedral radius-ratio; do
    expect_status 0 "$program" smooth bracket.msh -o out.msh "${slide[@]}" --objective worst --worst-measure $measure \
        --json report.json -v
    grep -q "for the worst element" out || fail "what the worst has become should be said"
    grep -q "  worst$" err || fail "the sweeps for the worst should be told"
    expect_json "r['worst']['measure'] == '$measure' and r['worst']['sweeps'] > 0"
    expect_json "r['worst']['objective_before'] == json.load(open('plain.json'))['objective']['after']"
    expect_json "r['worst']['objective_after'] <= 1.01 * r['worst']['objective_before']"
    expect_json "[s['phase'] for s in r['sweeps']].count('worst') == r['worst']['sweeps']"
    # The other measure may go as far as the worst of the input.
    check bracket.msh out.msh "$(python3 -c "print(1.01 * $rms)")"
    key=$([ $measure = dihedral ] && echo min_dihedral_movable_deg || echo max_radius_ratio_movable)
    expect_json "abs(r['worst']['before'] / json.load(open('plain.json'))['after']['$key'] - 1) < 1e-9"
    expect_json "abs(r['worst']['after'] / r['after']['$key'] - 1) < 1e-9"
    expect_json "r['worst']['after'] $([ $measure = dihedral ] && echo '>' || echo '<') r['worst']['before']"
    cp out.msh one.msh
    for threads in 1 3 $(unless_quick 2); do
        expect_status 0 "$program" smooth bracket.msh -o out.msh "${slide[@]}" --objective worst --worst-measure $measure \
            -j $threads -q
        cmp -s one.msh out.msh || fail "other bytes on $threads threads"
    done
done
expect_status 0 "$program" smooth bracket.msh -o default.msh --objective worst -q
expect_status 0 "$program" smooth bracket.msh -o dihedral.msh --objective worst --worst-measure dihedral -q
cmp -s default.msh dihedral.msh || fail "dihedral should be the measure by default"
expect_status 0 "$program" smooth bracket.msh -o none.msh "${slide[@]}" --objective worst --worst-rise 0 --json report.json
check plain.msh none.msh "$rms"
expect_status 0 "$program" smooth bracket.msh -o out.msh --objective worst --objective mean-ratio --json report.json
expect_json "r['worst'] is None and r['objective']['name'] == 'mean-ratio'"

mapfile -t refused < <(some "--objective worst --worst-measure sine" "--objective worse" "--objective worst --worst-rise -1" \
    "--objective worst --worst-rise nan" "--objective worst --worst-rise 1e9" "--worst-rise 0.1" \
    "--worst-measure dihedral" "--method laplacian --objective worst")
for wrong in "${refused[@]}"; do
    # shellcheck disable=SC2086 # options and their values
    expect_status 64 "$program" smooth bracket.msh -o wrong.msh $wrong
    expect_one_line
    expect_no_file wrong.msh
done

# Meshes that their generators have optimised.
command -v gmsh >/dev/null && command -v tetgen >/dev/null || finish
grep -v '^Mesh.Optimize' "$source_folder/docs/examples/bracket.geo" >bracket.geo
if [ -z "${PLANISH_QUICK-}" ]; then
    gmsh -3 -v 1 -nt 1 bracket.geo -format mesh -o gmsh.mesh || fail "gmsh"
    gmsh -3 -v 1 -nt 1 -algo hxt bracket.geo -format mesh -o hxt.mesh || fail "gmsh -algo hxt"
fi
gmsh -2 -v 1 -nt 1 bracket.geo -format stl -o bracket.stl && tetgen -pqO9/7 -Q bracket.stl >/dev/null ||
    fail "tetgen -O"
# Without its faces and edges, whose numbers TetGen's own writer of this format gets wrong.
{
    echo MeshVersionFormatted 2 Dimension 3
    awk 'NR == 1 { print "Vertices", $1 } NR > 1 && $1 !~ /#/ { print $2, $3, $4, 0 }' bracket.1.node
    awk -v first="$(awk 'NR == 2 { print $1 }' bracket.1.node)" 'NR == 1 { print "Tetrahedra", $1 }
        NR > 1 && $1 !~ /#/ { print $2 + 1 - first, $3 + 1 - first, $4 + 1 - first, $5 + 1 - first, 0 }' \
        bracket.1.ele
    echo End
} >tetgen.mesh
more=("--slide auto --objective worst")
[ -n "${PLANISH_QUICK-}" ] || more+=("" "--objective worst")
for mesh in tetgen.mesh $(unless_quick gmsh.mesh hxt.mesh); do
    for options in "${more[@]}"; do
        # shellcheck disable=SC2086 # options and their values
        expect_status 0 "$program" smooth $mesh -o optimised.mesh -q $options
        check $mesh optimised.mesh
    done
done

finish
