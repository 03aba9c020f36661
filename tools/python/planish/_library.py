"""The shared libraries: where they are, their functions, and threads."""

from __future__ import annotations

import ctypes
import ctypes.util
import operator
import os
import pathlib
from ctypes import byref, c_char_p, c_int, c_void_p
from typing import Any, Optional

from ._errors import exception_of
from ._structures import ErrorInfo, Options

VERSION = "0.2."  # structures are those of any version that begins so

# Folder of the installed libraries as seen from this one; cmake --install fills it in.
BESIDE = ""


# ---- loading --------------------------------------------------------------------------------------


def folders() -> list[pathlib.Path]:
    """Return the folders of the library beside this package: that of a wheel, and that of an installation."""
    here = pathlib.Path(__file__).resolve().parent
    return [here / "lib"] + ([here / BESIDE] if BESIDE else [])


def _paths(name: str) -> list[str]:
    """Return the paths at which to look for the library called name, in this order."""
    soname = f"lib{name}.so.{VERSION.rstrip('.')}"
    named = os.environ.get("PLANISH_LIBRARY")
    if named and name == "planish":
        return [named]
    if named:  # beside the one that is named
        folder = pathlib.Path(named).parent
        return [str(folder / soname), str(folder / f"lib{name}.so")]
    beside = [str(folder / soname) for folder in folders() if (folder / soname).exists()]
    return [*beside, soname, ctypes.util.find_library(name) or soname]


def _open(name: str, path: str) -> ctypes.CDLL:
    """Open the library called name at path; raise OSError if it is another one, or its version does not fit."""
    opened = ctypes.CDLL(path)
    if not hasattr(opened, name + "_version"):
        raise OSError(f"{path}: is no library of planish")
    version_of = getattr(opened, name + "_version")
    version_of.restype = c_char_p
    found = version_of().decode()
    if not found.startswith(VERSION):
        raise OSError(f"{path}: is version {found}, but this module needs {VERSION}x")
    return opened


def _load(name: str) -> ctypes.CDLL:
    """Load the library called name; raise ImportError if no path has it."""
    failures = []
    for path in _paths(name):
        try:
            return _open(name, path)
        except OSError as failure:
            failures.append(str(failure))
    raise ImportError(f"the library lib{name} was not found; install it, or name libplanish.so in PLANISH_LIBRARY ("
                      + "; ".join(dict.fromkeys(failures)) + ")")


library = _load("planish")
library.planish_checksum.restype = ctypes.c_uint64
for _name, _types in (("options_init_sized", [c_void_p, ctypes.c_size_t]), ("plan_destroy", [c_void_p]),
                      ("shape_destroy", [c_void_p]), ("shape_get_classes", [c_void_p, c_void_p]),
                      ("fit_destroy", [c_void_p]), ("fit_constrain", [c_void_p, c_void_p]),
                      ("plan_get_free", [c_void_p, c_void_p])):
    _function = getattr(library, "planish_" + _name)
    _function.restype, _function.argtypes = None, _types

_of_files: Optional[ctypes.CDLL] = None


def files() -> ctypes.CDLL:
    """Return libplanish_io, the library of mesh files. The first call loads it."""
    global _of_files  # pylint: disable=global-statement
    if _of_files is None:
        _of_files = _load("planish_io")
    return _of_files


# ---- calls ----------------------------------------------------------------------------------------


def call(function: Any, *arguments: Any) -> None:
    """Call a function whose last argument is a planish_error; raise the error that it returns."""
    error = ErrorInfo()
    if function(*arguments, byref(error)):
        raise exception_of(error.text.decode(errors="replace"), error.code, error.element, error.node)


def new_options() -> Options:
    """Return options with their defaults."""
    options = Options()
    library.planish_options_init_sized(byref(options), ctypes.sizeof(options))
    return options


def version() -> str:
    """Return the version of the library in use."""
    return str(library.planish_version().decode())


# ---- threads --------------------------------------------------------------------------------------

# A child of a fork has none of the parent's threads, and libgomp waits for them for ever.
_is_forked = False


def _after_fork() -> None:
    global _is_forked  # pylint: disable=global-statement
    _is_forked = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def threads_to_use(wanted: int) -> c_int:
    """Return the number of threads to ask of the library: in a forked process one instead of all."""
    return c_int(1 if _is_forked and wanted == 0 else whole(wanted, "threads"))


def whole(value: Any, name: str) -> int:
    """Return value as an integer; raise ValueError if C's int cannot hold it. name: the argument."""
    number = operator.index(value)
    if not -(2**31) <= number < 2**31:
        raise ValueError(f"{name} is {number}, which is out of range")
    return number
