#!/usr/bin/env bash
# Install into an empty prefix, move that elsewhere, and build against it as others do: C with
# pkg-config (shared and static), C++ with find_package, one with add_subdirectory; the manual, the
# completion, what the libraries export.
set -u
here=$(cd "$(dirname "$0")" && pwd)
source_dir=${PLANISH_SOURCE:?}
build=${PLANISH_BUILD:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
run() {
    "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }
}

run cmake --install "$build" --prefix "$work/first"
mv "$work/first" "$work/prefix"
prefix=$work/prefix
lib=$(dirname "$(find "$prefix" -name libplanish.a)")
for file in include/planish/planish.h include/planish/planish_io.h bin/planish \
    share/man/man1/planish.1 share/man/man3/planish.3 share/doc/planish/LICENSE \
    share/doc/planish/CHANGELOG.md share/doc/planish/docs/embedding.md \
    share/bash-completion/completions/planish \
    share/zsh/site-functions/_planish share/planish/python/planish/__init__.py \
    share/planish/python/planish/_library.py; do
    [ -s "$prefix/$file" ] || fail "$file is not installed"
done
[ -e "$prefix/share/planish/python/planish/py.typed" ] || fail "py.typed is not installed"
[ "$(find "$prefix" -name '*.h' | wc -l)" = 2 ] || fail "there are other headers"

# ---- the Python module finds the library beside it, wherever both are ---------------------------
python=/usr/bin/python3 # the one that Debian's packages are for
if $python -c 'import numpy' 2>/dev/null; then
    # shellcheck disable=SC2016
    run env -u PLANISH_LIBRARY -u LD_LIBRARY_PATH PYTHONDONTWRITEBYTECODE=1 \
        PYTHONPATH="$prefix/share/planish/python" $python -c '
import planish, sys
here = [line.split()[-1] for line in open("/proc/self/maps") if "libplanish.so" in line]
assert here and all(path.startswith(sys.argv[1]) for path in here), here
assert planish.version() == "0.2.0"
planish.smooth(planish.read(sys.argv[2]))
here = [line.split()[-1] for line in open("/proc/self/maps") if "libplanish_io.so" in line]
assert here and all(path.startswith(sys.argv[1]) for path in here), here' "$(cd "$prefix" && pwd -P)" "$source_dir/docs/examples/bracket.msh"
    run env -u LD_LIBRARY_PATH PYTHONPATH="$prefix/share/planish/python" $python -m planish --version
else
    echo "without numpy: the installed module is not tried"
fi

# ---- what is public -----------------------------------------------------------------------------
for name in planish planish_io; do
    library=$lib/lib$name.so
    others=$(nm -D --defined-only "$library" | awk '{ print $3 }' | grep -v '^planish_')
    [ -z "$others" ] || fail "lib$name.so exports $others"
    readelf -d "$library" | grep -q "SONAME.*lib$name\.so\.0\.2\]" || fail "SONAME of lib$name.so"
done
needed=$(readelf -d "$lib/libplanish.so" | sed -n 's/.*NEEDED.*\[\(.*\)\]/\1/p')
for library in $needed; do
    case $library in
        libgomp.so.1 | libomp.so.* | libhwloc.so.* | libm.so.* | libc.so.* | ld-linux*) ;;
        *) fail "libplanish.so needs $library" ;;
    esac
done
# Each function of the header is there.
for name in $(grep -o 'PLANISH_API [^;]*' "$prefix/include/planish/planish.h" |
    grep -o 'planish_[a-z_]*(' | tr -d '('); do
    nm -D --defined-only "$lib/libplanish.so" | grep -q " $name\$" || fail "$name is missing"
done

# ---- consumers ----------------------------------------------------------------------------------
expect_run() {
    LD_LIBRARY_PATH=$lib "$@" >"$work/out" 2>&1 || { cat "$work/out" >&2; fail "$* does not run"; }
}
if command -v pkg-config >/dev/null; then
    export PKG_CONFIG_PATH=$lib/pkgconfig
    flags=$(pkg-config --cflags --libs planish) || fail "pkg-config"
    # shellcheck disable=SC2086
    run cc -std=c99 -Wall -Wextra -pedantic -Werror "$here/pkgconfig/main.c" -o "$work/c" $flags
    expect_run "$work/c"
    grep -q "planish 0.2.0: RMS 2.* -> 1" "$work/out" || fail "$(cat "$work/out")"
    private=$(pkg-config --cflags --libs --static planish | sed 's/-lplanish /-l:libplanish.a /')
    # shellcheck disable=SC2086
    run cc "$here/pkgconfig/main.c" -o "$work/c_static" $private
    expect_run "$work/c_static"
    readelf -d "$work/c_static" | grep -q libplanish && fail "it is not linked statically"
    pkg-config --exists planish_io || fail "planish_io.pc"
    # shellcheck disable=SC2086
    run cc "$here/pkgconfig/stack.c" -o "$work/stack" $flags -lpthread
    expect_run "$work/stack"
    # Inside of parallel regions, of this OpenMP runtime and of another.
    for compiler in cc clang; do
        echo 'int main(void) { return 0; }' >"$work/empty.c"
        $compiler -fopenmp "$work/empty.c" -o "$work/empty" 2>/dev/null || continue
        # shellcheck disable=SC2086
        run $compiler -fopenmp -O1 "$here/pkgconfig/regions.c" -o "$work/regions" $flags
        expect_run "$work/regions"
    done
else
    echo "without pkg-config: its test is left out"
fi

run cmake -S "$here/find_package" -B "$work/cpp" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_CXX_FLAGS="-Wall -Wextra -pedantic -Werror"
run cmake --build "$work/cpp"
expect_run "$work/cpp/consumer"
expect_run "$work/cpp/consumer_io" "$source_dir/docs/examples/bracket.msh"
run cmake -S "$here/c_alone" -B "$work/c_alone" -DCMAKE_PREFIX_PATH="$prefix"
run cmake --build "$work/c_alone"
expect_run "$work/c_alone/consumer" "$source_dir/docs/examples/bracket.msh"
# A package without the static libraries serves those who use the shared ones.
cp -R "$prefix" "$work/shared_alone"
find "$work/shared_alone" -name '*.a' -delete
run cmake -S "$here/find_package" -B "$work/cpp_shared" -DCMAKE_PREFIX_PATH="$work/shared_alone"
run cmake --build "$work/cpp_shared"
expect_run "$work/cpp_shared/consumer"
mkdir "$work/newer"
sed 's/planish 0.2/planish 0.3/' "$here/find_package/CMakeLists.txt" >"$work/newer/CMakeLists.txt"
cp "$here/find_package/main.cpp" "$work/newer/"
cmake -S "$work/newer" -B "$work/cpp2" -DCMAKE_PREFIX_PATH="$prefix" >"$work/log" 2>&1 &&
    fail "version 0.2 passes for 0.3"
grep -q "version: 0.2.0" "$work/log" || fail "version 0.3 is refused for another reason"

run cmake -S "$here/subdirectory" -B "$work/sub" -DPLANISH_SOURCE="$source_dir" \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS="-O1 -Werror -Werror=float-equal" \
    -DCMAKE_COMPILE_WARNING_AS_ERROR=ON -DCMAKE_UNITY_BUILD=ON -DPLANISH_X86_KERNELS=OFF # soon built
run cmake --build "$work/sub" -j 2
expect_run "$work/sub/consumer"
[ -z "$(find "$work/sub" -name 'libplanish_io*' -o -name planish_program -o -name 'libplanish.so*')" ] ||
    fail "add_subdirectory builds more than the library"
run cmake "$work/sub" -DPLANISH_IO=ON -DPLANISH_HDF5=OFF
run cmake --build "$work/sub" -j 2
expect_run "$work/sub/consumer_io" "$source_dir/docs/examples/bracket.msh"
# A project around without a type of build installs planish with what finds its libraries.
run cmake -S "$here/subdirectory" -B "$work/typeless" -DPLANISH_SOURCE="$source_dir" -DPLANISH_INSTALL=ON
for name in planishTargets planishStaticTargets; do
    [ -n "$(find "$work/typeless" -name "$name-noconfig.cmake")" ] || fail "$name is of another type of build"
done

# ---- the program, its manual and completion -----------------------------------------------------
expect_run "$prefix/bin/planish" --version
grep -q "planish 0.2.0" "$work/out" || fail "version of the program"
for option in $("$prefix/bin/planish" smooth --help | grep -o '^ .\{4\} --[a-z-]*' |
    sed 's/.*--//'); do
    grep -qF -- "--$option" "$prefix/share/bash-completion/completions/planish" ||
        fail "bash does not know --$option"
    grep -qF -- "--$option" "$prefix/share/zsh/site-functions/_planish" ||
        fail "zsh does not know --$option"
    grep -qF -- "\\-\\-${option//-/\\-}" "$prefix/share/man/man1/planish.1" ||
        fail "planish(1) does not know --$option"
done
completions() { # WORD... : what bash offers for the last one
    bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _planish
        printf "%s\n" "${COMPREPLY[@]}"' - "$prefix/share/bash-completion/completions/planish" "$@"
}
[ "$(completions planish q)" = quality ] || fail "completion of commands"
[ "$(completions planish smooth --objective mea)" = mean-ratio ] || fail "completion of values"
completions planish smooth --s | grep -qx -- --slide || fail "completion of options"
completions planish quality --ob | grep -q . && fail "options of another command are offered"
if command -v man >/dev/null; then
    for page in 1 3; do
        warnings=$(LC_ALL=C MANWIDTH=80 man --warnings -l "$prefix/share/man/man$page/planish.$page" \
            2>&1 >"$work/page")
        [ -z "$warnings" ] || fail "planish($page): $warnings"
        grep -q "NAME" "$work/page" || fail "planish($page) is empty"
    done
fi
echo ok
