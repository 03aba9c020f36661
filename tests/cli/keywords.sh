#!/usr/bin/env bash
# Abaqus decks: what else they say than a mesh. Supports that may move, surfaces as tags, included files,
# keywords that a conversion loses, and tags that are mistyped.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_mesh.py" 4 0.2 box.mesh
expect_status 0 "$program" convert box.mesh box.inp
python3 - <<'END' || fail "deck.inp is made"
lines = open("box.inp").read().split("\n")
at = lines.index("*NODE")
place = {}
for line in lines[at + 1:]:
    if line.startswith("*"):
        break
    number, *x = line.split(",")
    place[int(number)] = [float(value) for value in x]
low, high = (sorted(f(p[d] for p in place.values()) for d in range(3)) for f in (min, max))
floor = [i for i, p in place.items() if p[2] == low[0]]
side = [i for i, p in place.items() if p[0] == low[0]]
with open("deck.inp", "w") as deck:
    deck.write("\n".join(lines).rstrip().replace("C3D4", "C3D4H") + "\n")
    deck.write("*NSET, NSET=\"Fixed Base\"\n" + "\n".join(map(str, floor)) + "\n")
    deck.write("*NSET, NSET=HOLE_N\n" + "\n".join(map(str, side)) + "\n")
    deck.write("*SURFACE, TYPE=NODE, NAME=SIDE_SURF\nHOLE_N, 1.\n")
    deck.write("*SURFACE, NAME=FACET_SURF\n1, S1\n*SURFACE, NAME=WHOLE\nVOLUME1,\n")
    deck.write("*INCLUDE, INPUT=sets/contact.inc\n*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n")
    deck.write("*STEP\n*STATIC\n*BOUNDARY\nFixed Base, 1, 3\n*END STEP\n")
END
sed -i 's/^Fixed Base, 1/"Fixed Base", 1/' deck.inp
mkdir sets && echo "*NSET, NSET=EXTRA" >sets/contact.inc && echo 1 >>sets/contact.inc

# The boundary stays by default: no word about supports. Where it slides, the note says what holds them.
expect_status 0 "$program" smooth deck.inp -o out.inp
! grep -q "boundary conditions" err || fail "a note on supports that stay: $(cat err)"
expect_status 0 "$program" smooth deck.inp -o out.inp --slide auto
grep -Eqx "note: [1-9][0-9]* of the 25 nodes with boundary conditions in the file may move; hold them with --fix 'Fixed Base'" err ||
    fail "no note on supports: $(cat err)"
expect_status 0 "$program" smooth deck.inp -o out.inp --slide auto --fix 'Fixed Base'
! grep -q "boundary conditions" err || fail "a note on supports that are held: $(cat err)"
expect_status 0 "$program" smooth deck.inp -o out.inp --slide auto -q
[ ! -s err ] || fail "notes with -q"
expect_status 0 "$program" advise deck.inp
grep -q "^--fix SET holds nodes (planish groups deck.inp)" out ||
    fail "advise on supports: $(cat out)"

# A surface is the nodes that it has; a tag may be spelled in capitals or not, unless it stands in quotes.
expect_status 0 "$program" groups deck.inp
grep -qx "nodes          25  SIDE_SURF" out && grep -qx "nodes           3  FACET_SURF" out || fail "surfaces: $(cat out)"
for tag in HOLE_N hole_n SIDE_SURF side_surf; do
    expect_status 0 "$program" smooth deck.inp -o "$tag.inp" --slide auto --fix $tag -q
    cmp HOLE_N.inp $tag.inp || fail "--fix $tag"
done
expect_status 64 "$program" smooth deck.inp -o out2.inp --fix WHOLE
expect_text "'WHOLE' is a *SURFACE that planish does not take as a group; give the set of nodes or elements"
expect_one_line
expect_status 64 "$program" smooth deck.inp -o out2.inp --fix 'fixed base'
expect_status 64 "$program" smooth deck.inp -o out2.inp --fix HOLEN
expect_text "there is no group 'HOLEN' to hold; did you mean 'HOLE_N'? Try 'planish smooth --help'"
expect_status 64 "$program" smooth deck.inp -o out2.inp --slide HOLE_N
expect_text "'HOLE_N' is a group of nodes, but one of triangles or quadrilaterals is needed"
expect_status 64 "$program" smooth deck.inp -o out2.inp --slide atuo
expect_text "did you mean --slide auto? Try 'planish smooth --help'"
expect_one_line
expect_no_file out2.inp

# Included files are not copied; a missing one is named with the line that wants it.
mkdir elsewhere
expect_status 0 "$program" smooth deck.inp -o elsewhere/out.inp
expect_text "elsewhere/out.inp includes sets/contact.inc, which is not there"
expect_status 0 "$program" smooth deck.inp -o out.inp
! grep -q "includes" err || fail "a note on files that are there: $(cat err)"
mv sets gone
line=$(grep -n '^\*INCLUDE' deck.inp | cut -d : -f 1)
expect_status 2 "$program" smooth deck.inp -o out3.inp
expect_text "deck.inp:$line: "
expect_text "sets/contact.inc"
expect_one_line
mv gone sets

# What a conversion loses has names.
expect_status 0 "$program" convert deck.inp other.inp
for what in "*MATERIAL, *ELASTIC, *STEP, *STATIC, *BOUNDARY" "the type C3D4H (now C3D4)"; do
    expect_text "$what"
done
! grep -q "NSET\|\*NODE\|\*ELEMENT\|HEADING" err || fail "what is kept is called lost: $(cat err)"
expect_status 0 "$program" convert deck.inp other.vtu
expect_text "*MATERIAL, *ELASTIC"
finish
