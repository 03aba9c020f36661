# shellcheck shell=bash
# packages: what planish needs from the system, in one place; sourced by quickstart and check.
#
# Debian's and Ubuntu's names. install_packages asks apt only for what is missing, and says so.

# shellcheck disable=SC2034 # used by those that source this
packages_build=(
    gcc g++       # the compilers: C11, and C++17 for reading and writing numbers
    make cmake    # the build
    libhwloc-dev  # where threads run
    libcjson-dev  # the report of the program
    libexpat1-dev # XML of VTK's .vtu
    libhdf5-dev   # MED, CGNS, VTKHDF and DMPlex files
    libjs-three   # the picture in reports
    zlib1g-dev liblz4-dev liblzma-dev # and what packs their arrays
)
# shellcheck disable=SC2034
packages_check=(
    libcmocka-dev # unit tests
    libgmp-dev    # exact arithmetic that results are compared with
    python3       # scripts of the tests: reads reports, measures meshes independently
    python3-numpy # the Python module
    pkg-config    # how other programs find the library
    ninja-build   # a fifth faster than make
    clang clang-tidy libomp-dev cppcheck # static analysis
)
# shellcheck disable=SC2034
packages_full=(
    libclang-rt-dev              # clang's sanitizers and the fuzzer
    valgrind                     # memory, independently of the sanitizers
    python3-meshio               # independent figures on large meshes
    python3-vtk9                 # another program's quality measures; planish's filter for VTK
    mypy pydocstyle              # types and docstrings of the Python package
    python3-pip python3-setuptools python3-wheel python3-venv # and its wheel
    coinor-libipopt-dev          # all nodes at once, to compare with
    gmsh tetgen python3-netgen   # meshes as their generators write them
    python3-gmsh                 # meshes in Gmsh's memory
    chromium                     # the page of a report, as a browser shows it
    llvm                         # lines and branches that tests reach
    abigail-tools                # the library's interface, compared with the last release
    libcgns-dev libmedc-dev python3-h5py # owners of formats in HDF5
    libtet1.5-dev libgmsh-dev libcgal-dev # meshers that the library is embedded in
    g++-mingw-w64-x86-64-posix wine64 # Windows
    dpkg-dev lintian file          # packages for Debian
    ruby python3-yaml              # recipes for other systems
    rustc gfortran                 # examples in other languages
    python3-sphinx python3-myst-parser furo # the documents as a site
    codespell aspell aspell-en     # spelling
)

# shellcheck disable=SC2034
packages_mpi=(
    libopenmpi-dev openmpi-bin # processes that share a mesh
    libpetsc-real-dev pkg-config # planish-mpi
    python3-h5py procps # tests read PETSc's files, and end processes
)
# shellcheck disable=SC2034
packages_long=(
    gcc-aarch64-linux-gnu g++-aarch64-linux-gnu # other machines
    gcc-s390x-linux-gnu g++-s390x-linux-gnu gcc-i686-linux-gnu
    qemu-user                    # runs their programs
)

is_installed() {
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

# install_packages WHY PACKAGE...: install those that are missing; nothing is asked of apt if none is.
install_packages() {
    local why=$1 missing=() package as_root=()
    shift
    if ! command -v dpkg-query >/dev/null; then
        echo "This is neither Debian nor Ubuntu: make sure yourself that there are: $*"
        return 0
    fi
    for package; do
        is_installed "$package" || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null; then
            echo "Missing $why: ${missing[*]}" >&2
            echo "As root, run: apt-get install ${missing[*]}" >&2
            return 1
        fi
        as_root=(sudo)
    fi
    echo "Installing $why: ${missing[*]}"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq >/dev/null || return 1
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}
