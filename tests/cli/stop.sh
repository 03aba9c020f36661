#!/usr/bin/env bash
# Ends before convergence: the mesh is written, the status is 1 and the reason is told; a second
# signal ends at once.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 24 0.2 in.mesh || exit 1
python3 "$cli/make_slow_mesh.py" 150 slow.mesh || exit 1

# json EXPRESSION: the report.json is such that it holds.
json() {
    python3 -c "import json; r = json.load(open('report.json')); assert $1, r['stop']" ||
        fail "report: $1"
}

for limit in 0.001 1e-9; do
    expect_status 1 "$program" smooth in.mesh -o out.mesh --time-limit $limit --json report.json -q
    expect_one_line
    expect_text "time limit"
    json "r['stop'] == 'time-limit' and 'time limit' in r['reason'] and r['certified']"
    "$program" quality out.mesh -q || fail "the mesh after a time limit is readable"
    rm -f out.mesh report.json
done
expect_status 0 "$program" smooth in.mesh -o out.mesh --max-sweeps 1 --json report.json -q
json "r['stop'] == 'max-sweeps' and r['reason'] == '' and len(r['sweeps']) == 1"
expect_status 0 "$program" smooth in.mesh -o out.mesh --max-sweeps 0 --json report.json -q
json "r['stop'] == 'max-sweeps' and r['moved_nodes'] == 0"
cmp in.mesh out.mesh || fail "no sweep, no change"
rm -f out.mesh report.json

# As good as: some ten seconds. With bounds there is no help for slow meshes.
endless=(--tolerance 0 --max-sweeps 2000000000 -j 1 --box=-9,-9,9,9)

# start OUT: an endless run in the background; returns once it is sweeping. Jobs of a script have
# SIGINT ignored unless it is reset.
start() {
    rm -f err
    env --default-signal=INT,TERM "$program" smooth slow.mesh -o "$1" "${endless[@]}" \
        --json report.json -v >out 2>err &
    run=$!
    wait_for "  smoothing" err
}

for signal in INT TERM; do
    rm -f out.mesh report.json
    start out.mesh
    if kill -$signal $run 2>/dev/null; then
        wait $run
        status=$?
        [ $status -eq 1 ] || fail "SIG$signal: status $status instead of 1"
        json "r['stop'] == 'interrupted' and 'interrupted' in r['reason']"
        json "r['after']['rms_radius_ratio'] <= r['before']['rms_radius_ratio']"
        json "r['after']['inverted'] == 0"
    else
        fail "the run ended before it could be interrupted"
    fi
done

# Before smoothing begins, a signal ends the program with one line. A pipe without an end keeps it reading.
mkfifo endless.mesh
for signal in INT TERM HUP; do
    rm -f err
    env --default-signal=INT,TERM,HUP "$program" smooth endless.mesh -o before.mesh --json before.json >out 2>err &
    run=$!
    exec 9>endless.mesh # returns as soon as planish has opened the pipe
    kill -$signal $run
    wait $run
    status=$?
    exec 9>&-
    [ $status -eq $((128 + $(kill -l $signal))) ] || fail "SIG$signal before smoothing: status $status"
    expect_one_line
    expect_text "planish: endless.mesh: interrupted by a signal before smoothing began; nothing was written"
    expect_no_file before.mesh before.json
done
rm -f err
env --default-signal=TERM "$program" convert endless.mesh before.msh >out 2>err &
run=$!
exec 9>endless.mesh
kill -TERM $run
wait $run
exec 9>&-
expect_one_line
expect_text "planish: endless.mesh: interrupted by a signal"
expect_no_file before.msh
rm endless.mesh

# Of several meshes the rest is not smoothed; a mesh that failed before counts more than that.
echo "no mesh" >wrong.mesh
rm -f err
env --default-signal=INT,TERM "$program" smooth wrong.mesh slow.mesh in.mesh --output-dir several "${endless[@]}" \
    -v >out 2>err &
run=$!
wait_for "  smoothing" err
kill -INT $run
wait $run
status=$?
[ $status -eq 2 ] || fail "several meshes and a signal: status $status instead of 2"
expect_text "in.mesh (and 0 more): not smoothed, because a signal stopped planish"
[ -e several/slow.mesh ] && [ ! -e several/in.mesh ] || fail "several meshes and a signal: $(ls several)"

# The second one: the first makes it write, and the pipe keeps it there, as nobody reads.
mkfifo pipe.mesh
for signal in INT TERM; do
    start pipe.mesh
    kill -$signal $run
    sleep 0.3
    kill -0 $run 2>/dev/null || fail "SIG$signal: the run should wait for a reader"
    kill -$signal $run
    wait $run
    status=$?
    [ $status -eq $((128 + $(kill -l $signal))) ] || fail "second SIG$signal: status $status"
done

# A signal that the parent had ignored stays ignored.
rm -f err
env --ignore-signal=INT --default-signal=TERM "$program" smooth slow.mesh -o out.mesh \
    "${endless[@]}" -v >out 2>err &
run=$!
wait_for "  smoothing" err
kill -INT $run
sleep 0.2
kill -0 $run 2>/dev/null || fail "an ignored SIGINT should stay ignored"
kill -TERM $run
wait $run
[ $? -eq 1 ] || fail "SIGTERM beside an ignored SIGINT"

# The input becomes shorter before the signal makes planish write: its name is told.
cp slow.mesh shrinking.mesh
rm -f out.mesh err
"$program" smooth shrinking.mesh -o out.mesh "${endless[@]}" -v >out 2>err &
run=$!
wait_for "  smoothing" err
: >shrinking.mesh
kill -TERM $run
wait $run
status=$?
[ $status -eq 2 ] || fail "shrinking input: status $status instead of 2"
[ "$(grep -c '^planish: shrinking.mesh: became shorter' err)" -eq 1 ] ||
    fail "shrinking input: one line expected"
[ "$(find . -name '*out.mesh*' | wc -l)" -eq 0 ] || fail "shrinking input: something was written"

# The same of one so large that it is mapped (zeros behind the mesh make it so), while it is being
# written: the pipe keeps planish there, as nobody reads, and then it looks at what is gone.
python3 "$cli/make_mesh.py" 32 0.2 large.mesh
truncate -s 80M large.mesh
rm -f err pipe.mesh
mkfifo pipe.mesh
"$program" smooth large.mesh -o pipe.mesh -j 1 --max-sweeps 2 -v >out 2>err &
run=$!
{
    dd bs=1000 count=1 of=head.txt 2>/dev/null
    : >large.mesh
    cat >/dev/null
} <pipe.mesh
wait $run
status=$?
[ $status -eq 2 ] || fail "shrinking mapped input: status $status instead of 2"
[ "$(grep -c '^planish: large.mesh: became shorter' err)" -eq 1 ] ||
    fail "shrinking mapped input: one line that names it expected: $(tail -n 2 err)"
rm -f large.mesh pipe.mesh

# Inverted elements that are left alone: status 1, how many there are, and the rest is smoothed.
python3 "$cli/make_mesh.py" 8 0.9 tangled.mesh
expect_status 1 "$program" smooth tangled.mesh -o out.mesh --no-untangle --json report.json -q
expect_one_line
expect_text "inverted"
json "r['before']['inverted'] > 0 and not r['certified']"
json "r['after']['inverted'] == r['before']['inverted'] and str(r['after']['inverted']) in r['reason']"
expect_status 0 "$program" quality tangled.mesh
finish
