#!/usr/bin/env bash
# Who may do what with the files that planish writes: a file that is replaced can be read by nobody
# who could not read it before, and links that the system does not follow are not followed.
. "$(dirname "$0")/common.sh"

cp "$sample" in.msh
cp "$source_folder"/tests/data/tetgen.{node,ele} .
"$program" smooth in.msh -o reference.msh -q || exit 1

# ---- links of others in a folder that all may write to -------------------------------------------

# Root is refused what anybody is. Where the kernel does not do so (fs.protected_symlinks=0), the
# preloaded library does.
protected=()
if [ "$(cat /proc/sys/fs/protected_symlinks 2>/dev/null)" != 1 ]; then
    protected=(env PROTECTED_LINKS=1 "LD_PRELOAD=${PLANISH_FAULTS-}")
fi

# refuses NAME COMMAND...: status 2, one line that names it and says why, and nothing is written.
refuses() {
    local name=$1
    shift
    expect_status 2 "${protected[@]}" "$@"
    expect_one_line
    expect_text "$name"
    expect_text "Permission denied"
    [ "$(cat victim)" = precious ] || fail "$*: what the link leads to was replaced"
    expect_no_file absent
    [ "$(ls sticky other)" = "$before" ] || fail "$*: left behind: $(ls sticky other)"
}

if [ "$(id -u)" -ne 0 ]; then
    echo "not tried: links of others (only root can make them)"
elif [ ${#protected[@]} -gt 0 ] && [ -z "${PLANISH_FAULTS-}" ]; then
    echo "not tried: links of others (this kernel follows them)"
else
    echo precious >victim
    mkdir sticky other
    chmod 1777 sticky
    for name in x.msh x.json x.html x.ele; do
        ln -s ../victim sticky/$name
    done
    ln -s ../absent sticky/new.msh
    ln -s ../sticky/x.msh other/chain.msh
    ln -s chain.msh other/long.msh
    chown -h 65534 sticky/*
    before=$(ls sticky other)
    refuses sticky/x.msh "$program" smooth in.msh -o sticky/x.msh -q
    refuses sticky/new.msh "$program" smooth in.msh -o sticky/new.msh -q
    refuses other/chain.msh "$program" smooth in.msh -o other/chain.msh -q
    refuses other/long.msh "$program" smooth in.msh -o other/long.msh -q
    refuses sticky/x.json "$program" quality in.msh --json sticky/x.json -q
    refuses sticky/x.html "$program" quality in.msh --report sticky/x.html -q
    refuses sticky/x.json "$program" smooth in.msh -o out.msh --json sticky/x.json -q
    refuses sticky/x "$program" smooth tetgen.node -o sticky/x.node -q
    expect_no_file out.msh sticky/x.node
    # One's own are followed, and so are all where not everybody can lay them.
    chown -h 0 sticky/x.msh
    expect_status 0 "${protected[@]}" "$program" smooth in.msh -o other/long.msh -q
    cmp victim reference.msh || fail "one's own links"
    ln -s ../victim other/x.json
    chown -h 65534 other/x.json
    expect_status 0 "${protected[@]}" "$program" quality in.msh --json other/x.json -q
    grep -q checksum victim || fail "a link in a folder that is not everybody's"
    rm -r sticky other
fi

# ---- modes, owners, access lists and attributes --------------------------------------------------

# Lists are made and read as the bytes that Linux keeps; their tools need not be installed.
cat >rights.py <<'END'
import os, struct, sys
LIST = "system.posix_acl_access"


def entries(*entries):
    """An access list: (tag, rights, number) each."""
    return struct.pack("<I", 2) + b"".join(struct.pack("<HHI", t, r, n & 0xffffffff)
                                           for t, r, n in entries)


def state(path):
    about = os.stat(path)
    names = [n for n in os.listxattr(path) if n == LIST or n.startswith("user.")]
    return [oct(about.st_mode), about.st_uid, about.st_gid] + \
        [(n, os.getxattr(path, n)) for n in sorted(names)]


SHARED = entries((1, 6, -1), (2, 4, 1234), (4, 0, -1), (0x10, 4, -1), (0x20, 0, -1))
DEFAULT = entries((1, 7, -1), (2, 7, 1234), (4, 7, -1), (0x10, 7, -1), (0x20, 7, -1))
END
cat >try.py <<'END'
import subprocess, sys
from rights import *


def smooth(path, *before):
    subprocess.run([*before, PROGRAM, "smooth", "in.msh", "-o", path, "-q"], check=True)
    assert open(path, "rb").read() == open("reference.msh", "rb").read()


def old(path, mode):
    open(path, "w").close()
    os.chmod(path, mode)
    return path


def has_lists():
    try:
        os.setxattr(old("probe", 0o600), LIST, SHARED)
        os.setxattr("probe", "user.note", b"1")
    except OSError:
        print("not tried: access lists (this file system has none)")
        return False
    return True


PROGRAM = os.environ["PLANISH_PROGRAM"]
for mode in (0o600, 0o640, 0o444, 0o664, 0o1604):
    smooth(old("mode.msh", mode))
    assert os.stat("mode.msh").st_mode & 0o7777 == mode, oct(mode)

if has_lists():
    # The list stays, and the mask is not taken for rights of the group.
    os.setxattr(old("listed.msh", 0o600), LIST, SHARED)
    os.setxattr("listed.msh", "user.note", b"of an owner")
    before = state("listed.msh")
    smooth("listed.msh")
    assert state("listed.msh") == before, state("listed.msh")
    # The folder's list is for new files.
    os.mkdir("inheriting")
    os.setxattr("inheriting", "system.posix_acl_default", DEFAULT)
    plain = old("inheriting/plain.msh", 0o640)
    os.removexattr(plain, LIST)
    os.chmod(plain, 0o640)
    smooth(plain)
    assert state(plain)[0] == "0o100640" and LIST not in os.listxattr(plain), state(plain)
    smooth("inheriting/new.msh")
    assert LIST in os.listxattr("inheriting/new.msh")

# Another one's file in a folder that all may write to: what its group could do that others could not
# nobody can, and what others could its group could not.
NOBODY, GROUP = 65534, 54321
if os.getuid() != 0:
    sys.exit()
as_nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
with_group = ["setpriv", "--reuid=65534", "--regid=65534", f"--groups={GROUP}"]
os.chmod(".", 0o777)
if subprocess.run([*as_nobody, "test", "-x", PROGRAM, "-a", "-r", "in.msh"]).returncode:
    print("not tried: another user (who cannot run the program)")
    sys.exit()
for mode, wanted in ((0o664, 0o644), (0o640, 0o600), (0o604, 0o600), (0o2755, 0o755),
                     (0o4711, 0o711)):
    os.chown(old("theirs.msh", mode), 0, GROUP)
    os.chmod("theirs.msh", mode)
    smooth("theirs.msh", *as_nobody)
    about = os.stat("theirs.msh")
    assert (about.st_uid, about.st_gid) == (NOBODY, NOBODY)
    assert about.st_mode & 0o7777 == wanted, (oct(mode), oct(about.st_mode))
    # A member of the group can let it have the file.
    os.chown(old("ours.msh", mode), 0, GROUP)
    os.chmod("ours.msh", mode)
    smooth("ours.msh", *with_group)
    about = os.stat("ours.msh")
    assert (about.st_uid, about.st_gid) == (NOBODY, GROUP)
    assert about.st_mode & 0o777 == mode & 0o777, (oct(mode), oct(about.st_mode))
# Root lets the owner have it.
os.chown(old("given.msh", 0o640), NOBODY, GROUP)
smooth("given.msh")
about = os.stat("given.msh")
assert (about.st_uid, about.st_gid, about.st_mode & 0o7777) == (NOBODY, GROUP, 0o640)
if has_lists():
    theirs = entries((1, 6, -1), (2, 4, 1234), (4, 6, -1), (0x10, 6, -1), (0x20, 4, -1))
    os.chown(old("list.msh", 0o600), 0, GROUP)
    os.setxattr("list.msh", LIST, theirs)
    smooth("list.msh", *as_nobody)
    wanted = entries((1, 6, -1), (2, 4, 1234), (4, 4, -1), (0x10, 6, -1), (0x20, 4, -1))
    assert os.getxattr("list.msh", LIST) == wanted, os.getxattr("list.msh", LIST)
END
chmod a+rx "$work"
python3 try.py || fail "rights of a file that is replaced"
expect_no_file ./*.planish-*
finish
