"""A run of the library that Python watches: progress, and what is raised meanwhile."""

from __future__ import annotations

import sys
import threading
from typing import Any, Callable, Optional

from ._structures import PROGRESS, Options, Progress


class _Watch:
    """The caller's progress, as the library calls it."""

    def __init__(self, progress: Callable[[Progress], Any]) -> None:
        self.progress = progress
        self.raised: list[BaseException] = []
        self.hook = sys.unraisablehook

    def __call__(self, seen: Any, _user: Any) -> int:
        """Call progress; end the run if that says so or raises."""
        if self.raised:
            return 1
        try:
            return bool(self.progress(Progress.from_buffer_copy(seen.contents)))
        except BaseException as exception:  # pylint: disable=broad-except
            self.raised.append(exception)
            return 1

    def note(self, unraisable: Any) -> None:
        """Take what a signal's handler raises before the first line of __call__, as KeyboardInterrupt."""
        if unraisable.object is self:
            self.raised.append(unraisable.exc_value)
        else:
            self.hook(unraisable)


def watched(options: Options, progress: Optional[Callable[[Progress], Any]], work: Callable[[], None]) -> None:
    """Do work, which calls the library with options, and raise what progress has raised, once it has ended."""
    if progress is None:
        options.progress = PROGRESS(0)
        work()
        return
    watch = _Watch(progress)
    note = watch.note
    options.progress = PROGRESS(watch)
    if threading.current_thread() is threading.main_thread():  # where handlers of signals run
        sys.unraisablehook = note
    try:
        work()
    finally:
        if sys.unraisablehook is note:
            sys.unraisablehook = watch.hook
        options.progress = PROGRESS(0)
    if watch.raised:
        raise watch.raised[0]
