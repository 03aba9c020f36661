#!/usr/bin/env bash
# What is told on a terminal and what elsewhere: colours, the line that is written over, -v, -vv and -q.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 24 0.2 in.mesh || exit 1
python3 "$cli/make_mesh.py" 10 0.9 tangled.mesh || exit 1
python3 "$cli/make_slow_mesh.py" 60 slow.mesh || exit 1
cp "$sample" bracket.msh
unset NO_COLOR
export TERM=xterm LC_ALL=C.UTF-8

# on_terminal STATUS COLUMNS COMMAND...: what it writes is in raw, what one sees in the end in screen
on_terminal() {
    local wanted=$1 columns=$2 status
    shift 2
    python3 "$cli/terminal.py" "$columns" raw screen "$@"
    status=$?
    [ $status -eq "$wanted" ] || fail "status $status instead of $wanted on $columns columns: $*"
}
escape=$(printf '\033')
coloured() {
    grep -q "$escape\[[0-9;]*m" "$1"
}
narrow() { # FILE [COLUMNS]
    python3 - "$1" "${2-80}" <<'END' || fail "$1 is wider than ${2-80} columns, or has trailing blanks"
import sys
lines, most = open(sys.argv[1], encoding="utf-8").read().split("\n"), int(sys.argv[2])
assert lines and all(len(line) <= most and line == line.rstrip() for line in lines), \
    [line for line in lines if len(line) > most or line != line.rstrip()]
END
}

# Better is green, worse red, headings are bold; the same words as in a pipe.
on_terminal 0 80 "$program" smooth bracket.msh -o out.msh
coloured raw || fail "no colours on a terminal"
grep -q "$escape\[32m *10.448" raw && grep -q "$escape\[1m *before" raw || fail "better, heading: $(cat -v raw)"
narrow screen
grep -q "worst radius ratio .* better$" screen || fail "the table on a terminal: $(cat screen)"
grep -q "█" screen || fail "no blocks where the locale has them"
! grep -q "reading\|smoothing, sweep\|writing \[" screen || fail "the line was not cleared: $(cat screen)"
for phase in reading planning measuring "smoothing, sweep 1" writing; do
    grep -q "$phase.* \[[#.]*\] .* %" raw || fail "the line never told $phase"
done
expect_status 0 "$program" smooth bracket.msh -o out.msh
[ ! -s err ] || fail "something on standard error in a pipe: $(cat err)"
! coloured out || fail "colours in a pipe"
narrow out
LC_ALL=C on_terminal 0 80 "$program" smooth bracket.msh -o out.msh
cmp <(grep -v " s: " out) <(grep -v " s: " screen) || fail "another table on a terminal than in a pipe"
! grep -q "[^[:print:]]" screen || fail "blocks where the locale has none"
on_terminal 0 80 "$program" smooth in.mesh -o out.mesh --method laplacian --fix 1 --max-sweeps 1
! grep -q "better\|worse" screen || fail "nothing moved, and something became better or worse"
on_terminal 1 80 "$program" smooth bracket.msh -o out.msh --method laplacian --max-sweeps 1
grep -q "$escape\[31m[^$escape]*worse$escape" raw || fail "what is worse is not red: $(cat screen)"

# Narrow terminals get all lines within 60 columns, wide ones nothing else than 80.
cp "$source_folder"/tests/data/square.msh . || exit 1
python3 "$cli/types_mesh.py" block mixed 4 0.2 mixed.vtk || fail "no mesh"
mapfile -t commands < <(some "smooth bracket.msh -o out.msh --objective worst" "smooth bracket.msh -o out.msh --slide curved" \
    "smooth mixed.vtk -o out.vtk" "quality mixed.vtk --worst 3" "smooth in.mesh -o out.mesh" \
    "quality bracket.msh --worst 3" "quality bracket.msh mixed.vtk --min-volume 1e-9" "quality bracket.msh square.msh" \
    bracket.msh "compare in.mesh out.mesh" "groups bracket.msh")
for command in "${commands[@]}"; do
    # shellcheck disable=SC2086
    on_terminal 0 60 "$program" $command
    grep -v "^hint: \|^note: " screen >lines
    narrow lines 60
done
on_terminal 0 120 "$program" smooth bracket.msh -o out.msh
narrow screen 80
on_terminal 0 60 "$program" smooth bracket.msh -o out.msh
grep -q "worst radius ratio  *98.386  *[0-9.]* .*better$" screen || fail "the narrow table: $(cat screen)"

# Notes and errors.
cp "$source_folder"/tests/data/tetgen.* .
on_terminal 64 80 "$program" smoth
grep -q "^$escape\[1;31mplanish:$escape\[0m unknown" raw || fail "errors are not red: $(cat -v raw)"
on_terminal 2 80 "$program" quality absent.msh
[ "$(grep -c . screen)" -eq 1 ] && grep -q "^planish: absent.msh" screen || fail "line and error: $(cat screen)"
on_terminal 0 80 "$program" smooth bracket.msh -o view.vtu
grep -q "$escape\[33mnote: " raw && grep -q "^note: view.vtu" screen || fail "notes are not yellow: $(cat -v raw)"

# No colours where they are not wanted; no line, either, on what cannot be written over.
cp "$source_folder/tests/data/square.msh" .
mapfile -t commands < <(some "smooth bracket.msh -o out.msh" "quality bracket.msh square.msh")
for setting in "NO_COLOR=1" "TERM=dumb" "-u TERM"; do
    for command in "${commands[@]}"; do
        # shellcheck disable=SC2086
        on_terminal 0 80 /usr/bin/env $setting "$program" $command
        ! coloured raw || fail "colours with $setting: $command"
        [ "$setting" = NO_COLOR=1 ] || ! grep -q "reading\|$escape" raw || fail "a line with $setting: $command"
    done
done
on_terminal 0 80 /usr/bin/env NO_COLOR= "$program" quality bracket.msh square.msh
coloured raw || fail "an empty NO_COLOR says nothing"
grep -q "$escape\[1m *1.614" raw || fail "the best value is not bold: $(cat -v raw)"
narrow screen

# A comparison has the room that the terminal has; names that are cut and the same stand on lines of their own.
long=$(printf 'x%.0s' $(seq 40))
for i in 1 2; do
    cp square.msh "$long$i$long.msh"
done
cp square.msh 網格曲面網格曲面網格曲面.msh
on_terminal 0 80 "$program" quality "$long"?"$long.msh" square.msh 網*.msh
for i in 1 2; do
    grep -q "^$long$i$long.msh\$" screen || fail "the whole name: $(cat screen)"
done
grep -q "^square.msh  *375 " screen || fail "a short name: $(cat screen)"
python3 - <<'END' || fail "wide characters: $(cat screen)"
line = [line for line in open("screen", encoding="utf-8").read().split("\n") if line.startswith("網")][0]
name = line.split()[0]
assert "..." in name and name.endswith(".msh")
wide = sum(ord(c) > 0x1100 for c in line)
head = [line for line in open("screen", encoding="utf-8").read().split("\n") if line.startswith("file")][0]
assert line.index(" 375") + 4 + wide == head.index("elements") + len("elements"), line
assert len(name) + sum(ord(c) > 0x1100 for c in name) in (19, 20, 21), name # the middle is whole
END
on_terminal 0 150 "$program" quality "$long"?"$long.msh" square.msh
grep -q "^${long}1$long.msh  *375 " screen || fail "a name where there is room: $(cat screen)"
awk 'length($0) > 150 { exit 1 }' screen || fail "wider than the terminal"

# -q is silent, and so is everything but the mesh where standard output takes it.
on_terminal 0 80 "$program" smooth bracket.msh -o out.msh -q
[ ! -s raw ] || fail "-q on a terminal: $(cat -v raw)"
on_terminal 0 80 "$program" quality bracket.msh square.msh -q
[ ! -s raw ] || fail "quality -q on a terminal: $(cat -v raw)"

# Narrow and odd terminals: never wider than they are, and nothing left behind. (The table is of 80 columns.)
for columns in $(some 20 80 5 200 60 40); do
    on_terminal 0 $columns /bin/sh -c "exec '$program' smooth in.mesh -o out.mesh >/dev/null"
    grep -q "$escape\[K" raw || fail "no line on $columns columns"
    [ ! -s screen ] || [ -z "$(tr -d '\n' <screen)" ] || fail "left on $columns columns: $(cat screen)"
    python3 - $columns <<'END' || fail "the line on $columns columns: $(tr '\r' '\n' <raw)"
import re, sys
# Parts are there or not, and none is cut; the bar is always the same, or never there.
lines = [line for line in open("raw", encoding="utf-8", newline="").read().replace("\x1b[K", "").split("\r") if line]
bars = {len(found.group()) if found else 0 for found in (re.search(r"\[[#.]*\]", line) for line in lines)}
assert len(bars) <= 1, bars
columns = int(sys.argv[1])
assert bars <= {0} if columns < 40 else 0 not in bars, bars
for line in lines:
    assert re.fullmatch(r"[a-z]+(, sweep \d+)?( \[[#.]*\] +\d+ %)?(, RMS [\d.]+(, about [\d:]+ (s|min|h) left)?)?", line), line
    assert columns < 70 or "sweep" not in line or "RMS" in line, line
END
done

# The bar never goes back; while elements are inverted the line tells how many.
meshes=(in.mesh tangled.mesh slow.mesh)
if [ -z "${PLANISH_QUICK-}" ]; then
    python3 "$cli/make_mesh.py" 44 0.2 large.mesh || exit 1
    meshes+=("large.mesh -j 1 --tolerance 1e-9")
fi
for mesh in "${meshes[@]}"; do
    # shellcheck disable=SC2086
    on_terminal 0 80 "$program" smooth $mesh -o out.mesh
    python3 - "$mesh" <<'END' || fail "the line of $mesh: $(tr '\r' '\n' <raw | grep '\[[#.]*\]')"
import re, sys
lines = [line for line in re.split(r"[\r\n]", open("raw", encoding="utf-8").read()) if "] " in line and " %" in line]
shares = [int(re.search(r"(\d+) %", line).group(1)) for line in lines]
assert len(shares) >= 5 and shares == sorted(shares) and shares[0] == 0 and 90 <= shares[-1] <= 100, shares
for line in lines:
    bar, share = re.search(r"\[([#.]*)\] +(\d+) %", line).groups()
    assert abs(bar.count("#") / len(bar) - int(share) / 100) <= 1 / len(bar) + 0.01, line
    assert len(line) <= 79 + len("\x1b[K"), line
    if "untangling" in line:
        assert "inverted" in line and "RMS" not in line and "left" not in line, line
    # Nothing is told of the time left until sweeps have been done.
    told, sweep = re.search(r"about .* left", line), re.search(r"sweep (\d+)", line)
    assert not told or int(sweep.group(1)) > 3, line
    assert not told or re.search(r"about (\d+ s|\d+:\d\d min|\d+:\d\d h) left", line), line
if sys.argv[1] == "tangled.mesh":
    assert any(re.search(r"untangling.* \d+ inverted", line) for line in lines), lines
END
done

# A signal while it is shown leaves nothing of it; the table tells the rest.
SIGNAL="INT:smoothing, sweep" on_terminal 1 80 "$program" smooth slow.mesh -o out.mesh --tolerance 0 \
    --max-sweeps 2000000000 --box=-9,-9,9,9
grep -q "^interrupted after" screen || fail "interrupted: $(cat screen)"
! grep -q "smoothing, sweep\|\] .* %" screen || fail "interrupted, and the line is still there: $(cat screen)"
# While it reads from a pipe that nobody writes to, it ends at once.
mkfifo pipe.msh
SIGNAL="INT:reading" on_terminal 130 80 "$program" smooth pipe.msh -o out.msh
! grep -q reading screen || fail "interrupted while it reads, and the line is still there: $(cat -v screen)"
grep -q "^planish: pipe.msh: interrupted by a signal before smoothing began" screen || fail "interrupted: $(cat -v screen)"

# -v: a line per sweep in columns below their names. -vv: one per colour as well.
mapfile -t options < <(some "-vv --min-volume 1e-9" -v "-v --verbose" "-v --objective mean-ratio" -vv "-v --min-volume 1e-9")
for mesh in in.mesh tangled.mesh; do
    for option in "${options[@]}"; do
        # shellcheck disable=SC2086
        expect_status 0 "$program" smooth $mesh -o out.mesh $option --json report.json
        narrow err
        python3 - "$option" <<'END' || fail "$option of $mesh: $(head -n 30 err)"
import json, re, sys
r, lines = json.load(open("report.json")), open("err").read().split("\n")
begin = next(i for i, line in enumerate(lines) if line.startswith("sweep "))
head = lines[begin].split()
sweeps = [line for line in lines[begin + 1:] if re.match(r" *\d+ ", line)]
colours = [line for line in lines[begin + 1:] if re.match(r" +(colour \d+/|step)", line)]
assert len(sweeps) == len(r["sweeps"])
for i, (line, sweep) in enumerate(zip(sweeps, r["sweeps"])):
    row = dict(zip(head, line.split()))
    assert row["sweep"] == str(i + 1) and row["inverted"] == str(sweep["inverted"])
    assert row["visits"] == str(sweep["visits"]) and row["RMS"] == "%.6g" % sweep["rms"]
    assert row["phase"] == {"untangle": "untangling", "smooth": "smoothing"}[sweep["phase"]]
    if "--objective" in sys.argv[1]:
        assert "movable" not in row and row["F"] == "%.6g" % sweep["objective"]
    else:
        assert row["movable"] == "%.6g" % sweep["rms_movable"]
    assert ("below" in row) == ("--min-volume" in sys.argv[1])
    assert line.index(row["phase"]) == lines[begin].index("phase")
if sys.argv[1].startswith("-v ") and "--verbose" not in sys.argv[1] or sys.argv[1] == "-v":
    assert not colours
elif r["untangling_sweeps"] == 0: # untangling has calls besides those of the colours
    n, total, sums = r["mesh"]["colours"], 0, []
    assert len(colours) == n * len(sweeps)
    assert all(" colour %d/%d " % (i % n + 1, n) in line for i, line in enumerate(colours))
    for line in lines[begin + 1:]:
        if line in colours:
            total += int(line.split()[2])
        elif line in sweeps:
            sums.append(total)
            total = 0
    assert sums == [sweep["visits"] for sweep in r["sweeps"]]
else: # its steps are of no colour: they are counted in each sweep, as are the colours
    assert any(" step 2 " in line for line in colours)
    wanted = {"colour": 1, "step": 1}
    for line in lines[begin + 1:]:
        if line in sweeps:
            wanted = {"colour": 1, "step": 1}
        elif line in colours:
            kind, number = line.split()[:2]
            assert int(number.split("/")[0]) == wanted[kind], line
            wanted[kind] += 1
END
    done
done
expect_status 0 "$program" smooth in.mesh -o out.mesh -v -q
[ ! -s out ] && [ ! -s err ] || fail "-q after -v"
on_terminal 0 80 "$program" smooth in.mesh -o out.mesh -v
! grep -q "reading \[" raw || fail "-v and a line"
grep -q "$escape\[1msweep " raw || fail "the heading of -v is not bold"
finish
