#!/usr/bin/env bash
# tools/release, and the recipes that it fills in: what they build is built from the archive, by stand-ins for the
# programs that read recipes (recipes/). Soon built: without kernels for other CPUs, without optimisation.
set -u
here=$(cd "$(dirname "$0")" && pwd)
source_dir=${PLANISH_SOURCE:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python=/usr/bin/python3
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
run() {
    "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }
}
refuse() { # TEXT COMMAND...: it must fail, and say TEXT
    local text=$1
    shift
    "$@" >"$work/log" 2>&1 && fail "not refused: $*"
    grep -q "$text" "$work/log" || fail "$*: $(cat "$work/log")"
}
for tool in git ruby cmake; do
    command -v $tool >/dev/null || { echo "without $tool"; exit 77; }
done
$python -c 'import yaml' 2>/dev/null || { echo "without python3-yaml"; exit 77; }

# ---- release: in a repository of its own, which has all that is here ----------------------------
mkdir "$work/repository"
(cd "$source_dir" && tar -c --exclude='./build*' --exclude=./.git .) | tar -x -C "$work/repository"
cd "$work/repository" || exit 1
export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=a GIT_AUTHOR_EMAIL=a@a GIT_COMMITTER_NAME=a GIT_COMMITTER_EMAIL=a@a
run git init -q
run git add -A
run git commit -qm one
version=$(sed -n 's/^project(planish VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
export PLANISH_VERSION=$version
release() { tools/release --trial --url https://localhost/planish.tar.gz --homepage https://localhost "$@"; }
run release --maintainer somebody "$version" "$work/out"
grep -q "still have" "$work/log" && fail "$(cat "$work/log")"
run release "$version" "$work/again" HEAD
grep -q "still have @MAINTAINER@" "$work/log" || fail "$(cat "$work/log")"
archive=$work/out/planish-$version.tar.gz
cmp "$archive" "$work/again/planish-$version.tar.gz" || fail "the archive has other bytes"
(cd "$work/out" && run sha256sum --check SHA256SUMS)
[ "$(wc -l <"$work/out/SHA256SUMS")" = 2 ] || fail "SHA256SUMS"
grep -q '^- ' "$work/out/planish-$version-notes.md" && ! grep -q '^## ' "$work/out/planish-$version-notes.md" ||
    fail "notes: $(cat "$work/out/planish-$version-notes.md")"
refuse "does not say 'project(planish VERSION 9.9.9 '" release 9.9.9 "$work/no"
refuse "is no tag or commit" release "$version" "$work/no" no-such-tag
touch stray
refuse "not committed" release "$version" "$work/no"
rm stray
sed -i "s/^## $version .*/## $version (unreleased)/" CHANGELOG.md
run git commit -qam two --allow-empty
refuse "says '## $version (unreleased)'" tools/release "$version" "$work/no"
sed -i "s/^## $version .*/## $version (2026-01-01)/" CHANGELOG.md
rm -f tests/install/abi/*-"$version".abi
run git commit -qam dated
refuse "planish-$version.abi is not in HEAD" tools/release "$version" "$work/no"
sed -i "s/^## $version .*/## 0.0.1/" CHANGELOG.md
run git commit -qam three
refuse "has no '## $version'" release "$version" "$work/no"

# ---- the recipes --------------------------------------------------------------------------------
recipes=$work/out/recipes
run $python "$here/recipes/recipes.py" check "$recipes" CITATION.cff
grep -q "sha256 \"$(sha256sum <"$archive" | cut -d ' ' -f 1)\"" "$recipes/homebrew/planish.rb" || fail "the sum"
soon=(-DCMAKE_BUILD_TYPE=Debug -DPLANISH_X86_KERNELS=OFF)
export CMAKE_BUILD_PARALLEL_LEVEL
CMAKE_BUILD_PARALLEL_LEVEL=$(nproc)

# unpack NAME: the archive, for that recipe; the script goes there.
unpack() {
    mkdir "$work/$1"
    tar -xzf "$archive" -C "$work/$1"
    cd "$work/$1/planish-$version" || exit 1
}
unpack conda
export PREFIX=$work/conda/prefix SHLIB_EXT=.so
export CMAKE_ARGS="-DCMAKE_INSTALL_PREFIX=$PREFIX -DCMAKE_INSTALL_LIBDIR=lib ${soon[*]}"
{ echo "set -e; export PATH=$PREFIX/bin:\$PATH"; $python "$here/recipes/recipes.py" conda "$recipes/conda/meta.yaml"; } >"$work/conda/script"
[ "$(wc -l <"$work/conda/script")" -ge 7 ] || fail "$(cat "$work/conda/script")"
run bash "$work/conda/script"
unset CMAKE_ARGS

unpack homebrew
run ruby "$here/recipes/brew.rb" "$recipes/homebrew/planish.rb" "$work/homebrew/prefix" "${soon[@]}"

unpack spack
mapfile -t arguments < <($python "$here/recipes/recipes.py" spack "$recipes/spack/package.py")
[ ${#arguments[@]} = 4 ] || fail "the arguments of Spack are ${arguments[*]}"
run cmake -S . -B build -DCMAKE_INSTALL_PREFIX="$work/spack/prefix" "${soon[@]}" "${arguments[@]}"
run cmake --build build
run cmake --install build
[ "$("$work/spack/prefix/bin/planish" --version | head -n 1)" = "planish $version" ] || fail "the program of Spack"

mkdir "$work/vcpkg"
run cmake -DPORTFILE="$recipes/vcpkg/portfile.cmake" -DARCHIVE_FILE="$archive" -DWORK="$work/vcpkg" \
    -DFEATURES=io "-DARGUMENTS=$(IFS=';' && echo "${soon[*]}")" -P "$here/recipes/vcpkg.cmake"
for file in include/planish/planish_io.h lib/libplanish.a lib/libplanish_io.a; do
    [ -s "$work/vcpkg/package/$file" ] || fail "vcpkg has no $file"
done
echo ok
