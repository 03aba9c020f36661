"""Accessor of PyVista: mesh.planish.smooth(), mesh.planish.quality().

PyVista 0.48 and later finds the accessor of an installed package by itself (pyvista_plugin.py). import planish
registers it if PyVista was imported before. Otherwise call register(pyvista), or planish.smooth(mesh).
"""

from __future__ import annotations

import sys
from typing import Any, Callable, Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._choices import Direction, Fix, Layers, Length, Method, Nodes, Objective, Path, Slide, WorstMeasure
from ._quality import find_layers, quality
from ._regions import BY_RULE
from ._results import Quality, Result
from ._run import Progress
from ._shapes import Shape
from ._smooth import smooth

NAME = "planish"


class Accessor:
    """Namespace planish of a mesh of PyVista."""

    def __init__(self, mesh: Any) -> None:
        """Take the mesh."""
        self._mesh = mesh

    def smooth(
        self,
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
        """Smooth the mesh in place, with the options of planish.smooth."""
        return smooth(
            self._mesh, fix=fix, min_volume=min_volume, threads=threads, only_worse_than=only_worse_than, rings=rings,
            around=around, regions=regions, rounding=rounding, layers=layers, slide=slide,
            slide_interfaces=slide_interfaces, slide_tolerance=slide_tolerance, surface_of=surface_of,
            crease_angle=crease_angle, onto=onto, like=like, size=size, size_from=size_from, keep_sizes=keep_sizes,
            size_weight=size_weight, objective=objective, worst_measure=worst_measure, worst_rise=worst_rise,
            min_volume_fraction=min_volume_fraction, area_weight=area_weight, curve_quality=curve_quality,
            surface_tolerance=surface_tolerance, max_displacement=max_displacement, box=box, method=method,
            direction=direction, untangle=untangle, max_sweeps=max_sweeps, tolerance=tolerance, time_limit=time_limit,
            progress=progress)

    def quality(
        self,
        *,
        fix: Optional[Fix] = None,
        regions: Any = BY_RULE,
        rounding: Optional[float] = None,
        per_element: bool = False,
        like: Any = None,
        size: Any = None,
        start: Any = None,
        threads: int = 0,
    ) -> Quality:
        """Return the quality of the mesh, with the options of planish.quality."""
        return quality(self._mesh, fix=fix, regions=regions, rounding=rounding, per_element=per_element, like=like,
                       size=size, start=start, threads=threads)

    def find_layers(self, *, threads: int = 0) -> NDArray[np.bool_]:
        """Return a mask of the elements that are thin in layers, as planish.find_layers does."""
        return find_layers(self._mesh, threads=threads)


def register(pyvista: Any) -> bool:
    """Register the accessor, if this PyVista has accessors. Return whether it is registered."""
    if not hasattr(pyvista, "register_dataset_accessor"):
        return False
    for target in (pyvista.UnstructuredGrid, pyvista.PolyData):
        if NAME not in vars(target):  # registered_accessors would import all other packages with accessors
            pyvista.register_dataset_accessor(NAME, target)(Accessor)
    return True


if "pyvista" in sys.modules:
    register(sys.modules["pyvista"])
