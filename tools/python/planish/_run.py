"""A run of the library with the caller's progress, and the exceptions raised meanwhile."""

from __future__ import annotations

import sys
import threading
from typing import Any, Callable, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Points, pointer
from ._library import call, library
from ._structures import PROGRESS, Options, ProgressFields


class Progress(ProgressFields):
    """State of a run: planish_progress of planish.h, field by field. Times are in seconds."""

    _seen: Any = None  # pointer to the library's own, while progress is called
    _start: Optional[Points] = None

    @classmethod
    def of(cls, seen: Any, start: Points) -> Progress:
        """Return a copy of what the library shows, for modules of this package. start: the points being smoothed."""
        made = cls.from_buffer_copy(seen.contents)
        made._seen, made._start = seen, start
        return made

    def end(self) -> None:
        """Forget where the nodes are, for modules of this package: the library is about to go on."""
        self._seen = self._start = None

    def points(self) -> NDArray[np.float64]:
        """Return the coordinates of the nodes [n, 2 or 3] at the end of the sweep: those that the figures describe.

        planish_progress_get_coordinates of planish.h has the details. Raise ValueError, except while progress is called
        and sweep_done is not 0.
        """
        if self._start is None or not self.sweep_done:
            raise ValueError("points are known only while progress is called, where sweep_done is not 0")
        found = self._start.copy()
        call(library.planish_progress_get_coordinates, self._seen, pointer(found))
        return self._start.shown(found)


class _Watch:
    """Function for the library to call, which calls the caller's progress."""

    def __init__(self, progress: Callable[[Progress], Any], points: Points) -> None:
        self.progress = progress
        self.points = points
        self.raised: list[BaseException] = []
        self.hook = sys.unraisablehook

    def __call__(self, seen: Any, _user: Any) -> int:
        """Call progress. Return 1, which ends the run, if progress returns a true value or raises."""
        if self.raised:
            return 1
        try:
            shown = Progress.of(seen, self.points)
            try:
                return bool(self.progress(shown))
            finally:
                shown.end()
        except BaseException as exception:  # pylint: disable=broad-except
            self.raised.append(exception)
            return 1

    def note(self, unraisable: Any) -> None:
        """Keep what a signal's handler raises before the first line of __call__, such as KeyboardInterrupt.

        What the library is told then is either not 0, which ends the run, or 0, and the next call ends it. From Python
        3.13 on nobody says whose exception it is.
        """
        trace = unraisable.exc_traceback
        frame = trace.tb_frame if trace is not None else None
        if frame is not None and frame.f_code is _Watch.__call__.__code__ and frame.f_locals.get("self") is self:
            self.raised.append(unraisable.exc_value)
        else:
            self.hook(unraisable)


def watched(options: Options, progress: Optional[Callable[[Progress], Any]], points: Points,
            work: Callable[[], None]) -> None:
    """Do work, which smooths points with options. Then raise the exception that progress raised, if any."""
    if progress is None:
        options.progress = PROGRESS(0)
        work()
        return
    watch = _Watch(progress, points)
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
