"""Plans: one connectivity, smoothed and measured at many positions of its nodes."""

from __future__ import annotations

import contextlib
import os
import threading
from ctypes import byref, c_void_p
from typing import Any, Callable, Iterator, Mapping, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _targets
from ._arrays import Points, address, chosen_nodes, pointer, refuse_masked
from ._choices import (Direction, Fix, Layers, Length, Method, Nodes, Objective, Path, PlanChoices, RunChoices,
                       Slide, WorstMeasure, check_curved, check_method, check_plan, check_run_onto, set_run, size_weight_of)
from ._files import opened
from ._fit import Fit
from ._layers import take_layers
from ._library import call, library, new_options, threads_to_use, whole
from ._regions import BY_RULE
from ._results import FitInfo, Quality, Result, ShapeDistance, SlideInfo
from ._run import Progress, watched
from ._shapes import Shape, shape_for
from ._structures import Options
from ._view import View
from ._views import Holding, Source, view_of

_AT_WORK = ("the plan is at work, in another thread or in the smooth that calls progress: it smooths one mesh at a "
            "time")


# ---- setting up -------------------------------------------------------------------------------------


def _take_targets(view: View, choices: PlanChoices) -> None:
    """Give the view the target shapes or sizes of its elements."""
    if choices.like is not None:
        _targets.take_like(view, opened(choices.like))
    if isinstance(choices.size, str):
        _targets.take_size(view, view.named_size(choices.size))
    elif choices.size is not None:
        _targets.take_size(view, choices.size)
    if choices.size_from is not None:
        _targets.take_size(view, view.sizes_from(choices.size_from))
    if choices.keep_sizes:
        _targets.take_size(view, _targets.sizes_of(view))


def _take_min_volume(view: View, given: Any) -> None:
    """Give the view the minimum volumes of its elements: an array [m], or volumes by groups."""
    if isinstance(given, Mapping):
        given = view.name_min_volumes(given)
    refuse_masked(given, "min_volume")
    volumes = np.require(given, np.float64, ["C", "A"])
    if volumes.shape != (view.elements.n,):
        raise ValueError(f"min_volume must have one value for each of {view.elements.n} elements")
    view.give("min_volume", volumes)


def _view_for(source: Source, choices: PlanChoices) -> View:
    """Return the view of the mesh of a plan, before nodes that slide are found."""
    is_sliding, _, groups = choices.slides()
    holding = Holding(choices.fix, choices.regions, is_sliding or choices.onto is not None, groups)
    view = view_of(source, holding, choices.threads)
    if choices.min_volume is not None:
        _take_min_volume(view, choices.min_volume)
    _take_targets(view, choices)
    take_layers(view, choices.layers)
    return view


def _options_for(view: View, choices: PlanChoices) -> Options:
    """Return the options that a plan is made with."""
    options = new_options()
    options.threads = threads_to_use(choices.threads).value
    options.size_weight = size_weight_of(choices)
    options.only_worse_than = choices.only_worse_than
    options.rings = whole(choices.rings, "rings")
    options.rounding = view.rounding(choices.rounding)
    view.set_storage(options, view.points)
    return options


class Plan:
    """Plan of one connectivity, for many positions of its nodes: neighbourhoods, colours and memory.

    A plan serves one thread at a time. Another thread waits while it measures, and gets RuntimeError while it smooths.
    Close a plan, or use it in a with statement.

    slides is a SlideInfo, shape the Shape that nodes slide on, or None.
    """

    def __init__(
        self,
        points: Any,
        cells: Any = None,
        *,
        fix: Optional[Fix] = None,
        min_volume: Union[ArrayLike, Mapping[str, float], None] = None,
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
    ) -> None:
        """Make a plan for a mesh. Its elements are the m cells of the highest dimension, in the given order.

        Elements are smoothed, except pyramids of second order. All other cells hold their nodes. The mid of an edge
        follows its ends; -1 stands for a missing mid. If some elements are not triangles or tetrahedra, ratios are the
        aspect ratios AR of all elements (docs/elements.md).

        Raise Error, a ValueError, if planish refuses the mesh, ValueError or TypeError for a wrong argument, and
        MemoryError.

        Args:
            points: coordinates, an array [n, 2 or 3] of numpy, or a mesh of planish.read, meshio or PyVista. Flat
                elements lie in a plane of constant x, y or z; smooth and quality take other planes and surfaces, too
            cells: an array [m, 3 or 4] of triangles or tetrahedra; or a dict, or pairs, of types and arrays [m, k]:
                meshio's names ("tetra10") with meshio's order of nodes, or VTK's numbers with VTK's; or a tuple of
                VTK's arrays, (cells, celltypes) as in PyVista, or (nodes, offsets, types); None with a mesh
            fix: nodes that stay besides those of the boundary: numbers, a mask, or names of groups of the mesh
            min_volume: minimum volume of each element, an array [m], 0 for none; with planish.read a dict by groups
            threads: number of threads; 0: as many as the machine has and the mesh is large enough for, but one in a
                child of os.fork (multiprocessing), which has no threads of its parent
            only_worse_than: move only nodes of elements whose ratio is above this
            rings: with only_worse_than or around: also the nodes of so many rings of elements around
            around: move only these nodes (numbers, or a mask [n]) and those of rings; qualities and results are of
                their elements
            regions: hold the nodes between regions (materials): an array [m] of whole numbers, or names of arrays of
                the cell data. Left out: all arrays of the cell data that look like regions, by the program's rule
                (docs/algorithm.md). None: let these nodes move. On a surface in space, which smooth and quality take,
                the nodes slide along the curves between regions
            rounding: distance, in the units of points, of a straight edge's mid from the middle that counts as
                rounding; None: what floats leave
            layers: "hold" the nodes of boundary layers, "ignore" the layers, or "keep" their heights while nodes move
                along them. None: hold those of wedges and hexahedra, and of quadrilaterals beside triangles, but no
                node of an invalid element
            slide: let nodes of the boundary move: "auto" within planes and straight edges, "curved" also on curved
                patches and edges; with planish.read also names of groups, to slide on these alone. Facets and edges
                among the cells are then tags, as for Shape, and hold nothing
            slide_interfaces: with slide="curved": let nodes slide on curved interfaces between regions, too
            slide_tolerance: largest distance from a plane or line, as a fraction of the bounding box's diagonal
            surface_of: original surface for slide="curved", so that repeated runs do not drift: a Shape, or points, a
                mesh or a path with the same elements
            crease_angle: as for Shape
            onto: fit the surface to this Shape, mesh or path (docs/surfaces.md, "Another surface"). The points move
                there, in place, as far as elements stay valid, and then slide along it
            like: points [n, 2 or 3], a mesh or a path with the same nodes. The target of each element is its shape
                there (docs/targets.md), and ratios are aspect ratios against the targets
            size: wanted edge lengths [n] at the points, in relation to one another; or metrics, symmetric matrices
                [n, 2, 2] or [n, 3, 3]; or the name of an array of the mesh
            size_from: a .sol or .solb file of Medit's with these sizes or metrics
            keep_sizes: the elements are to have their present sizes, in relation to one another
            size_weight: weight of sizes, 0 .. 1; shapes have the rest. None: 0.9, with like 0. Above 0 the ratios that
                never get worse count sizes, and shapes alone may get worse
        """
        self._setup(Source(points, cells), PlanChoices(
            fix=fix, min_volume=min_volume, threads=threads, only_worse_than=only_worse_than, rings=rings,
            around=around, regions=regions, rounding=rounding, layers=layers, slide=slide,
            slide_interfaces=slide_interfaces, slide_tolerance=slide_tolerance, surface_of=surface_of,
            crease_angle=crease_angle, onto=onto, like=like, size=size, size_from=size_from, keep_sizes=keep_sizes,
            size_weight=size_weight))

    @classmethod
    def of_choices(cls, source: Source, choices: PlanChoices, run: RunChoices) -> Plan:
        """Return the plan of a mesh with its options, for modules of this package.

        run: options of the run that the plan is for, which are checked before onto moves points.
        """
        made = cls.__new__(cls)
        made._setup(source, choices, run)
        return made

    def _setup(self, source: Source, choices: PlanChoices, run: Optional[RunChoices] = None) -> None:
        """Make the plan."""
        check_plan(choices)
        self._plan = c_void_p()
        self._lock = threading.RLock()
        self._depth = 0  # uses within one another, by the thread that has the lock
        self._smoother = 0  # the thread that smooths
        self._process = os.getpid()
        self._fit: Optional[Fit] = None
        self._choices = choices
        self._start: Optional[NDArray[Any]] = None  # points before onto moved them
        self._is_stopped = False
        self._view = _view_for(source, choices)
        if run is None and self._view.is_for_one_run:
            raise ValueError("the elements lie in a tilted plane, for which there is no Plan: smooth and quality take them")
        self._options = _options_for(self._view, choices)
        self.slides = SlideInfo()
        self.shape: Optional[Shape] = None
        self._find_slides(source, choices)
        self._choose(choices.around)
        if choices.onto is None:
            self._create()
        else:
            self._create_onto(source, choices, run)

    def _create_onto(self, source: Source, choices: PlanChoices, run: Optional[RunChoices]) -> None:
        """Move the points onto the other surface, and make the plan; after an error they are where they were."""
        if run is not None:
            self._set_run(run, Options.from_buffer_copy(self._options))
        self._start = np.array(self._view.given)
        needs_start = self._view.has_targets and not self._view.mesh.reference
        if needs_start:  # sizes and layers are those of the points before they move
            _targets.take_places(self._view, self._view.points.array.copy(), "points")
        try:
            self._move_onto(source, choices)
            self._create()
        except BaseException:
            self.go_back(self._start)
            raise
        if needs_start:
            self._view.give("reference", None)

    def _create(self) -> None:
        """Let the library make the plan."""
        self._view.own_elements()  # the plan reads them as long as it lives
        call(library.planish_plan_create, byref(self._view.mesh), byref(self._options), byref(self._plan))

    def _find_slides(self, source: Source, choices: PlanChoices) -> None:
        """Find the nodes that slide, as the option slide says."""
        is_sliding, is_curved, _ = choices.slides()
        check_curved(self._view.dim, is_curved)
        if is_curved:
            self.shape = shape_for(source, opened(choices.surface_of), choices.regions, choices.crease_angle, choices.threads)
            self._options.shape = self.shape.pointer().value
        if not is_sliding:
            return
        surface = self._view.surface()
        surface.slide_interfaces = bool(choices.slide_interfaces)
        surface.shape = self._options.shape
        if choices.slide_tolerance:
            surface.tolerance = choices.slide_tolerance
        self.slides = self._view.find_slides(surface)
        if self._view.layer_nodes is not None:
            self._view.fix(self._view.layer_nodes)

    def _move_onto(self, source: Source, choices: PlanChoices) -> None:
        """Move the points onto the other surface, and let nodes slide along it."""
        own = shape_for(source, None, choices.regions, choices.crease_angle, choices.threads)
        onto = choices.onto if isinstance(choices.onto, Shape) else Shape(
            opened(choices.onto), crease_angle=choices.crease_angle, threads=choices.threads)
        self._view.hold_for_onto(False)
        self._fit = Fit(self._view, own, onto, self._options)
        if self._fit.is_held() and self._view.has_marks():
            self._view.hold_for_onto(True)
            self._fit = Fit(self._view, own, onto, self._options)
        self._fit.move(self._options)
        self._fit.let_slide(self._options)

    def start(self) -> NDArray[Any]:
        """Return the points where they were given, before onto moved them, for modules of this package."""
        return np.array(self._view.given) if self._start is None else self._start

    def go_back(self, start: NDArray[Any]) -> None:
        """Set the points to start after an error, for modules of this package. What progress raises is none."""
        if not self._is_stopped and self._view.given.flags.writeable:
            self._view.given[...] = start

    def _choose(self, around: Any) -> None:
        """Choose the nodes that move."""
        self._around = None if around is None else chosen_nodes(around, self._view.n, "around")
        if self._around is not None:
            self._options.around = address(self._around) or 1
            self._options.n_around = self._around.size

    # ---- use by threads ---------------------------------------------------------------------------

    @contextlib.contextmanager
    def _use(self, measures: bool = False) -> Iterator[None]:
        """Keep other threads from the plan.

        measures: the work only measures, so that progress may do it, too, and so may handlers of signals.
        """
        if self._smoother not in (0, threading.get_ident()):
            raise RuntimeError(_AT_WORK)
        if not self._lock.acquire(blocking=self._process == os.getpid()):
            raise RuntimeError("the plan was at work when this process was forked; make another one here")
        try:
            if self._depth > 0 and not measures:
                raise RuntimeError(_AT_WORK)
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1
        finally:
            self._lock.release()

    def close(self) -> None:
        """Release the memory of the plan, which cannot be used afterwards."""
        if not self._plan:
            return
        with self._use():
            plan, self._plan = self._plan, c_void_p()
            if plan:
                library.planish_plan_destroy(plan)
            if self._fit is not None:
                self._fit.close()

    def __reduce__(self) -> Any:
        """Raise TypeError: a plan cannot be copied or pickled."""
        raise TypeError("a plan can be neither copied nor pickled; make another one")

    def __enter__(self) -> Plan:
        """Return the plan."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the plan."""
        self.close()

    def __del__(self) -> None:
        """Release the memory of a plan that was not closed."""
        if getattr(self, "_plan", None):
            self.close()

    def _coordinates(self, points: Any, writes: bool = False) -> Points:
        """Return the coordinates of points, a mesh or None (the first points), laid out as the plan's mesh."""
        if not self._plan:
            raise ValueError("the plan is closed")
        if self._process != os.getpid() and self._options.threads != 1:
            raise RuntimeError("the plan was made before this process was forked, and may have threads that "
                               "are not here; make it with threads=1, or another one here")
        points = self._view.given if points is None else getattr(points, "points", points)
        taken = Points(self._view.in_plane(points), self._view.dim, self._view.points.strides, writes)
        taken.show = self._view.shown
        if len(points) != self._view.n:
            raise ValueError(f"points has {len(points)} rows, but the plan is for {self._view.n}")
        return taken

    # ---- what people call ---------------------------------------------------------------------------

    @property
    def region_arrays(self) -> list[str]:
        """Names of the arrays of cell data between whose values nodes are held."""
        return list(self._view.region_arrays)

    @property
    def view(self) -> View:
        """Mesh as the library sees it, for modules of this package."""
        return self._view

    @property
    def fit(self) -> Optional[FitInfo]:
        """Counts of the nodes fitted to the surface of onto; None without onto."""
        return None if self._fit is None else self._fit.info

    def fit_distance(self, points: Any = None) -> ShapeDistance:
        """Return the distance of the surface from that of onto, and back, proved for every point.

        Raise ValueError if the plan was made without onto.

        Args:
            points: coordinates of the nodes, or the mesh; None: those given at first
        """
        with self._use(measures=True):
            taken = self._coordinates(points)
            if self._fit is None:
                raise ValueError("the plan was made without onto")
            return self._fit.distance(taken)

    def free(self) -> NDArray[np.bool_]:
        """Return a mask [n] of the nodes that may move anywhere."""
        mask = np.zeros(self._view.n, dtype=np.uint8)
        with self._use(measures=True):
            if not self._plan:
                raise ValueError("the plan is closed")
            library.planish_plan_get_free(self._plan, address(mask))
        return mask.astype(bool)

    def quality(self, points: Any = None) -> Quality:
        """Return the quality of the mesh. cells and elements are None: planish.quality has them.

        Args:
            points: coordinates [n, 2 or 3], or the mesh; None: those given at first
        """
        found = Quality()
        with self._use(measures=True):
            taken = self._coordinates(points)
            call(library.planish_measure, self._plan, pointer(taken.array), byref(found))
        return found

    def radius_ratios(self, points: Any = None) -> NDArray[np.float64]:
        """Return the radius ratio of each element [m]: 1 is best, 0 means inverted or flat.

        If some elements are not triangles or tetrahedra, return the aspect ratio AR of each. The value is nan for
        elements outside a plan with around.

        Args:
            points: coordinates [n, 2 or 3], or the mesh; None: those given at first
        """
        ratios = np.zeros(self._view.mesh.n_elements)
        with self._use(measures=True):
            taken = self._coordinates(points)
            call(library.planish_measure_elements, self._plan, pointer(taken.array), pointer(ratios))
        return ratios

    def smooth(
        self,
        points: Any = None,
        *,
        objective: Optional[Objective] = None,
        worst_measure: Optional[WorstMeasure] = None,
        worst_rise: float = 0.01,
        min_volume: float = 0,
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
        """Smooth the mesh in place, after untangling it.

        Args:
            points: coordinates [n, 2 or 3], or the mesh; None: those given at first
            objective: "radius-ratio" (default of triangles and tetrahedra alone), "mean-ratio" (default of other
                meshes), "edge-ratio", or "worst": the default, and then the worst elements
            worst_measure: measure of the worst elements: "dihedral" (default) or "radius-ratio" for triangles and
                tetrahedra alone, "scaled-jacobian" (default) or "aspect-ratio" for other meshes
            worst_rise: largest relative rise of the objective allowed for the worst elements
            min_volume: minimum volume (area in two dimensions) of every element; 0: any positive volume
            min_volume_fraction: minimum volume as a fraction of the sum of all volumes
            area_weight: weight of volumes above the minimum, 0 .. 1
            curve_quality: mids of a curved element move by themselves if its least Jacobian is below this fraction of
                the mean one; 0: none do
            surface_tolerance: with slide="curved": largest distance of the surface from the original one, a number in
                the units of points, or a text in mean edges, such as "0.02h"; 0: "0.05h"
            max_displacement: largest distance that a node moves, given in the same two ways; 0: any distance
            box: lower and upper corner of a box that movable nodes stay in, 4 or 6 numbers
            method: "planish", or for comparison "laplacian", "area-laplacian" or "length-laplacian", which may invert
                elements
            direction: search direction of a node's local problem, "newton" or "fletcher-reeves"
            untangle: repair inverted elements first
            max_sweeps: largest number of sweeps
            tolerance: smoothing has converged if a sweep lowers the RMS by less than this fraction
            time_limit: time in seconds after which smoothing ends; 0: none
            progress: called with a Progress after every colour of nodes. Smoothing ends if it returns a true value. If
                progress, or a handler of a signal meanwhile, raises an exception, smoothing ends, and smooth raises
                it; points keep the improvement so far. Without progress signals wait for the end
        """
        return self.run(points, RunChoices(
            objective=objective, worst_measure=worst_measure, worst_rise=worst_rise, min_volume=min_volume,
            min_volume_fraction=min_volume_fraction, area_weight=area_weight, curve_quality=curve_quality,
            surface_tolerance=surface_tolerance, max_displacement=max_displacement, box=box, method=method,
            direction=direction, untangle=untangle, max_sweeps=max_sweeps, tolerance=tolerance, time_limit=time_limit,
            progress=progress))

    def renew(self) -> None:
        """Make the plan anew, as its view is now, for modules of this package."""
        with self._use():
            library.planish_plan_destroy(self._plan)
            self._plan = c_void_p()
            call(library.planish_plan_create, byref(self._view.mesh), byref(self._options), byref(self._plan))

    def _set_run(self, choices: RunChoices, options: Options) -> None:
        """Check the options of a run, and set them in options."""
        check_method(self._choices, choices)
        if self._choices.onto is not None:
            check_run_onto(choices)
        if choices.surface_tolerance != 0 and self.shape is None:
            raise ValueError("surface_tolerance has no effect without slide='curved'")
        set_run(choices, options, self._view, self._view.has_types())

    def run(self, points: Any, choices: RunChoices) -> Result:
        """Smooth the mesh in place, with options of one run, for modules of this package."""
        options, result = self._options, Result()
        with self._use():  # the options, too, are those of who smooths
            self._is_stopped = False
            self._set_run(choices, options)
            taken = self._coordinates(points, writes=True)
            self._view.set_storage(options, taken)
            shape = None if self.shape is None else self.shape.handle()  # progress may close it
            options.shape = None if shape is None else shape.pointer.value

            def work() -> None:
                call(library.planish_smooth, self._plan, pointer(taken.array), byref(options), byref(result))
                taken.write_back()
                self._is_stopped = True  # if now anything is raised, progress did it

            self._smoother = threading.get_ident()
            try:
                watched(options, choices.progress, taken, work)
                self._is_stopped = False
            finally:
                self._smoother = 0
        return result
