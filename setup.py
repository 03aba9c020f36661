"""Build of the wheel: CMake builds libraries and program, which go into the package (tools/python/planish).

    pip install .                                      # needs CMake, compilers and what docs/embedding.md names
    pip wheel . --no-build-isolation --no-deps         # offline, with setuptools and wheel of the system

One wheel serves all versions of Python 3 on a platform, as the module calls the libraries by ctypes. The variable
CMAKE_ARGS has more options for CMake.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:
    from wheel.bdist_wheel import bdist_wheel

TOP = pathlib.Path(__file__).resolve().parent
TARGETS = ["planish_shared", "planish_io_shared", "planish_program"]
LIBRARIES = ["libplanish.so.{}", "libplanish_io.so.{}"]


def version():
    """Return the version that CMakeLists.txt has."""
    return re.search(r"project\(planish VERSION ([0-9.]+)", (TOP / "CMakeLists.txt").read_text()).group(1)


def configure(folder):
    """Configure the build in folder: the program finds the libraries in ../lib, and nothing has symbols."""
    flags = f"{os.environ.get('LDFLAGS', '')} -s".strip()
    subprocess.run(
        ["cmake", "-S", TOP, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DPLANISH_TESTS=OFF", "-DPLANISH_BENCH=OFF",
         "-DPLANISH_INSTALL=OFF", "-DPLANISH_SHARED_PROGRAM=ON", "-DCMAKE_BUILD_WITH_INSTALL_RPATH=ON",
         "-DCMAKE_INSTALL_LIBDIR=lib",
         f"-DCMAKE_SHARED_LINKER_FLAGS={flags}", f"-DCMAKE_EXE_LINKER_FLAGS={flags}",
         *shlex.split(os.environ.get("CMAKE_ARGS", ""))], check=True)


def build(folder):
    """Build libraries and program in folder."""
    configure(folder)
    subprocess.run(["cmake", "--build", folder, "-j", str(os.cpu_count() or 1), "--target", *TARGETS], check=True)


class BuildPackage(build_py):
    """The package with libraries and program in it."""

    def run(self):
        """Build all."""
        super().run()
        if not getattr(self, "editable_mode", False):  # there PLANISH_LIBRARY names the library
            self.pack(pathlib.Path(self.get_finalized_command("build").build_temp).resolve() / "cmake")

    def pack(self, built):
        """Put libraries and program into the package."""
        build(built)
        package = pathlib.Path(self.build_lib) / "planish"
        abi = ".".join(version().split(".")[:2])
        for name, folder in [*((library.format(abi), "lib") for library in LIBRARIES), ("planish", "bin")]:
            (package / folder).mkdir(parents=True, exist_ok=True)
            shutil.copy(built / name, package / folder / name)


class Platform(Distribution):
    """A distribution that holds machine code."""

    def has_ext_modules(self):
        """Say that files are for one platform."""
        return True


class BuildWheel(bdist_wheel):
    """A wheel for all versions of Python 3 on this platform."""

    def get_tag(self):
        """Return the tags of the wheel."""
        return "py3", "none", super().get_tag()[2]


if sys.platform == "win32":
    raise SystemExit("planish is built for Windows by CMake alone, with MinGW")
setup(version=version(), distclass=Platform, cmdclass={"build_py": BuildPackage, "bdist_wheel": BuildWheel})
