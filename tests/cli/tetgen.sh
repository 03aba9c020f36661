#!/usr/bin/env bash
# The files that tetgen writes beside .node and .ele: those that stay right when nodes move are
# written along, and tetgen reads the result.
. "$(dirname "$0")/common.sh"

command -v tetgen >/dev/null || { echo "skipped: no tetgen"; exit 77; }

cat >cube.poly <<'END'
8 3 0 1
1 0 0 0 1
2 1 0 0 1
3 1 1 0 1
4 0 1 0 1
5 0 0 1 1
6 1 0 1 1
7 1 1 1 1
8 0 1 1 1
6 1
1 0 1
4 1 2 3 4
1 0 2
4 5 6 7 8
1 0 3
4 1 2 6 5
1 0 4
4 2 3 7 6
1 0 5
4 3 4 8 7
1 0 6
4 4 1 5 8
0
1
1 .5 .5 .5 7 0.01
END
tetgen -pqAa0.003nnfezkQ cube.poly || fail tetgen
for extension in node ele face edge neigh vtk; do
    [ -s cube.1.$extension ] || fail "tetgen wrote no .$extension"
done

# Files for tetgen itself: volumes that elements may have, sizes at nodes, a boundary without nodes.
n=$(head -n 1 cube.1.ele | awk '{ print $1 }')
awk -v n="$n" 'BEGIN { print n; for (i = 0; i < n; i++) print i, -1 }' >cube.1.vol
awk 'NR == 1 { print $1, 1; n = $1 } NR > 1 && NR <= n + 1 { print 0.2 }' cube.1.node >cube.1.mtr
sed -e '1,9d' cube.poly | sed -e '1i 0 3 0 1' >cube.1.poly

expect_status 0 "$program" smooth cube.1.node -o smooth.node --json report.json -q
expect_json "r['moved_nodes'] > 0"
for extension in ele face edge neigh vol mtr poly; do
    cmp cube.1.$extension smooth.$extension || fail "smooth.$extension"
done
expect_no_file smooth.vtk
# Where coordinates did not change, nothing did.
changed=$(diff cube.1.node smooth.node | grep -c '^>')
[ "$changed" = "$(python3 -c "import json; print(json.load(open('report.json'))['moved_nodes'])")" ] ||
    fail "$changed lines of .node changed"

# tetgen reads it, refines it where it should, and finds the same neighbours.
tetgen -rnQ smooth.node || fail "tetgen -r"
[ "$(head -n 1 smooth.1.ele | awk '{ print $1 }')" = "$n" ] || fail "elements that tetgen read"
python3 - <<'END' || fail "the neighbours"
def table(name):
    rows = [line.split() for line in open(name) if not line.startswith("#")]
    return [[int(x) for x in row] for row in rows[1:] if row]
elements = {e[0]: set(e[1:5]) for e in table("smooth.ele")}
rows = table("smooth.neigh")
assert len(rows) == len(elements)
for number, *neighbours in rows:
    for other in neighbours:
        assert other == -1 or len(elements[number] & elements[other]) == 3
END
tetgen -raQ smooth.node || fail "tetgen -ra"

# Beside the source of the mesh, and beside Netgen's: neither is touched.
printf 'mesh3d\n' >cube.vol
rm cube.1.poly cube.1.vol
cp cube.poly source.poly
expect_status 0 "$program" smooth cube.1.ele -o cube.ele -q
cmp source.poly cube.poly || fail "cube.poly"
[ "$(cat cube.vol)" = mesh3d ] || fail "cube.vol"
printf '0 3 0 1\n' >cube.1.poly
expect_status 2 "$program" smooth cube.1.ele -o cube.ele -q
expect_one_line
expect_text "cube.poly"
cmp source.poly cube.poly || fail "cube.poly would be lost"
finish
