# shellcheck shell=bash
# common: what the tests of the program share; sourced by each.
#
# A test runs in an empty folder of its own, which is removed at the end. It ends with 0 if all of
# its expectations held, 1 if not, 77 if it cannot run here.

program=${PLANISH_PROGRAM:?the program to test}
source_folder=${PLANISH_SOURCE:?the source folder}
sample=$source_folder/docs/examples/bracket.msh
cli=$source_folder/tests/cli
failures=0
export PYTHONPATH=$cli PYTHONDONTWRITEBYTECODE=1 # scripts of the tests import mesh_file

# Scripts of the tests need Python's own modules alone; it starts in half the time without others.
python3() {
    command python3 -S "$@"
}

work=$(mktemp -d) || exit 1
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work" || exit 1

fail() {
    failures=$((failures + 1))
    echo "FAILED: $*"
}

# expect_status N COMMAND...: runs it; what it prints is in the files out and err.
expect_status() {
    local wanted=$1 status
    shift
    "$@" >out 2>err </dev/null
    status=$?
    if [ "$status" -ne "$wanted" ]; then
        fail "exit status $status instead of $wanted: $*"
        head -n 5 err
    fi
}

# The last command printed one line on standard error, which begins with "planish: ", and nothing
# on standard output.
expect_one_line() {
    if [ "$(wc -l <err)" -ne 1 ] || [ "$(grep -c '^planish: ' err)" -ne 1 ]; then
        fail "one line 'planish: ...' was expected, and this came:"
        cat err
    fi
    [ ! -s out ] || fail "standard output should be empty"
}

# expect_text TEXT: the last command's standard error holds TEXT.
expect_text() {
    grep -qF -e "$1" err || { fail "'$1' was expected in:"; cat err; }
}

# expect_no_file PATTERN...: nothing of that name is there.
expect_no_file() {
    local name
    for name; do
        [ ! -e "$name" ] || fail "$name should not be there"
    done
}

# expect_json EXPRESSION: report.json, as r, is such that it holds.
expect_json() {
    python3 -c "import json; r = json.load(open('report.json')); assert $1" 2>/dev/null ||
        fail "report.json: $1"
}

# wait_for TEXT FILE: until TEXT is in FILE; gives up after half a minute.
wait_for() {
    local i
    for ((i = 0; i < 3000; i++)); do
        ! grep -qF -e "$1" "$2" 2>/dev/null || return 0
        sleep 0.01
    done
    fail "'$1' never came"
    return 1
}

# lacks FILE: planish was built without what the file needs.
lacks() {
    ! "$program" quality "$1" -q >/dev/null 2>lacks && grep -q "was built without\|packed by" lacks
}

# some WORD...: all of them; every third one where PLANISH_QUICK leaves the others to tools/check --full.
some() {
    local step=1 i
    [ -z "${PLANISH_QUICK-}" ] || step=3
    for ((i = 1; i <= $#; i += step)); do
        printf '%s\n' "${!i}"
    done
}

finish() {
    [ "$failures" -eq 0 ] || echo "$failures expectations did not hold"
    [ "$failures" -eq 0 ]
    exit
}
