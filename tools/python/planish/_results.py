"""Results: structures of planish.h for callers, field by field."""

from __future__ import annotations

import ctypes
from ctypes import Structure, c_double, c_int, c_int64
from typing import Annotated, Any, NamedTuple, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from ._cell_types import KNOWN
from ._fields import Double, Int, Int64, fields
from ._tables import Rows, html_table, text_table


class Printed(Structure):
    """A structure that shows its values."""

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name; arrays as lists."""
        values = {}
        for name, *_ in self._fields_:
            value = getattr(self, name)
            if isinstance(value, Printed):
                value = value.as_dict()
            values[name.lstrip("_")] = list(value) if isinstance(value, ctypes.Array) else value
        values.pop("reserved", None)
        return values

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        return [(name, value) for name, value in self.as_dict().items() if isinstance(value, (int, float, str))]

    def __repr__(self) -> str:
        """Return all values."""
        values = ", ".join(f"{name}={value!r}" for name, value in self.as_dict().items())
        return f"{type(self).__name__}({values})"

    def __str__(self) -> str:
        """Return a short table."""
        return text_table(self.rows())

    def _repr_html_(self) -> str:
        """Return the table for notebooks."""
        return html_table(self.rows())


@fields
class Spread(Printed):
    """Smallest, mean and largest value of a measure over the valid elements; 0 if they do not have this measure."""

    min: Double
    mean: Double
    max: Double


@fields
class CellMeasures(Printed):
    """Measures of elements of one type or of all: planish_cell_measures of planish.h, field by field."""

    n_elements: Int64
    n_inverted: Int64
    n_uncertified: Int64
    n_inverted_corners: Int64
    n_curved: Int64
    rms_aspect_ratio: Double
    mean_aspect_ratio: Double
    max_aspect_ratio: Double
    worst_element: Int64
    min_scaled_jacobian: Double
    min_jacobian_ratio: Double
    max_edge_ratio: Double
    reserved: Annotated[Any, c_double * 4]


@fields
class CellQuality(Printed):
    """Quality of elements of any types: planish_cell_quality of planish.h.

    all has the measures of all elements, by_type those of each type by meshio's name of the type.
    """

    all: CellMeasures
    _n_types: Int
    _type: Annotated[Sequence[int], c_int * 16]
    _by_type: Annotated[Sequence[CellMeasures], CellMeasures * 16]
    reserved: Annotated[Any, c_int64 * 8]

    @property
    def by_type(self) -> dict[str, CellMeasures]:
        """Measures of the elements of each type."""
        return {KNOWN[self._type[i]].name: self._by_type[i] for i in range(self._n_types)}

    @property
    def counts(self) -> dict[str, int]:
        """Number of elements of each type."""
        return {name: measures.n_elements for name, measures in self.by_type.items()}

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name."""
        return {"all": self.all.as_dict(), "by_type": {name: of.as_dict() for name, of in self.by_type.items()}}

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        return [*self.counts.items(), *self.all.rows()]


class CellValues(NamedTuple):
    """Measures of single elements, arrays [m]: planish_cell_values of planish.h.

    The value is 0 for a measure that an element does not have.
    """

    number: NDArray[np.int64]  # place of the element among all cells given, those of lower dimension included
    state: NDArray[np.uint8]  # 1 valid, 2 inverted, 3 uncertified
    is_curved: NDArray[Any]
    aspect_ratio: NDArray[np.float64]
    scaled_jacobian: NDArray[np.float64]
    jacobian_ratio: NDArray[np.float64]
    edge_ratio: NDArray[np.float64]


@fields
class Quality(Printed):
    """Quality of a mesh: planish_quality of planish.h, field by field.

    If some elements are not triangles or tetrahedra, or if they have targets, fields of radius ratios have the aspect
    ratio AR, and angles are 0. cells is the CellQuality of all elements, if some are not straight triangles or
    tetrahedra, or with per_element, like or size; else None. elements is the CellValues with per_element, else None.
    """

    cells: Optional[CellQuality] = None
    elements: Optional[CellValues] = None

    n_elements: Int64
    n_inverted: Int64
    min_volume: Double
    max_volume: Double
    total_volume: Double
    rms_radius_ratio: Double
    rms_radius_ratio_movable: Double
    mean_radius_ratio: Double
    max_radius_ratio: Double
    worst_element: Int64
    min_angle_deg: Double
    max_angle_deg: Double
    max_radius_ratio_movable: Double
    min_angle_deg_movable: Double
    n_fixed_elements: Int64
    fixed_rms_radius_ratio: Double
    fixed_max_radius_ratio: Double
    radius_ratio: Spread
    circumradius_to_edge: Spread
    edge_to_inradius: Spread
    edge_ratio: Spread
    mean_ratio: Spread
    scaled_jacobian: Spread
    smallest_angle_deg: Spread
    largest_angle_deg: Spread
    histogram_edges: Annotated[Sequence[float], c_double * 13]
    histogram_counts: Annotated[Sequence[int], c_int64 * 12]
    angle_edges_deg: Annotated[Sequence[float], c_double * 16]
    angle_counts: Annotated[Sequence[int], c_int64 * 15]
    n_reversed: Int64
    reserved: Annotated[Any, c_int64 * 7]

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name; arrays as lists."""
        return {**super().as_dict(), **({"cells": self.cells.as_dict()} if self.cells else {})}

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        ratio = "radius ratio" if self.max_angle_deg > 0 else "aspect ratio"
        counts = self.cells.counts.items() if self.cells else [("elements", self.n_elements)]
        n_inverted = self.cells.all.n_inverted + self.cells.all.n_uncertified if self.cells else self.n_inverted
        found = [*counts, ("inverted", n_inverted), (f"{ratio}, RMS", self.rms_radius_ratio),
                 (f"{ratio}, worst", self.max_radius_ratio)]
        if self.max_angle_deg > 0:
            return [*found, ("angle, smallest", self.min_angle_deg), ("angle, largest", self.max_angle_deg)]
        return [*found, ("scaled Jacobian, least", self.scaled_jacobian.min)]


@fields
class ShapeInfo(Printed):
    """Contents of a shape: planish_shape_info of planish.h, field by field."""

    n_nodes: Int64
    n_facets: Int64
    n_patches: Int64
    n_edges: Int64
    n_creases: Int64
    n_on_patch: Int64
    n_on_curve: Int64
    n_corners: Int64
    edge_length: Double
    n_mids: Int64
    n_open_edges: Int64
    n_nonmanifold_edges: Int64
    n_conflict_edges: Int64
    n_turned: Int64
    n_flat: Int64
    reserved: Annotated[Any, c_int64 * 8]


@fields
class ShapeDistance(Printed):
    """Distance of a surface from its shape: planish_shape_distance of planish.h, field by field."""

    distance: Double
    distance_back: Double
    in_edges: Double
    back_in_edges: Double
    n_unproved: Int64
    max_bend: Double
    max_bend_before: Double
    reserved: Annotated[Any, c_int64 * 8]


@fields
class FitInfo(Printed):
    """Counts of the nodes fitted to another surface: planish_fit_info of planish.h, field by field."""

    n_nodes: Int64
    n_on_patch: Int64
    n_on_curve: Int64
    n_on_corner: Int64
    n_out_of_reach: Int64
    n_held: Int64
    n_off: Int64
    farthest: Double
    n_cut: Int64
    n_unclear: Int64
    n_unused: Int64
    reserved: Annotated[Any, c_int64 * 5]


@fields
class SlideInfo(Printed):
    """Counts of the nodes that slide: planish_slide_info of planish.h, field by field."""

    n_surface: Int64
    n_on_plane: Int64
    n_on_line: Int64
    n_on_patch: Int64
    n_on_curve: Int64
    reserved: Annotated[Any, c_int64 * 2]


class Slides(NamedTuple):
    """Constraint of each node: 0 free, 1 fixed, 2 on a plane, 3 on a line, 5 on a patch, 6 on a curve."""

    constraint: NDArray[np.uint8]  # [n]
    direction: NDArray[np.float64]  # [n, dim] normals of planes, and directions of lines
    info: SlideInfo


@fields
class SizeQuality(Printed):
    """Sizes of elements against the wanted sizes: planish_size_quality of planish.h, field by field.

    With per_element ratio [m] is size / (factor * wanted) of each element, else None.
    """

    ratio: Optional[NDArray[np.float64]] = None

    n_elements: Int64
    factor: Double
    rms_log: Double
    min: Double
    max: Double
    smallest: Int64
    largest: Int64
    reserved: Annotated[Any, c_double * 2]


@fields
class LayerRow(Printed):
    """Heights of edges across layers, in parts of the wanted ones: planish_layer_row of planish.h, field by field."""

    n: Int64
    min: Double
    median: Double
    max: Double


@fields
class LayerHeights(Printed):
    """Heights of layers against the wanted heights: planish_layer_heights of planish.h.

    all has those of all edges across layers, by_row those of each row from the thin end on. With per_node off [n] is
    by how much of what is wanted the height of an edge at the node is off at most, else None.
    """

    off: Optional[NDArray[np.float64]] = None

    all: LayerRow
    reference: LayerRow
    n_told: Int64
    _n_rows: Int
    _row: Annotated[Sequence[LayerRow], LayerRow * 32]
    n_at_moved_walls: Int64
    reserved: Annotated[Any, c_double * 1]

    @property
    def by_row(self) -> list[LayerRow]:
        """Heights of each row; the last one has all beyond it."""
        return list(self._row[:self._n_rows])

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name."""
        return {"all": self.all.as_dict(), "reference": self.reference.as_dict(), "n_told": self.n_told,
                "n_at_moved_walls": self.n_at_moved_walls, "by_row": [row.as_dict() for row in self.by_row]}

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        return [("edges", self.all.n), ("height, least", self.all.min), ("height, median", self.all.median),
                ("height, largest", self.all.max)]


@fields
class Result(Printed):
    """Result of smoothing: planish_result of planish.h, field by field.

    With onto, fit has the counts of nodes, and fit_distance the distance from that surface. Else both are None.
    """

    fit: Optional[FitInfo] = None
    fit_distance: Optional[ShapeDistance] = None

    _stop: Int
    sweeps: Int
    untangling_sweeps: Int
    worst_sweeps: Int
    visits: Int64
    n_moved_nodes: Int64
    max_displacement: Double
    n_put_back: Int64
    n_inverted: Int64
    rms: Double
    rms_movable: Double
    min_volume: Double
    n_below_min_volume: Int64
    n_held_outside: Int64
    objective_before: Double
    objective: Double
    objective_of_worst: Double
    worst_before: Double
    worst_after: Double
    evaluations: Int64
    kkt_residual: Double
    kkt_rms: Double
    max_multiplier: Double
    n_active: Int64
    seconds: Double
    n_not_enclosed: Int64
    n_curved: Int64
    n_inverted_inside: Int64
    n_refused: Int64
    n_released_mids: Int64
    n_infeasible_curved: Int64
    n_off_shape: Int64
    reserved: Annotated[Any, c_int64 * 8]

    @property
    def stop(self) -> str:
        """Reason why smoothing ended: converged, max-sweeps, time-limit, interrupted or infeasible."""
        return ("converged", "max-sweeps", "time-limit", "interrupted", "infeasible")[self._stop]

    def end_as(self, other: Result) -> None:
        """Take the reason of another result why smoothing ended."""
        self._stop = other._stop

    def end_by_time(self) -> None:
        """Let the time limit be the reason why smoothing ended."""
        self._stop = 2

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name."""
        return {**super().as_dict(), "stop": self.stop}

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        return [("ended", self.stop), ("sweeps", self.sweeps), ("nodes moved", self.n_moved_nodes),
                ("inverted", self.n_inverted), ("objective, before", self.objective_before),
                ("objective, after", self.objective), ("seconds", self.seconds)]
