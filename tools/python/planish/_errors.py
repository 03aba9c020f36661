"""Errors of the library, as exceptions."""

from __future__ import annotations


class Error(ValueError):
    """Error of the library. The text says what is wrong, where, and what to do.

    code is a planish_status. element and node are the indices of the ones meant, or -1.
    """

    def __init__(self, text: str, code: int = 0, element: int = -1, node: int = -1) -> None:
        """Take the text, the planish_status, and the element and node that the error is about."""
        super().__init__(text)
        self.code = code
        self.element = element
        self.node = node


class FileError(Error, OSError):
    """Error of a file: it cannot be opened, read or written, or its content breaks the rules of its format.

    Where there is no file to read it is a FileNotFoundError, too.
    """


class MissingFileError(FileError, FileNotFoundError):
    """Error of a file that is to be read and is not there."""

    def __str__(self) -> str:
        """Return the text of the library, which names the file."""
        return str(self.args[0])


class ConversionWarning(UserWarning):
    """Warning that a converted file lacks data of the mesh: its format cannot store them."""


_MEMORY, _OF_FILES = -3, (-4, -5)  # planish_status


def exception_of(text: str, code: int, element: int, node: int) -> Exception:
    """Return the exception for an error of the library."""
    if code == _MEMORY:
        return MemoryError(text)
    return (FileError if code in _OF_FILES else Error)(text, code, element, node)
