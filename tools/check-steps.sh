# shellcheck shell=bash
# check-steps: the parts of tools/check and the count of what passed; sourced by it.

passed=0 failed=0 skipped=0 resume=0
record= # of steps that have passed: a file that begin_record has begun; tools/check alone has one
jobs=$(nproc)
tests_at_once=$((jobs + 1)) # some wait for a while
sample=docs/examples/bracket.msh

# alone COMMAND...: print the command that runs a step alone, to be pasted into a shell. Functions of
# this file print the commands that they call themselves.
alone() {
    [ "$(type -t "$1")" = function ] || echo "   alone: $(printf '%q ' "$@")"
}

# sources: a name for the sources as they are, committed or not, and for how much of the check is run.
sources() {
    { git rev-parse HEAD && git diff HEAD && git ls-files -z --others --exclude-standard | xargs -0r sha256sum &&
        echo "${full-} ${short-}"; } 2>/dev/null | sha256sum
}

# begin_record FILE: what passes from now on is added to it. What it has stays if --resume is given and the
# sources are the same.
begin_record() {
    local state
    state=$(sources) || state="unknown $$"
    mkdir -p "$(dirname "$1")"
    [ "$resume" = 1 ] && [ "$(head -n 1 "$1" 2>/dev/null)" = "$state" ] || echo "$state" >"$1"
}

has_passed() { # NAME: with --resume, before
    [ -n "$record" ] && grep -qxF "passed: $1" "$record"
}

# step NAME COMMAND ...: one thing that passes or fails.
step() {
    local name=$1 begin=$SECONDS
    shift
    echo "== $name"
    alone "$@"
    if has_passed "$name"; then
        echo "   passed before"
        passed=$((passed + 1))
    elif "$@"; then
        [ -z "$record" ] || echo "passed: $name" >>"$record"
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED: $name"
    fi
    echo "   took $((SECONDS - begin)) s"
}

# said FILE: what a step that ran side by side with others said, and its exit status; a failure if it
# has left none.
said() {
    cat "$1.log" && return "$(cat "$1.status")"
}

# steps_side_by_side NAME...: tools/reliability/NAME --short, as many at a time as there are CPUs, since
# most keep one of them busy; what each says comes whole, and stays in build-check.
steps_side_by_side() {
    local folder=build-check/side-by-side name
    rm -rf $folder
    mkdir -p $folder
    echo "== side by side: $*"
    for name; do
        alone "tools/reliability/$name" --short
    done
    # shellcheck disable=SC2016 # it is for the inner shell
    for name; do
        has_passed "tools/reliability/$name --short" || echo "$name"
    done | xargs -P "$jobs" -I{} bash -c \
        'tools/reliability/{} --short >"$0/{}.log" 2>&1; echo $? >"$0/{}.status"' $folder
    for name; do
        step "tools/reliability/$name --short" said "$folder/$name"
    done
}

# build_tree FOLDER CMAKE-OPTION...: configure and build $target, or all; what it says is shown if it fails.
build_tree() {
    local folder=$1 log build=()
    shift
    # Only now, as tools/check may just have installed it; a tree that is there keeps its generator.
    ! command -v ninja >/dev/null || export CMAKE_GENERATOR=Ninja
    echo "== building $folder"
    build=(cmake --build "$folder" -j "$jobs" --target "${target:-all}")
    alone cmake -S . -B "$folder" "$@"
    alone "${build[@]}"
    mkdir -p "$folder"
    log=$folder/build.log
    if ! { cmake -S . -B "$folder" "$@" && "${build[@]}"; } >"$log" 2>&1; then
        cat "$log"
        echo "FAILED: the build in $folder"
        failed=$((failed + 1))
        return 1
    fi
}

# libraries_of FOLDER: the libraries that CMake found for what it builds there, a path a line.
libraries_of() {
    sed -n 's/^[A-Z0-9_]*_LIBRARY:FILEPATH=\(.*[^D]\)$/\1/p' "$1/CMakeCache.txt"
}

# count PATTERN FILE: lines of FILE with PATTERN; 0 if there is no file.
count() {
    grep -c -e "$1" "$2" 2>/dev/null || true
}

# run_tests FOLDER CTEST-OPTION...: all tests of a tree; adds up the counts. A test that neither
# passed nor said itself that it cannot run here has failed.
run_tests() {
    local folder=$1 report=$1/tests.xml log=$1/tests.log all good out before status left=() begin=$SECONDS
    shift
    echo "== testing $folder"
    alone ctest --test-dir "$folder" --parallel "$tests_at_once" --output-on-failure "$@"
    begin_record "$log"
    before=$(sed -n 's/^.* Test  *#[0-9]*: \([^ ]*\) .* Passed .*/\1/p' "$log" | sort -u)
    if [ -n "$before" ]; then
        left=(--exclude-regex "^($(echo "$before" | paste -sd '|'))\$")
        passed=$((passed + $(echo "$before" | wc -l)))
        echo "   $(echo "$before" | wc -l) passed before"
    fi
    rm -f "$report"
    ctest --test-dir "$folder" --parallel "$tests_at_once" --output-on-failure --output-junit "$PWD/$report" "$@" \
        "${left[@]}" | tee -a "$log"
    status=${PIPESTATUS[0]}
    echo "   took $((SECONDS - begin)) s"
    all=$(count '<testcase ' "$report")
    good=$(count '<testcase .*status="run"' "$report")
    out=$(count '<skipped message="SKIP_' "$report")
    if [ "${all:-0}" -eq 0 ] && { [ -z "$before" ] || [ "$status" -ne 0 ]; }; then
        echo "FAILED: no test was run in $folder"
        failed=$((failed + 1))
        return 1
    fi
    passed=$((passed + good))
    skipped=$((skipped + out))
    failed=$((failed + all - good - out))
}

# What is called python3 may be a script that looks for the one to run, as pyenv's does for up to a
# second; tests call it hundreds of times, so it is looked for once.
find_python() {
    if [ "$(head -c 2 "$(command -v python3)")" = '#!' ]; then
        PATH=$(dirname "$(python3 -c 'import sys; print(sys.executable)')"):$PATH
    fi
}

# A cube of 48 000 tetrahedra with its nodes off their places: large enough that all threads work.
make_cube() {
    python3 tests/cli/make_mesh.py 20 0.2 "$1"
}

# same_bits TREE TREE: the programs of both trees smooth sample and cube to the same bytes.
same_bits() {
    local tree
    make_cube build-check/cube.mesh || return 1
    for tree in "$1" "$2"; do
        "$tree/planish" smooth "$sample" -o "$tree/sample.msh" -q &&
            "$tree/planish" smooth build-check/cube.mesh -o "$tree/cube-smooth.mesh" -q || return 1
    done
    cmp "$1/sample.msh" "$2/sample.msh" && cmp "$1/cube-smooth.mesh" "$2/cube-smooth.mesh"
}

check_clang() {
    build_tree build-clang -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
        -DCMAKE_BUILD_TYPE=Release -DPLANISH_DEVELOPER=ON -DPLANISH_BENCH=OFF &&
        run_tests build-clang --label-regex unit &&
        same_bits build-check build-clang
}

# finish FULL: the count as the last line, and the exit status.
finish() {
    if [ "$1" = 1 ] && [ "$skipped" -gt 0 ]; then
        echo "FAILED: $skipped tests were skipped, and nothing may be in the full check"
        failed=$((failed + 1))
    fi
    if [ "$skipped" -gt 0 ]; then
        echo "$passed passed, $failed failed, $skipped skipped"
    else
        echo "$passed passed, $failed failed"
    fi
    [ "$failed" -eq 0 ]
}
