#!/usr/bin/env bash
# Where the mesh may go: over its input, through links, into pipes and devices; modes are kept.
. "$(dirname "$0")/common.sh"

cp "$sample" in.msh
expect_status 0 "$program" smooth in.msh -o out.msh -q
[ ! -s out ] && [ ! -s err ] || fail "-q should print nothing"
cmp -s in.msh out.msh && fail "nothing was smoothed"
cmp in.msh "$sample" || fail "the input was changed"

# Everything but coordinates of inner nodes is the same, byte by byte.
python3 - <<'END' || fail "more than coordinates changed"
old, new = (open(name, "rb").read().split(b"\n") for name in ("in.msh", "out.msh"))
assert len(old) == len(new)
begin, end = old.index(b"$Nodes"), old.index(b"$EndNodes")
changed = [i for i in range(len(old)) if old[i] != new[i]]
assert changed and begin < changed[0] and changed[-1] < end
assert all(len(old[i].split()) == len(new[i].split()) == 3 for i in changed)
END

# Over itself.
cp in.msh same.msh
expect_status 0 "$program" smooth same.msh -o same.msh -q
cmp same.msh out.msh || fail "OUT = IN gives another mesh"

# A name without extension, or with that of another format: fine if the output has the same.
cp in.msh plain
expect_status 0 "$program" smooth plain -o plain -q
cmp plain out.msh || fail "a name without extension"
cp in.msh odd.vtk
expect_status 0 "$program" smooth odd.vtk -o odd_out.vtk -q
cmp odd_out.vtk out.msh || fail "a name with another extension"

# A report appended to a log leaves what is in it; one that would land on the mesh is refused.
echo "first line" >log
"$program" quality in.msh -q --json /dev/stdout >>log || fail "report to a log"
head -n 1 log | grep -q "first line" || fail "the log was replaced"
expect_status 64 "$program" smooth in.msh -o absent.msh --json ./absent.msh -q
ln -s absent.msh absent.json
expect_status 64 "$program" smooth in.msh -o absent.msh --json absent.json -q
expect_status 64 "$program" quality in.msh --json absent.json --report absent.msh -q
expect_no_file absent.msh
cp "$source_folder/tests/data/tetgen.node" mesh.node
cp "$source_folder/tests/data/tetgen.ele" mesh.ele
cp mesh.node MESH.NODE
cp mesh.ele MESH.ELE
cp mesh.node mesh.txt
cp mesh.ele mesh.txt.ele
for report in "mesh.node mesh.ele" "mesh.ele mesh.neigh" "MESH.NODE MESH.ELE" "MESH.NODE MESH.face"; do
    expect_status 64 "$program" quality ${report% *} --json "${report#* }" -q
    expect_text "would overwrite the mesh"
done
expect_status 64 "$program" quality mesh.txt --format tetgen --json mesh.txt.ele -q
expect_status 64 "$program" smooth mesh.node -o other.node --json other.neigh -q
expect_no_file other.node mesh.neigh MESH.face
cmp MESH.ELE "$source_folder/tests/data/tetgen.ele" || fail "MESH.ELE"

# What writing would fail for is said before the work: a name that is too long, a file in its way.
expect_status 2 "$program" smooth in.msh -o "$(printf 'a%.0s' $(seq 300)).msh" -v
expect_one_line
expect_text "too long"
printf '1 1\n' >other.face
expect_status 2 "$program" smooth mesh.node -o other.node -v
expect_one_line
expect_text "other.face: belongs to another mesh"
rm other.face

# The longest name that a file can have.
long=$(printf 'x%.0s' $(seq 251)).msh
expect_status 0 "$program" smooth in.msh -o "$long" -q
cmp "$long" out.msh || fail "a long name"

# A limit on the size of files is like a full disk.
expect_status 2 bash -c "ulimit -f 20; exec \"$program\" smooth in.msh -o limited.msh -q"
expect_one_line
expect_no_file limited.msh*

# Files of another TetGen mesh are not silently joined to the one that is written.
cp "$source_folder"/tests/data/tetgen.* .
echo "0 1" >stale.face
expect_status 2 "$program" smooth tetgen.node -o stale.node -q
expect_text "stale.face"
expect_no_file stale.node stale.ele

# Through symbolic links, which stay links; one that leads nowhere yet makes the file.
mkdir elsewhere
cp in.msh elsewhere/target.msh
ln -s elsewhere/target.msh link.msh
expect_status 0 "$program" smooth in.msh -o link.msh -q
[ -L link.msh ] && cmp elsewhere/target.msh out.msh || fail "symbolic link"
ln -s elsewhere/new.msh new.msh
expect_status 0 "$program" smooth in.msh -o new.msh -q
[ -L new.msh ] && cmp elsewhere/new.msh out.msh || fail "symbolic link to a new file"

# Modes: kept if there is a file, those of the umask if not.
cp in.msh mode.msh
chmod 640 mode.msh
expect_status 0 "$program" smooth in.msh -o mode.msh -q
[ "$(stat -c %a mode.msh)" = 640 ] || fail "mode $(stat -c %a mode.msh) instead of 640"
expect_status 0 bash -c "umask 027; exec \"$program\" smooth in.msh -o fresh.msh --json fresh.json -q"
[ "$(stat -c %a fresh.msh)" = 640 ] || fail "mode $(stat -c %a fresh.msh) of a new file"
[ "$(stat -c %a fresh.json)" = 640 ] || fail "mode $(stat -c %a fresh.json) of a new report"

# Pipes and devices; the table keeps out of the way.
"$program" smooth in.msh -o /dev/stdout 2>err | cat >piped.msh
[ "${PIPESTATUS[0]}" -eq 0 ] && cmp piped.msh out.msh || fail "pipe"
expect_text "worst radius ratio"
expect_status 0 "$program" smooth in.msh -o /dev/null
grep -q "worst radius ratio" out || fail "table on standard output"
[ -c /dev/null ] || fail "/dev/null was replaced"
"$program" smooth in.msh -o /dev/stdout -q >redirected.msh
cmp redirected.msh out.msh || fail "standard output that is a file"
# But not onto the input, which is still read then.
cp in.msh both.msh
expect_status 2 bash -c '"$0" smooth both.msh -o /dev/stdout -q 1<>both.msh' "$program"
cmp both.msh in.msh || fail "the input was overwritten while it was read"
grep -q "is the input" err || fail "onto the input: $(cat err)"
mkfifo fifo
"$program" smooth in.msh -o fifo -q &
cat fifo >piped.msh
wait $! && cmp piped.msh out.msh || fail "named pipe"
"$program" smooth /dev/stdin -o from_stdin.msh -q <in.msh && cmp from_stdin.msh out.msh ||
    fail "from standard input"
cat in.msh | "$program" smooth /dev/stdin -o from_pipe.msh -q && cmp from_pipe.msh out.msh ||
    fail "from a pipe"

# A reader that goes away is an error, not death.
(
    "$program" smooth in.msh -o /dev/stdout -q 2>err
    echo $? >status
) | true
[ "$(cat status)" -eq 2 ] || fail "broken pipe: status $(cat status)"
[ "$(wc -l <err)" -eq 1 ] || fail "broken pipe: one line expected"

# Standard streams that are closed do not end up in files.
"$program" smooth in.msh -o closed.msh >&- 2>&- <&-
cmp closed.msh out.msh || fail "closed standard streams"

# The report replaces as a whole, too, and keeps mode and links.
echo old >report.json
chmod 600 report.json
ln -s report.json report_link.json
expect_status 0 "$program" smooth in.msh -o out.msh --json report_link.json -q
[ -L report_link.json ] && [ "$(stat -c %a report.json)" = 600 ] || fail "link or mode of the report"
python3 -m json.tool report.json >/dev/null || fail "report is no JSON"
[ "$(find . -name '*.planish*' -o -name '*.tmp*' | wc -l)" -eq 0 ] || fail "temporary files: $(ls -A)"
finish
