#!/usr/bin/env bash
# A node of thousands of elements with a minimum volume that half of them cannot reach: limits and signals
# hold, in the search for proofs and in the reports after it, and what was not decided is said.
. "$(dirname "$0")/common.sh"

# make_ball.py N OUT: a ball whose surface has 2 N^2 triangles of uneven sizes, around one node.
cat >make_ball.py <<'END'
import math
import sys
n, path = int(sys.argv[1]), sys.argv[2]
state = 4711


def random():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 33) / 2**31


points = [(0.1, 0.1, 0.1), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
for row in range(n):
    for column in range(n):
        z = 1 - 2 * (row + 0.6 + 0.7 * random()) / (n + 1)
        angle = 2 * math.pi * (column + 0.9 * random()) / n
        r = math.sqrt(1 - z * z)
        points.append((r * math.cos(angle), r * math.sin(angle), z))


def number(row, column):
    return 1 if row < 0 else 2 if row >= n else 3 + row * n + column % n


faces = []
for row in range(-1, n):
    for column in range(n):
        a, b = number(row, column), number(row, column + 1)
        c, d = number(row + 1, column), number(row + 1, column + 1)
        faces += [f for f in ((a, c, b), (b, c, d)) if len(set(f)) == 3]
with open(path, "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
    for p in points:
        file.write("%r %r %r 0\n" % p)
    file.write("Tetrahedra\n%d\n" % len(faces))
    for f in faces:
        file.write("1 %d %d %d 1\n" % tuple(i + 1 for i in f))
    file.write("End\n")
END

# Without limits: it ends, and each element is below or not, possible or not.
python3 make_ball.py 40 small.mesh
expect_status 1 "$program" smooth small.mesh -o out.mesh --min-volume-fraction 3e-4 --json report.json -q
expect_text "of these cannot reach it"
expect_json "0 < len(r['unfixable']) <= len(r['below_min']) and 'no time' not in r['reason']"
expect_json "r['stop'] == 'infeasible'"
for threads in 1 3; do
    expect_status 1 "$program" smooth small.mesh -o $threads.mesh --min-volume-fraction 3e-4 -q -j $threads
    cmp out.mesh $threads.mesh || fail "$threads threads give another mesh"
done

# With one: 31 000 elements, for which a look at all of them for each that is given up takes a minute.
python3 make_ball.py 125 large.mesh
begin=$SECONDS
expect_status 1 timeout 60 "$program" smooth large.mesh -o out.mesh --min-volume-fraction 3e-5 \
    --time-limit 0.2 --json report.json -q
[ $((SECONDS - begin)) -lt 15 ] || fail "the time limit took $((SECONDS - begin)) s"
expect_json "r['stop'] == 'time-limit' and r['seconds']['smooth'] < 5"
expect_text "stopped by the time limit"

# A signal.
begin=$SECONDS
"$program" smooth large.mesh -o out.mesh --min-volume-fraction 3e-5 --tolerance 0 --max-sweeps 100000000 \
    -vv >out 2>err &
wait_for "sweep" err
kill -INT $!
wait $!
[ $? -eq 1 ] || fail "a signal does not end it with status 1"
[ $((SECONDS - begin)) -lt 30 ] || fail "the signal took $((SECONDS - begin)) s"

finish
