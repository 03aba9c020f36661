#!/usr/bin/env bash
# Elements that are thin in layers: the user is warned of what smoothing does to them, and of what
# keeps them; then they are kept, to the bit.
. "$(dirname "$0")/common.sh"

# A cube of 10 cells in each direction, the lowest three rows a tenth as high: 1800 thin elements, of
# which 1728 have a node that is not on the surface. layered.mesh has one region, parts.mesh and
# parts.msh one more for the layers, mixed.mesh for a quarter of the others, too. In folded.mesh they
# lie over the others, inverted. In flat.mesh all cells are low; in grown.mesh four rows grow by 1.5,
# of which the last two are not thin any more. bricks.msh has hexahedra in the lowest three rows.
python3 "$cli/make_mesh.py" 10 0.01 cube.mesh
python3 - <<'END'
import mesh_file
cube = mesh_file.read("cube.mesh")
ROWS, N = 3, 10


def height(z):
    return z / 10 if z <= ROWS / N else z - ROWS / N * 0.9


def write(name, points, elements, regions):
    with open(name + ".mesh", "w") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
        file.writelines("%r %r %r 0\n" % p for p in points)
        file.write("Tetrahedra\n%d\n" % len(regions))
        file.writelines("%d %d %d %d %d\n" % (*(n + 1 for n in e), r)
                        for e, r in zip(elements, regions))
        file.write("End\n")


points = [(x, y, height(round(z * N) / N)) for x, y, z in cube.points]
is_thin = [max(points[n][2] for n in e) <= (ROWS + 0.5) / N / 10 for e in cube.elements]
assert sum(is_thin) == 6 * ROWS * N * N
parts = [1 + t for t in is_thin]
mixed = [p if i % 4 else 2 for i, p in enumerate(parts)]
for name, regions in (("layered", cube.regions), ("parts", parts), ("mixed", mixed)):
    write(name, points, cube.elements, regions)
TOP = ROWS / N / 10
write("folded", [(x, y, z if z > TOP else 2 * TOP - z) for x, y, z in points], cube.elements, parts)
flat = [(x, y, z / 10) for x, y, z in cube.points]
write("flat", flat, cube.elements, cube.regions)
grown = [(x, y, 0.02 * (1.5 ** round(10 * z) - 1) / 0.5 if z < 0.45 else z - 0.2375)
         for x, y, z in cube.points]
write("grown", grown, cube.elements, cube.regions)
cell = {tuple(round(N * c) for c in p): i for i, p in enumerate(cube.points)}
CORNERS = (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)
bricks = [[cell[x + a, y + b, z + c] + 1 for a, b, c in CORNERS]
          for x in range(N) for y in range(N) for z in range(ROWS)]
with open("bricks.msh", "w") as file:
    file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n" % len(points))
    file.writelines("%d %r %r %r\n" % (i + 1, *p) for i, p in enumerate(points))
    others = [(5, b) for b in bricks] + [(4, [n + 1 for n in e]) for e, t in zip(cube.elements, is_thin) if not t]
    file.write("$EndNodes\n$Elements\n%d\n" % len(others))
    file.writelines("%d %d 2 0 1 %s\n" % (i + 1, t, " ".join(map(str, e))) for i, (t, e) in enumerate(others))
    file.write("$EndElements\n")
with open("parts.msh", "w") as file:
    file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"far\"\n"
               "3 2 \"near the wall\"\n$EndPhysicalNames\n$Nodes\n%d\n" % len(points))
    file.writelines("%d %r %r %r\n" % (i + 1, *p) for i, p in enumerate(points))
    file.write("$EndNodes\n$Elements\n%d\n" % len(parts))
    file.writelines("%d 4 2 %d 7 %d %d %d %d\n" % (i + 1, r, *(n + 1 for n in e))
                    for i, (e, r) in enumerate(zip(cube.elements, parts)))
    file.write("$EndElements\n")
END

# kept IN OUT yes|no: the nodes of the layers are where they were, to the bit; others have moved.
kept() {
    python3 - "$@" <<'END' || fail "layers kept should be $3: $1 $2"
import sys
import mesh_file
old, new = (mesh_file.read(name).points for name in sys.argv[1:3])
moved = [a[2] for a, b in zip(old, new) if a != b]
assert any(z > 0.1 for z in moved)
assert any(z < 0.031 for z in moved) == (sys.argv[3] == "no")
END
}

# ---- warned

for command in "smooth layered.mesh -o out.mesh" "quality layered.mesh"; do
    expect_status 0 "$program" $command --json report.json
    [ "$(grep -c '^note: .* thin in layers' err)" -eq 1 ] || fail "one note was expected: $command"
    expect_text "note: 1728 elements (29 %) are thin in layers (a boundary layer?): --fix-layers keeps them"
    expect_json "(r['mesh']['layer_elements'], r['mesh']['free_layer_elements']) == (1800, 1728)"
    expect_status 0 "$program" $command -q --json report.json
    [ ! -s err ] || fail "nothing should be said with -q: $command"
    expect_json "r['mesh']['layer_elements'] == 1800"
    expect_status 0 "$program" $command -q
done
expect_status 0 "$program" quality "$sample" layered.mesh
[ "$(grep -c "thin in layers" err)" -eq 1 ] && expect_text "note: layered.mesh: "
expect_status 0 "$program" smooth layered.mesh -o out.mesh --report page.html
kept layered.mesh out.mesh no
grep -q "elements were thin in layers" page.html || fail "the page should say it, too"

# ---- kept

for options in "" "--slide auto" "--method laplacian" "--objective worst"; do
    for threads in 1 2; do
        expect_status 0 "$program" smooth layered.mesh -o out$threads.mesh --fix-layers $options -j $threads \
            --json report.json
        expect_text "are thin in layers, and held"
        expect_json "r['mesh']['layer_elements'] == 1800 <= r['mesh']['fixed_elements']"
        expect_json "r['mesh']['free_layer_elements'] == 0"
        kept layered.mesh out$threads.mesh yes
    done
    cmp out1.mesh out2.mesh || fail "the threads change the bits: $options"
done
expect_status 0 "$program" quality layered.mesh --fix-layers -q --json report.json --report page.html
! grep -q "elements were thin in layers" page.html || fail "layers that are held need no warning in the page"
expect_json "r['mesh']['layer_elements'] == 1800 <= r['mesh']['fixed_elements']"
could_slide() {
    "$program" quality layered.mesh "$@" -q --json - | python3 -c "import json, sys; print(json.load(sys.stdin)['mesh']['could_slide'])"
}
[ "$(could_slide --fix-layers)" -lt "$(could_slide)" ] || fail "what is held cannot slide"

# ---- hexahedra: quality says what smooth does

# Bricks on tetrahedra share no faces: each of their 100 top faces lies against two triangles.
unjoined="note: 100 quadrilateral faces lie against two triangles each: their 121 nodes stay as on the boundary; pyramids between would join the elements"
# The hint names the option that frees the worst element, which layers hold, whatever slides elsewhere.
for options in "--layers hold" "--layers hold --slide auto" "--objective worst"; do
    # shellcheck disable=SC2086
    expect_status 0 "$program" smooth bricks.msh -o out.msh $options --json report.json
    grep -q "^hint: the worst element has no movable node; --layers ignore lets nodes of thin layers move" out ||
        fail "the hint with $options: $(grep '^hint' out)"
    expect_text "$unjoined"
    expect_json "r['after']['max_aspect_ratio'] == r['before']['max_aspect_ratio']"
done
expect_status 0 "$program" smooth bricks.msh -o out.msh --layers ignore --json report.json
expect_json "r['after']['max_aspect_ratio'] < r['before']['max_aspect_ratio']"
! grep -q "^hint:.*layers" out || fail "the hint with --layers ignore: $(grep '^hint' out)"
expect_status 0 "$program" smooth bricks.msh -o out.msh # layers that keep their heights would be held
! grep -q "^hint: --objective worst" out || fail "the hint of layers that are kept: $(grep '^hint' out)"
expect_status 0 "$program" smooth layered.mesh -o out.mesh
! grep -q "quadrilateral faces" err || fail "tetrahedra are joined"
expect_status 0 "$program" quality bricks.msh --json report.json
expect_text "note: 300 elements (6.7 %) are thin in layers, and keep their heights; --layers hold holds their nodes"
expect_json "(r['mesh']['layer_elements'], r['mesh']['free_layer_elements']) == (300, 0)"
expect_json "(r['mesh']['kept_layer_elements'], r['mesh']['held_layer_elements']) == (300, 0)"
cp err noted
expect_status 0 "$program" smooth bricks.msh -o out.msh
expect_text "$(grep 'thin in layers' noted)"
expect_status 0 "$program" smooth bricks.msh -o out.msh --fix-layers --json report.json
expect_text "note: 300 elements (6.7 %) are thin in layers, and held"
expect_json "r['mesh']['layer_elements'] == 300"

# ---- a group that is the layers is named, and holding it is enough

for case in "parts.mesh|3:2|--fix 3:2" "parts.msh|near the wall|--fix 'near the wall'"; do
    IFS='|' read -r file tag option <<<"$case"
    expect_status 0 "$program" smooth $file -o out.${file##*.} --ignore-regions
    expect_text ": $option keeps them"
    expect_status 0 "$program" smooth $file -o out.${file##*.} --ignore-regions --fix "$tag" --json report.json
    ! grep -q "thin in layers" err || fail "they are held"
    expect_json "r['mesh']['layer_elements'] == 1800 and r['mesh']['free_layer_elements'] == 0"
    kept $file out.${file##*.} yes
done
expect_status 0 "$program" quality mixed.mesh
expect_text ": --fix-layers keeps them"
expect_status 0 "$program" quality flat.mesh # all of it: with --fix nothing would move
expect_text "5832 elements (97 %) are thin in layers (a boundary layer?): --fix-layers keeps them"

# ---- inverted ones, and those of rows that are not thin any more

expect_status 0 "$program" quality folded.mesh --ignore-regions --json report.json
expect_text "1728 elements (29 %) are thin in layers (a boundary layer?): --fix 3:2 keeps them"
expect_json "r['quality']['inverted'] == r['mesh']['layer_elements'] == 1800"
expect_status 0 "$program" smooth grown.mesh -o out.mesh --fix-layers --json report.json
expect_json "r['mesh']['layer_elements'] == 2400"

# ---- a layer whose wall was moved: inverted because it is held

# wall.mesh: the lowest plane of nodes but its rim was moved up through the layers.
python3 - <<'END'
import mesh_file
mesh = mesh_file.read("layered.mesh")
inner = lambda p: 0 < p[0] < 1 and 0 < p[1] < 1
points = [(x, y, 0.015 if z == 0 and inner((x, y)) else z) for x, y, z in mesh.points]
with open("wall.mesh", "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
    file.writelines("%r %r %r 0\n" % p for p in points)
    file.write("Tetrahedra\n%d\n" % len(mesh.elements))
    file.writelines("%d %d %d %d 1\n" % tuple(n + 1 for n in e) for e in mesh.elements)
    file.write("End\n")
END
expect_status 1 "$program" smooth wall.mesh -o out.mesh --fix-layers --json report.json
expect_text "of these stay inverted because --fix-layers holds their nodes: run without it to repair them"
expect_json "r['after']['inverted'] > 100 and r['inverted_held'] == {'fix_layers': r['after']['inverted'], 'fix': 0, 'regions': 0}"
! grep -q "by moving free nodes" err || fail "the option holds them, and nothing else"
expect_status 0 "$program" smooth wall.mesh -o out.mesh --json report.json
expect_json "r['before']['inverted'] > 100 and r['inverted_held'] == {'fix_layers': 0, 'fix': 0, 'regions': 0}"

# The same by a group.
expect_status 1 "$program" smooth folded.mesh -o out.mesh --fix 2 --fix 1 --json report.json
expect_text "of these stay inverted because --fix holds their nodes"
expect_json "r['inverted_held']['fix'] > 1000"

# ---- meshes that are stretched throughout, and without edges across

python3 - <<'END'
import math
import mesh_file
cube = mesh_file.read("cube.mesh")
cut = [(x, 0.6 * y + 0.8 * z, 1e-3 * (0.6 * z - 0.8 * y)) for x, y, z in cube.points]
n = 400
fan = [(0, 0, 0), (0, 0, 1), (0, 0, -1)]
fan += [(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n), 0) for i in range(n)]
slices = [e for i in range(n) for a, b in [(3 + i, 3 + (i + 1) % n)]
          for e in ((0, a, b, 1), (0, b, a, 2))]
for name, points, elements in (("stretched", cut, cube.elements), ("fan", fan, slices)):
    with open(name + ".mesh", "w") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
        file.writelines("%r %r %r 0\n" % p for p in points)
        file.write("Tetrahedra\n%d\n" % len(elements))
        file.writelines("%d %d %d %d 1\n" % tuple(n + 1 for n in e) for e in elements)
        file.write("End\n")
END
expect_status 0 "$program" quality stretched.mesh --json report.json
expect_text "are thin in layers (a boundary layer?): --fix-layers keeps them"
expect_json "r['mesh']['layer_elements'] == r['mesh']['elements']"

# ---- meshes without layers

expect_status 0 "$program" quality fan.mesh --json report.json # slices around an axis
! grep -q "thin in layers" err || fail "slices are no layers"
expect_json "r['mesh']['free_nodes'] == 1 and r['mesh']['layer_elements'] == 0"

for file in "$sample" cube.mesh; do
    for command in "smooth $file -o out.${file##*.}" "quality $file"; do
        expect_status 0 "$program" $command --json report.json
        ! grep -q "thin in layers" err || fail "there are none: $command"
        expect_json "not r['mesh']['layer_elements'] and not r['mesh']['free_layer_elements']"
    done
done
python3 "$cli/make_mesh.py" 10 0.9 tangled.mesh
expect_status 0 "$program" quality tangled.mesh --json report.json
! grep -q "thin in layers" err || fail "there are none in a tangled mesh"
expect_json "r['mesh']['layer_elements'] is not None and r['mesh']['layer_elements'] < 60"
expect_status 0 "$program" smooth cube.mesh -o out.mesh --fix-layers
expect_text "note: 0 elements (0 %) are thin in layers, and held"

finish
