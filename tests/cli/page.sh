#!/usr/bin/env bash
# The page for people: well-formed, complete, alone; the same from the run and from its JSON.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 6 0.9 tangled.mesh
cp "$source_folder/tests/data/square.msh" square.msh
expect_status 0 "$program" smooth "$sample" -o none.msh --report none.html -q
grep -q "without three.js" none.html && picture="" || picture=yes

# check_page PAGE JSON [MESH...]: with the meshes if this build draws them.
check_page() {
    [ -n "$picture" ] || set -- "$1" "$2"
    python3 "$cli/check_page.py" "$@" || fail "page $1"
}

# In 3-D, untangled, with nodes that slide; in the plane; and the same pages from the JSON.
expect_status 0 "$program" smooth tangled.mesh -o smooth.mesh --slide auto --report run.html --json run.json
check_page run.html run.json tangled.mesh smooth.mesh
for command in "smooth tangled.mesh -o smooth.mesh --slide auto --report -" "report run.json -o -"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" $command
    [ "$(head -n 1 out)" = "<!DOCTYPE html>" ] && [ "$(tail -n 1 out)" = "</html>" ] || fail "not only a page: $command"
    expect_no_file ./-
done
cmp out run.html || fail "the page on standard output is another one"
expect_status 0 "$program" quality tangled.mesh --report -
[ "$(head -n 1 out)" = "<!DOCTYPE html>" ] && grep -q "worst radius ratio" err || fail "quality --report -"
expect_status 2 bash -c "exec \"$program\" quality tangled.mesh --report - -q >/dev/full"
[ "$(wc -l <err)" -eq 1 ] || fail "one message: $(cat err)"
expect_status 0 "$program" report run.json -o again.html
[ ! -s out ] && [ ! -s err ] || fail "report should be silent"
cmp run.html again.html || fail "the page of the JSON is another one"
expect_status 0 "$program" smooth square.msh -o plane.msh --json plane.json --report plane.html -q
check_page plane.html plane.json square.msh plane.msh
expect_status 0 "$program" quality tangled.mesh --json quality.json --report quality.html -q
check_page quality.html quality.json tangled.mesh
expect_status 0 "$program" report quality.json -o again.html
cmp quality.html again.html || fail "the page of quality's JSON"

# Sweeps and inverted elements are counted in whole numbers, also where they are few.
python3 "$cli/make_mesh.py" 3 0.5 few.mesh
expect_status 0 "$program" smooth few.mesh -o smooth.mesh --max-sweeps 1 --report few.html --json few.json -q
python3 - <<'END' || fail "the axes of few sweeps and inverted elements"
import json, re
assert 0 < json.load(open("few.json"))["before"]["inverted"] < 10
sweeps, inverted = re.findall("<figure><h3>(?:By sweep|Inverted).*?</figure>", open("few.html").read(), re.S)
below, beside = ('class="%s"[^>]*>([0-9.e+-]+)<' % word for word in ("middle", "end"))
ticks = re.findall(below, sweeps) + re.findall(below, inverted) + re.findall(beside, inverted)
assert len(ticks) >= 5 and all(tick.isdigit() for tick in ticks), ticks
END

# Ratios of other valid elements than before are not compared; negative values have no percentages.
python3 "$cli/types_mesh.py" block hexahedron 4 0.3 block.vtk
expect_status 0 "$program" smooth block.vtk -o block_out.vtk --json block.json -q
python3 - <<'END'
import json
result = json.load(open("block.json"))
for name, left in ("fewer", 1), ("same", 3):
    for state, inverted, least in ("before", 3, -0.4), ("after", left, -0.2):
        result[state].update(inverted=inverted, inverted_inside=inverted, curved=9, min_jacobian_ratio=least)
    json.dump(result, open(name + ".json", "w"))
END
for name in fewer same; do
    expect_status 0 "$program" report $name.json -o $name.html
done
python3 - <<'END' || fail "changes of aspect ratios and negative values"
import re
rows = lambda page: re.findall('<tr[^>]*><th scope="row">([^<]*)</th>(.*?)</tr>', open(page).read())
words = lambda page, name: re.findall('<td class="(?:change|word[^"]*)">(.*?)</td>', dict(rows(page)[::-1])[name])
assert words("same.html", "RMS aspect ratio")[1] == "better"
assert words("fewer.html", "RMS aspect ratio") == ["", ""]
assert words("same.html", "least Jacobian coefficient / mean, curved elements") == ["", "better"]
names = [name for name, _ in rows("fewer.html")]
assert names[:2] == ["inverted elements", "though their corners are right"], names
END

# A page by itself has the same figures; the first ones of a long list.
expect_status 0 "$program" smooth tangled.mesh -o smooth.mesh --slide auto --report alone.html -q
checksum=$(python3 -c "import json; print(json.load(open('run.json'))['checksum'])")
grep -q "$checksum" alone.html || fail "the checksum of a page without JSON"
expect_status 0 "$program" quality tangled.mesh --worst 1100 --report many.html -q
grep -q "These are the first 1000 of 1100" many.html || fail "a long list"
expect_status 64 bash -c "\"$program\" report /dev/stdin <run.json"
expect_text "name the HTML report by -o"

# Regular elements, whose radius ratio rounding might take below 1.
python3 - >regular.mesh <<'END'
import math, random
random.seed(5)
n = 300
print("MeshVersionFormatted 2 Dimension 2 Vertices", 3 * n)
for i in range(n):
    turn, size = random.uniform(0, 7), random.uniform(0.1, 0.4)
    for j in range(3):
        angle = turn + j * 2 * math.pi / 3
        print(i % 20 + size * math.cos(angle), i // 20 + size * math.sin(angle), 0)
print("Triangles", n)
for i in range(n):
    print(3 * i + 1, 3 * i + 2, 3 * i + 3, 1)
print("End")
END
expect_status 0 "$program" quality regular.mesh --json regular.json --report regular.html -q
check_page regular.html regular.json regular.mesh

# Of more triangles than are drawn: coarsely, but for the bad ones.
python3 - >large.mesh <<'END'
n = 160  # 2 n n triangles of a square, rows pushed to and fro
print("MeshVersionFormatted 2 Dimension 2 Vertices", (n + 1) ** 2)
for j in range(n + 1):
    for i in range(n + 1):
        inside = 0 < i < n and 0 < j < n
        print((i + (0.3 if inside and j % 3 else 0)) / n, j / n, 0)
print("Triangles", 2 * n * n)
for j in range(n):
    for i in range(n):
        a = j * (n + 1) + i + 1
        print(a, a + 1, a + n + 2, 1, a, a + n + 2, a + n + 1, 1)
print("End")
END
expect_status 0 "$program" smooth large.mesh -o few.mesh --max-sweeps 2 --report large.html --json large.json -q
check_page large.html large.json
[ -z "$picture" ] || python3 - large.html <<'END' || fail "the coarse picture"
import base64, json, sys
text = open(sys.argv[1]).read()
text = text[text.index('id="picture-data">') + len('id="picture-data">'):]
picture = json.loads(text[:text.index("</script>")])
drawn = len(base64.b64decode(picture["triangles"])) * 8 // picture["index_bits"] // 3
assert picture["coarse"] and 15000 < drawn <= 40000 < picture["elements"], drawn
for state in picture["states"]:
    assert len(base64.b64decode(state["codes"])) == drawn * len(picture["measures"])
    assert len(base64.b64decode(state["bad_ratios"])) == 4 * 4000
END

# From another folder; the page stands beside the JSON unless told otherwise.
mkdir elsewhere
(cd elsewhere && expect_status 0 "$program" report ../run.json -o here.html && cmp here.html ../run.html) ||
    fail "report from elsewhere"
cp run.json copy.json
expect_status 0 "$program" report copy.json
cmp copy.html run.html || fail "the page beside the JSON"

# A surface in space is drawn from its files, too.
python3 - >ring.off <<'END'
import math
n, m = 16, 8
print("OFF\n%d %d 0" % (n * m, 2 * n * m))
for i in range(n):
    for j in range(m):
        u, v = 2 * math.pi * (i + 0.3 * (j % 2)) / n, 2 * math.pi * j / m
        print((2 + math.cos(v)) * math.cos(u), (2 + math.cos(v)) * math.sin(u), math.sin(v))
for i in range(n):
    for j in range(m):
        a, b, c, d = (k % n * m + l % m for k, l in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        print(3, a, b, c, "\n3", a, c, d)
END
expect_status 0 "$program" smooth ring.off -o round.off --json ring.json --report ring.html -q
expect_status 0 "$program" report ring.json -o again.html
[ ! -s err ] || fail "report of a surface: $(cat err)"
cmp ring.html again.html || fail "the page of the JSON of a surface"

# Meshes that are gone or have changed are not drawn, and that is said.
if [ -n "$picture" ]; then
    mv smooth.mesh gone.mesh
    expect_status 0 "$program" report run.json -o half.html
    expect_text "'smooth.mesh' no longer exists"
    grep -q "no longer exists" half.html || fail "what is not drawn should be said"
    cp tangled.mesh smooth.mesh
    expect_status 0 "$program" report run.json -o half.html
    expect_text "'smooth.mesh' has different coordinates now"
    mv gone.mesh smooth.mesh
    expect_status 0 "$program" report run.json -o half.html -q
    [ ! -s err ] || fail "report -q should be silent"
fi

# Unreadable files and things that are no files cost the picture, not the page, nor time.
if [ -n "$picture" ]; then
    cp run.json odd.json
    for what in pipe $(unless_quick garbage folder); do
        mv smooth.mesh gone.mesh
        case $what in
        garbage) echo rubbish >smooth.mesh ;;
        folder) mkdir smooth.mesh ;;
        pipe) mkfifo smooth.mesh ;;
        esac
        expect_status 0 timeout 60 "$program" report odd.json -o half.html
        expect_text "note: The mesh after is not drawn: its file 'smooth.mesh' "
        python3 "$cli/check_page.py" half.html odd.json tangled.mesh || fail "page without $what"
        rm -rf smooth.mesh
        mv gone.mesh smooth.mesh
    done
    # Another mesh of that name here does not hide the one beside the JSON; nor does a folder that is gone.
    mkdir -p here/deep && cp tangled.mesh here/smooth.mesh
    (cd here && expect_status 0 "$program" report ../run.json -o page.html && [ $failures = 0 ]) ||
        fail "a decoy"
    cmp here/page.html run.html || fail "a decoy hides the mesh"
    expect_status 0 "$program" smooth "$work/tangled.mesh" -o here/deep/x.mesh --json here/deep/x.json -q
    mv here/deep moved && cp tangled.mesh moved/
    (cd moved && expect_status 0 "$program" report x.json && [ ! -s err ]) || fail "a folder that moved"
fi

# More inverted elements than are drawn; what became worse is called so.
python3 "$cli/make_mesh.py" 14 2.5 wild.mesh
expect_status 0 "$program" quality wild.mesh --json wild.json --report wild.html -q
python3 "$cli/check_page.py" wild.html wild.json || fail "page wild.html"
[ -z "$picture" ] || python3 - wild <<'END' || fail "the count of inverted elements"
import json, sys
inverted = json.load(open(sys.argv[1] + ".json"))["quality"]["inverted"]
assert inverted > 4000 and '"inverted":%d' % inverted in open(sys.argv[1] + ".html").read()
END
python3 - run.json <<'END'
import json, sys
result = json.load(open(sys.argv[1]))
result["before"], result["after"] = result["after"], result["before"]
json.dump(result, open("worse.json", "w"))
result["before"]["histogram"]["counts"].append(0)
result["before"]["histogram"]["edges"].insert(0, 0)
result["output"] = "\u0001\u009b\u202e"
json.dump(result, open("bins.json", "w"))
END
expect_status 0 "$program" report worse.json -o worse.html -q
grep -q "does not hold" worse.html || fail "what is worse should not hold"
expect_status 0 "$program" report bins.json -o bins.html -q
[ "$(grep -c '<h3>Radius ratio' bins.html)" = 0 ] || fail "bins that differ are no histogram"
grep -q "<h3>Smallest dihedral" bins.html || fail "the other histogram"
! grep -qP '\x01|\xc2\x9b|\xe2\x80\xae' bins.html || fail "control characters in the page"

# A name is a name, whatever it looks like.
name=$'<script>alert(1)<b>&"\'.msh'
cp "$sample" "$name"
expect_status 0 "$program" smooth "$name" -o "$name" --report odd.html --json odd.json -q
! grep -q '<script>alert(1)' odd.html || fail "a name should be escaped"
check_page odd.html odd.json

# What is no result.
printf '{"mesh": ' >broken.json
expect_status 2 "$program" report broken.json
expect_one_line
expect_text "broken.json, line 1: is not JSON"
head -c 3000 run.json >cut.json
expect_status 2 "$program" report cut.json
expect_one_line
(cat run.json; echo '{') >behind.json
expect_status 2 "$program" report behind.json
expect_one_line
printf '[1, 2]' >list.json
expect_status 2 "$program" report list.json
expect_one_line
expect_text "is not a JSON object"
printf '{"mesh": {"elements": 5}, "before": 3, "after": {}}' >other.json
expect_status 2 "$program" report other.json
expect_one_line
: >empty.json
expect_status 2 "$program" report empty.json
expect_one_line
expect_status 2 "$program" report nowhere.json
expect_one_line
expect_text "nowhere.json"
expect_status 2 "$program" report elsewhere
expect_one_line
expect_no_file broken.html cut.html list.html other.html empty.html nowhere.html elsewhere.html

# Values of any kind: a page is made, or one line says why not.
python3 - run.json <<'END'
import json, sys
result = json.load(open(sys.argv[1]))
odd = [None, -1, 1e308, "text", [], {}, [None] * 3, "\u0000<&>", True]
def spoil(value, k):
    if isinstance(value, dict):
        return {key: spoil(v, k * 31 + i) for i, (key, v) in enumerate(value.items())}
    if isinstance(value, list) and k % 3:
        return [spoil(v, k * 17 + i) for i, v in enumerate(value)]
    return odd[k % len(odd)] if k % 5 == 0 else value
for i in range(40):
    json.dump(spoil(result, i), open("spoilt%d.json" % i, "w"))
END
for i in $(some $(seq 0 39)); do
    "$program" report spoilt$i.json -o spoilt.html -q 2>err
    status=$?
    [ $status = 0 ] || { [ $status = 2 ] && [ "$(wc -l <err)" = 1 ]; } || fail "spoilt$i.json: $status"
    [ $status = 2 ] || ! sed '/<script/,/<\/script>/d' spoilt.html | grep -qE '[^a-z]-?(nan|inf)[^a-z]' ||
        fail "spoilt$i.json: numbers that are none in the page"
done

# Nothing is overwritten by a slip, and nothing is left half-written.
cp run.json keep.json
expect_status 64 "$program" report run.json -o run.json
expect_status 64 "$program" report run.json -o tangled.mesh
expect_status 64 "$program" smooth tangled.mesh -o x.mesh --report tangled.mesh
expect_status 64 "$program" smooth tangled.mesh -o x.mesh --report x.mesh
expect_status 64 "$program" smooth tangled.mesh -o x.mesh --report x.html --json x.html
expect_status 64 "$program" quality tangled.mesh --report tangled.mesh
cmp run.json keep.json || fail "run.json has changed"
expect_no_file x.mesh
expect_status 2 "$program" report run.json -o nowhere/page.html
expect_one_line
expect_status 2 "$program" smooth tangled.mesh -o x.mesh --report nowhere/page.html -q
expect_one_line
expect_no_file x.mesh
if [ -w /dev/full ]; then
    expect_status 2 "$program" report run.json -o /dev/full
    expect_one_line
    expect_status 1 "$program" smooth tangled.mesh -o x.mesh --report /dev/full -q
    expect_one_line
fi
# Of elements of any type the page says that the picture has no mid-side nodes.
python3 - <<'END'
corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
mids = [tuple((a + b) / 2 for a, b in zip(corners[i], corners[j])) for i, j in edges]
for n, kind in (8, 12), (20, 25):
    with open(f"hex{n}.vtk", "w") as file:
        print("# vtk DataFile Version 3.0\nhex\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", n, "double", file=file)
        for place in (corners + mids)[:n]:
            print(*place, file=file)
        print("CELLS 1", n + 1, file=file)
        print(n, *range(n), file=file)
        print("CELL_TYPES 1", kind, sep="\n", file=file)
END
expect_status 0 "$program" quality hex20.vtk --report mids.html -q
grep -q "The picture has no mid-side nodes" mids.html || fail "no word of mid-side nodes of hexahedra"
grep -q "1 element with mid-side nodes" mids.html || fail "the summary has no word of mid-side nodes of hexahedra"
expect_status 0 "$program" quality hex8.vtk --report straight.html -q
! grep -q "mid-side nodes" straight.html || fail "mid-side nodes of straight elements"

finish
