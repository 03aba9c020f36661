"""Choices that callers have: words, and options of plans and runs."""

from __future__ import annotations

import os
from typing import AbstractSet, Any, Callable, Literal, NamedTuple, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Array
from ._layers import KEEP_BY_TYPE
from ._library import whole
from ._regions import BY_RULE
from ._run import Progress
from ._structures import Options
from ._view import View

Objective = Literal["radius-ratio", "mean-ratio", "edge-ratio", "worst"]
WorstMeasure = Literal["dihedral", "radius-ratio", "aspect-ratio", "scaled-jacobian"]
Method = Literal["planish", "laplacian", "area-laplacian", "length-laplacian"]
Direction = Literal["newton", "fletcher-reeves"]
Layers = Literal["hold", "keep", "ignore"]
Slide = Union[str, Sequence[str]]  # auto, curved, none or groups
Length = Union[float, str]  # a number, or one and h: in edges
Nodes = Union[ArrayLike, AbstractSet[int]]  # numbers, or a mask
Fix = Union[str, Sequence[str], AbstractSet[str], Nodes]  # groups, or nodes
Path = Union[str, "os.PathLike[str]"]

_OBJECTIVES = {"radius-ratio": 0, "mean-ratio": 1, "edge-ratio": 2, "worst": 0}
_WORST = {"radius-ratio": 1, "dihedral": 2, "aspect-ratio": 3, "scaled-jacobian": 4}
_METHODS = {"planish": 0, "laplacian": 1, "area-laplacian": 2, "length-laplacian": 3}
_DIRECTIONS = {"newton": 0, "fletcher-reeves": 1}
_OF_TYPES = 3  # measures of worst elements from here on are of meshes with other elements than simplices
_WEIGHT_OF_SIZES = 0.9


class PlanChoices(NamedTuple):
    """Options of a plan, as Plan describes them."""

    fix: Any = None
    min_volume: Any = None
    threads: int = 0
    only_worse_than: float = 0
    rings: int = 0
    around: Any = None
    regions: Any = BY_RULE
    rounding: Optional[float] = None
    layers: Optional[str] = None
    slide: Any = None
    slide_interfaces: bool = False
    slide_tolerance: float = 0
    surface_of: Any = None
    crease_angle: float = 0
    onto: Any = None
    like: Any = None
    size: Any = None
    size_from: Any = None
    keep_sizes: bool = False
    size_weight: Optional[float] = None

    def has_sizes(self) -> bool:
        """Whether sizes are asked for."""
        return self.size is not None or self.size_from is not None or self.keep_sizes

    def slides(self) -> tuple[bool, bool, list[str]]:
        """Return whether nodes slide, whether on curved surfaces too, and the groups to slide on ([]: any)."""
        given = [] if self.slide is None else [self.slide] if isinstance(self.slide, str) else self.slide
        if not np.iterable(given) or not all(isinstance(word, str) for word in given):
            raise TypeError(f"slide must be auto, curved, none, None or names of groups, not {given!r}")
        words = list(given)
        groups = [word for word in words if word not in ("auto", "curved", "none")]
        return any(word != "none" for word in words), "curved" in words, groups


class RunChoices(NamedTuple):
    """Options of a run, as Plan.smooth describes them."""

    objective: Optional[str] = None
    worst_measure: Optional[str] = None
    worst_rise: float = 0.01
    min_volume: float = 0
    min_volume_fraction: float = 0
    area_weight: float = 0
    curve_quality: float = 0.3
    surface_tolerance: Length = 0
    max_displacement: Length = 0
    box: Any = None
    method: str = "planish"
    direction: str = "newton"
    untangle: bool = True
    max_sweeps: int = 200
    tolerance: float = 1e-5
    time_limit: float = 0
    progress: Optional[Callable[[Progress], Any]] = None


# Options that Laplacian methods do not heed.
_PLAN_OPTIMISES = ("only_worse_than", "rings", "layers", "slide", "slide_interfaces", "onto", "like", "size", "size_from",
                   "keep_sizes", "size_weight")
_RUN_OPTIMISES = ("objective", "worst_measure", "worst_rise", "area_weight", "curve_quality", "surface_tolerance",
                  "direction", "untangle")

# ---- plans ------------------------------------------------------------------------------------------


def check_chosen(choices: PlanChoices) -> None:
    """Raise ValueError if rings have no nodes that they are around."""
    if choices.rings > 0 and not choices.only_worse_than and choices.around is None:
        raise ValueError("rings has no effect without only_worse_than or around")


def _refuse_beside_onto(**given: Any) -> None:
    """Raise ValueError if an option is given that has no place beside onto, as the program refuses them."""
    for name, is_given in given.items():
        if is_given:
            raise ValueError(f"give onto or {name}, not both")


def check_plan(choices: PlanChoices) -> None:
    """Raise ValueError if options of a plan exclude each other, or one lacks another."""
    is_sliding, is_curved, _ = choices.slides()
    if choices.onto is not None:
        _refuse_beside_onto(slide=is_sliding, around=choices.around is not None, only_worse_than=choices.only_worse_than,
                            surface_of=choices.surface_of is not None)
    is_of_curved = choices.surface_of is not None or choices.slide_interfaces or (
        choices.crease_angle and choices.onto is None)
    if not is_curved and is_of_curved:
        raise ValueError("surface_of, crease_angle and slide_interfaces are for slide='curved'")
    check_chosen(choices)
    if choices.slide_tolerance and not is_sliding:
        raise ValueError("slide_tolerance has no effect without slide")
    if choices.size_weight and choices.like is None and not choices.has_sizes():
        raise ValueError("size_weight is for plans with like or sizes (size, size_from, keep_sizes)")
    if choices.like is not None and choices.has_sizes():
        raise ValueError("give like or size, not both")
    if (choices.size is not None) + (choices.size_from is not None) + choices.keep_sizes > 1:
        raise ValueError("give one of size, size_from and keep_sizes")


def check_curved(dim: int, is_curved: bool) -> None:
    """Raise ValueError if nodes are to slide on curved surfaces in a plane. dim: that of the mesh."""
    if is_curved and dim == 2:
        raise ValueError("the mesh lies in a plane, which has no curved surface: use slide='auto'")


def size_weight_of(choices: PlanChoices) -> float:
    """Return the weight of sizes."""
    usual = _WEIGHT_OF_SIZES if choices.has_sizes() else 0.0
    return usual if choices.size_weight is None else choices.size_weight


def layers_of_smooth(choices: PlanChoices, run: RunChoices) -> PlanChoices:
    """Return the choices of a plan for one run. Without layers, it keeps those of some types if the run allows that."""
    is_usual = run.objective in (None, "mean-ratio") and run.method == "planish"
    return choices._replace(layers=KEEP_BY_TYPE) if choices.layers is None and is_usual else choices


# ---- runs -------------------------------------------------------------------------------------------


def _number_of(word: Any, words: dict[str, int], name: str) -> int:
    """Return the number of a word; raise ValueError if words does not have it. name: the option."""
    if not isinstance(word, str) or word not in words:
        raise ValueError(f"{name} must be one of {', '.join(words)}, not {word!r}")
    return words[word]


def length(given: Length, name: str) -> tuple[float, int]:
    """Return a length and its unit: a number in the units of points, or a text such as "0.05h" in mean edges."""
    if not isinstance(given, str):
        return given, 0
    try:
        return (float(given[:-1]), 1) if given.endswith("h") else (float(given), 0)
    except ValueError:
        raise ValueError(f"{name} must be a number, or one and h, such as 0.05h, not {given!r}") from None


def check_run(run: RunChoices) -> None:
    """Raise ValueError if an option of a run has no effect without another one, and TypeError if progress is none."""
    if run.progress is not None and not callable(run.progress):
        raise TypeError(f"progress must be a function, not {type(run.progress).__name__}")
    _number_of("dihedral" if run.worst_measure is None else run.worst_measure, _WORST, "worst_measure")
    for name in ("worst_measure", "worst_rise"):
        if run.objective != "worst" and getattr(run, name) != getattr(RunChoices(), name):
            raise ValueError(f"{name} has no effect without objective='worst'")


def _given(choices: Any, names: tuple[str, ...]) -> list[str]:
    """Return those of the names whose option is not as usual."""
    usual = type(choices)()._asdict()
    return [name for name, value in choices._asdict().items()
            if name in names and value is not usual[name] and (usual[name] is None or value != usual[name])]


def check_run_onto(run: RunChoices) -> None:
    """Raise ValueError if a run of a plan with onto has an option that has no place beside it."""
    _refuse_beside_onto(box=run.box is not None,
                        max_displacement=length(run.max_displacement, "max_displacement")[0] != 0)


def check_method(choices: PlanChoices, run: RunChoices) -> None:
    """Raise ValueError if a Laplacian method does not heed an option of its plan or run."""
    if run.method == "planish":
        return
    heeded = choices._replace(slide=choices.slide if choices.slides()[0] else None,
                              layers="keep" if choices.layers == "keep" else None)
    given = _given(heeded, _PLAN_OPTIMISES) + _given(run, _RUN_OPTIMISES)
    if given:
        raise ValueError(f"{given[0]} has no effect with method={run.method!r}")


def _check_objective(run: RunChoices, has_types: bool) -> None:
    """Raise ValueError if an objective or measure is of other elements than those of the mesh."""
    if has_types and run.objective == "radius-ratio":
        raise ValueError("radius-ratio is of triangles and tetrahedra alone; leave objective out, or give edge-ratio")
    if run.worst_measure is not None and (_WORST[run.worst_measure] >= _OF_TYPES) != has_types:
        raise ValueError(f"worst_measure {run.worst_measure!r} is of other elements than the mesh has; leave it out")


def _set_objective(run: RunChoices, options: Options, has_types: bool) -> None:
    """Set what a run minimises."""
    objective = "radius-ratio" if run.objective is None else run.objective
    measure = ("scaled-jacobian" if has_types else "dihedral") if run.worst_measure is None else run.worst_measure
    options.objective = _number_of(objective, _OBJECTIVES, "objective")
    worst = _number_of(measure, _WORST, "worst_measure")
    _check_objective(run, has_types)
    options.worst = worst if run.objective == "worst" else 0
    options.worst_rise = run.worst_rise
    options.area_weight = run.area_weight
    options.curve_quality = run.curve_quality
    options.method = _number_of(run.method, _METHODS, "method")
    options.search = _number_of(run.direction, _DIRECTIONS, "direction")


def _set_box(options: Options, corners: tuple[Array, Array]) -> None:
    for i, (low, high) in enumerate(zip(*corners)):
        options.box_lower[i], options.box_upper[i] = low, high


def set_run(run: RunChoices, options: Options, view: View, has_types: bool) -> None:
    """Set the options of a run; its progress is called elsewhere."""
    check_run(run)
    _set_objective(run, options, has_types)
    options.min_volume = run.min_volume
    options.min_volume_fraction = run.min_volume_fraction
    options.surface_tolerance, options.surface_tolerance_unit = length(run.surface_tolerance, "surface_tolerance")
    options.max_displacement, options.displacement_unit = length(run.max_displacement, "max_displacement")
    none = np.full(view.dim, np.inf)
    _set_box(options, (-none, none) if run.box is None else view.box(np.asarray(run.box, dtype=float).ravel()))
    options.untangle = bool(run.untangle)
    options.max_sweeps = whole(run.max_sweeps, "max_sweeps")
    options.tolerance = run.tolerance
    options.time_limit = run.time_limit
