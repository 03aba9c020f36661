#!/usr/bin/env bash
# Elements that are thin in layers: the user is warned of what smoothing does to them, and of what
# keeps them; then they are kept, to the bit.
. "$(dirname "$0")/common.sh"

# A cube of 10 cells in each direction, the lowest three rows a tenth as high: 1800 thin elements.
# layered.mesh has one region, parts.mesh and parts.msh one more for the layers, mixed.mesh for a
# quarter of the others, too.
python3 "$cli/make_mesh.py" 10 0.01 cube.mesh
python3 - <<'END'
import mesh_file
cube = mesh_file.read("cube.mesh")
ROWS, N = 3, 10


def height(z):
    return z / 10 if z <= ROWS / N else z - ROWS / N * 0.9


points = [(x, y, height(round(z * N) / N)) for x, y, z in cube.points]
is_thin = [max(points[n][2] for n in e) <= (ROWS + 0.5) / N / 10 for e in cube.elements]
assert sum(is_thin) == 6 * ROWS * N * N
parts = [1 + t for t in is_thin]
mixed = [p if i % 4 else 2 for i, p in enumerate(parts)]
for name, regions in (("layered", cube.regions), ("parts", parts), ("mixed", mixed)):
    with open(name + ".mesh", "w") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % len(points))
        file.writelines("%r %r %r 0\n" % p for p in points)
        file.write("Tetrahedra\n%d\n" % len(parts))
        file.writelines("%d %d %d %d %d\n" % (*(n + 1 for n in e), r)
                        for e, r in zip(cube.elements, regions))
        file.write("End\n")
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
    expect_text ": --fix-layers keeps them"
    expect_json "r['mesh']['layer_elements'] == 1800"
    expect_status 0 "$program" $command -q --json report.json
    [ ! -s err ] || fail "nothing should be said with -q: $command"
    expect_json "r['mesh']['layer_elements'] == 1800"
    expect_status 0 "$program" $command -q
done
expect_status 0 "$program" quality layered.mesh
expect_text "smoothing would make them regular"
expect_status 0 "$program" quality "$sample" layered.mesh
[ "$(grep -c "thin in layers" err)" -eq 1 ] && expect_text "note: layered.mesh: "
expect_status 0 "$program" smooth layered.mesh -o out.mesh
expect_text "smoothing makes them regular"
kept layered.mesh out.mesh no

# ---- kept

for options in "" "--slide auto" "--method laplacian" "--objective worst"; do
    for threads in 1 2; do
        expect_status 0 "$program" smooth layered.mesh -o out$threads.mesh --fix-layers $options -j $threads \
            --json report.json
        expect_text "are thin in layers, and held"
        expect_json "r['mesh']['layer_elements'] == 1800 <= r['mesh']['fixed_elements']"
        kept layered.mesh out$threads.mesh yes
    done
    cmp out1.mesh out2.mesh || fail "the threads change the bits: $options"
done
expect_status 0 "$program" quality layered.mesh --fix-layers -q --json report.json
expect_json "r['mesh']['layer_elements'] == 1800 <= r['mesh']['fixed_elements']"
could_slide() {
    "$program" quality layered.mesh "$@" -q --json - | python3 -c "import json, sys; print(json.load(sys.stdin)['mesh']['could_slide'])"
}
[ "$(could_slide --fix-layers)" -lt "$(could_slide)" ] || fail "what is held cannot slide"

# ---- a group that is the layers is named, and holding it is enough

for case in "parts.mesh|3:2|--fix 3:2" "parts.msh|near the wall|--fix 'near the wall'"; do
    IFS='|' read -r file tag option <<<"$case"
    expect_status 0 "$program" smooth $file -o out.${file##*.} --ignore-regions
    expect_text ": $option keeps them"
    expect_status 0 "$program" smooth $file -o out.${file##*.} --ignore-regions --fix "$tag" --json report.json
    ! grep -q "thin in layers" err || fail "they are held"
    expect_json "r['mesh']['layer_elements'] == 1800"
    kept $file out.${file##*.} yes
done
expect_status 0 "$program" quality mixed.mesh
expect_text ": --fix-layers keeps them"

# ---- meshes without layers

for file in "$sample" cube.mesh; do
    for command in "smooth $file -o out.${file##*.}" "quality $file"; do
        expect_status 0 "$program" $command --json report.json
        ! grep -q "thin in layers" err || fail "there are none: $command"
        expect_json "not r['mesh']['layer_elements']"
    done
done
python3 "$cli/make_mesh.py" 10 0.9 tangled.mesh
expect_status 0 "$program" quality tangled.mesh --json report.json
! grep -q "thin in layers" err || fail "there are none in a tangled mesh"
expect_json "r['mesh']['layer_elements'] is not None and r['mesh']['layer_elements'] < 60"
expect_status 0 "$program" smooth cube.mesh -o out.mesh --fix-layers
expect_text "note: 0 elements (0 %) are thin in layers, and held"

finish
