#!/usr/bin/env bash
# VTK's XML files as VTK and meshio write them, in every encoding: smoothed they are what these read,
# with other points. Needs python3-vtk9 and python3-meshio.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
has_modules meshio numpy vtk ||
    { echo "skipped: no VTK, meshio or numpy"; exit 77; }

if lacks "$source_folder/tests/data/ascii.vtu"; then
    echo "skipped: planish was built without Expat"
    exit 77
fi
"$python" "$cli/vtk_variants.py" "$source_folder/tests/data/ascii.vtk" >all || fail "no files"
[ "$(wc -l <all)" -gt 50 ] || fail "there should be more variants"
some $(tac all) >names # the first is of meshio
while read -r name; do
    ! lacks "$name" || continue
    expect_status 0 "$program" smooth "$name" -o "smooth-$name" --json "$name.json" -q
    expect_status 0 "$program" smooth "$name" -o same.vtu --max-sweeps 0 -q
    cmp -s "$name" same.vtu || fail "$name: not the same bytes where nothing moved"
done <names
# However it is written, it is one mesh, and what is smoothed of it is so everywhere.
python3 - >pairs <<'END' || fail "the encodings differ"
import glob, json
rms = {}
for path in sorted(glob.glob("*.json")):
    report, name = json.load(open(path)), path[:-len(".json")]
    print(name, "smooth-" + name, report["moved_nodes"])
    rms.setdefault(name.endswith("1.vtu"), set()).add(report["after"]["rms_radius_ratio"])
assert all(len(values) == 1 for values in rms.values()) and len(rms) == 2, rms
END
[ "$(wc -l <pairs)" -gt $(($(wc -l <names) / 2)) ] || fail "too few were smoothed"
"$python" "$cli/same_vtu.py" <pairs || fail "as VTK reads them"
"$python" -c "
import meshio
name = '$(head -n 1 names)'
a, b = meshio.read(name), meshio.read('smooth-' + name)
assert (a.points != b.points).any() and len(a.cells) == len(b.cells)
assert all((x.data == y.data).all() for x, y in zip(a.cells, b.cells))" || fail "meshio"
finish
