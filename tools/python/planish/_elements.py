"""Elements: the cells of a mesh's dimension, laid out as the library takes them."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from . import _holders
from ._arrays import Array, address, joined, narrow, simplices
from ._blocks import Block, blocks_by_type, blocks_of_mesh, is_by_type
from ._cell_types import CORNERS, HELD, SIMPLICES, TRIANGLE, TYPES, WIDTHS
from ._structures import Cells


class Tagged(NamedTuple):
    """Facets or edges with tags."""

    nodes: NDArray[np.int32]  # corners of all
    offsets: NDArray[np.int64]  # [n + 1] where those of each begin
    tags: NDArray[np.int32]  # [n]


class Layout(NamedTuple):
    """Arrays of planish_cells."""

    types: NDArray[np.uint8]  # [m]
    offsets: NDArray[np.int64]  # [m + 1]
    nodes: NDArray[np.int32]

    def structure(self) -> Cells:
        """Return the planish_cells that points to the arrays. The caller keeps the arrays alive."""
        return Cells(n=len(self.types), type=address(self.types), offset=address(self.offsets),
                     node=address(self.nodes))


class Elements:
    """Elements in the given order, and the other cells.

    Straight simplices of one type are simple [m, dim + 1]; else layout has the elements. corners [.., dim + 1]
    are those of simplices, straight or not. at [m] are the places of elements among all cells, data arrays [m] by
    their names.
    """

    def __init__(self, dim: int, simple: Optional[Array], layout: Optional[Layout], corners: Array, at: Array,
                 data: dict[str, Any], others: list[Block]) -> None:
        """Take the parts."""
        self.dim = dim
        self.simple = simple
        self.layout = layout
        self.corners = corners
        self.at = at
        self.data = data
        self.others = others

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.at)

    def held(self, n_points: int, without_tags: bool) -> Optional[NDArray[np.uint8]]:
        """Return a mask [n_points] of the nodes that other cells hold; None: there are no other cells.

        without_tags: facets and edges hold none.
        """
        if not self.others:
            return None
        return _holders.held_nodes([block for block in self.others if not without_tags
                                    or _holders.tag_kind(block, self.dim) is None], n_points)

    def tagged(self, kind: str) -> Optional[Tagged]:
        """Return the facets or edges whose tags mark features of the surface; None: there are none."""
        blocks = [block for block in self.others if _holders.tag_kind(block, self.dim) == kind and len(block.nodes)]
        if not blocks:
            return None
        corners = [block.nodes[:, :block.kind.n_corners] for block in blocks if block.kind]
        names = set.intersection(*(set(block.data) for block in blocks))
        counts = np.concatenate([np.full(len(part), part.shape[1]) for part in corners])
        tags = _holders.tags({name: joined([block.data[name] for block in blocks]) for name in sorted(names)},
                             len(counts))
        return Tagged(np.concatenate([narrow(part).ravel() for part in corners]), np.append(0, np.cumsum(counts)),
                      tags.astype(np.int32))

    def has_types(self) -> bool:
        """Whether some smoothed elements are not simplices. Aspect ratios then replace radius ratios."""
        return self.layout is not None and not np.isin(self.layout.types, SIMPLICES[self.dim] + HELD).all()

    def is_smoothed(self) -> bool:
        """Whether any element is of a type that is smoothed."""
        return self.layout is None or not np.isin(self.layout.types, HELD).all()

    def has_only(self, number: int) -> bool:
        """Whether all elements are of one type, by its number."""
        if self.layout is None:
            return number == SIMPLICES[self.dim][0]
        return bool(np.all(self.layout.types == number))

    def nodes_of(self, chosen: Array) -> Array:
        """Return the nodes of the elements that a mask [m] chooses, once for each element that has them."""
        if self.layout is None:
            assert self.simple is not None
            return self.simple[chosen].ravel()
        nodes: Array = self.layout.nodes[np.repeat(chosen, np.diff(self.layout.offsets))]
        return nodes[nodes >= 0]

    def corners_of_all(self) -> tuple[Array, Array]:
        """Return the corners of all elements, and the element that each of these is one of."""
        layout = self.as_layout()
        owner = np.repeat(np.arange(self.n), np.diff(layout.offsets))
        is_corner = np.arange(len(owner)) - layout.offsets[owner] < CORNERS[layout.types][owner]
        return layout.nodes[is_corner], owner[is_corner]

    def as_layout(self) -> Layout:
        """Return the elements as planish_cells has them."""
        if self.layout is not None:
            return self.layout
        assert self.simple is not None
        nodes = np.require(narrow(self.simple), np.int32, "C")
        n, width = nodes.shape
        types = np.full(n, SIMPLICES[self.dim][0], dtype=np.uint8)
        return Layout(types, np.arange(0, width * n + 1, width, dtype=np.int64), nodes.ravel())


# ---- from blocks ------------------------------------------------------------------------------------


def _placed(chosen: list[Block]) -> tuple[Array, Optional[Array]]:
    """Return the places of the elements among all cells, and their order in the blocks (None: the same order)."""
    at = joined([block.at for block in chosen])
    if len(chosen) == 1 or np.all(at[1:] > at[:-1]):
        return at, None
    order = np.argsort(at, kind="stable")
    return at[order], order


def _data_of(chosen: list[Block], order: Optional[Array]) -> dict[str, Any]:
    """Return the arrays that all blocks have."""
    data = {name: joined([block.data[name] for block in chosen])
            for name in chosen[0].data if all(name in block.data for block in chosen)}
    if order is None:
        return data
    return {name: values[order] if len(values) == len(order) else values for name, values in data.items()}


def _lay_out(chosen: list[Block], order: Optional[Array]) -> Layout:
    """Make the arrays of planish_cells."""
    types = np.concatenate([np.full(len(block.nodes), block.kind.number, np.uint8) for block in chosen if block.kind])
    rank = np.arange(len(types))
    if order is not None:
        types = types[order]
        rank[order] = np.arange(len(order))
    offsets = np.append(0, np.cumsum(WIDTHS[types]))
    nodes, first = np.empty(offsets[-1], dtype=np.int32), 0
    for block in chosen:
        places = offsets[rank[first:first + len(block.nodes)]]
        nodes[places[:, None] + np.arange(block.nodes.shape[1])] = narrow(block.nodes)
        first += len(block.nodes)
    return Layout(types, offsets, nodes)


def corners_of_simplices(layout: Layout, dim: int) -> Array:
    """Return the corners [.., dim + 1] of triangles or tetrahedra of any order."""
    is_simplex = np.isin(layout.types, SIMPLICES[dim])
    return layout.nodes[layout.offsets[:-1][is_simplex][:, None] + np.arange(dim + 1)]


def _of_blocks(blocks: list[Block], n_points: int) -> Elements:
    """Return the elements among blocks."""
    known = [block for block in blocks if block.kind is not None and len(block.nodes)]
    dim = max((block.kind.dim for block in known if block.kind), default=0)
    if dim < 2:
        raise ValueError("the mesh has no elements; planish knows "
                         + ", ".join(kind.name for kind in TYPES if kind.dim >= 2))
    chosen = [block for block in known if block.kind and block.kind.dim == dim]
    others = [block for block in blocks if block.kind is None or block.kind.dim < dim]
    at, order = _placed(chosen)
    if all(block.kind.number == SIMPLICES[dim][0] for block in chosen if block.kind):
        nodes = joined([block.nodes for block in chosen])
        simple, layout = simplices(nodes if order is None else nodes[order]), None
        corners = simple
    else:
        simple, layout = None, _lay_out(chosen, order)
        corners = corners_of_simplices(layout, dim)
    for block in others:
        _holders.check_nodes(block, n_points)
    others = _holders.that_say_something(others, corners) if len(corners) else others
    return Elements(dim, simple, layout, corners, at, _data_of(chosen, order), others)


def elements_of(points: Any, cells: Any) -> Elements:
    """Return the elements of cells, or, if these are None, of the mesh points."""
    if cells is None:
        return _of_blocks(blocks_of_mesh(points), len(points.points))
    if is_by_type(cells):
        return _of_blocks(blocks_by_type(cells), len(points) if hasattr(points, "__len__") else 0)
    nodes = simplices(cells)
    return Elements(nodes.shape[1] - 1, nodes, None, nodes, np.arange(len(nodes)), {}, [])


def is_triangles(elements: Elements) -> bool:
    """Whether all elements are straight triangles."""
    return elements.has_only(TRIANGLE)
