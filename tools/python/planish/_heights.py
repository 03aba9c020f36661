"""Heights of kept layers: where a run changes them by much, nodes are held, and the run begins again.

The rounds are those of the program (tools/commands/rounds.c, tools/job/heights.c).
"""

from __future__ import annotations

from ctypes import byref
from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Points, address, pointer
from ._choices import RunChoices
from ._library import call, library, threads_to_use
from ._plan import Plan
from ._results import LayerHeights, Result

_MUCH, _HELD_FROM = 0.1, 0.05  # parts of a height
_HOLDS, _RELEASES = 7, 2  # rounds that hold more nodes, at most, and rounds that let nodes go again
_RELEASED_RINGS = 4  # of elements around those that are not valid whose nodes are not held
_LEAST_TIME = 1e-3  # seconds
_FIXED = 1  # planish_constraint
_VALID = 1  # planish_cell_state
_HAS_ENDED = ("converged", "max-sweeps")
_IS_CUT = ("time-limit", "interrupted")
_ENOUGH = 0.5  # part of the last round that the next one should have: of its time to begin, of its sweeps to stand


def run_with_layers(plan: Plan, run: RunChoices) -> Result:
    """Smooth in place. Begin again with nodes held where kept layers change their heights by much.

    Nodes that inverted elements need are let go again: no more of these are left than by the first run.
    """
    if plan.view.is_layer is None or plan.fit is not None:
        return plan.run(None, run)
    return _Rounds(plan, run).smooth()


class _Standing(NamedTuple):
    """A result that can come back after rounds that hold more nodes."""

    points: NDArray[Any]
    held: NDArray[np.bool_]
    result: Result
    n_faulty: int
    worst: float  # by how much a height is off most, in parts of a height


class _Rounds:
    """Rounds of smoothing from the same start, with other nodes held."""

    def __init__(self, plan: Plan, run: RunChoices) -> None:
        """Take the mesh as it is, and smooth it once."""
        view = plan.view
        self.plan, self.view, self.run = plan, view, run
        self.start: NDArray[Any] = np.array(view.given)
        self.constraint = np.zeros(view.n, dtype=np.uint8) if view.constraint is None else view.constraint.copy()
        self.held, self.released = np.zeros(view.n, dtype=bool), np.zeros(view.n, dtype=bool)
        self.nodes, self.owner = view.elements.corners_of_all()
        self.n_holds, self.n_releases, self.worst = 0, 0, 0.0
        self.is_tangled = bool((view.states() > _VALID).any())
        self.result = plan.run(None, run)
        self.seconds = self.result.seconds
        self.faulty = self._find_faulty()
        self.n_first = int(self.faulty.sum())
        self.standing: Optional[_Standing] = None

    def smooth(self) -> Result:
        """Hold nodes in rounds until no heights change by much.

        A round that a limit or signal ends early is hardly smoothed, but keeps more heights than the one before. It
        stands if it has no more invalid elements, has heights less far off, and has had half the sweeps of that one.
        """
        is_late = False
        while self.result.stop in _HAS_ENDED and not is_late:
            held = self._choose_nodes()
            if not (held != self.held).any():
                break
            is_late = not self._has_time()
            if not is_late:
                self._smooth_again(held)
        if self.standing is not None and self._gives_way(self.standing):
            self._let_standing_return(self.standing)
        if is_late:
            self.result.end_by_time()
        self.result.seconds = self.seconds
        return self.result

    def _find_faulty(self) -> NDArray[np.bool_]:
        """Return a mask [m] of the elements that are not valid now, if some were not before."""
        if not self.is_tangled:
            return np.zeros(self.view.elements.n, dtype=bool)
        faulty: NDArray[np.bool_] = self.view.states() > _VALID
        return faulty

    def _choose_nodes(self) -> NDArray[np.bool_]:
        """Return the mask of held nodes with more of them, or without those around elements that are not valid."""
        if self.faulty.sum() > self.n_first and self.n_releases < _RELEASES:
            self.n_releases += 1
            return self._without_released()
        if self.faulty.sum() <= self.n_first and self.n_holds < _HOLDS:
            self.n_holds += 1
            return self._with_chosen()
        return self.held

    def _has_time(self) -> bool:
        """Return whether enough is left of the time for another round."""
        limit = self.run.time_limit
        return limit <= 0 or limit - self.seconds >= _ENOUGH * self.result.seconds

    def _gives_way(self, standing: _Standing) -> bool:
        """Return whether the result is to give way to the one that stands."""
        if self.result.stop not in _IS_CUT:
            return bool(self.faulty.sum() > self.n_first)
        return bool(self.faulty.sum() > standing.n_faulty or self.result.sweeps < _ENOUGH * standing.result.sweeps
                    or not self._worst(self._off()) < standing.worst)

    def _worst(self, off: NDArray[np.float64]) -> float:
        """Return the largest of off [n] but at nodes that were released, where it becomes 0."""
        off[self.released] = 0
        return float(np.fmax.reduce(off, initial=0))

    def _with_chosen(self) -> NDArray[np.bool_]:
        """Return the mask of held nodes with those at which heights are off, if some are by much; in the end of all."""
        off = self._off()
        self.worst = self._worst(off)
        if not self.worst > _MUCH:
            return self.held
        if self.n_holds == _HOLDS:
            assert self.view.is_layer is not None
            off[self.nodes[self.view.is_layer[self.owner]]] = np.inf
        held: NDArray[np.bool_] = self.held | ((off > _HELD_FROM) & (self.constraint != _FIXED) & ~self.released)
        return held

    def _without_released(self) -> NDArray[np.bool_]:
        """Release the nodes of faulty elements and rings around all released ones. Return the mask of held nodes."""
        faulty = self.faulty.copy()
        self.released[self.nodes[faulty[self.owner]]] = True
        for _ in range(_RELEASED_RINGS):
            faulty[self.owner[self.released[self.nodes]]] = True
            self.released[self.nodes[faulty[self.owner]]] = True
        return self.held & ~self.released

    def _begin_again(self) -> None:
        """Go back to the start, with the nodes held that are held now."""
        self.view.constrain(np.where(self.held, _FIXED, self.constraint).astype(np.uint8), self.view.direction)
        self.view.given[...] = self.start
        self.plan.renew()

    def _smooth_again(self, held: NDArray[np.bool_]) -> None:
        """Smooth again from the start, in what is left of the time, with these nodes held.

        The result as it is now stands, unless nodes are let go as it leaves too many elements that are not valid.
        """
        limit = self.run.time_limit
        if self.faulty.sum() <= self.n_first:
            self.standing = _Standing(np.array(self.view.given), self.held, self.result, int(self.faulty.sum()), self.worst)
        self.held = held
        left = max(limit - self.seconds, _LEAST_TIME) if limit > 0 else 0
        self._begin_again()
        self.result = self.plan.run(None, self.run._replace(time_limit=left))
        self.seconds += self.result.seconds
        self.faulty = self._find_faulty()

    def _let_standing_return(self, standing: _Standing) -> None:
        """Let the result come back that stands. Sweeps that a limit or signal has ended say so still."""
        last, self.held, self.result = self.result, standing.held, standing.result
        self._begin_again()
        self.view.given[...] = standing.points
        if last.stop not in _HAS_ENDED:
            self.result.end_as(last)

    def _off(self) -> NDArray[np.float64]:
        """Return by how much heights at each node [n] are off those at the start, in parts of these."""
        view, off = self.view, np.zeros(self.view.n)
        mesh, before = view.mesh_now(), Points(self.start, view.dim, view.points.strides)
        mesh.reference, mesh.size, mesh.metric = address(before.array), None, None
        call(library.planish_measure_layers, byref(mesh), threads_to_use(view.threads), byref(LayerHeights()), pointer(off))
        return off
