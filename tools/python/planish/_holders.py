"""Cells that hold their nodes: points, edges, facets, and cells of unknown types."""

from __future__ import annotations

import itertools
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, joined
from ._blocks import Block
from ._cell_types import POLYVERTEX


def tags(data: dict[str, Any], n: int) -> NDArray[np.int64]:
    """Return a tag [n] for each of n cells. Cells with equal whole numbers in all arrays get equal tags."""
    found = np.zeros(n, dtype=np.int64)
    for values in map(np.asarray, data.values()):
        if values.shape == found.shape and values.dtype.kind in "biuf" and np.all(values == np.floor(values)):
            codes = np.unique(values, return_inverse=True)[1]
            found = np.unique(found * (codes.max(initial=0) + 1) + codes, return_inverse=True)[1]
    return found


def _codes(rows: Array) -> Array:
    """Return a code for each row of nodes. Rows with the same nodes, in any order, get equal codes."""
    rows = np.sort(rows.astype(np.int64), axis=1)
    codes, n = rows[:, 0], rows.max(initial=0) + 1
    for i in range(1, rows.shape[1]):
        codes = np.unique(codes * n + rows[:, i], return_inverse=True)[1].ravel()
    return codes


def _parts(elements: Array, corners: int) -> Array:
    """Return all facets, or edges, of elements: shared ones once for each element."""
    sets = list(itertools.combinations(range(elements.shape[1]), corners))
    found: Array = elements[:, sets].reshape(-1, corners)
    return found


def _boundary_edges(elements: Array) -> Array:
    """Return the edges of the facets that belong to one element alone."""
    facets = _parts(elements, elements.shape[1] - 1)
    _, first, count = np.unique(_codes(facets), return_index=True, return_counts=True)
    return _parts(facets[first[count == 1]], 2)


def _holders(listed: Array, listed_tags: Array, elements: Array) -> NDArray[np.bool_]:
    """Return a mask of the listed edges or facets that hold their nodes.

    A list may have all edges or facets of the elements. Then the most frequent tag inside the mesh holds nothing, nor
    does the most frequent tag of edges on the boundary (docs/formats.md).
    """
    holds = np.ones(len(listed), dtype=bool)
    corners, of_element = listed.shape[1], elements.shape[1]
    is_facet = of_element - corners == 1
    if len(listed) < (of_element * len(elements) // 2 if is_facet else len(elements)):
        return holds
    parts = [listed, _parts(elements, corners)] + ([] if is_facet else [_boundary_edges(elements)])
    codes = np.split(_codes(np.concatenate(parts)), np.cumsum([len(part) for part in parts])[:-1])
    count = np.bincount(codes[1], minlength=max(code.max(initial=0) for code in codes) + 1)
    if not np.isin(codes[1], codes[0]).all():
        return holds
    is_boundary = count[codes[0]] == 1 if is_facet else np.isin(codes[0], codes[2])
    is_inside = (count[codes[0]] > 0) & ~is_boundary
    for there in (is_inside,) if is_facet else (is_inside, is_boundary):
        if there.any():
            holds[there & (listed_tags == np.argmax(np.bincount(listed_tags[there])))] = False
    return holds


def _without_complete(of_kind: list[Block], n_corners: int, elements: Array) -> list[Block]:
    """Return blocks of one kind, without the edges or facets that a complete list has (see _holders)."""
    names = set.intersection(*(set(block.data) for block in of_kind))
    listed = joined([block.nodes[:, :n_corners] for block in of_kind])
    of_listed = tags({name: joined([block.data[name] for block in of_kind]) for name in sorted(names)}, len(listed))
    ends = np.cumsum([len(block.nodes) for block in of_kind])[:-1]
    holds = np.split(_holders(listed, of_listed, elements), ends)
    return [block._replace(nodes=block.nodes[rows]) for block, rows in zip(of_kind, holds)]


def that_say_something(blocks: list[Block], elements: Array) -> list[Block]:
    """Return blocks without the edges and facets of complete lists, which hold nothing."""
    corners = [block.kind.n_corners if block.kind else 0 for block in blocks]
    kept = [block for block, n in zip(blocks, corners) if n not in (2, 3)]
    for n_corners in (2, 3):
        of_kind = [block for block, n in zip(blocks, corners) if n == n_corners and len(block.nodes)]
        if of_kind:
            kept += _without_complete(of_kind, n_corners, elements)
    return kept


def check_nodes(block: Block, n_points: int) -> None:
    """Raise ValueError if a node is out of range. -1 stands for a missing mid."""
    corners = block.kind.n_corners if block.kind else 0
    parts = [(block.nodes, 0)] if not corners else [(block.nodes[:, :corners], 0), (block.nodes[:, corners:], -1)]
    for nodes, least in parts:
        if nodes.size and not (least <= nodes.min() and nodes.max() < n_points):
            wrong = nodes.max() if nodes.max() >= n_points else nodes.min()
            raise ValueError(f"cells of type {block.name} have node {wrong}, which is not in 0 .. {n_points - 1}")


def _is_of_points(block: Block) -> bool:
    return bool(block.name == POLYVERTEX or (block.kind is not None and block.kind.dim == 0))


def held_nodes(blocks: list[Block], n_points: int) -> NDArray[np.uint8]:
    """Return a mask [n_points] of the nodes that cells hold. A list of all points holds none, as in files."""
    held = np.zeros(n_points, dtype=np.uint8)
    for of_points in (True, False):
        for block in blocks:
            if _is_of_points(block) == of_points:
                nodes = block.nodes.ravel()
                held[nodes[nodes >= 0]] = 1
        if of_points and held.all():
            held[:] = 0
    return held


def tag_kind(block: Block, dim: int) -> Optional[str]:
    """Return "facets" or "edges" for cells that elements of dimension dim may have as such; None: neither."""
    below = dim - (block.kind.dim if block.kind else dim)
    return "facets" if below == 1 else "edges" if below == 2 and dim == 3 else None
