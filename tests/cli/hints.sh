#!/usr/bin/env bash
# The line after a run that names the option which would help more: where there is one, and what it promises.
. "$(dirname "$0")/common.sh"

cp "$sample" a.msh
hint() {
    expect_status 0 "$program" smooth a.msh -o out.msh "$@"
    grep "^hint: " out
}
angle() {
    sed -n 's/^smallest dihedral angle *[^ ]* *\([^ ]*\) .*/\1/p' out
}
is_above() { # A B: whether number A is above B
    python3 -c 'import sys; sys.exit(not float(sys.argv[1]) > float(sys.argv[2]))' "$1" "$2"
}

# The worst element is held: nodes that slide let it go.
[ "$(hint)" = "hint: the worst element has no movable node; --slide auto lets 1152 nodes slide" ] || fail "hint: $(hint)"
hint >hints
held=$(angle)
hint --slide auto >hints
grep -q "^hint: --objective worst may improve " hints || fail "hint with --slide auto: $(cat hints)"
is_above "$(angle)" "$held" || fail "--slide auto does not help"
slid=$(angle)
hint --slide auto --objective worst >hints
is_above "$(angle)" "$slid" || fail "--objective worst does not help"
! grep -q "objective" hints || fail "what was given is a hint: $(cat hints)"

# None with --quiet, among data, of another method's result, nor of a good mesh.
for options in "-q" "--method laplacian --max-sweeps 0" "--like a.msh"; do
    # shellcheck disable=SC2086
    "$program" smooth a.msh -o out.msh $options >out 2>err
    ! grep -q "^hint" out err || fail "a hint with $options"
done
"$program" smooth a.msh -o out.msh --json - 2>err | grep -q "^hint" && fail "a hint among data"
grep -q "^hint: " err || fail "no hint beside data"
python3 "$cli/make_mesh.py" 4 0.05 good.mesh || exit 1
expect_status 0 "$program" smooth good.mesh -o out.mesh
! grep -q "^hint" out || fail "a hint on a good mesh: $(cat out)"
finish
