#!/usr/bin/env bash
# tools/check --resume: what has passed with the same sources is not done again; all else is.
set -uo pipefail
source_dir=${PLANISH_SOURCE:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
command -v git >/dev/null || { echo "without git"; exit 77; }
cd "$work" || exit 1
export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=a GIT_AUTHOR_EMAIL=a@a GIT_COMMITTER_NAME=a GIT_COMMITTER_EMAIL=a@a
git init -q
echo 'build*' >.gitignore
echo one >source
git add . && git commit -qm one

# Stand-in for ctest: of the tests good and bad, the latter fails; it says which ones it was to run.
ctest() {
    local test status
    [ ! -e build-dies ] || return 137
    : >build-report
    for test in good bad; do
        [[ " $* " == *"^($test)"* ]] && continue
        [ $test = good ] && status="Passed" || status="***Failed"
        echo "1/2 Test  #1: $test ........   $status    0.01 sec"
        [ $test = good ] && status=run || status=fail
        echo "<testcase name=\"$test\" status=\"$status\">" >>build-report
        echo "$test" >>build-ran
    done
    cp build-report build-a/tests.xml
}

# check RESUME: two steps and two tests, the second of each fails; the last line is the count.
check() (
    # shellcheck source=tools/check-steps.sh
    . "$source_dir/tools/check-steps.sh"
    resume=$1
    rm -f build-ran
    mkdir -p build-a
    record=build-check/passed
    begin_record $record
    step first touch build-ran
    step second false
    run_tests build-a --fast
    finish 0
)

expect() { # WHAT COUNT RAN
    [ "$(tail -n 1 build-out)" = "$2" ] || fail "$1: $(cat build-out)"
    [ "$(tr '\n' ' ' <build-ran)" = "$3" ] || fail "$1: ran $(cat build-ran), not $3"
}
check 0 >build-out && fail "a failure is a success"
expect "at first" "2 passed, 2 failed" "good bad "
check 1 >build-out && fail "a failure is a success"
expect "resumed" "2 passed, 2 failed" "bad "
[ "$(grep -c 'passed before' build-out)" = 2 ] || fail "$(cat build-out)"
touch build-dies
check 1 >build-out && fail "a failure is a success"
[ "$(tail -n 1 build-out)" = "2 passed, 2 failed" ] || fail "tests that were ended: $(cat build-out)"
rm build-dies
check 0 >build-out
expect "anew" "2 passed, 2 failed" "good bad "
echo two >>source
check 1 >build-out
expect "a source has changed" "2 passed, 2 failed" "good bad "
echo new >other
check 1 >build-out
expect "there is a new source" "2 passed, 2 failed" "good bad "
full=1 check 1 >build-out
expect "more is checked" "2 passed, 2 failed" "good bad "

# Other scripts have steps, too, but no record.
(
    # shellcheck source=tools/check-steps.sh
    . "$source_dir/tools/check-steps.sh"
    step first false
    step first true
    finish 0
) >build-out && fail "a failure is a success"
[ "$(tail -n 1 build-out)" = "1 passed, 1 failed" ] || fail "steps without a record: $(cat build-out)"
