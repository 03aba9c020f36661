# shellcheck shell=bash
# boxes: meshes of bench/scaling and bench/phases. Their run sources this file in the root of the project.
# build_programs NAME builds into build-bench and copies the programs, so that another build in the same
# folder does no harm. make_box NX NY NZ makes a box of so many tiles of about 100 000 tetrahedra and
# prints its path.
# shellcheck source=tools/packages.sh
. tools/packages.sh
build=build-bench
meshes=$build/meshes/boxes
results=$build/results
python=/usr/bin/python3 # the one that Debian's packages are for
export PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=bench

build_programs() {
    install_packages "what the benchmark needs" "${packages_build[@]}" gmsh python3 \
        python3-matplotlib >&2
    mkdir -p $meshes $results
    cmake -S . -B $build -DCMAKE_BUILD_TYPE=Release -DPLANISH_TESTS=OFF >$build/build.log
    cmake --build $build -j "$(nproc)" >>$build/build.log
    programs=$build/programs-$1
    mkdir -p "$programs"
    cp $build/planish $build/bench/{bench_smooth,tiles} "$programs/"
    [ -s $meshes/tile.msh ] ||
        make_file $meshes/tile.msh gmsh -3 -v 1 bench/tile.geo -format msh41 -o
}

# make_file OUT COMMAND... makes OUT by COMMAND... FILE, whole or not at all: later runs use it again.
make_file() {
    local out=$1 part=${1%/*}/part-${1##*/}
    shift
    "$@" "$part" >&2 && mv "$part" "$out"
}

make_tiles() {
    "$programs/tiles" $meshes/tile.msh "$4" "$1" "$2" "$3"
}

make_box() {
    local out=$meshes/box_$1x$2x$3.msh
    [ -s "$out" ] || make_file "$out" make_tiles "$1" "$2" "$3"
    echo "$out"
}
