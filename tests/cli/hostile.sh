#!/usr/bin/env bash
# Files and names that are made to do harm, or happen to: numbers that lie, XML that unpacks or nests
# without measure, files of gigabytes that hold nothing, devices without end, names of any bytes, other
# locales. Each gives a right result, or one line and status 2; never a signal, a hang, much memory or
# something left behind.
. "$(dirname "$0")/common.sh"

# tame STATUS FILES COMMAND...: ends with that status (2: after one line) within minutes, and then there
# are so many files here.
tame() {
    local wanted=$1 files=$2
    shift 2
    expect_status "$wanted" timeout 300 "$@"
    [ "$wanted" -ne 2 ] || expect_one_line
    rm -f out err
    [ "$(find . -mindepth 1 -printf x | wc -c)" -eq "$files" ] || fail "left behind by $*: $(ls -A)"
}

# Sanitizers need address space of their own.
limits=()
megabytes=400
if (ulimit -v 400000 && "$program" --version) >/dev/null 2>&1; then
    limits=(bash -c 'ulimit -v 400000; exec "$@"' limited)
else
    megabytes=0
fi

# ---- numbers that lie ---------------------------------------------------------------------------
mkdir lies
(cd lies && python3 "$cli/lying_counts.py" "$program" "$([ -n "${PLANISH_LONG-}" ] && echo 5 || echo 400)" \
    "$megabytes") || fail "numbers that lie"
rm -r lies

# ---- XML ----------------------------------------------------------------------------------------
mkdir xml && cd xml || exit 1
echo secret >secret
mkfifo pipe # whoever opens it waits for ever
python3 - "$([ -n "${PLANISH_LONG-}" ] && echo 100 || echo 20)" <<'END'
import sys
megabytes = int(sys.argv[1])
head = '<?xml version="1.0"?>\n'
vtk = '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"'
def write(name, *parts):
    with open(name, "w") as file:
        file.writelines(parts)
write("nested.vtu", head, vtk, ">", "<a>" * 1000000, "</a>" * 1000000, "</VTKFile>")
write("open.vtu", head, vtk, ">", "<UnstructuredGrid>" * 1000000)
write("attribute.vtu", head, vtk, ' x="', *["y" * 1000000] * megabytes, '"></VTKFile>')
write("attributes.vtu", head, vtk, *[' a%d="1"' % i for i in range(1000000)], "></VTKFile>")
write("name.vtu", head, "<", *["y" * 1000000] * megabytes, "/>")
write("comment.vtu", head, "<!--", *["y" * 1000000] * megabytes, "-->", vtk, "/>")
laughs = "".join('<!ENTITY l%d "%s">' % (i, "&l%d;" % (i - 1) * 10) for i in range(1, 10))
write("laughs.vtu", head, '<!DOCTYPE l [<!ENTITY l0 "ha">', laughs, "]>", vtk, ">&l9;</VTKFile>")
write("laughs_in_attribute.vtu", head, '<!DOCTYPE l [<!ENTITY l0 "ha">', laughs, "]>", vtk, ' x="&l9;"/>')
for target in "secret", "pipe", "/etc/passwd", "http://127.0.0.1:1/x":
    name = "external_%d.vtu" % len(target)
    write(name, head, '<!DOCTYPE x [<!ENTITY e SYSTEM "%s">]>' % target, vtk, ">&e;</VTKFile>")
    write("p" + name, head, '<!DOCTYPE x [<!ENTITY %% e SYSTEM "%s"> %%e;]>' % target, vtk, "/>")
    write("d" + name, head, '<!DOCTYPE VTKFile SYSTEM "%s">' % target, vtk, "/>")
deep = 10 ** 5
write("laughs.xdmf", head, '<!DOCTYPE l [<!ENTITY l0 "ha">', laughs, "]><Xdmf>&l9;</Xdmf>")
write("deep.xdmf", head, "<Xdmf><Domain>", "<Grid GridType='Tree'>" * deep, "</Grid>" * deep, "</Domain></Xdmf>")
write("paths.xdmf", head, "<Xdmf><Domain>", "".join(
    "<Grid><include xpointer='xpointer(%s[@a=\"%d\"])'/></Grid>" % ("//*" * 9, i) for i in range(20000)), "</Domain></Xdmf>")
points = '<Geometry><DataItem Dimensions="5 3" Format="%s">%s</DataItem></Geometry>'
cells = '<Topology Type="Tetrahedron"><DataItem Dimensions="4">0 1 2 3</DataItem></Topology>'
for i, target in enumerate(("secret", "pipe", "/etc/passwd", "../xml.bin", ".", "http://127.0.0.1:1/x")):
    for form in "Binary", "HDF":
        name = target + (":/x" if form == "HDF" else "")
        write("named_%d_%s.xdmf" % (i, form), head, "<Xdmf><Domain><Grid>", cells, points % (form, name),
              "</Grid></Domain></Xdmf>")
END
n=$(find . -mindepth 1 | wc -l)
for file in *.vtu *.xdmf; do
    tame 2 "$n" "${limits[@]}" "$program" smooth "$file" -o "result.${file##*.}"
done
cd .. && rm -r xml

# ---- parts that multiply --------------------------------------------------------------------------
# Within a minute of CPU, and never for want of memory. (glibc reserves room for each thread, of which the
# limit knows no more than that it is addressed: there is one such room.)
mkdir multiplied && cd multiplied || exit 1
python3 "$cli/multiplied.py"
n=$(find . -mindepth 1 -printf x | wc -c)
frugal=(env MALLOC_ARENA_MAX=1 bash -c 'ulimit -t 60; [ '"$megabytes"' -eq 0 ] || ulimit -v 400000; exec "$@"' limited)
for file in refused_* read_* choose_*; do
    case $file in
    refused_*) wanted=2 action=(groups "$file") ;;
    read_*) wanted=0 action=(groups "$file") ;;
    *) wanted=0 action=(quality "$file" --fix all -q) ;;
    esac
    expect_status $wanted "${frugal[@]}" "$program" "${action[@]}"
    [ $wanted -ne 2 ] || expect_one_line
    ! grep -q "memory\|did not finish" err || fail "$file: $(cat err)"
    rm -f out err
done
for file in convert_*; do
    expect_status 0 bash -c 'ulimit -t 60; exec "$@"' limited "$program" quality "$file" # tags of all regions
    for to in exodus gmsh gmsh22 abaqus nastran medit vtu vtk; do
        expect_status 0 "${frugal[@]}" "$program" convert "$file" -o "result.$to" --to "$to" -q
        [ "$(stat -c %s "result.$to")" -lt 100000000 ] || fail "$file as $to: $(stat -c %s "result.$to") bytes"
        rm -f "result.$to" out err
    done
done
[ "$(find . -mindepth 1 -printf x | wc -c)" -eq "$n" ] || fail "left behind: $(ls -A)"
cd .. && rm -r multiplied

# ---- large files that hold nothing --------------------------------------------------------------
# Mapped they need address space of their size and next to no more. (What is all zeros is text of one
# line: what reads it word by word takes seconds for gigabytes.)
mkdir large && cd large || exit 1
size=$([ -n "${PLANISH_LONG-}" ] && echo 5000000 || echo 100000) # kB
roomy=()
[ "$megabytes" -eq 0 ] || roomy=(bash -c "ulimit -v $((size + 150000))"'; exec "$@"' limited)
python3 -c 'from tiny_meshes import meshes
for name, data in meshes().items():
    open(name, "wb").write(data)'
cp "$source_folder"/tests/data/cube.{vtkhdf,med,h5} .
for file in *; do
    case $file in
    tetgen.face | tetgen.ele) continue ;; # with .node
    *.off | *.ply | *.avs | *.su2 | *.unv | *.stl | *.obj | *.vtu | *.xdmf | *.med | *.vtkhdf | *.h5) wanted=any ;; # what is behind them may be a fault
    *) wanted=0 ;;
    esac
    cp "$file" "../$file" && truncate -s "${size}K" "$file"
    timeout 300 "${roomy[@]}" "$program" quality "$file" -q >../out 2>../err </dev/null
    status=$?
    if [ $status -ne 0 ] && { [ "$wanted" != any ] || [ $status -ne 2 ] || [ "$(wc -l <../err)" -ne 1 ]; }; then
        fail "$file of $size kB: status $status, $(head -c 500 ../err)"
    fi
    mv "../$file" "$file"
done
rm -f ./*
for extension in msh mesh meshb vtk vtu vtkhdf med cgns h5 node vol inp bdf off obj ply stl mfem avs su2 unv exo xdmf; do
    truncate -s "${size}K" "zero.$extension"
    tame 2 1 "${roomy[@]}" "$program" quality "zero.$extension"
    rm "zero.$extension"
done
truncate -s 500M huge.msh # more than may be mapped
[ "$megabytes" -eq 0 ] || tame 2 1 "${limits[@]}" "$program" quality huge.msh
cd .. && rm -r large out err

# ---- what is no file ----------------------------------------------------------------------------
mkdir things && cd things || exit 1
mkdir folder.msh
mkfifo pipe.msh
python3 -c 'import socket; socket.socket(socket.AF_UNIX).bind("socket.msh")'
ln -s loop.msh loop.msh
ln -s nowhere.msh dangling.msh
cp "$source_folder/tests/data/ascii22.msh" in.msh
n=$(find . -mindepth 1 | wc -l)
for input in folder.msh socket.msh loop.msh dangling.msh /dev/zero /dev/full /dev/urandom /dev/null; do
    tame 2 "$n" "${limits[@]}" "$program" smooth "$input" -o result.msh
    tame 2 "$n" "${limits[@]}" "$program" smooth "$input" -o result.msh --format gmsh
    tame 2 "$n" "${limits[@]}" "$program" report "$input" -o result.html
done
for input in /dev/zero /dev/full /dev/urandom; do
    expect_status 2 "${limits[@]}" "$program" quality "$input"
    expect_text "more than 1 MB, and no end"
done
rm out err
for output in folder.msh socket.msh loop.msh /dev/full; do
    tame 2 "$n" "$program" smooth in.msh -o "$output"
done
tame 0 "$n" "$program" smooth in.msh -o /dev/null
[ ! -s nowhere.msh ] || fail "a link without end was followed"
"$program" smooth in.msh -o plain.msh -q
cat in.msh >pipe.msh &
tame 0 $((n + 2)) "$program" smooth pipe.msh -o piped.msh
cat pipe.msh >taken.msh &
tame 0 $((n + 3)) "$program" smooth in.msh -o pipe.msh
wait
cmp plain.msh piped.msh || fail "from a named pipe"
cmp plain.msh taken.msh || fail "to a named pipe"
rm piped.msh taken.msh
# Streams without end: within a limit there is a line, not a killed process.
[ "$megabytes" -eq 0 ] ||
    tame 2 $((n + 1)) bash -c "ulimit -v 400000; yes | \"$program\" smooth /dev/stdin -o result.msh"
cp in.msh result.html && echo '<html>' >page.html
expect_status 2 "$program" report page.html
expect_text "page.html, line 1: is not JSON"
truncate -s 257M large.json
(printf '[' && yes 1, | tr -d '\n' | head -c 70M) >values.json
for file in large values; do
    expect_status 2 bash -c 'ulimit -t 60; exec "$@"' limited "$program" report $file.json
    expect_one_line
    expect_text "$file.json: has more than 256 MB or 33 million values"
done
cd .. && rm -r things

# ---- folders, and what lies beside a mesh -------------------------------------------------------
# Whoever reads a pipe there waits for ever, and a device has no end. Dictionaries nest, packed files
# unpack, lists say one number for all, includes go in circles.
mkdir beside && cd beside || exit 1
python3 - <<'END'
import gzip
import os
from tiny_meshes import POINTS, folders, meshes, numbered

HEAD = "FoamFile{version 2.0;format ascii;class x;object x;}\n"
THINGS = {"fifo": os.mkfifo, "folder": os.mkdir, "zero": lambda path: os.symlink("/dev/zero", path),
          "loop": lambda path: os.symlink(path, path), "nowhere": lambda path: os.symlink("nowhere", path),
          "empty": lambda path: open(path, "w").close()}


def write(path, data):
    with open(path, "wb") as file:
        file.write(data if isinstance(data, bytes) else data.encode())


def folder(name, kind, **changed):
    os.mkdir(name)
    for file, data in {**folders()[kind], **changed}.items():
        if callable(data):
            data(os.path.join(name, file))
        elif data is not None:
            write(os.path.join(name, file), data)


def bomb(path):
    with gzip.open(path, "wb", 9) as file:
        file.write(folders()["openfoam"]["points"][:70])
        for _ in range(300):
            file.write(b" " * (1 << 20))


# What is copied along with a mesh is in its folder: a link may lead to what nobody means to hand on.
write("secret", "secret")
os.mkdir("secrets")
write("secrets/key", "secret")
for kind, file in ("elmer", "mesh.other"), ("openfoam", "other"), ("openfoam", "sets"):
    away = "../secrets" if file == "sets" else "../secret"
    folder("refused_%s_away_%s" % (kind, file), kind, **{file: lambda path, away=away: os.symlink(away, path)})
folder("read_openfoam_link", "openfoam", other=lambda path: os.symlink("points", path))
for kind in "elmer", "openfoam":
    for file in folders()[kind]:
        is_optional = file in ("mesh.names", "cellZones", "faceZones")
        for thing, make in THINGS.items():
            wanted = "read" if is_optional and thing in ("loop", "nowhere", "empty") else "refused"
            folder(f"{wanted}_{kind}_{file}_{thing}", kind, **{file: make})
folder("read_openfoam_others", "openfoam", other=os.mkfifo, more=os.mkdir)
folder("read_elmer_others", "elmer", **{"mesh.other": os.mkfifo})
folder("refused_blocks", "openfoam", boundary=HEAD + "1\n(\na\n{b " + "{c " * 300000)
folder("refused_brackets", "openfoam", boundary=HEAD + "1\n(\na\n{b " + "(" * 1000000)
folder("refused_header", "openfoam", points="FoamFile{" + "a {" * 300000)
folder("refused_comment", "openfoam", points="/*" * 300000)
folder("refused_itself", "openfoam", boundary='#include "boundary"\n')
folder("refused_overlap", "openfoam", boundary=HEAD + "5000\n(\n" + "".join(
    "p%d{type patch;nFaces 6;startFace 1;}\n" % i for i in range(5000)) + ")")
folder("read_patches", "openfoam", boundary=HEAD + "5001\n(\n" + "".join(
    "p%d{type patch;nFaces 0;startFace 1;}\n" % i for i in range(5000)) + "s{type patch;nFaces 6;startFace 1;}\n)")
folder("read_equal", "openfoam", cellZones=HEAD + "5000\n(\n" + "".join(
    "z%d{type cellZone;cellLabels List<label> 65536{0};}\n" % i for i in range(5000)) + ")")
folder("refused_bomb", "openfoam", points=None, **{"points.gz": bomb})
packed = gzip.compress(folders()["openfoam"]["points"])
for i in range(8):
    folder("refused_packed_%d" % i, "openfoam", points=None, **{"points.gz": packed[:len(packed) * i // 8]})
os.mkdir("refused_several")
for i in range(300):
    os.mkdir("refused_several/%d" % i)
    folder("refused_several/%d/polyMesh" % i, "openfoam")

os.mkfifo("pipe.inc")
os.mkdir("folder.inc")
write("round.inc", "*INCLUDE, INPUT=round.inc\n" * 2)
write("round.bulk", "INCLUDE 'round.bulk'\n" * 2)
nodes = "*NODE\n" + numbered(POINTS).replace(" ", ", ")
for name in "pipe.inc", "folder.inc", "round.inc", "refused_round.inp":
    write("refused_%s.inp" % name.split(".")[0].replace("refused_round", "itself"), nodes + "*INCLUDE, INPUT=%s\n" % name)
for name in "pipe.inc", "round.bulk":
    write("refused_%s.bdf" % name.split(".")[0], "BEGIN BULK\nGRID,1,,0.,0.,0.\nINCLUDE '%s'\nENDDATA\n" % name)
for extension in "ele", "face":
    for beside in "ele", "face":
        path = "refused_%s.%s" % (extension, beside)
        os.mkfifo(path) if beside == extension else write(path, meshes()["tetgen." + beside])
    write("refused_%s.node" % extension, meshes()["tetgen.node"])
END
n=$(find . -mindepth 1 -printf x | wc -c)
for mesh in refused_*; do
    case $mesh in *.ele | *.face) continue ;; esac
    out=result
    [ -d "$mesh" ] || out=result.${mesh##*.}
    tame 2 "$n" "${limits[@]}" "$program" smooth "$mesh" -o "$out"
done
for mesh in read_*; do
    expect_status 0 timeout 300 "${limits[@]}" "$program" smooth "$mesh" -o result -q
    rm -r result
done
cd .. && rm -r beside

# ---- names --------------------------------------------------------------------------------------
mkdir names && cd names || exit 1
cp "$source_folder/tests/data/ascii22.msh" ../in.msh
"$program" smooth ../in.msh -o ../plain.msh -q
long=$(printf '%0251d' 0)
deep=$(printf 'd%.0s' {1..200})
# shellcheck disable=SC2016 # the dollar is a part of the name
for name in "a b.msh" "it's.msh" 'quo"te.msh' $'new\nline.msh' '$(touch x).msh' '*.msh' '%s%n.msh' 'back\slash.msh' \
    $'\xff\xfe.msh' $'\xc3\x28.msh' "äöü.msh" $'\e[31m.msh' $'a\xe2\x80\xaeb.msh' $'a\xe2\x81\xa6b.msh' $'a\xc2\x9bb.msh' './-lead.msh' "$long.msh" '<b>&.msh' '.msh.msh'; do
    cp ../in.msh "$name"
    tame 0 1 "$program" smooth "$name" -o "$name"
    cmp "$name" ../plain.msh || fail "smoothed as '$name'"
    expect_status 0 "$program" smooth "$name" -o ../result.msh --json ../report.json --report ../page.html
    ! grep -q $'\e\|\r' err out || fail "control characters of '$name' reach the terminal"
    ! LC_ALL=C grep -qP '\xe2\x80\xae|\xe2\x81\xa6|\xc2\x9b' err out ../report.json ../page.html ||
        fail "characters of '$name' that turn text, or control a terminal"
    expect_status 0 "$program" quality "$name" --json ../quality.json
    python3 -c 'import json, sys
for name in sys.argv[1:]: json.load(open(name, encoding="utf-8"))' ../report.json ../quality.json ||
        fail "JSON with '$name'"
    iconv -f UTF-8 -t UTF-8 ../page.html >/dev/null || fail "page with '$name'"
    rm -f ../page.html out err "$name"
done
tame 2 0 "$program" smooth ../in.msh -o "${long}00000.msh" # 260 bytes
tame 2 0 "$program" quality "${long}00000.msh"
path=.
for i in {1..25}; do path=$path/$deep; done # longer than the system takes
tame 2 0 "$program" quality "$path/in.msh"
tame 2 0 "$program" smooth ../in.msh -o "$path/out.msh"
tame 2 0 "$program" report "$path/in.json"
tame 64 0 "$program" smooth ../in.msh -o ''
tame 64 0 "$program" quality ''
cd .. && rm -rf names

# Names inside of files: as they are in the file, and legal in what is written of them.
mkdir inside && cd inside || exit 1
python3 - <<'END'
from tiny_meshes import meshes
data = meshes()["gmsh22.msh"]
for i, name in enumerate([b"\xff\xfe", b"\xc3(", b"<&>", b"]]>", b"a\x01b", b"\xed\xa0\x80", b"y" * 100000, b"\x1b[31m",
                          b"%s%n", b"\xef\xbf\xbf", b"a\xe2\x80\xaeb", b"a\xe2\x81\xa6b", b"a\xc2\x9bb"]):
    open("%d.msh" % i, "wb").write(data.replace(b"body", name))
END
for file in ?.msh ??.msh; do
    expect_status 0 "$program" smooth "$file" -o same.msh --json report.json --report page.html
    cmp "$file" same.msh || fail "$file is not what it was"
    expect_status 64 "$program" smooth "$file" -o same.msh --fix nobody
    ! grep -q $'\e\|\x01' err || fail "control characters in the message of $file: $(cat err)"
    ! LC_ALL=C grep -qP '\xe2\x80\xae|\xe2\x81\xa6|\xc2\x9b' err report.json page.html ||
        fail "characters that turn text, or control a terminal, of $file"
    expect_status 0 "$program" smooth "$file" -o view.vtu
    python3 -c 'import sys, xml.parsers.expat
head = open("view.vtu", "rb").read().split(b"<AppendedData")[0]
parser = xml.parsers.expat.ParserCreate()
parser.Parse(head, False)' || fail "view of $file is no XML"
    expect_status 0 "$program" quality view.vtu
    expect_status 0 "$program" smooth "$file" -o view.vtk
    expect_status 0 "$program" quality view.vtk
done
cd .. && rm -r inside

# ---- locales ------------------------------------------------------------------------------------
# A decimal comma, letters of which the lower case is another: the same bytes. The program itself
# follows no locale; a library that is loaded first has it do so, as programs may that have it read.
mkdir locales && cd locales || exit 1
echo '#include <locale.h>
__attribute__((constructor)) static void follow(void) { setlocale(LC_ALL, ""); }' >follow.c
if [ "$megabytes" -eq 0 ] || ! cc -shared -fPIC -o follow.so follow.c; then
    echo "skipped: locales (sanitizers want to be loaded first, or there is no compiler)"
    cd .. && finish
fi
files=("$source_folder"/tests/data/{ascii22.msh,medit.mesh,ascii.vtk,ascii.vtu,netgen.vol,abaqus.inp})
[ -z "${PLANISH_LONG-}" ] || files=("$source_folder"/tests/data/*.{msh,mesh,meshb,vtk,vtu,vtkhdf,med,h5,vol,inp,bdf,off,obj,ply,stl,node,avs,su2,unv})

# smooth_in FILE LANGUAGE PRELOAD: to LANGUAGE.out, and to a view in LANGUAGE.view.
smooth_in() {
    local name=${1##*/} out=out.${1##*.}
    LD_PRELOAD=$3 LC_ALL=$2 "$program" smooth "$name" -o "$out" -q --max-sweeps 2 2>err ||
        fail "$2: $name: $(cat err)"
    LD_PRELOAD=$3 LC_ALL=$2 "$program" smooth "$name" -o view.vtu -q --max-sweeps 0 2>err ||
        fail "$2: view of $name: $(cat err)"
    mv "$out" "$2.out" && mv view.vtu "$2.view"
}

for locale in de_DE.UTF-8 tr_TR.UTF-8; do
    localedef -i "${locale%.*}" -f UTF-8 "./$locale" >localedef.txt 2>&1
    export LOCPATH=$PWD
    if ! LC_ALL=$locale python3 -c 'import locale; locale.setlocale(locale.LC_ALL, "")' 2>/dev/null; then
        echo "skipped: no locale $locale, and localedef cannot make it: $(head -c 200 localedef.txt)"
        continue
    fi
    for file in "${files[@]}"; do
        ! lacks "$file" || continue
        case $file in */damaged*) continue ;; esac # it is refused
        cp "$file" . && case $file in *.node) cp "${file%.*}.ele" . ;; esac
        smooth_in "$file" C "" && smooth_in "$file" "$locale" "$PWD/follow.so"
        cmp C.out "$locale.out" || fail "$locale: $file"
        cmp C.view "$locale.view" || fail "$locale: the view of $file"
        rm -f "${file##*/}" C.out C.view
    done
    LC_ALL=$locale expect_status 0 "$program" smooth ../in.msh -o out.msh -q --json report.json \
        --min-volume-fraction 1.5e-9 --max-displacement 0.5h --max-sweeps 1
    python3 -m json.tool report.json >/dev/null || fail "$locale: the report is no JSON"
    LC_ALL=$locale expect_status 64 "$program" smooth ../in.msh -o out.msh --max-displacement 0,5
done
finish
