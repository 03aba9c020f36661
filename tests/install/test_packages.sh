#!/usr/bin/env bash
# Debian's packages: built twice with the same bytes, first in a folder whose name has a blank, then as the Dockerfile
# does; looked at by lintian;
# installed, used, upgraded, removed and purged in a copy of this system that is in memory (packages_inside.sh).
set -u
here=$(cd "$(dirname "$0")" && pwd)
source_dir=${PLANISH_SOURCE:?}
work=$(mktemp -d)
as_root=()
[ "$(id -u)" = 0 ] || as_root=(sudo -n --preserve-env)
trap '"${as_root[@]}" rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
skip() {
    echo "not here: $*"
    exit 77
}
[ -e /etc/debian_version ] || skip "this is not Debian"
for tool in lintian dpkg-shlibdeps cpack unshare; do
    command -v $tool >/dev/null || skip "without $tool"
done
enter=("${as_root[@]}" unshare --mount)
"${enter[@]}" true 2>/dev/null || skip "no mounts of one's own are allowed"

cd "$source_dir" || exit 1
export SOURCE_DATE_EPOCH=1700000000
mkdir "$work/the source"
tar -c --exclude='./build*' --exclude=./.git . | tar -x -C "$work/the source" || fail "no copy of the source"
"$work/the source/tools/install/deb" "$work/debs" || fail "the packages are not built"
(cd "$work/debs" && printf '%s\n' *.deb) >"$work/names"
[ "$(sed 's/_.*//' "$work/names" | xargs)" = "libplanish-dev libplanish0.2 planish python3-planish" ] ||
    fail "there are $(xargs <"$work/names")"
du -b "$work"/debs/*.deb | sed 's|\t.*/| |'

# ---- what they say of themselves ----------------------------------------------------------------
lintian --allow-root --fail-on error "$work"/debs/*.deb >"$work/lintian" 2>&1 || fail "$(cat "$work/lintian")"
cat "$work/lintian"
for package in planish libplanish0.2; do
    dpkg-deb -f "$work/debs/$package"_*.deb Depends | grep -q 'libhdf5.*libhwloc15' || fail "what $package needs"
done

# ---- again, as the Dockerfile does it, in a folder of another name ------------------------------
mkdir "$work/docker"
cat >"$work/again.sh" <<'END'
set -e
python3 "$1/tests/install/dockerfile.py" "$1/packaging/docker/Dockerfile" "$1" / "$2/docker" "$1/docs/examples/bracket.msh"
cp -r "$2/docker/stage0/root/debs" "$2/debs-again"
END
CCACHE_DISABLE=1 "${enter[@]}" bash "$work/again.sh" "$source_dir" "$work" >"$work/log" 2>&1 ||
    fail "the Dockerfile: $(cat "$work/log")"
diff -r "$work/debs" "$work/debs-again" || fail "the same source gives other bytes"

# ---- a newer version, for an upgrade ------------------------------------------------------------
mkdir "$work/newer"
for deb in "$work"/debs/*.deb; do
    rm -rf "$work/unpacked"
    dpkg-deb -R "$deb" "$work/unpacked"
    sed -i 's/^Version: .*/Version: 9.9.9-1/; s/(= [0-9.-]*)/(= 9.9.9-1)/' "$work/unpacked/DEBIAN/control"
    dpkg-deb --root-owner-group -b "$work/unpacked" "$work/newer" >/dev/null || fail "the newer version"
done

cp -r "$here" docs/examples/bracket.msh "$work/"
chmod -R a+rX "$work"
"${enter[@]}" bash "$here/packages_inside.sh" "$work" || fail "see above"
echo ok
