"""Surfaces in space: triangles and quadrilaterals that lie in no common plane, smoothed on their own shape."""

from __future__ import annotations

from ctypes import byref
from typing import Any, Optional

import numpy as np

from . import _values
from ._arrays import Points, pointer
from ._choices import PlanChoices, RunChoices, check_chosen, set_run
from ._elements import is_triangles
from ._files import Mesh, opened
from ._library import call, library, new_options, threads_to_use, whole
from ._regions import nodes_between
from ._results import CellQuality, Quality, Result
from ._run import watched
from ._shapes import Shape, shape_for
from ._structures import Options
from ._view import View
from ._views import Holding, Source, surface_in_space

_PATCH = 1  # planish_shape_class
_OF_PLAN = {"fix", "regions", "threads", "only_worse_than", "rings", "surface_of", "crease_angle", "slide", "layers"}
_OF_FILES = {"slide_tolerance"}
_OF_RUN = {"objective", "worst_measure", "worst_rise", "surface_tolerance", "max_displacement", "box", "max_sweeps",
           "tolerance", "time_limit", "progress", "untangle"}


def _refuse_others(choices: Any, known: set[str]) -> None:
    """Raise ValueError if an option is given that has no meaning on a surface in space."""
    usual = type(choices)()
    for name, value in choices._asdict().items():
        is_given = value is not getattr(usual, name) and (np.ndim(value) > 0 or value != getattr(usual, name))
        if is_given and name not in known:
            raise ValueError(f"{name} is not for surfaces in space")


def _check(source: Source, choices: PlanChoices, run: RunChoices, has_quads: bool) -> None:
    """Raise ValueError for options and values that are not for surfaces in space."""
    check_chosen(choices)
    is_file = isinstance(source.points, Mesh)
    _refuse_others(choices, _OF_PLAN | (_OF_FILES if is_file else set()))
    _refuse_others(run, _OF_RUN)
    if choices.layers not in (None, "ignore"):
        raise ValueError("layers is not for surfaces in space")
    if not is_file and choices.slide not in (None, "curved"):
        raise ValueError("slide is not for surfaces in space")
    usual = "mean-ratio" if has_quads else "radius-ratio"
    if run.objective not in (None, "worst", usual):
        raise ValueError(f"objective must be {usual} or worst on this surface in space, not {run.objective!r}")


class SpaceSurface:
    """A surface in space, and its shape."""

    def __init__(self, view: View, shape: Shape) -> None:
        """Take the view of the surface, and its shape."""
        self.view = view
        self.shape = shape

    @classmethod
    def of(cls, source: Source, choices: PlanChoices) -> Optional[SpaceSurface]:
        """Return the surface in space of a mesh; None: the mesh is another one."""
        _, _, groups = choices.slides()
        view = surface_in_space(source, Holding(choices.fix, choices.regions, True, groups), choices.threads)
        if view is None:
            return None
        shape = shape_for(source, opened(choices.surface_of), choices.regions, choices.crease_angle, choices.threads)
        return cls(view, shape)

    def _hold_off_curves(self) -> None:
        """Fix the nodes between regions that are on no curve, as the shape was made without these regions."""
        if self.view.region is not None:
            lost = nodes_between(self.view, self.view.region) & (self.shape.classes() == _PATCH)
            if lost.any():
                self.view.fix(lost)

    def _find_slides(self, choices: PlanChoices) -> None:
        """Find the nodes that slide. On a surface of arrays all do that neither regions nor anything else holds."""
        is_sliding, is_curved, groups = choices.slides()
        self._hold_off_curves()
        surface = self.view.surface()
        is_everywhere = choices.slide is None or is_curved or not is_sliding or bool(groups)
        surface.shape = self.shape.pointer().value if is_everywhere else None
        if choices.slide_tolerance:
            surface.tolerance = choices.slide_tolerance
        self.view.find_slides(surface)
        self.view.hold_on_surface(choices.slide is not None and not is_sliding)

    def _options(self, choices: PlanChoices, run: RunChoices) -> Options:
        """Return the options of a run."""
        options, has_quads = new_options(), self.view.has_types()
        set_run(run._replace(objective=run.objective if run.objective == "worst" else None), options, self.view,
                has_quads)
        options.threads = threads_to_use(choices.threads).value
        options.shape = self.shape.pointer().value
        options.only_worse_than = choices.only_worse_than
        options.rings = whole(choices.rings, "rings")
        return options

    def run(self, source: Source, choices: PlanChoices, run: RunChoices) -> Result:
        """Smooth the surface in place."""
        view, result = self.view, Result()
        _check(source, choices, run, view.has_types())
        self._find_slides(choices)
        options, shape = self._options(choices, run), self.shape.handle()  # progress may close it
        taken = Points(source.array, 3, view.points.strides, writes=True)
        view.set_storage(options, taken)

        def work() -> None:
            call(library.planish_smooth_surface, byref(view.mesh), pointer(taken.array), byref(options), byref(result))
            taken.write_back()

        watched(options, run.progress, taken, work)
        del shape
        return result

    def quality(self, per_element: bool) -> Quality:
        """Return the quality of the surface."""
        view, found, cells = self.view, Quality(), CellQuality()
        arrays = _values.room(view, per_element)
        call(library.planish_measure_surface, self.shape.pointer(), byref(view.mesh), threads_to_use(view.threads),
             byref(found), None, byref(cells), _values.structure(arrays))
        found.elements = _values.finished(arrays)
        if per_element or not is_triangles(view.elements):
            found.cells = cells
        return found
