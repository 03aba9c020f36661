#!/usr/bin/env bash
# Regions: nodes between the values of any array of whole numbers that looks like regions stay; which
# arrays these are is said, and can be chosen.
. "$(dirname "$0")/common.sh"

make() {
    python3 "$cli/regions_mesh.py" "$@" || fail "regions_mesh.py $*"
}

# expect_free N FILE [OPTION...]: so many nodes of it are free.
expect_free() {
    local wanted=$1
    shift
    expect_status 0 "$program" quality "$@" --json report.json
    expect_json "r['mesh']['free_nodes'] == $wanted"
}

expect_no_note() {
    ! grep "taken for regions" err || fail "that needs no note"
}

# expect_arrays LIST: the last report names these.
expect_arrays() {
    expect_json "r['mesh']['region_arrays'] == $1"
}

# Free nodes: all inside; those that are not between two halves; nor between four quarters.
all=(0 0 25 125)
half=(0 0 20 100)
quarter=(0 0 16 80)

of_each_type=() names=
for type in int8 int16 int32 int64 uint8 uint16 uint32 uint64 float32 float64; do
    of_each_type+=("Material $type:$type:halves")
    names+="'Material $type', "
done
names="[$names]"

for dim in 3 $(unless_quick 2); do
    # Names that planish has never heard of, of every type, in every form of the formats.
    for how in $(some ascii binary field binary-field); do
        make "$dim" box.vtk "$how" "${of_each_type[@]}" "T:float64:fraction"
        expect_free "${half[dim]}" box.vtk
        expect_arrays "$names"
        expect_text "the values of arrays 'Material int8', 'Material int16', "
    done
    for how in $(some ascii base64 pieces packed raw); do
        make "$dim" box.vtu "$how" "${of_each_type[@]}" "T:float64:fraction"
        lacks box.vtu && continue
        n=${half[dim]}
        [ "$how" != pieces ] || n=$((2 * n))
        expect_free "$n" box.vtu
        expect_arrays "$names"
    done
    if /usr/bin/python3 -c "import h5py" 2>/dev/null; then
        /usr/bin/python3 "$cli/regions_mesh.py" "$dim" box.vtkhdf - "${of_each_type[@]}" "T:float64:fraction"
        if ! lacks box.vtkhdf; then
            expect_free "${half[dim]}" box.vtkhdf
            expect_json "sorted(r['mesh']['region_arrays']) == sorted($names)"
        fi
    fi
    make "$dim" box.vtk ascii "GeometryIds:int32:halves"
    expect_free "${half[dim]}" box.vtk
    expect_arrays "['GeometryIds']"
    expect_text "the values of array 'GeometryIds' for regions"

    # Gmsh's values of elements add to its entities, which hold whatever arrays are chosen.
    for how in ascii binary; do
        make "$dim" box.msh "$how" "T:float64:fraction" "number:float64:number"
        expect_free "${half[dim]}" box.msh
        expect_arrays "[]"
        expect_no_note
        make "$dim" box.msh "$how" "color:float64:halves" "T:float64:fraction" "rank:float64:quarters"
        expect_free "${quarter[dim]}" box.msh
        expect_arrays "['color']"
        expect_text "the values of array 'color' for regions"
        expect_free "${half[dim]}" box.msh --regions rank
        expect_arrays "['rank']"
        expect_free "${all[dim]}" box.msh --regions none
        expect_arrays "[]"
        expect_free "${all[dim]}" box.msh --ignore-regions
    done

    # What is no region.
    for rule in $(some one_nan same parity fraction number); do
        make "$dim" box.vtk ascii "x:float64:$rule"
        expect_free "${all[dim]}" box.vtk
        expect_arrays "[]"
        expect_no_note
    done
    mapfile -t others < <(some "MPI Rank" Partition_Id rank vtkGhostType partition proc vtkOriginalCellIds)
    for name in "${others[@]}"; do
        make "$dim" box.vtk ascii "$name:int32:halves"
        expect_free "${all[dim]}" box.vtk
        expect_arrays "[]"
        expect_free "${half[dim]}" box.vtk --regions "$name"
        expect_arrays "['$name']"
    done

    # Huge and negative numbers.
    make "$dim" box.vtk ascii a:int64:huge b:int32:negative c:float64:number
    expect_free "${half[dim]}" box.vtk
    expect_arrays "['a', 'b']"
    make "$dim" box.vtu ascii a:int64:huge
    lacks box.vtu || expect_free "${half[dim]}" box.vtu

    # Several arrays: nodes between the values of any of them.
    make "$dim" box.vtk field "part id:int16:halves" zone:float32:quarters n:int64:number rank:int8:quarters
    expect_free "${quarter[dim]}" box.vtk
    expect_arrays "['part id', 'zone']"
    expect_text "the values of arrays 'part id', 'zone' for regions"
    expect_free "${half[dim]}" box.vtk --regions "part id"
    expect_arrays "['part id']"
    expect_no_note
    expect_free "${half[dim]}" box.vtk --regions zone
    expect_free "${quarter[dim]}" box.vtk --regions zone --regions "part id"
    expect_free "${half[dim]}" box.vtk --regions none --regions zone
    for lifted in "--regions none" --ignore-regions "--regions zone --regions none"; do
        # shellcheck disable=SC2086
        expect_free "${all[dim]}" box.vtk $lifted
        expect_arrays "[]"
    done
    expect_free 0 box.vtk --regions n
    expect_status 64 "$program" smooth box.vtk -o out.vtk --regions nothing
    expect_one_line
    expect_text "there is no array 'nothing' of one whole number per element; the file has: part id, zone, n, rank"
    expect_no_file out.vtk

    # A name that is known counts as ever, others beside it.
    make "$dim" box.vtk ascii region:int32:halves
    expect_free "${half[dim]}" box.vtk
    expect_arrays "['region']"
    expect_no_note
    expect_status 0 "$program" quality box.vtk --fix "$dim:4" --json report.json -q
    expect_json "r['mesh']['free_nodes'] == ${half[dim]} / 2"
    make "$dim" box.vtk ascii mat_id:int32:halves
    expect_status 0 "$program" quality box.vtk --fix "$dim:4" --json report.json -q
    expect_json "r['mesh']['free_nodes'] == ${half[dim]} / 2"
    make "$dim" box.vtk ascii zone:int32:quarters region:int32:halves gmsh:physical:int64:quarters
    expect_free "${quarter[dim]}" box.vtk
    expect_arrays "['zone', 'region', 'gmsh:physical']"
done

# Smoothing leaves the interface where it was, whatever the threads; sliding keeps its plane.
on_interface='import sys
points = [[], []]
for k in range(2):
    words = open(sys.argv[1 + k]).read().split()
    at = words.index("POINTS") + 3
    x = list(map(float, words[at:at + 3 * 343]))
    points[k] = [x[3 * i:3 * i + 3] for i in range(343)]
middle = range(3 * 49, 4 * 49)
moved = sum(a != b for a, b in zip(*points))
held = sum(points[0][i] != points[1][i] for i in middle)
off = max(abs(points[0][i][0] - points[1][i][0]) for i in middle)
assert moved > 0 and eval(sys.argv[3]), (moved, held, off)'
make 3 box.vtk ascii mat_id:int32:halves
for threads in 1 5 $(unless_quick 2); do
    expect_status 0 "$program" smooth box.vtk -o out$threads.vtk -j $threads -q --json report.json --report page.html
    cmp -s out1.vtk out$threads.vtk || fail "$threads threads: other bits"
done
python3 -c "$on_interface" box.vtk out1.vtk "held == 0" || fail "the interface moves"
grep -q "between the values of array <code>mat_id</code>" page.html || fail "the page names no array"
expect_status 0 "$program" smooth box.vtk -o slid.vtk -q --slide auto
python3 -c "$on_interface" box.vtk slid.vtk "held >= 25 and off < 1e-9" || fail "the interface is not slid on"
expect_status 0 "$program" smooth box.vtk -o free.vtk -q --regions none
python3 -c "$on_interface" box.vtk free.vtk "held == 25" || fail "the interface stays"
expect_status 0 "$program" smooth box.vtk -o out.vtu -q
lacks out.vtu || { expect_free 100 out.vtu; expect_json "'region' in r['mesh']['region_arrays']"; }
# Elementary entities of Gmsh's are regions of one physical group: the nodes between them are counted, with the option
# that lets them move. Nodes that are between physical groups, too, or on listed lines are held for that.
cat >entities.py <<'END2'
import itertools
import sys
import box_file

N = 6
kind, physical = sys.argv[1], [int(p) for p in sys.argv[2].split(",")]
dim = box_file.dimension(kind)
number = {at: i + 1 for i, at in enumerate(itertools.product(range(N + 1), repeat=dim))}
cells = box_file.elements(kind, [N] * dim, number)
lows = list(itertools.product(range(N), repeat=dim))
of_cell = [lows[i // (len(cells) // len(lows))][0] * 3 // N for i in range(len(cells))]  # three slices
middle = [number[2, y] for y in range(N + 1)] if len(sys.argv) > 3 else []
lines = list(zip(middle, middle[1:]))
print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d" % len(number))
for at, i in number.items():
    print(i, *at, *[0] * (3 - dim))
print("$EndNodes\n$Elements\n%d" % (len(cells) + len(lines)))
for i, (e, slice_) in enumerate(zip(cells, of_cell)):
    print(i + 1, {3: 2, 4: 4}[len(e)], 2, physical[slice_], slice_ + 1, *e)
for i, line in enumerate(lines):
    print(len(cells) + i + 1, 1, 2, 9, 9, *line)
print("$EndElements")
END2
for dim in 2 3; do
    kind=triangles inside=5
    [ $dim = 2 ] || kind=tets inside=25
    python3 entities.py $kind 7,7,7 >one.msh
    python3 entities.py $kind 7,7,8 >two.msh
    python3 entities.py $kind 7,8,9 >three.msh
    python3 entities.py $kind 0,0,0 >none.msh
    for command in "quality one.msh" "smooth one.msh -o out.msh"; do
        expect_status 0 "$program" $command
        expect_text "note: $((2 * inside)) nodes are held between elementary entities of one physical group; --regions none lets nodes between regions move"
        expect_status 0 "$program" $command --regions none
        ! grep -q "elementary" err || fail "they are not held: $command"
        expect_status 0 "$program" $command -q
        [ ! -s err ] || fail "notes with -q: $(cat err)"
    done
    expect_free $((5 * inside)) one.msh --regions none
    expect_status 0 "$program" quality two.msh
    expect_text "note: $inside nodes are held between elementary entities of one physical group;"
    for file in three.msh none.msh; do
        expect_status 0 "$program" quality $file
        ! grep -q "elementary" err || fail "no group holds several of them: $file"
    done
done
python3 entities.py triangles 7,7,7 lines >lines.msh
expect_status 0 "$program" quality lines.msh
expect_text "note: 5 nodes are held between elementary entities of one physical group;" # the lines hold the others
finish
