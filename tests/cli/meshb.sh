#!/usr/bin/env bash
# Medit's binary files as meshio writes them, versions 3 and 4, and those of Mmg and
# PRAgMaTIc: nothing but coordinates changes, and the result is that of the text file.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import numpy, meshio" 2>/dev/null || { echo "skipped: no numpy or meshio"; exit 77; }

python3 "$cli/make_mesh.py" 6 0.2 text.mesh
"$python" - <<'END' >/dev/null 2>&1 || fail "meshio writes"
import meshio, numpy
mesh = meshio.read("text.mesh")
for name, integer in (("v3", "i4"), ("v4", "i8")):
    data = {key: [a.astype(integer) for a in arrays] for key, arrays in mesh.cell_data.items()}
    blocks = [(block.type, block.data.astype(integer)) for block in mesh.cells]
    points = {key: a.astype(integer) for key, a in mesh.point_data.items()}
    meshio.Mesh(mesh.points, blocks, points, data).write(name + ".meshb", file_format="medit")
END

expect_status 0 "$program" smooth text.mesh -o text_smooth.mesh --json text.json -q
for version in 3 4; do
    name=v$version
    # The version is the file's second number.
    [ "$(od -An -i -j4 -N4 $name.meshb | tr -d ' ')" = $version ] || fail "meshio wrote no $name"
    expect_status 0 "$program" smooth $name.meshb -o ${name}_smooth.meshb --json report.json -q
    "$python" "$cli/same_mesh.py" $name.meshb ${name}_smooth.meshb report.json || fail $name
    [ "$(stat -c %s $name.meshb)" = "$(stat -c %s ${name}_smooth.meshb)" ] || fail "$name: size"
done
"$python" - <<'END' || fail "binary and text are smoothed alike"
import meshio, numpy
text = meshio.read("text_smooth.mesh").points
for name in "v3", "v4":
    assert numpy.array_equal(meshio.read(name + "_smooth.meshb").points, text), name
END

# Big-endian files, and sections that meshio does not write.
if [ -n "${PLANISH_MESHES-}" ]; then
    for name in mmg_cube prag_cube20; do
        expect_status 0 "$program" smooth "$PLANISH_MESHES/$name.meshb" -o out.meshb \
            --slide auto --json report.json -q
        "$python" "$cli/same_mesh.py" "$PLANISH_MESHES/$name.meshb" out.meshb report.json ||
            fail $name
    done
fi

# The content says what it is, not the name.
cp v3.meshb binary.mesh
cp text.mesh text.meshb
expect_status 0 "$program" quality binary.mesh -q
expect_status 0 "$program" quality text.meshb -q
expect_status 64 "$program" smooth v3.meshb -o other.mesh -q
expect_one_line
expect_no_file other.mesh
expect_status 0 "$program" smooth binary.mesh -o other.mesh -q
head -c 3000 v3.meshb >cut.meshb
expect_status 2 "$program" smooth cut.meshb -o out2.meshb
expect_one_line
expect_no_file out2.meshb
finish
