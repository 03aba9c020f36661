"""Structures of C whose fields are annotations, so that readers and type checkers see them."""

from __future__ import annotations

import ctypes
import typing
from typing import Annotated, Any, Optional

Int = Annotated[int, ctypes.c_int]
Int64 = Annotated[int, ctypes.c_int64]
Size = Annotated[int, ctypes.c_size_t]
Double = Annotated[float, ctypes.c_double]
Text = Annotated[Optional[bytes], ctypes.c_char_p]
Pointer = Annotated[Optional[int], ctypes.c_void_p]

Made = typing.TypeVar("Made", bound="type[ctypes.Structure]")


def _type_of(hint: Any) -> Any:
    """Return the type of ctypes that an annotation means; None: the annotation is not of a field."""
    for extra in getattr(hint, "__metadata__", ()):
        return extra
    return hint if isinstance(hint, type) and issubclass(hint, ctypes.Structure) else None


def fields(made: Made) -> Made:
    """Turn the annotations of a class into fields of its structure: those of the types above, and structures."""
    inherited: dict[str, Any] = {}
    for base in made.__mro__[1:]:
        inherited.update(getattr(base, "__annotations__", {}))
    hints = typing.get_type_hints(made, include_extras=True)
    types = [(name, _type_of(hint)) for name, hint in hints.items() if name not in inherited]
    made._fields_ = [(name, of) for name, of in types if of is not None]
    return made
