#!/usr/bin/env bash
# MED and CGNS files written by their owners' libraries, VTKHDF files by h5py: smoothed, read back by
# these (and by VTK and meshio), and every byte but those of coordinates as it was. Needs
# libcgns-dev, libmedc-dev, python3-h5py, python3-meshio, python3-vtk9: what is missing is left out.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
done_some=0
echo any >any.med
! lacks any.med || { echo "skipped: built without HDF5"; exit 77; }
rm any.med

# The HDF5 library crashes on the one and takes memory without end for the other; planish does not.
for file in damaged.med $(unless_quick damaged_endless.med); do # the other takes seconds: tests/io/test_child.c
    expect_status 2 "$program" quality "$source_folder/tests/data/$file"
    expect_one_line
    expect_text "$file"
done

# A compiler and the folders of an HDF5, for one built with MPI or without.
compile() { # PROGRAM LIBRARIES...
    local name=$1 folder
    shift
    for folder in serial openmpi mpich; do
        for compiler in cc mpicc; do
            "$compiler" -I"/usr/include/hdf5/$folder" -o "$name" "$cli/$name.c" "$@" \
                -L"/usr/lib/$(uname -m)-linux-gnu/hdf5/$folder" -lhdf5 2>/dev/null && return 0
        done
    done
    return 1
}

# check_bytes IN OUT MOST FORMAT: OUT, which IN was smoothed to, differs from it in at most that many
# bytes, and is what comes through pipes, too.
check_bytes() {
    [ "$(wc -c <"$1")" = "$(wc -c <"$2")" ] || fail "$2 has another size than $1"
    [ "$(cmp -l "$1" "$2" | wc -l)" -le "$3" ] || fail "$2: other bytes changed, too"
    "$program" smooth "$1" -o /dev/stdout -q 2>/dev/null | cmp - "$2" || fail "$1: to a pipe"
    # shellcheck disable=SC2002 # a pipe is what is tested
    cat "$1" | "$program" smooth /dev/stdin -o "piped.$4" -q --format "$4" 2>/dev/null
    cmp "piped.$4" "$2" || fail "$1: from a pipe"
}

# ---- CGNS by the CGNS library -------------------------------------------------------------------
if compile write_cgns -lcgns && ./write_cgns write fixed.cgns 6 double fixed hdf5; then
    done_some=1
    ./write_cgns write mixed.cgns 6 float mixed hdf5
    expect_status 0 "$program" smooth fixed.cgns -o out.cgns
    [ "$(./write_cgns compare fixed.cgns out.cgns)" = 300 ] || fail "CGNS: 100 nodes should move"
    check_bytes fixed.cgns out.cgns 2400 cgns
    expect_status 0 "$program" smooth fixed.cgns -o out.cgns --ignore-regions
    [ "$(./write_cgns compare fixed.cgns out.cgns)" = 375 ] || fail "CGNS: 125 nodes should move"
    expect_status 0 "$program" smooth fixed.cgns -o out.cgns --fix upper --ignore-regions
    [ "$(./write_cgns compare fixed.cgns out.cgns)" = 150 ] || fail "CGNS: 50 nodes should move"
    expect_status 0 "$program" smooth mixed.cgns -o out.cgns
    [ "$(./write_cgns compare mixed.cgns out.cgns)" = 375 ] || fail "CGNS: 125 nodes should move"
    check_bytes mixed.cgns out.cgns 1500 cgns
    for group in $(some bottom top lid corner); do
        expect_status 0 "$program" smooth mixed.cgns -o out.cgns --fix "$group"
    done
    expect_status 64 "$program" smooth mixed.cgns -o out.cgns --fix nowhere
    expect_text "bottom"
    ./write_cgns write adf.cgns 3 double fixed adf
    expect_status 2 "$program" smooth adf.cgns -o out.cgns
    expect_text "adf2hdf"
    if command -v adf2hdf >/dev/null && adf2hdf adf.cgns converted.cgns >/dev/null 2>&1; then
        expect_status 0 "$program" smooth converted.cgns -o out.cgns
    fi
    if "$python" -c "from vtkmodules.vtkIOCGNSReader import vtkCGNSReader" 2>/dev/null; then
        "$program" smooth mixed.cgns -o out.cgns -q
        "$python" "$cli/read_vtk.py" cgns mixed.cgns out.cgns || fail "CGNS as VTK reads it"
    fi
else
    echo "without libcgns-dev: CGNS is left out"
fi

# ---- MED by the MED library, and by meshio ------------------------------------------------------
if compile write_med -lmedC && ./write_med write in.med 6; then
    done_some=1
    expect_status 0 "$program" smooth in.med -o out.med
    [ "$(./write_med compare in.med out.med)" = 300 ] || fail "MED: 100 nodes should move"
    check_bytes in.med out.med 2400 med
    expect_status 0 "$program" smooth in.med -o out.med --ignore-regions --fix upper
    [ "$(./write_med compare in.med out.med)" = 150 ] || fail "MED: 50 nodes should move"
    expect_status 0 "$program" smooth in.med -o out.med --fix middle
    expect_status 0 "$program" smooth in.med -o out.med --min-volume solid=1e-6
    expect_status 64 "$program" smooth in.med -o out.med --fix nowhere
    expect_text "solid, lower, upper, bottom, top, middle"
else
    echo "without libmedc-dev: its MED files are left out"
fi
if "$python" -c "import meshio, h5py" 2>/dev/null; then
    done_some=1
    "$python" "$cli/convert_hdf5.py" make "$sample" || fail "meshio and h5py"
    for name in plain.med single.vtkhdf packed.vtkhdf $(unless_quick plain.vtkhdf chunked.vtkhdf); do
        expect_status 0 "$program" smooth "$name" -o "out-$name"
        "$python" "$cli/convert_hdf5.py" compare "$name" "out-$name" || fail "$name"
    done
    expect_status 2 "$program" smooth packed.vtkhdf -o /dev/stdout
    expect_text "cannot be written to a pipe"
    cp packed.vtkhdf same.vtkhdf # no node is free: nothing is changed
    expect_status 0 "$program" smooth same.vtkhdf -o unchanged.vtkhdf --max-sweeps 0
    cmp same.vtkhdf unchanged.vtkhdf || fail "a packed file changes without a changed coordinate"
    if "$python" -c "from vtkmodules.vtkIOHDF import vtkHDFReader" 2>/dev/null; then
        for name in packed.vtkhdf $(unless_quick plain.vtkhdf single.vtkhdf); do
            "$python" "$cli/read_vtk.py" hdf "$name" "out-$name" || fail "$name as VTK reads it"
        done
    fi
else
    echo "without meshio and h5py: VTKHDF is left out"
fi

[ "$done_some" = 1 ] || exit 77
finish
