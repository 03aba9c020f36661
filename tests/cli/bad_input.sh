#!/usr/bin/env bash
# shellcheck disable=SC2016 # the dollars are those of the MSH format
# Input that is no mesh, and output that cannot be written: status 2, one line, no output, IN as it was.
. "$(dirname "$0")/common.sh"

bad() {
    expect_status 2 "$program" smooth "$@" -o out.msh
    expect_one_line
    expect_no_file out.msh
    [ ! -f "$1" ] || expect_text "$(basename "$1")"
    expect_status 2 "$program" quality "$@"
    expect_one_line
}

bad nothing.msh
mkdir folder.msh
bad folder.msh
: >empty.msh
bad empty.msh
head -c 5000 /dev/urandom >garbage.msh
bad garbage.msh
for bytes in 1 30 400 5000 100000 300000; do
    head -c $bytes "$sample" >truncated.msh
    bad truncated.msh
done
sed '/^\$EndElements/,$d' "$sample" >truncated.msh
bad truncated.msh

# Counts that lie must not allocate what they say: from here on a gigabyte of address space has to do
# (sanitizers need more for themselves).
if (ulimit -v 1000000 && "$program" --version) >/dev/null 2>&1; then
    ulimit -v 1000000
fi
header='$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n'
for count in 4611686018427387904 9223372036854775807 99999999999999999999 4294967296 -1 x; do
    printf '%b%s\n1 0 0 0\n' "$header" $count >counts.msh
    bad counts.msh
    printf '%b1\n1 0 0 0\n$EndNodes\n$Elements\n%s\n1 4 2 1 1 1 1 1 1\n' "$header" $count >counts.msh
    bad counts.msh
done

# One tetrahedron and what may be wrong with it. $1: coordinates of node 4, $2: its number, $3: nodes.
tetrahedron() {
    printf '%b4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n%s %s\n$EndNodes\n$Elements\n1\n1 4 2 1 1 %s\n$EndElements\n' \
        "$header" "$2" "$1" "$3"
}
tetrahedron "0 0 1" 4 "1 2 3 4" >good.msh
expect_status 0 "$program" smooth good.msh -o out.msh
cmp good.msh out.msh || fail "a mesh without free nodes comes back as it is"
expect_text "note: out.msh: no node is free"
grep -q "gmsh, 1 tetrahedron, 4 nodes" out && grep -q "^0 of 4 nodes are free to move" out || fail "one: $(cat out)"
rm out.msh
while IFS='|' read -r name place number nodes text; do
    tetrahedron "$place" "$number" "$nodes" >"$name.msh"
    bad "$name.msh"
    expect_text "$text"
done <<'TABLE'
nan|0 0 nan|4|1 2 3 4|:9: node 4
inf|0 0 inf|4|1 2 3 4|:9: node 4
huge|0 0 1e999|4|1 2 3 4|:9: node 4
word|0 0 one|4|1 2 3 4|:9: node 4
twice|0 0 1|3|1 2 3 4|node number 3
range|0 0 1|4|1 2 3 5|no node 5
repeated|0 0 1|4|1 2 3 3|element 1 has node 3 twice
TABLE
sed 's/^4 0 0 1/70 0 0 1/; s/^1 4 2 1 1.*/800 4 2 1 1 1 2 70 70/' good.msh >repeated.msh
bad repeated.msh # in the file's numbers
expect_text "repeated.msh: element 800 has node 70 twice"
# Others' .msh.
printf '4 2 4\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n1 2 3 1\n1 3 4 1\n' >freefem.msh
printf '$ENTER COMPONENT NAME=A\n$STRUCTURE\n' >permas.msh
for file in freefem permas; do
    bad $file.msh
    expect_text "no \$MeshFormat: this is not a mesh of Gmsh"
done
printf '%b1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 2 1 1 1\n$EndElements\n' "$header" >points.msh
bad points.msh

# No standard streams by that name.
expect_status 64 "$program" smooth - -o out.msh
expect_text "/dev/stdin"
expect_status 64 "$program" smooth good.msh -o -
expect_text "/dev/stdout"

# Outputs that cannot be written.
cp "$sample" in.msh
unwritable() {
    expect_status 2 "$program" smooth in.msh -o "$@"
    expect_one_line
}
unwritable nowhere/out.msh
unwritable .
unwritable folder.msh
unwritable in.msh/out.msh
unwritable /dev/full
if [ "$(id -u)" -ne 0 ]; then
    mkdir locked
    chmod a-w locked
    unwritable locked/out.msh
fi
expect_status 2 "$program" smooth in.msh -o out.msh --json nowhere/out.json
expect_one_line
expect_no_file out.msh

# A limit on the size of files stands for a full disk.
expect_status 2 bash -c "ulimit -f 100; trap '' XFSZ; exec \"$program\" smooth in.msh -o out.msh"
expect_one_line
[ "$(find . -name '*out.msh*' | wc -l)" -eq 0 ] || fail "half a file is left: $(ls)"
cmp in.msh "$sample" || fail "the input was changed"

# The mesh is written, the report is not: a usable mesh, but not all that was asked for.
expect_status 1 "$program" smooth in.msh -o out.msh --json /dev/full -q
expect_one_line
[ -s out.msh ] || fail "the mesh should be there"
expect_status 2 "$program" quality in.msh --json /dev/full -q
expect_one_line
finish
