#!/usr/bin/env bash
# Places where a mesh cannot be written, or not all of it: full file systems and devices, folders
# that may not be written, odd links, limits of the process. The input keeps its bytes, what is
# written is complete or as it was, no temporary file stays, and one line says what is wrong.
. "$(dirname "$0")/common.sh"

limited=$work/limited # what limits apply to is made here
mkdir files "$limited"
cp "$sample" files/in.msh
cp "$source_folder"/tests/data/{medit.mesh,ascii.vtu,tetgen.node,tetgen.ele,cube.vtkhdf} files
cd files || exit 1
sum=$(cat ./* | cksum)
"$program" smooth in.msh -o "$work/reference.msh" -q || exit 1
size=$(stat -c %s "$work/reference.msh")

# inputs_are_whole WHAT: nothing was done to the inputs, and no other file lies beside them.
inputs_are_whole() {
    [ "$(cat ./* | cksum)" = "$sum" ] || fail "$1: an input was touched, or something left: $(ls)"
}

# fails_cleanly WHAT OUT COMMAND...: status 2, one line that names OUT, and inputs are whole.
fails_cleanly() {
    local what=$1 out=$2 status
    shift 2
    "$@" >"$work/out" 2>"$work/err" </dev/null
    status=$?
    [ $status -eq 2 ] || fail "$what: status $status instead of 2"
    { [ "$(wc -l <"$work/err")" -eq 1 ] && grep -q "^planish: .*$out" "$work/err"; } ||
        fail "$what: not one line that names $out: $(cat "$work/err")"
    inputs_are_whole "$what"
}

# is_empty WHAT FOLDER
is_empty() {
    [ -z "$(ls -A "$2")" ] || fail "$1: left behind: $(ls -A "$2")"
}

# ---- a file system that is too small: of 4 kB pages, with room for so many ----------------------

# on_small PAGES OLD COMMAND...: with $small, a file system of so many pages. OLD: a file that fills
# so many bytes is there as old.msh, and must stay as it is.
on_small() {
    unshare -rm bash -c '
        mount -t tmpfs -o size=$(($1 * 4096)) none "$0" || exit 99
        head -c $2 /dev/zero | tr "\0" o >"$0/old.msh" && cksum <"$0/old.msh" >"$0/../old.sum"
        "${@:3}"; status=$?
        cksum <"$0/old.msh" | cmp -s - "$0/../old.sum" || echo "old.msh was changed" >&2
        ls "$0" | grep -vx "old.msh" >&2
        exit $status' "$limited" "$@"
}

if on_small 2 1 true 2>/dev/null; then
    for pages in $(some 3 2 5); do
        fails_cleanly "$pages pages" new.msh on_small $pages 100 \
            "$program" smooth in.msh -o "$limited/new.msh" -q
        fails_cleanly "$pages pages, replaced" old.msh on_small $pages 100 \
            "$program" smooth in.msh -o "$limited/old.msh" -q
        fails_cleanly "$pages pages, converted" new.vtu on_small $pages 100 \
            "$program" smooth in.msh -o "$limited/new.vtu" -q
        fails_cleanly "$pages pages, TetGen" 'new\.' on_small $pages 100 \
            "$program" smooth tetgen.node -o "$limited/new.node" -q
        fails_cleanly "$pages pages, HDF5" new.vtkhdf on_small $pages 100 \
            "$program" smooth cube.vtkhdf -o "$limited/new.vtkhdf" -q
        # The mesh has found its room, and the report has none: status 1.
        "$program" smooth in.msh -o whole.msh -q && on_small $pages 100 \
            "$program" smooth in.msh -o whole.msh --report "$limited/r.html" -q 2>"$work/err"
        status=$?
        { [ $status -eq 1 ] && [ "$(wc -l <"$work/err")" -eq 1 ]; } ||
            fail "report on $pages pages: status $status: $(cat "$work/err")"
        cmp whole.msh "$work/reference.msh" || fail "the mesh of a lost report"
        rm whole.msh
    done
else
    echo "not tried: file systems that are too small (no tmpfs in a namespace of one's own)"
fi

# ---- devices, pipes, links ----------------------------------------------------------------------

fails_cleanly "full device" /dev/full "$program" smooth in.msh -o /dev/full -q
[ -c /dev/full ] || fail "/dev/full was replaced"
"$program" smooth in.msh -o /dev/stdout -q >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "standard output on a full device"
"$program" quality in.msh >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "a table on a full device"
"$program" smooth in.msh -o /dev/null --json - >/dev/full -q 2>"$work/err"
[ $? -eq 1 ] || fail "a report on a full device"
"$program" --help >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "help on a full device"
inputs_are_whole "full devices"

ln -s loop.msh "$limited/loop.msh"
ln -s ../nowhere/x.msh "$limited/dangling.msh"
ln -s . "$limited/folder.msh"
fails_cleanly "a loop of links" loop.msh "$program" smooth in.msh -o "$limited/loop.msh" -q
fails_cleanly "a link into a folder that is not there" dangling.msh \
    "$program" smooth in.msh -o "$limited/dangling.msh" -q
fails_cleanly "a link to a folder" folder.msh "$program" smooth in.msh -o "$limited/folder.msh" -q
[ "$(ls "$limited" | wc -l)" -eq 3 ] || fail "links: left behind: $(ls "$limited")"
rm "$limited"/*

# A hard link: the other name keeps the old file. One to the input is no reason to touch it.
cp in.msh "$limited/one.msh"
ln "$limited/one.msh" "$limited/two.msh"
"$program" smooth in.msh -o "$limited/one.msh" -q || fail "a hard link"
cmp "$limited/one.msh" "$work/reference.msh" || fail "a hard link: what was written"
cmp "$limited/two.msh" in.msh || fail "a hard link: the other name"
ln "$limited/two.msh" "$limited/same.msh"
"$program" smooth "$limited/two.msh" -o "$limited/same.msh" -q || fail "a hard link to the input"
cmp "$limited/two.msh" in.msh || fail "a hard link to the input: the input"
cmp "$limited/same.msh" "$work/reference.msh" || fail "a hard link to the input: the output"
# A link to the input is its name: it is replaced.
ln -s two.msh "$limited/link.msh"
"$program" smooth "$limited/two.msh" -o "$limited/link.msh" -q || fail "a link to the input"
{ [ -L "$limited/link.msh" ] && cmp "$limited/two.msh" "$work/reference.msh"; } ||
    fail "a link to the input: the input"
rm "$limited"/*

# A pipe whose reader leaves after a while, and one that has none for a while.
mkfifo "$limited/pipe.msh"
head -c 100 "$limited/pipe.msh" >/dev/null &
"$program" smooth in.msh -o "$limited/pipe.msh" -q 2>"$work/err"
status=$?
wait
case $status in
    0) ;; # all of it was in the pipe by then
    2) grep -q "pipe.msh" "$work/err" || fail "a reader that left: $(cat "$work/err")" ;;
    *) fail "a reader that left: status $status" ;;
esac
(sleep 0.3; exec cat "$limited/pipe.msh" >"$work/late.msh") &
"$program" smooth in.msh -o "$limited/pipe.msh" -q || fail "a reader that comes late"
wait
cmp "$work/late.msh" "$work/reference.msh" || fail "a reader that comes late: what it got"
rm "$limited"/*

# ---- folders and files that may not be written --------------------------------------------------

# as_nobody COMMAND...: by a user who is not root, for whom there are permissions.
as_nobody() {
    if [ "$(id -u)" -eq 0 ]; then
        setpriv --reuid=65534 --regid=65534 --clear-groups "$@"
    else
        "$@"
    fi
}

chmod a+rx "$work" # a folder of mktemp is its owner's alone
if as_nobody test -x "$program" && as_nobody test -r "$PWD/in.msh"; then
    cp in.msh "$limited/old.msh"
    chmod 555 "$limited"
    fails_cleanly "a folder that is read only" new.msh \
        as_nobody "$program" smooth in.msh -o "$limited/new.msh" -q
    fails_cleanly "a file in such a folder" old.msh \
        as_nobody "$program" smooth in.msh -o "$limited/old.msh" -q
    fails_cleanly "a report in such a folder" r.json \
        as_nobody "$program" quality in.msh --json "$limited/r.json" -q
    chmod 000 "$limited"
    fails_cleanly "a folder that cannot be entered" new.msh \
        as_nobody "$program" smooth in.msh -o "$limited/new.msh" -q
    fails_cleanly "an input in such a folder" old.msh \
        as_nobody "$program" quality "$limited/old.msh" -q
    chmod 755 "$limited"
    cmp "$limited/old.msh" in.msh || fail "a file in a folder that is read only"
    chmod 000 "$limited/old.msh"
    fails_cleanly "an input that cannot be read" old.msh \
        as_nobody "$program" quality "$limited/old.msh" -q
    # In /tmp and its like only the owner may replace a file; one of TetGen's files is another's.
    if [ "$(id -u)" -eq 0 ]; then
        cp tetgen.ele "$limited/new.ele"
        chmod 1777 "$limited"
        fails_cleanly "another one's file" 'new\.' \
            as_nobody "$program" smooth tetgen.node -o "$limited/new.node" -q
        { cmp "$limited/new.ele" tetgen.ele && [ ! -e "$limited/new.node" ]; } ||
            fail "another one's file: $(ls "$limited")"
        chmod 755 "$limited"
    fi
    rm -f "$limited"/*
    is_empty "permissions" "$limited"
else
    echo "not tried: permissions (another user cannot run $program)"
fi
if unshare -rm bash -c 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0"' "$limited" 2>/dev/null; then
    fails_cleanly "a file system that is read only" new.msh unshare -rm bash -c '
        mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" &&
            exec "$1" smooth in.msh -o "$0/new.msh" -q' "$limited" "$program"
fi

# ---- limits of the process ----------------------------------------------------------------------

# Blocks of 1 kB that a file may have: as many as there are, and a bit more.
for ((blocks = 0; blocks * 1024 <= size + 1024; blocks += size / 4096)); do
    (ulimit -f $blocks && exec "$program" smooth in.msh -o "$limited/new.msh" -q 2>"$work/err")
    status=$?
    if [ $((blocks * 1024)) -ge "$size" ]; then
        { [ $status -eq 0 ] && cmp "$limited/new.msh" "$work/reference.msh"; } ||
            fail "files of $blocks kB are enough: status $status"
        rm -f "$limited/new.msh"
    else
        { [ $status -eq 2 ] && [ "$(wc -l <"$work/err")" -eq 1 ]; } ||
            [ "$blocks" -eq 0 ] || fail "files of $blocks kB: status $status: $(cat "$work/err")"
    fi
    is_empty "files of $blocks kB" "$limited"
done

# try_limit OPTION VALUE: what is written is complete or not there, and 0 means complete.
try_limit() {
    local status
    (ulimit "$1" "$2" && exec "$program" smooth in.msh -o "$limited/new.msh" -q -j 2) \
        >"$work/out" 2>"$work/err"
    status=$?
    if [ $status -eq 0 ]; then
        succeeded=$((succeeded + 1))
        cmp "$limited/new.msh" "$work/reference.msh" || fail "ulimit $1 $2"
        rm -f "$limited/new.msh"
    elif [ $status -ne 127 ]; then # the loader has a word of its own
        failed=$((failed + 1))
        { [ $status -eq 2 ] && [ "$(grep -c '^planish: ' "$work/err")" -eq 1 ]; } ||
            fail "ulimit $1 $2: status $status: $(cat "$work/err")"
    fi
    is_empty "ulimit $1 $2" "$limited"
}

succeeded=0 failed=0
for ((n = 3; n < 12; n++)); do
    try_limit -n $n
done
[ $succeeded -gt 0 ] && [ $failed -gt 0 ] || fail "open files: $succeeded times enough, $failed not"
succeeded=0 failed=0
step=8000
[ -z "${PLANISH_QUICK-}" ] || step=24000
[ -z "${PLANISH_LONG-}" ] || step=500
for ((kb = 40000; kb < 400000 && succeeded < 5; kb += step)); do
    try_limit -v $kb
done
echo "figure: address space: $succeeded times enough, $failed times not"
[ $succeeded -gt 0 ] || fail "no address space is enough"
inputs_are_whole limits
finish
