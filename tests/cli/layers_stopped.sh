#!/usr/bin/env bash
# Rounds that hold nodes of layers, and a signal or the time limit: which result stands. A round that is stopped
# late stands, as it has its heights less far off; one that is stopped early does not. A round for which there is
# hardly time does not begin.
. "$(dirname "$0")/common.sh"

[ "$(uname)" = Linux ] || exit 77 # the size of pipes is Linux's

python3 "$cli/uneven_mesh.py" >uneven.mesh

# reader.py ROUND SWEEP WAIT COMMAND...: run it, and read its lines, of which it can be no more than 4096 bytes ahead: ten
# sweeps. After a sweep of a round stop reading for WAIT seconds; 0: send a signal. Print how many rounds there were.
cat >reader.py <<'END2'
import fcntl
import signal
import subprocess
import sys
import time

stop_round, stop_sweep, wait = int(sys.argv[1]), sys.argv[2].encode(), float(sys.argv[3])
run = subprocess.Popen(sys.argv[4:], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, bufsize=0)
fcntl.fcntl(run.stderr, 1031, 4096)  # F_SETPIPE_SZ
rounds = 0
for line in run.stderr:
    words = line.split()
    if len(words) != 7 or not words[0].isdigit():
        continue
    rounds += words[0] == b"1"
    if (rounds, words[0]) == (stop_round, stop_sweep):
        time.sleep(wait) if wait > 0 else run.send_signal(signal.SIGINT)
run.wait()
print(rounds)
END2

# stop ROUND SWEEP WAIT OPTION...: smooth with lines of colours; the number of rounds is in the file rounds.
stop() {
    python3 reader.py "$1" "$2" "$3" "$program" smooth uneven.mesh -o out.mesh -vv -j 1 --json report.json \
        --max-sweeps 30 --tolerance 0 "${@:4}" >rounds
}

# What the first round comes to: it does not end by itself, but by its 30 sweeps.
stop 0 0 0
[ "$(cat rounds)" -eq 8 ] || fail "there should be several rounds: $(cat rounds)"
expect_json 'r["stop"] == "max-sweeps" and 0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1'

stop 2 1 0
[ "$(cat rounds)" -eq 2 ] || fail "a signal ends the second round: $(cat rounds)"
expect_json 'r["stop"] == "interrupted" and len(r["sweeps"]) == 30 and r["layer_heights"]["held_nodes"] == 0'
expect_json 'r["layer_heights"]["min"] < 0.9 or r["layer_heights"]["max"] > 1.1'
mv out.mesh first.mesh

# In the last round all nodes of layers are held. Most of it is better than a round that lets heights go.
stop 8 17 0
[ "$(cat rounds)" -eq 8 ] || fail "a signal ends the last round late: $(cat rounds)"
expect_json 'r["stop"] == "interrupted" and 17 <= len(r["sweeps"]) < 30'
expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1'
stop 8 1 0
[ "$(cat rounds)" -eq 8 ] || fail "a signal ends the last round early: $(cat rounds)"
expect_json 'r["stop"] == "interrupted" and len(r["sweeps"]) == 30 and r["layer_heights"]["max"] > 1.1'

# The first round takes two thirds of the time and more, as nobody reads its lines.
stop 1 1 4.5 --time-limit 6
[ "$(cat rounds)" -eq 1 ] || fail "there is hardly time for a second round: $(cat rounds)"
expect_json 'r["stop"] == "time-limit" and len(r["sweeps"]) == 30'
cmp -s out.mesh first.mesh || fail "the first round stands"

finish
