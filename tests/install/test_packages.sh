#!/usr/bin/env bash
# Debian's packages: built twice with the same bytes, looked at by lintian; installed, used, upgraded, removed and
# purged in a copy of this system that lives in memory alone (packages_inside.sh).
set -u
here=$(cd "$(dirname "$0")" && pwd)
source_dir=${PLANISH_SOURCE:?}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
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
enter=(unshare --mount)
[ "$(id -u)" = 0 ] || enter+=(--map-root-user)
"${enter[@]}" true 2>/dev/null || skip "no mounts of one's own are allowed"

cd "$source_dir" || exit 1
export SOURCE_DATE_EPOCH=1700000000
tools/install/deb "$work/debs" || fail "the packages are not built"
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

# ---- again, elsewhere ---------------------------------------------------------------------------
mkdir "$work/again"
tar -c --exclude='./build*' --exclude=./.git . | tar -x -C "$work/again"
CCACHE_DISABLE=1 "$work/again/tools/install/deb" "$work/debs-again" || fail "they are not built again"
rm -rf "$work/again"
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
