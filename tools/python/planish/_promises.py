"""Promises in tilted planes: nodes go back where rounding to stored digits breaks a promise of smoothing.

In a tilted plane coordinates are not those that are stored: this module rounds them, as the library cannot.
As in the program, nodes go back if their elements are then inverted, or worse than promised.
"""

from __future__ import annotations

from ctypes import byref, c_double
from typing import NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import address
from ._cell_types import CORNERS
from ._choices import PlanChoices, RunChoices
from ._library import call, library, threads_to_use
from ._plan import Plan
from ._results import CellMeasures, CellQuality, Quality, Result
from ._structures import CellValueArrays
from ._view import View

_ROUNDS = 20  # then all nodes go back
_ROUNDING = 1e-12  # relative, of sums over the same elements; of scaled Jacobians
_ANGLE_RELATIVE, _ANGLE_ABSOLUTE = 1e-9, 1e-12  # of degrees
_VALID = 1  # planish_cell_state


class _State(NamedTuple):
    """Measures of a mesh."""

    quality: Quality
    cells: Optional[CellMeasures]  # None: all elements are straight simplices
    states: Optional[NDArray[np.uint8]]  # planish_cell_state of each


class Promises:
    """Promises for a mesh in a tilted plane, and its measures before smoothing."""

    def __init__(self, plan: Plan, view: View, choices: PlanChoices, run: RunChoices) -> None:
        """Measure the mesh."""
        self.plan, self.view, self.run = plan, view, run
        self.has_types = view.has_types()
        self.before = self._measure()
        has_volumes = choices.min_volume is not None or run.min_volume > 0 or run.min_volume_fraction > 0
        self.was_valid = self._faults(self.before) == 0 and not has_volumes
        usual = (None, "worst", "mean-ratio" if self.has_types else "radius-ratio")
        self.is_usual = run.objective in usual and not run.area_weight and not choices.has_sizes()
        self.is_blunt = not view.mesh.reference or bool(view.mesh.is_layer)

    def _measure(self) -> _State:
        """Measure the mesh as it is."""
        quality = self.plan.quality()
        if not self.view.mesh.cells:
            return _State(quality, None, None)
        states, found = np.zeros(self.view.elements.n, dtype=np.uint8), CellQuality()
        call(library.planish_measure_cells, byref(self.view.mesh), c_double(self.view.rounding(None)),
             threads_to_use(self.view.threads), byref(found), byref(CellValueArrays(state=address(states))))
        return _State(quality, found.all, states)

    def _faults(self, state: _State) -> int:
        """Return the number of elements that are not valid."""
        return state.quality.n_inverted if state.cells is None else state.cells.n_inverted + state.cells.n_uncertified

    def _newly_invalid(self, after: _State) -> NDArray[np.bool_]:
        """Return a mask [m] of the elements that were valid before and are not valid now."""
        if self.before.states is None or after.states is None:
            return np.zeros(self.view.elements.n, dtype=bool)
        found: NDArray[np.bool_] = (self.before.states == _VALID) & (after.states != _VALID)
        return found

    def _is_more_inverted(self, after: _State) -> bool:
        if self.has_types:
            return self._faults(after) > self._faults(self.before)
        return after.quality.n_inverted > self.before.quality.n_inverted or bool(self._newly_invalid(after).any())

    def _is_sharper(self, after: _State, slack: float) -> bool:
        """Whether the smallest angle, or scaled Jacobian, is smaller than it was."""
        if not self.has_types:
            least = self.before.quality.min_angle_deg_movable * (1 - _ANGLE_RELATIVE) - _ANGLE_ABSOLUTE
            return after.quality.min_angle_deg_movable < least
        if not self.is_blunt or after.cells is None or self.before.cells is None:
            return False
        return after.cells.min_scaled_jacobian < self.before.cells.min_scaled_jacobian - _ROUNDING - slack

    def _is_broken(self, after: _State, result: Result) -> bool:
        """Whether the mesh breaks a promise."""
        slack = _ROUNDING if self.has_types else 0.0
        if self._is_more_inverted(after):
            return True
        if not self.was_valid or self.run.method != "planish":
            return False
        before, now = self.before.quality, after.quality
        if now.max_radius_ratio_movable > before.max_radius_ratio_movable * (1 + slack):
            return True
        if not self.is_usual:
            return False
        return self._is_sharper(after, slack) or (
            result.objective_of_worst <= 0 and now.rms_radius_ratio > before.rms_radius_ratio * (1 + _ROUNDING))

    def _mark(self, after: _State, back: NDArray[np.uint8]) -> None:
        """Mark in back [n] the corners of elements that break promises, or all nodes if these are marked already."""
        ratios, layout = self.plan.radius_ratios(), self.view.elements.as_layout()
        breaks = (ratios == 0) | self._newly_invalid(after)
        if self.was_valid:
            breaks |= ratios > self.before.quality.max_radius_ratio_movable
        at = layout.offsets[:-1][breaks]
        corners = np.concatenate([np.arange(first, first + n) for first, n in zip(at, CORNERS[layout.types[breaks]])]
                                 or [np.zeros(0, dtype=np.int64)])
        nodes = layout.nodes[corners]
        if (back[nodes] != 0).all():
            back[:] = 1
        back[nodes] = 1

    def keep(self, result: Result) -> None:
        """Round the points to the digits that are stored, and put nodes back where that breaks a promise."""
        back = np.zeros(self.view.n, dtype=np.uint8)
        for turn in range(_ROUNDS + 2):
            result.n_moved_nodes -= self.view.round_in_plane(back)
            after = self._measure()
            if not self._is_broken(after, result):
                return
            self._mark(after, back)
            if turn >= _ROUNDS:
                back[:] = 1


def promises_for(plan: Plan, choices: PlanChoices, run: RunChoices) -> Optional[Promises]:
    """Return the promises to keep after smoothing a mesh; None: the library keeps them."""
    return Promises(plan, plan.view, choices, run) if plan.view.is_tilted else None
