"""The program planish, as a wheel has it in this package or an installation beside it."""

from __future__ import annotations

import os
import pathlib
import sys

from ._library import folders


def _find() -> pathlib.Path:
    """Return the path of the program."""
    here = pathlib.Path(__file__).resolve().parent
    places = [here / "bin", *(folder.parent / "bin" for folder in folders()[1:])]
    for place in places:
        if (place / "planish").is_file():
            return place / "planish"
    raise SystemExit("planish: the program is not in this package; install the wheel, or run the installed planish")


def main() -> None:
    """Become the program."""
    program = str(_find())
    os.execv(program, [program, *sys.argv[1:]])
