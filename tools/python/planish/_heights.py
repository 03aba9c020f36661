"""Heights of kept layers: where a run changes them by much, nodes are held, and the run begins again."""

from __future__ import annotations

from ctypes import byref
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Points, address, pointer
from ._choices import RunChoices
from ._library import call, library, threads_to_use
from ._plan import Plan
from ._results import LayerHeights, Result
from ._structures import MeshView
from ._view import View

_MUCH, _HELD_FROM = 0.1, 0.05  # parts of a height, as in the program (tools/job/heights.c)
_ROUNDS = 6
_LEAST_TIME = 1e-3  # seconds
_FIXED = 1  # planish_constraint
_VALID = 1  # planish_cell_state
_HAS_ENDED = ("converged", "max-sweeps")


def run_with_layers(plan: Plan, run: RunChoices) -> Result:
    """Smooth in place. Begin again with nodes held where kept layers of a valid mesh change their heights by much."""
    view = plan.view
    if not view.mesh.is_layer or plan.fit is not None or (view.states() != _VALID).any():
        return plan.run(None, run)
    start: NDArray[Any] = np.array(view.given)
    result, seconds = plan.run(None, run), 0.0
    for _ in range(_ROUNDS):
        if result.stop not in _HAS_ENDED or not _hold(view, start):
            break
        seconds += result.seconds
        view.given[...] = start
        plan.renew()
        left = max(run.time_limit - seconds, _LEAST_TIME) if run.time_limit > 0 else 0
        result = plan.run(None, run._replace(time_limit=left))
    result.seconds += seconds
    return result


def _hold(view: View, start: NDArray[Any]) -> int:
    """Fix the nodes at which heights are off those at start, if some are by much. Return the number of new ones."""
    off = _off(view, start)
    if not off.max(initial=0) > _MUCH:
        return 0
    new = off > _HELD_FROM
    if view.constraint is not None:
        new &= view.constraint != _FIXED
    view.fix(new)
    return int(new.sum())


def _off(view: View, start: NDArray[Any]) -> NDArray[np.float64]:
    """Return by how much heights at each node [n] are off those at start, in parts of these."""
    now, before = (Points(points, view.dim, view.points.strides) for points in (view.given, start))
    mesh, off = MeshView.from_buffer_copy(view.mesh), np.zeros(view.n)
    mesh.coordinates, mesh.reference = address(now.array), address(before.array)
    mesh.size = mesh.metric = None
    call(library.planish_measure_layers, byref(mesh), threads_to_use(view.threads), byref(LayerHeights()), pointer(off))
    return off
