"""Smoothing in one call."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike

from ._choices import (Direction, Fix, Layers, Length, Method, Nodes, Objective, Path, PlanChoices, RunChoices,
                       Slide, WorstMeasure, layers_of_smooth)
from ._heights import run_with_layers
from ._plan import Plan
from ._promises import promises_for
from ._regions import BY_RULE
from ._results import Result
from ._run import Progress
from ._shapes import Shape
from ._surfaces import SpaceSurface
from ._views import Source


def smooth(
    points: Any,
    cells: Any = None,
    *,
    fix: Optional[Fix] = None,
    min_volume: Union[float, ArrayLike, Mapping[str, float]] = 0,
    threads: int = 0,
    only_worse_than: float = 0,
    rings: int = 0,
    around: Optional[Nodes] = None,
    regions: Any = BY_RULE,
    rounding: Optional[float] = None,
    layers: Optional[Layers] = None,
    slide: Optional[Slide] = None,
    slide_interfaces: bool = False,
    slide_tolerance: float = 0,
    surface_of: Any = None,
    crease_angle: float = 0,
    onto: Union[Shape, Path, Any, None] = None,
    like: Any = None,
    size: Any = None,
    size_from: Optional[Path] = None,
    keep_sizes: bool = False,
    size_weight: Optional[float] = None,
    objective: Optional[Objective] = None,
    worst_measure: Optional[WorstMeasure] = None,
    worst_rise: float = 0.01,
    min_volume_fraction: float = 0,
    area_weight: float = 0,
    curve_quality: float = 0.3,
    surface_tolerance: Length = 0,
    max_displacement: Length = 0,
    box: Optional[ArrayLike] = None,
    method: Method = "planish",
    direction: Direction = "newton",
    untangle: bool = True,
    max_sweeps: int = 200,
    tolerance: float = 1e-5,
    time_limit: float = 0,
    progress: Optional[Callable[[Progress], Any]] = None,
) -> Result:
    """Smooth a mesh in place, after untangling it, as the program does (docs/program.md).

    Raise Error, a ValueError, if planish refuses the mesh, ValueError or TypeError for a wrong argument, and
    MemoryError. Points then keep their values, except after an exception of progress.

    Args:
        points: coordinates, an array [n, 2 or 3] of numpy, or a mesh of planish.read, meshio or PyVista. The boundary
            of flat elements in any plane stays; in no plane they are a surface in space (docs/surfaces.md)
        cells: arrays of nodes, as for Plan; None with a mesh
        fix: nodes to hold besides those of the boundary: numbers, a mask, or names of groups of the mesh
        min_volume: minimum volume (area) of every element, 0: any positive volume; or of each element, as for Plan
        threads: as for Plan
        only_worse_than: as for Plan
        rings: as for Plan
        around: as for Plan
        regions: as for Plan
        rounding: as for Plan
        layers: as for Plan, except None: keep the heights of layers of wedges, hexahedra and quadrilaterals; with an
            objective, like or sizes that exclude this, hold these layers as Plan does
        slide: as for Plan
        slide_interfaces: as for Plan
        slide_tolerance: as for Plan
        surface_of: as for Plan
        crease_angle: as for Plan
        onto: as for Plan; the result has fit and fit_distance
        like: as for Plan
        size: as for Plan
        size_from: as for Plan
        keep_sizes: as for Plan
        size_weight: as for Plan
        objective: as for Plan.smooth
        worst_measure: as for Plan.smooth
        worst_rise: as for Plan.smooth
        min_volume_fraction: as for Plan.smooth
        area_weight: as for Plan.smooth
        curve_quality: as for Plan.smooth
        surface_tolerance: as for Plan.smooth
        max_displacement: as for Plan.smooth
        box: as for Plan.smooth
        method: as for Plan.smooth
        direction: as for Plan.smooth
        untangle: as for Plan.smooth
        max_sweeps: as for Plan.smooth
        tolerance: as for Plan.smooth
        time_limit: as for Plan.smooth
        progress: as for Plan.smooth
    """
    is_plain = not isinstance(min_volume, Mapping) and np.ndim(min_volume) == 0
    choices = PlanChoices(
        fix=fix, min_volume=None if is_plain else min_volume, threads=threads, only_worse_than=only_worse_than,
        rings=rings, around=around, regions=regions, rounding=rounding, layers=layers, slide=slide,
        slide_interfaces=slide_interfaces, slide_tolerance=slide_tolerance, surface_of=surface_of,
        crease_angle=crease_angle, onto=onto, like=like, size=size, size_from=size_from, keep_sizes=keep_sizes,
        size_weight=size_weight)
    run = RunChoices(
        objective=objective, worst_measure=worst_measure, worst_rise=worst_rise,
        min_volume=float(min_volume) if is_plain else 0,  # type: ignore[arg-type]
        min_volume_fraction=min_volume_fraction, area_weight=area_weight, curve_quality=curve_quality,
        surface_tolerance=surface_tolerance, max_displacement=max_displacement, box=box, method=method,
        direction=direction, untangle=untangle, max_sweeps=max_sweeps, tolerance=tolerance, time_limit=time_limit,
        progress=progress)
    try:
        return _smooth(Source(points, cells), choices, run)
    finally:
        _mark_modified(points)


def _mark_modified(mesh: Any) -> None:
    """Tell VTK that the points of a mesh have changed, so that pictures and locators follow."""
    points = mesh.GetPoints() if hasattr(mesh, "GetPoints") else None
    if points is not None:
        points.Modified()


def _smooth(source: Source, choices: PlanChoices, run: RunChoices) -> Result:
    """Smooth a mesh with all options."""
    surface = SpaceSurface.of(source, choices)
    if surface is not None:
        return surface.run(source, choices, run)
    with Plan.of_choices(source, layers_of_smooth(choices, run), run) as plan:
        plan.view.check_writable()
        start = plan.start()
        try:
            return _smooth_by(plan, choices, run)
        except BaseException:
            plan.go_back(start)
            raise
        finally:
            plan.view.finish()


def _smooth_by(plan: Plan, choices: PlanChoices, run: RunChoices) -> Result:
    """Smooth the mesh of a plan in all steps."""
    promises = promises_for(plan, choices, run)
    result = run_with_layers(plan, run)
    if promises is not None:
        promises.keep(result)
    if plan.fit is not None:
        result.fit, result.fit_distance = plan.fit, plan.fit_distance()
    return result
