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

# contents_of FILE: in contents; nothing else is started for it, as tests do so thousands of times.
contents_of() {
    contents=
    IFS= read -r -d "" contents <"$1"
}

# The last command printed one line on standard error, which begins with "planish: ", and nothing
# on standard output.
expect_one_line() {
    contents_of err
    if [[ $contents != "planish: "*$'\n' || ${contents%$'\n'} == *$'\n'* ]]; then
        fail "one line 'planish: ...' was expected, and this came:"
        cat err
    fi
    [ ! -s out ] || fail "standard output should be empty"
}

# expect_text TEXT: the last command's standard error holds TEXT.
expect_text() {
    contents_of err
    [[ $contents == *"$1"* ]] || { fail "'$1' was expected in:"; cat err; }
}

# expect_no_file PATTERN...: nothing of that name is there.
expect_no_file() {
    local name
    for name; do
        [ ! -e "$name" ] || fail "$name should not be there"
    done
}

# expect_json EXPRESSION: report.json, as r, is such that it holds. One Python looks at all of a test's.
expect_json() {
    local answer
    if [ "$BASH_SUBSHELL" -gt 0 ]; then # which has no way to that Python
        answer=$(printf '%s\0%s\0' "$PWD" "$1" | python3 "$cli/judge_json.py")
    else
        [ -n "${json_judge_PID-}" ] || coproc json_judge { python3 "$cli/judge_json.py"; }
        printf '%s\0%s\0' "$PWD" "$1" >&"${json_judge[1]}"
        read -r answer <&"${json_judge[0]}"
    fi
    [ "$answer" = holds ] || fail "report.json: $1 ($answer)"
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

# has_modules NAME...: Debian's Python has these; they are not loaded, which takes a second for some.
has_modules() {
    /usr/bin/python3 -c 'import importlib.util, sys; sys.exit(not all(map(importlib.util.find_spec, sys.argv[1:])))' "$@"
}

# some WORD...: all of them; every third one where PLANISH_QUICK leaves the others to tools/check --full.
some() {
    local step=1 i
    [ -z "${PLANISH_QUICK-}" ] || step=3
    for ((i = 1; i <= $#; i += step)); do
        printf '%s\n' "${!i}"
    done
}

# unless_quick WORD...: all of them, or none where PLANISH_QUICK leaves them to tools/check --full.
unless_quick() {
    [ -n "${PLANISH_QUICK-}" ] || printf '%s\n' "$@"
}

finish() {
    [ "$failures" -eq 0 ] || echo "$failures expectations did not hold"
    [ "$failures" -eq 0 ]
    exit
}
