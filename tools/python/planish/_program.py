"""The program planish, as a wheel has it in this package, or an installation beside it or in PATH."""

from __future__ import annotations

import os
import pathlib
import shutil
import sys

from ._library import folders


def _is_program(path: pathlib.Path) -> bool:
    """Whether path is a program, and no script that calls this one."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(2) != b"#!"


def _find() -> pathlib.Path:
    """Return the path of the program."""
    here = pathlib.Path(__file__).resolve().parent
    places = [here / "bin", *(folder.parent / "bin" for folder in folders()[1:])]
    in_path = shutil.which("planish")
    for path in [*(place / "planish" for place in places), *([pathlib.Path(in_path)] if in_path else [])]:
        if _is_program(path):
            return path
    raise SystemExit("planish: the program is neither in this package nor installed; install the wheel or the program")


def main() -> None:
    """Become the program."""
    program = str(_find())
    os.execv(program, [program, *sys.argv[1:]])
