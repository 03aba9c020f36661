"""Errors of the library, as exceptions."""

from __future__ import annotations


class Error(ValueError):
    """Refusal of the library: the text says what, where and what to do.

    code is a planish_status; element and node are the ones meant, or -1.
    """

    def __init__(self, text: str, code: int = 0, element: int = -1, node: int = -1) -> None:
        """Take the text of a message, and what it is about."""
        super().__init__(text)
        self.code = code
        self.element = element
        self.node = node


class FileError(Error, OSError):
    """Refusal of a file: it cannot be opened, read or written, or its content is not that of its format."""


class ConversionWarning(UserWarning):
    """Warning that a file of another format lacks some of what the mesh has."""


_MEMORY, _OF_FILES = -3, (-4, -5)  # planish_status


def exception_of(text: str, code: int, element: int, node: int) -> Exception:
    """Return the exception for an error of the library."""
    if code == _MEMORY:
        return MemoryError(text)
    return (FileError if code in _OF_FILES else Error)(text, code, element, node)
