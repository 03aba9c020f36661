# SPDX-License-Identifier: (Apache-2.0 OR MIT)
# Spack: program, libraries and Python module. Untested in its own system.

from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Planish(CMakePackage):
    """Smooths and untangles meshes of triangles, tetrahedra and elements of other types by moving their nodes;
    no element gets worse than the worst was."""

    homepage = "@HOMEPAGE@"
    url = "@URL@"

    license("BSD-3-Clause")

    version("@VERSION@", sha256="@SHA256@")

    variant("hdf5", default=True, description="Read and write MED, CGNS, VTKHDF, DMPlex and Exodus files")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.18:", type="build")
    depends_on("hwloc")
    depends_on("cjson")
    depends_on("expat")
    depends_on("zlib-api")
    depends_on("lz4")
    depends_on("xz")
    depends_on("hdf5~mpi", when="+hdf5")

    def cmake_args(self):
        return [
            self.define("PLANISH_TESTS", False),
            self.define("PLANISH_BENCH", False),
            self.define("PLANISH_PETSC", False),
            self.define_from_variant("PLANISH_HDF5", "hdf5"),
        ]

    def setup_run_environment(self, env):
        env.prepend_path("PYTHONPATH", self.prefix.share.planish.python)
