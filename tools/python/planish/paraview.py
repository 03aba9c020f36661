"""A filter for VTK and ParaView that smooths vtkUnstructuredGrid and vtkPolyData.

    from planish.paraview import Smooth      # with VTK alone
    smooth = Smooth()
    smooth.SetInputConnection(reader.GetOutputPort())
    smooth.SetSlide(Smooth.CURVED)
    smooth.Update()

In ParaView load the file paraview_plugin.py beside this one by Tools > Manage Plugins; the filter is Filters >
Alphabetical > Planish Smooth. The output has moved points and these arrays: displacement and fixed of points;
aspect_ratio, scaled_jacobian and cell_state (1: valid, 2: inverted, 3: uncertified) of cells. The input stays as it
is.
"""

# VTK has no types for its Python modules.
# mypy: no-warn-unused-ignores, allow-subclassing-any, allow-untyped-decorators, no-warn-return-any

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

try:
    from vtkmodules.numpy_interface.dataset_adapter import numpyTovtkDataArray  # type: ignore[import]
    from vtkmodules.util.numpy_support import vtk_to_numpy  # type: ignore[import]
    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase  # type: ignore[import]
    from vtkmodules.vtkCommonCore import (VTK_DOUBLE, VTK_FLOAT, vtkDataArray,  # type: ignore[import]
                                          vtkIdTypeArray, vtkOutputWindow, vtkPoints)
    from vtkmodules.vtkCommonDataModel import (vtkDataObject, vtkPointSet, vtkPolyData,  # type: ignore[import]
                                               vtkUnstructuredGrid)
except ImportError as _failure:
    raise ImportError("planish.paraview needs VTK's Python modules: install python3-vtk9 (Debian), or vtk by pip, or "
                      "use ParaView's pvpython") from _failure

import planish
from planish._choices import PlanChoices, RunChoices
from planish._views import Source

try:
    from paraview.util.vtkAlgorithm import smdomain, smproperty, smproxy  # type: ignore[import]
except ImportError:  # VTK alone: the decorators do nothing

    class _Decorators:
        """Decorators of ParaView's that return what they are given."""

        def __getattr__(self, _name: str) -> Any:
            return lambda *_arguments, **_options: lambda decorated: decorated

    smdomain = smproperty = smproxy = _Decorators()

__all__ = ["Smooth"]

Array = NDArray[Any]


# ---- meshes -----------------------------------------------------------------------------------------

_VERTEX, _POLYVERTEX, _LINE, _POLYLINE, _TRIANGLE, _STRIP, _POLYGON, _QUAD = 1, 2, 3, 4, 5, 6, 7, 9


class _Mesh(NamedTuple):
    """A mesh with the attributes of a mesh of PyVista's."""

    points: Array  # [n, 3]
    cells: Array  # of each cell the number of its points, and these
    celltypes: Array  # [m] VTK's numbers
    cell_data: dict[str, Array]


def _values(array: vtkDataArray) -> Array:
    """Return the values of an array, also of one that VTK computes on demand."""
    try:
        return vtk_to_numpy(array)
    except (AttributeError, TypeError, ValueError):
        copy = vtkIdTypeArray()
        copy.DeepCopy(array)
        return vtk_to_numpy(copy)


def _lists(cells: Any) -> tuple[Array, Array]:
    """Return the lists of a vtkCellArray in the order of _Mesh.cells, and the number of points of each cell."""
    nodes, offsets = _values(cells.GetConnectivityArray()), _values(cells.GetOffsetsArray())
    counts = np.diff(offsets)
    return np.insert(nodes, offsets[:-1], counts).astype(np.int64), counts


def _cells_of_grid(grid: vtkUnstructuredGrid) -> tuple[Array, Array]:
    """Return cells and types. A polygon of three points becomes a triangle, and so on for other general types."""
    lists, counts = _lists(grid.GetCells())
    types = _values(grid.GetCellTypesArray()).copy()
    for general, count, kind in ((_POLYGON, 3, _TRIANGLE), (_POLYGON, 4, _QUAD), (_POLYLINE, 2, _LINE),
                                 (_STRIP, 3, _TRIANGLE)):
        types[(types == general) & (counts == count)] = kind
    return lists, types


def _cells_of_surface(surface: vtkPolyData) -> tuple[Array, Array]:
    """Return cells and types. Cell data have points first, then lines, polygons and strips."""
    parts = []
    for cells, usual, other in ((surface.GetVerts(), {1: _VERTEX}, _POLYVERTEX),
                                (surface.GetLines(), {2: _LINE}, _POLYLINE),
                                (surface.GetPolys(), {3: _TRIANGLE, 4: _QUAD}, _POLYGON),
                                (surface.GetStrips(), {3: _TRIANGLE}, _STRIP)):
        lists, counts = _lists(cells)
        types = np.full(len(counts), other, dtype=np.uint8)
        for count, kind in usual.items():
            types[counts == count] = kind
        parts.append((lists, types))
    return np.concatenate([lists for lists, _ in parts]), np.concatenate([types for _, types in parts])


def _cell_data(data_set: vtkPointSet) -> dict[str, Array]:
    """Return the arrays of numbers of the cells, by name."""
    data = data_set.GetCellData()
    arrays = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    return {array.GetName(): _values(array) for array in arrays if array is not None and array.GetName()}


def _copy_points(points: vtkPoints) -> vtkPoints:
    """Return a copy in float or double, which planish may change."""
    copy = vtkPoints()
    copy.SetDataType(VTK_FLOAT if points.GetDataType() == VTK_FLOAT else VTK_DOUBLE)
    copy.DeepCopy(points)
    return copy


def _add(data: Any, name: str, values: Array) -> None:
    data.AddArray(numpyTovtkDataArray(np.ascontiguousarray(values), name))


# ---- the filter --------------------------------------------------------------------------------------


_DEFAULTS = {"max_sweeps": 200, "time_limit": 0, "untangle": True, "surface_tolerance": "0.05h", "crease_angle": 0}


def _enumeration(**numbers: int) -> str:
    entries = "".join(f'<Entry text="{text.replace("_", "-")}" value="{value}"/>' for text, value in numbers.items())
    return f'<EnumerationDomain name="enum">{entries}</EnumerationDomain>'


def _choice_of_arrays(of: str) -> str:
    return (f'<ArrayListDomain name="array_list" input_domain_name="{of}_array" none_string="(none)">'
            '<RequiredProperties><Property name="Input" function="Input"/></RequiredProperties></ArrayListDomain>')


def _array_domain(of: str) -> str:
    return f'<InputArrayDomain name="{of}_array" attribute_type="{of}" number_of_components="1" optional="1"/>'


@smproxy.filter(name="PlanishSmooth", label="Planish Smooth")
@smproperty.input(name="Input", port_index=0)
@smdomain.xml(_array_domain("point"))
@smdomain.xml(_array_domain("cell"))
@smdomain.datatype(dataTypes=["vtkUnstructuredGrid", "vtkPolyData"], composite_data_supported=True)
class Smooth(VTKPythonAlgorithmBase):
    """Smooth and untangle a mesh. Options have the program's meanings (docs/program.md)."""

    SLIDES = (None, "auto", "curved")
    NO_SLIDE, AUTO, CURVED = range(3)
    OBJECTIVES = (None, "radius-ratio", "mean-ratio", "edge-ratio", "worst")
    LAYERS = (None, "hold", "keep", "ignore")

    def __init__(self) -> None:
        """Make a filter with the program's defaults."""
        super().__init__(nInputPorts=1, nOutputPorts=1, inputType="vtkPointSet", outputType="vtkPointSet")
        self._options: dict[str, Any] = {}
        self._region_array: Optional[str] = None
        self._fixed_array: Optional[str] = None
        self._holds_regions = True
        self.result: Optional[planish.Result] = None  # of the last update

    def _choose(self, name: str, value: Any) -> None:
        """Set an option of planish.smooth; None: its default."""
        if self._options.get(name) != value:
            self._options[name] = value
            self.Modified()

    @smproperty.intvector(name="Slide", default_values=0)
    @smdomain.xml(_enumeration(none=0, auto=1, curved=2))
    def SetSlide(self, value: int) -> None:
        """Set which boundary points move: NO_SLIDE, AUTO (in planes and on straight edges), CURVED."""
        self._choose("slide", self.SLIDES[value])

    @smproperty.intvector(name="Objective", default_values=0)
    @smdomain.xml(_enumeration(default=0, radius_ratio=1, mean_ratio=2, edge_ratio=3, worst=4))
    def SetObjective(self, value: int) -> None:
        """Set the objective by its place in OBJECTIVES."""
        self._choose("objective", self.OBJECTIVES[value])

    @smproperty.intvector(name="Layers", default_values=0, panel_visibility="advanced")
    @smdomain.xml(_enumeration(default=0, hold=1, keep=2, ignore=3))
    def SetLayers(self, value: int) -> None:
        """Set the treatment of boundary layers by its place in LAYERS."""
        self._choose("layers", self.LAYERS[value])

    @smproperty.intvector(name="MaxSweeps", default_values=200, panel_visibility="advanced")
    @smdomain.intrange(min=0, max=1000)
    def SetMaxSweeps(self, value: int) -> None:
        """Set the largest number of sweeps."""
        self._choose("max_sweeps", value)

    @smproperty.doublevector(name="TimeLimit", default_values=0.0, panel_visibility="advanced")
    def SetTimeLimit(self, seconds: float) -> None:
        """Set the time in seconds after which smoothing ends; 0: none."""
        self._choose("time_limit", seconds)

    @smproperty.intvector(name="Untangle", default_values=1, panel_visibility="advanced")
    @smdomain.xml('<BooleanDomain name="bool"/>')
    def SetUntangle(self, value: int) -> None:
        """Set whether inverted cells are repaired."""
        self._choose("untangle", bool(value))

    @smproperty.doublevector(name="SurfaceTolerance", default_values=0.05, panel_visibility="advanced")
    def SetSurfaceTolerance(self, edges: float) -> None:
        """Set the largest distance of a curved surface from its original shape, in mean edges."""
        self._choose("surface_tolerance", f"{edges}h")

    @smproperty.doublevector(name="CreaseAngle", default_values=0.0, panel_visibility="advanced")
    def SetCreaseAngle(self, degrees: float) -> None:
        """Set the angle in degrees by which facets turn at an edge of the surface; 0: planish finds the edges."""
        self._choose("crease_angle", degrees)

    @smproperty.intvector(name="HoldRegions", default_values=1)
    @smdomain.xml('<BooleanDomain name="bool"/>')
    def SetHoldRegions(self, value: int) -> None:
        """Set whether points between regions stay."""
        self._holds_regions = bool(value)
        self.Modified()

    @smproperty.stringvector(name="RegionArray", number_of_elements=1, default_values="(none)")
    @smdomain.xml(_choice_of_arrays("cell"))
    def SetRegionArray(self, name: Optional[str]) -> None:
        """Set the array of cells whose values are regions; None: arrays that look like regions."""
        self._region_array = None if name in (None, "", "(none)", "None") else name
        self.Modified()

    @smproperty.stringvector(name="FixedArray", number_of_elements=1, default_values="(none)")
    @smdomain.xml(_choice_of_arrays("point"))
    def SetFixedArray(self, name: Optional[str]) -> None:
        """Set the array of points whose value is not 0 for points that stay."""
        self._fixed_array = None if name in (None, "", "(none)", "None") else name
        self.Modified()

    # ---- VTK's pipeline

    def FillInputPortInformation(self, _port: int, info: Any) -> int:
        """Tell VTK the types of data sets."""
        info.Set(self.INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid")
        info.Append(self.INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData")
        return 1

    def RequestDataObject(self, _request: Any, inputs: Any, outputs: Any) -> int:
        """Make an output of the input's type."""
        given, made = vtkDataObject.GetData(inputs[0], 0), vtkDataObject.GetData(outputs, 0)
        if given is not None and (made is None or made.GetClassName() != given.GetClassName()):
            outputs.GetInformationObject(0).Set(vtkDataObject.DATA_OBJECT(), given.NewInstance())
        return 1

    def RequestData(self, _request: Any, inputs: Any, outputs: Any) -> int:
        """Smooth the input. Report an error of planish as one of VTK."""
        given, made = vtkPointSet.GetData(inputs[0], 0), vtkPointSet.GetData(outputs, 0)
        made.ShallowCopy(given)
        if given.GetNumberOfCells() == 0:
            return 1
        try:
            self._smooth(given, made)
        except (ValueError, TypeError, MemoryError) as failure:
            made.Initialize()
            vtkOutputWindow.GetInstance().DisplayErrorText(f"planish: {failure}\n")
            return 0
        return 1

    def _smooth(self, given: vtkPointSet, made: vtkPointSet) -> None:
        """Give the output the moved points, and arrays of displacement, fixed points and quality."""
        points = _copy_points(given.GetPoints())
        lists, types = _cells_of_surface(given) if given.IsA("vtkPolyData") else _cells_of_grid(given)
        mesh = _Mesh(vtk_to_numpy(points.GetData()), lists, types, _cell_data(given))
        before = mesh.points.copy()
        held: dict[str, Any] = {"fix": self._fix(given), **self._regions()}
        options = {name: value for name, value in self._options.items() if self._is_meant(name)}
        fixed = _fixed_points(mesh, held, options)
        self.result = planish.smooth(mesh, **held, **options, progress=self._report)
        made.SetPoints(points)
        _add(made.GetPointData(), "displacement", mesh.points - before)
        _add(made.GetPointData(), "fixed", fixed.astype(np.uint8))
        measured = planish.quality(mesh, **held, per_element=True).elements
        assert measured is not None  # with per_element
        _add_quality(made.GetCellData(), measured, len(types))

    def _is_meant(self, name: str) -> bool:
        """Whether an option differs from its default. ParaView sets all options, also useless ones."""
        return self._options[name] != _DEFAULTS.get(name)

    def _regions(self) -> dict[str, Any]:
        if not self._holds_regions:
            return {"regions": None}
        return {"regions": self._region_array} if self._region_array else {}

    def _fix(self, given: vtkPointSet) -> Optional[Array]:
        """Return a mask [n] of the points that the chosen array holds; None: no array is chosen."""
        if self._fixed_array is None:
            return None
        array = given.GetPointData().GetArray(self._fixed_array)
        if array is None:
            raise ValueError(f"the mesh has no array of points {self._fixed_array!r}")
        return _values(array) != 0

    def _report(self, progress: planish.Progress) -> bool:
        """Tell VTK the progress, as if ten sweeps were usual. Return whether VTK asks smoothing to end."""
        done = progress.sweep + progress.colour / max(progress.n_colours, 1)
        self.UpdateProgress(1 - 0.85**done)
        return bool(self.GetAbortExecute())


_CORNER, _FIXED = 3, 1  # of planish.Shape.classes and planish.Slides.constraint


def _fixed_points(mesh: _Mesh, held: dict[str, Any], options: dict[str, Any]) -> Array:
    """Return a mask [n] of the points that cannot move."""
    crease_angle = {"crease_angle": options.get("crease_angle", 0)}
    source = Source(mesh, None)
    if source.has_flat_elements_in_space and source.plane is None:
        with planish.Shape(mesh, **crease_angle) as shape:
            is_fixed = shape.classes() == _CORNER
        return is_fixed if held["fix"] is None else is_fixed | held["fix"]
    if "slide" not in options:
        with planish.Plan.of_choices(source, PlanChoices(**held), RunChoices()) as plan:
            return ~plan.free()
    if options["slide"] == "auto":
        return planish.find_slides(mesh, **held).constraint == _FIXED
    with planish.Shape(mesh, **{name: held[name] for name in held if name != "fix"}, **crease_angle) as shape:
        return planish.find_slides(mesh, **held, surface_of=shape).constraint == _FIXED


def _add_quality(data: Any, elements: planish.CellValues, n: int) -> None:
    """Add arrays of measures. Cells without measures get NaN, and the state 0."""
    for name, values in (("aspect_ratio", elements.aspect_ratio), ("scaled_jacobian", elements.scaled_jacobian)):
        measured = np.full(n, np.nan)
        measured[elements.number] = np.where(values == 0, np.nan, values) if name == "aspect_ratio" else values
        _add(data, name, measured)
    state = np.zeros(n, dtype=np.uint8)
    state[elements.number] = elements.state
    _add(data, "cell_state", state)
