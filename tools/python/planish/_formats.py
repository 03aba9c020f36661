"""Formats of mesh files."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p
from typing import NamedTuple

from ._io import io, texts
from ._io_structures import FormatInfo


class Format(NamedTuple):
    """A format of mesh files."""

    name: str
    title: str  # full name and versions
    extensions: tuple[str, ...]  # with the dot; none: folders
    is_read: bool  # False: the library was built without what the format needs
    is_target: bool  # whether meshes can be converted to it


def formats() -> list[Format]:
    """Return the formats of mesh files (docs/formats.md)."""
    targets: list[str] = []
    found: list[Format] = []
    while (name := io("target")(len(targets))) is not None:
        targets.append(name.decode())
    info = FormatInfo()
    while io("format_info")(len(found), byref(info)):
        extensions = ctypes.cast(info.extensions, ctypes.POINTER(c_char_p)) if info.extensions else None
        name = (info.name or b"").decode()
        found.append(Format(name, (info.title or b"").decode(), tuple(texts(extensions)), bool(info.is_read),
                            name in targets))
    return found
