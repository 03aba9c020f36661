#!/usr/bin/env bash
# Called by test_packages.sh, in a mount namespace of its own: packages_inside.sh FOLDER, which has packages in debs and
# newer. First a copy of this system, in memory, is laid over it; then the script calls itself in there, where copy has
# what was changed.
set -u
work=$1
fail() {
    echo "FAILED: $*" >&2
    exit 1
}
quiet() {
    "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }
}

if [ "${2-}" != inside ]; then
    mkdir "$work/copy"
    mount -t tmpfs tmpfs "$work/copy" && mkdir "$work"/copy/{changed,work,root} &&
        mount -t overlay overlay -o "lowerdir=/,upperdir=$work/copy/changed,workdir=$work/copy/work" "$work/copy/root" &&
        mkdir -p "$work/copy/root/$work" && mount --bind "$work" "$work/copy/root/$work" &&
        mount --bind "$work/copy/changed" "$work/copy/root/$work/copy" &&
        mount --rbind /proc "$work/copy/root/proc" && mount --rbind /dev "$work/copy/root/dev" ||
        fail "there is no copy of the system"
    exec chroot "$work/copy/root" /bin/bash "$work/install/packages_inside.sh" "$work" inside
fi

as_user=(setpriv --reuid=65534 --regid=65534 --clear-groups)
mkdir "$work/home"
chmod 777 "$work/home"
cd "$work/home" || exit 1
export HOME=$work/home
unset LD_LIBRARY_PATH PLANISH_LIBRARY PYTHONPATH PKG_CONFIG_PATH CMAKE_PREFIX_PATH
user() {
    "${as_user[@]}" "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$*"; }
}
# Files that were changed or added, and folders that have the project's name.
left_behind() {
    find "$work"/copy/{usr,etc,opt,var/lib} -path '*/var/lib/dpkg' -prune -o -name ld.so.cache -o ! -type d -print -o \
        -name '*planish*' -print 2>/dev/null
}

# What uses the packages: works says what each of them must do.
use_program() {
    user planish smooth "$work/bracket.msh" -o "$work/home/out.msh"
    grep -q 'worst radius ratio .*better' "$work/log" || fail "the bracket is not smoothed"
    user test -s "$work/home/out.msh"
    user bash -c '. /usr/share/bash-completion/completions/planish && complete -p planish'
    [ -e /usr/share/zsh/vendor-completions/_planish ] || fail "nothing for zsh"
    ! command -v man >/dev/null || user bash -c 'man 1 planish && man 3 planish'
}
use_library() {
    local flags
    flags=$(pkg-config --cflags --libs planish planish_io) || fail pkg-config
    # shellcheck disable=SC2086
    user cc "$work/install/pkgconfig/main.c" -o shared $flags
    user ./shared
    grep -q 'RMS 2.* -> 1' "$work/log" || fail "$(cat "$work/log")"
    user ldd shared
    grep -q "libplanish.so.0.2 => .*/libplanish.so.0.2" "$work/log" || fail "$(cat "$work/log")"
    flags=$(pkg-config --cflags --libs --static planish | sed 's/-lplanish /-l:libplanish.a /')
    # shellcheck disable=SC2086
    user cc "$work/install/pkgconfig/main.c" -o static $flags
    user ./static
    rm -rf cmake
    user cmake -S "$work/install/find_package" -B cmake
    user cmake --build cmake
    user cmake/consumer_io "$work/bracket.msh"
}
use_python() {
    user /usr/bin/python3 -c '
import numpy, planish
points = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.8, 0.7]])
planish.smooth(points, numpy.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))
assert abs(points[4] - 0.5).max() < 1e-6, points
assert planish.__file__.startswith("/usr/lib/python3/dist-packages/"), planish.__file__'
}
dpkg_quiet() { quiet env DEBIAN_FRONTEND=noninteractive dpkg "$@"; }

names=(planish libplanish0.2 libplanish-dev python3-planish)
[ -z "$(left_behind)" ] || fail "these are no changes: $(left_behind | head -n 20)"
dpkg_quiet --install "$work"/debs/*.deb
left_behind | grep -q /usr/bin/planish || fail "it is not seen what is left"
use_program
use_library
use_python
[ -z "$(dpkg --verify "${names[@]}")" ] || fail "$(dpkg --verify "${names[@]}")"
compgen -G '/usr/lib/python3/dist-packages/__pycache__/planish*.pyc' >/dev/null ||
    compgen -G '/usr/lib/python3/dist-packages/planish/__pycache__/*.pyc' >/dev/null || fail "the module is not compiled"

# Neither the program nor Python needs what is for developers.
dpkg_quiet --remove libplanish-dev
[ ! -e "$(find /usr/lib -name libplanish.so)" ] || fail "libplanish.so is left"
use_python
dpkg_quiet --install "$work"/debs/libplanish-dev_*.deb

# The library goes only with those that need it.
! dpkg --remove libplanish0.2 >/dev/null 2>&1 || fail "the library was removed alone"

dpkg_quiet --install "$work"/newer/*.deb
dpkg-query -W -f '${Version} ${db:Status-Status}\n' "${names[@]}" | grep -vx '9.9.9-1 installed' && fail "no upgrade"
use_program
use_library
use_python

dpkg_quiet --remove "${names[@]}"
ldconfig -p | grep planish && fail "ld.so.cache still has it"
dpkg_quiet --purge "${names[@]}"
dpkg-query -W "${names[@]}" 2>/dev/null && fail "dpkg still has them"
compgen -G '/var/lib/dpkg/info/*planish*' && fail "dpkg still has files of them"
[ -z "$(left_behind)" ] || fail "not all is as it was: $(left_behind | head -n 20)"
echo "installed, used, upgraded, removed and purged"
