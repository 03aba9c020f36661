# shellcheck shell=bash
# check-steps: the parts of tools/check and the count of what passed; sourced by it.

passed=0 failed=0 skipped=0
jobs=$(nproc)
sample=docs/examples/bracket.msh
fuzz_seconds=${PLANISH_FUZZ_SECONDS:-5}

# step NAME FUNCTION: one thing that passes or fails.
step() {
    echo "== $1"
    if "$2"; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED: $1"
    fi
}

# build_tree FOLDER CMAKE-OPTION...: configure and build; what it says is shown if it fails.
build_tree() {
    local folder=$1 log
    shift
    echo "== building $folder"
    mkdir -p "$folder"
    log=$folder/build.log
    if ! { cmake -S . -B "$folder" "$@" && cmake --build "$folder" -j "$jobs"; } >"$log" 2>&1; then
        cat "$log"
        echo "FAILED: the build in $folder"
        failed=$((failed + 1))
        return 1
    fi
}

# count PATTERN FILE: lines of FILE with PATTERN; 0 if there is no file.
count() {
    grep -c -e "$1" "$2" 2>/dev/null || true
}

# run_tests FOLDER CTEST-OPTION...: all tests of a tree; adds up the counts. A test that neither
# passed nor said itself that it cannot run here has failed.
run_tests() {
    local folder=$1 report=$1/tests.xml all good out
    shift
    echo "== testing $folder"
    rm -f "$report"
    ctest --test-dir "$folder" --output-on-failure --output-junit "$PWD/$report" "$@"
    all=$(count '<testcase ' "$report")
    good=$(count '<testcase .*status="run"' "$report")
    out=$(count '<skipped message="SKIP_' "$report")
    if [ "${all:-0}" -eq 0 ]; then
        echo "FAILED: no test was run in $folder"
        failed=$((failed + 1))
        return 1
    fi
    passed=$((passed + good))
    skipped=$((skipped + out))
    failed=$((failed + all - good - out))
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

# Every target starts from the small meshes of the tests.
check_fuzzers() {
    local target corpus=build-fuzz/corpus count=0
    build_tree build-fuzz -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
        -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPLANISH_TESTS=OFF -DPLANISH_BENCH=OFF \
        -DPLANISH_FUZZ=ON || return 1
    for target in build-fuzz/fuzz/fuzz_*; do
        [ -x "$target" ] || continue
        count=$((count + 1))
        rm -rf "$corpus"
        mkdir -p "$corpus"
        "$target" -max_total_time="$fuzz_seconds" -rss_limit_mb=2048 -timeout=10 -print_final_stats=0 \
            -verbosity=0 -artifact_prefix=build-fuzz/ "$corpus" tests/data >build-fuzz/log 2>&1 ||
            { cat build-fuzz/log; return 1; }
    done
    echo "$count fuzz targets"
    [ "$count" -gt 0 ]
}

# Valgrind 3.19 lacks an instruction (vmovq between registers) that compilers emit for AVX.
check_valgrind() {
    build_tree build-valgrind -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPLANISH_TESTS=OFF \
        -DPLANISH_BENCH=OFF -DPLANISH_X86_KERNELS=OFF &&
        OMP_NUM_THREADS=1 valgrind -q --error-exitcode=9 --leak-check=full \
            --errors-for-leak-kinds=definite \
            build-valgrind/planish smooth "$sample" -o build-valgrind/sample.msh --max-sweeps 2 -q
}

# libomp tells the sanitizer about its barriers through Archer; libgomp does not, and every
# parallel loop would look like a race. The mesh is large enough that a colour is shared out.
check_races() {
    local archer
    archer=$(find /usr/lib -name 'libarcher.so' 2>/dev/null | head -n 1)
    if [ -z "$archer" ]; then
        echo "libarcher.so (of libomp-dev) was not found"
        return 1
    fi
    build_tree build-tsan -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
        -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPLANISH_TESTS=OFF -DPLANISH_BENCH=OFF \
        -DPLANISH_SANITIZE=thread &&
        make_cube build-tsan/cube.mesh &&
        OMP_TOOL_LIBRARIES=$archer TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=9" \
            build-tsan/planish smooth build-tsan/cube.mesh -o build-tsan/smooth.mesh -j 4 -q
}

check_abi() {
    tools/install/abi check
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
