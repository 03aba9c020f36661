"""A run of the library with the caller's progress, and the exceptions raised meanwhile."""

from __future__ import annotations

import sys
import threading
from typing import Any, Callable, Optional

from ._structures import PROGRESS, Options, Progress


class _Watch:
    """Function for the library to call, which calls the caller's progress."""

    def __init__(self, progress: Callable[[Progress], Any]) -> None:
        self.progress = progress
        self.raised: list[BaseException] = []
        self.hook = sys.unraisablehook

    def __call__(self, seen: Any, _user: Any) -> int:
        """Call progress. Return 1, which ends the run, if progress returns a true value or raises."""
        if self.raised:
            return 1
        try:
            return bool(self.progress(Progress.from_buffer_copy(seen.contents)))
        except BaseException as exception:  # pylint: disable=broad-except
            self.raised.append(exception)
            return 1

    def note(self, unraisable: Any) -> None:
        """Keep what a signal's handler raises before the first line of __call__, such as KeyboardInterrupt."""
        if unraisable.object is self:
            self.raised.append(unraisable.exc_value)
        else:
            self.hook(unraisable)


def watched(options: Options, progress: Optional[Callable[[Progress], Any]], work: Callable[[], None]) -> None:
    """Do work, which calls the library with options. Then raise the exception that progress raised, if any."""
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
