#!/usr/bin/env bash
# planish groups: each group once, as --fix takes it; of many groups as fast as of few.
. "$(dirname "$0")/common.sh"

cp "$sample" a.msh
expect_status 0 "$program" groups a.msh
grep -qx "solids  *[1-9][0-9]*  bracket" out && grep -qx "faces   *[1-9][0-9]*  skin" out || fail "groups: $(head -n 5 out)"
[ "$(sort out | uniq -d)" = "" ] || fail "a group is listed twice"
[ ! -s err ] || fail "messages: $(cat err)"

# Sets of one name, for nodes and elements, are two rows; the same set in two parts is one.
cat >deck.inp <<'END'
*NODE, NSET=both
1,0,0,0
2,1,0,0
3,0,1,0
4,0,0,1
*ELEMENT, TYPE=C3D4, ELSET=both
1,1,2,3,4
*NSET, NSET=both
1
END
expect_status 0 "$program" groups deck.inp
[ "$(sort out)" = "$(printf 'nodes           4  both\nsolids          1  both')" ] || fail "sets of one name: $(cat out)"

# A mesh without groups says so; wrong files and full disks have one line.
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >plain.off
expect_status 0 "$program" groups plain.off
expect_text "note: plain.off: has no groups"
expect_status 2 "$program" groups nowhere.msh
expect_one_line
expect_status 64 "$program" groups a.msh a.msh
expect_one_line
if [ -e /dev/full ]; then
    "$program" groups a.msh >/dev/full 2>err </dev/null
    [ $? = 2 ] && [ "$(wc -l <err)" = 1 ] || fail "a full disk: $(cat err)"
fi

# 100 000 groups with names, and 100 000 without.
python3 - <<'PY' || fail "many.msh is made"
n = 100000
with open("many.msh", "w") as mesh:
    mesh.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n" % n)
    mesh.writelines('2 %d "name %d"\n' % (i, i) for i in range(1, n + 1))
    mesh.write("$EndPhysicalNames\n$Nodes\n%d\n" % (2 * n + 2))
    mesh.writelines("%d %d 0 0\n%d %d 1 0\n" % (2 * i + 1, i, 2 * i + 2, i) for i in range(n + 1))
    mesh.write("$EndNodes\n$Elements\n%d\n" % (2 * n))
    for i in range(n):
        a, b, c, d = range(2 * i + 1, 2 * i + 5)
        mesh.write("%d 2 2 %d 1 %d %d %d\n" % (a, i + 1, a, c, b))
        mesh.write("%d 2 2 %d 1 %d %d %d\n" % (b, i + n + 1, b, c, d))
    mesh.write("$EndElements\n")
PY
expect_status 0 timeout 15 "$program" groups many.msh
[ "$(wc -l <out)" = 200000 ] && [ "$(head -n 1 out)" = "faces           1  name 1" ] &&
    [ "$(tail -n 1 out)" = "faces           1  2:200000" ] || fail "many groups: $(wc -l <out), $(sed -n '1p;$p' out)"
# ---- long names ---------------------------------------------------------------------------------
# What a format has no room for is said.
python3 - <<'END'
for n in 80, 81, 240, 241, 256, 257:
    with open("named%d.msh" % n, "w") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"%s\"\n$EndPhysicalNames\n"
                   "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
                   "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n" % ("n" * n))
END
for n in 80 81 240 241 256 257; do
    expect_status 0 "$program" convert named$n.msh -o long.inp
    [ "$(grep -c "lacks names that Abaqus takes (of at most 80 characters) for 1 group\(\$\|,\)" err)" -eq $((n > 80)) ] ||
        fail "$n characters in Abaqus: $(cat err)"
    [ "$(grep -c "the ends of names of more than 256 bytes" err)" -eq $((n > 256)) ] || fail "$n bytes in Abaqus: $(cat err)"
    grep -q "\"n\{$((n < 256 ? n : 256))\}\"" long.inp || fail "the name of $n bytes in Abaqus: $(cat long.inp)"
    expect_status 0 "$program" convert named$n.msh -o long.e
    [ "$(grep -c "the ends of names of more than 240 bytes" err)" -eq $((n > 240)) ] || fail "$n bytes in Exodus: $(cat err)"
    expect_status 0 "$program" groups long.e
    grep -q "[^n]n\{$((n < 240 ? n : 240))\}\$" out || fail "the name of $n bytes in Exodus: $(cat out)"
done

# Names are cut before a character that does not fit, or where bytes are none.
python3 - <<'END'
head = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \""
tail = (b"\"\n$EndPhysicalNames\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 1\n$EndNodes\n"
        b"$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n")
for name, most in ("e", 240), ("inp", 256), ("bdf", 256), ("obj", 256), ("stl", 256):
    for text, end in ("two", "\u00e9".encode()), ("four", "\U0001F600".encode()), ("none", b"\x80" * 9):
        with open("%s_%s.msh" % (text, name), "wb") as file:
            file.write(head + b"n" * (most - len(end) + 1 if text != "none" else most - 5) + end + tail)
END
for name in e inp bdf obj stl; do
    most=$([ $name = e ] && echo 240 || echo 256)
    for text in two:2:0 four:4:0 none:6:5; do
        IFS=: read -r kind size rest <<<"$text"
        expect_status 0 "$program" convert ${kind}_$name.msh -o cut.$name
        LC_ALL=C grep -aoE $'n{200,}[\x80-\xff]*' cut.$name | head -n 1 | tr -d '\n' >found
        [ "$(wc -c <found)" -eq $((most - size + 1 + rest)) ] || fail "$kind in $name: $(wc -c <found) bytes"
        [ "$(tr -d n <found | wc -c)" -eq "$rest" ] || fail "$kind in $name: $(tail -c 9 found | od -c)"
    done
done

# ---- names of one number --------------------------------------------------------------------------
# Each number is written once, not for each of its names, whether others have them or not.
python3 - <<'END'
n = 300
for kind, last in ("shared", ['3 3 "GROUP%s"\n' % i for i in (1, "_2")]), ("own", ['3 1 "own"\n']):
    with open(kind + ".msh", "w") as mesh:
        names = ['3 %d "n%d"\n' % (number, i) for i in range(n) for number in (1, 2)] + last
        mesh.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n" % len(names))
        mesh.writelines(names)
        mesh.write("$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n")
        mesh.write("$Elements\n%d\n" % (n + 1))
        mesh.writelines("%d 4 2 %d %d 1 2 3 4\n" % (i, 1 + i % 3 // 2, i) for i in range(1, n + 1))
        mesh.write("%d 4 2 3 %d 1 2 3 4\n" % (n + 1, n + 1))
        mesh.write("$EndElements\n")
END
for kind in shared own; do
    expect_status 0 "$program" convert $kind.msh -o $kind.inp
    [ "$(wc -c <$kind.inp)" -lt 60000 ] || fail "names of one number ($kind): $(wc -c <$kind.inp) bytes"
    expect_status 0 "$program" groups $kind.inp
    [ "$(grep -c '^solids  *300  n[0-9]*$' out)" = 300 ] || fail "names of one number ($kind): $(head -n 5 out)"
done
expect_status 0 "$program" groups shared.inp
[ "$(grep -ci '^solids  *1  group' out)" = 2 ] || fail "groups of names as the writer's own: $(grep -i group out)"
expect_status 0 "$program" groups own.inp
grep -q '^solids  *200  own$' out || fail "a name of one number: $(grep own out)"

# ---- names as those of the writer's own sets, and names that are written as others ----------------
python3 - <<'END'
for kind, names in ("own", ((2, "VOLUME1"), (1, "volume_2"))), ("quoted", ((1, "a'"), (1, "b"), (2, "a_"), (2, "c"))):
    with open(kind + ".msh", "w") as mesh:
        mesh.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n" % len(names))
        mesh.writelines('3 %d "%s"\n' % (number, name.replace("'", "\t")) for number, name in names)
        mesh.write("$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n")
        mesh.write("$Elements\n3\n1 4 2 1 1 1 2 3 4\n2 4 2 2 2 2 3 4 5\n3 4 2 1 3 1 2 3 4\n$EndElements\n")
END
expect_status 0 "$program" convert own.msh -o own.inp
! grep -q quotes err || fail "lost of names as the writer's own: $(cat err)"
expect_status 0 "$program" groups own.inp
[ "$(grep -c '^solids  *1  VOLUME1$' out)$(grep -c '^solids  *2  volume_2$' out)" = 11 ] ||
    fail "groups of names as those of elements: $(cat out)"
expect_status 0 "$program" convert quoted.msh -o quoted.inp
expect_text "lacks quotes and control characters (now '_') in the names of 1 group"
expect_status 0 "$program" groups quoted.inp
[ "$(grep -c '^solids  *2  b$' out)$(grep -c '^solids  *1  c$' out)" = 11 ] || fail "names with '_': $(cat out)"

finish
