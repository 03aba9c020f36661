"""Smooth and measure the mesh of a Gmsh model in Gmsh's memory, without a file.

    import gmsh
    import planish.gmsh

    gmsh.initialize()
    gmsh.open("part.geo")
    gmsh.model.mesh.generate(3)
    planish.gmsh.smooth(slide="curved")
    print(planish.gmsh.quality().min_angle_deg)

The mesh counts as it does in a file that Gmsh writes with Mesh.SaveAll: entities are regions, elements of
surfaces and curves are tags, nodes of embedded points and curves stay. Coordinates become those that the
program makes of the file. Needs Gmsh's Python API of 4.8 or later.
"""

# Some versions of Gmsh have types.
# mypy: no-warn-unused-ignores

from __future__ import annotations

import ctypes
import itertools
from typing import Any, Iterable, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

import planish

try:
    import gmsh  # type: ignore[import]
except ImportError as _failure:
    raise ImportError("planish.gmsh needs Gmsh's Python API: install python3-gmsh (Debian), or gmsh "
                      "by pip") from _failure

__all__ = ["quality", "smooth"]

Array = NDArray[Any]

_HIGHEST_ORDER = 2
_MOST_NUMBERS_PER_NODE = 8  # that a table of all numbers is made for

# Types by Gmsh's number: the number that planish has for it (VTK's), and where VTK's nodes stand in Gmsh's order.
_EDGES_OF_HEXAHEDRON = [8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]
_EDGES_OF_WEDGE = [6, 9, 7, 12, 14, 13, 8, 10, 11]
_EDGES_OF_PYRAMID = [5, 8, 10, 6, 7, 9, 11, 12]
_TYPES: dict[int, tuple[int, Optional[list[int]]]] = {
    15: (1, None), 1: (3, None), 8: (21, None),
    2: (5, None), 9: (22, None), 3: (9, None), 16: (23, None), 10: (28, None),
    4: (10, None), 11: (24, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    5: (12, None), 17: (25, [*range(8), *_EDGES_OF_HEXAHEDRON]),
    12: (29, [*range(8), *_EDGES_OF_HEXAHEDRON, 22, 23, 21, 24, 20, 25, 26]),
    6: (13, None), 18: (26, [*range(6), *_EDGES_OF_WEDGE]), 13: (32, [*range(6), *_EDGES_OF_WEDGE, 15, 17, 16]),
    7: (14, None), 19: (27, [*range(5), *_EDGES_OF_PYRAMID]), 14: (128, [*range(5), *_EDGES_OF_PYRAMID, 13])}


# ---- the mesh as Gmsh has it -----------------------------------------------------------------------


class _Block(NamedTuple):
    """Elements of one type on one entity, with the attributes of a block of meshio's."""

    type: Any  # planish's number; a text: a type that planish does not know, whose nodes stay
    data: Array  # [k, nodes] indices
    tags: Array  # [k] Gmsh's numbers of the elements


class _Mesh:
    """The mesh of the current model, with the attributes of a mesh of meshio's.

    points [n, 3] and tags [n], Gmsh's numbers of the nodes, are in the order of gmsh.model.mesh.getNodes(). An item of
    entities is (dim, tag, first, last): the nodes [first, last) are on this entity.
    """

    def __init__(self, dim: Optional[int]) -> None:
        self._take_nodes()
        self.cells: list[_Block] = []
        regions: list[Array] = []
        for entity in gmsh.model.getEntities():
            region = _region(*entity)
            for block in self._blocks(*entity) if region is not None else ():
                self.cells.append(block)
                regions.append(np.full(len(block.data), region, dtype=np.int32))
        self._choose(dim)
        self.cell_data = {"gmsh:geometrical": regions}

    def _take_nodes(self) -> None:
        self.entities, parts, n = [], [], 0
        for dim, tag in gmsh.model.getEntities():
            tags, xyz, _ = gmsh.model.mesh.getNodes(dim, tag, False, False)
            self.entities.append((dim, tag, n, n + len(tags)))
            parts.append((tags, np.reshape(xyz, (-1, 3))))
            n += len(tags)
        if not n:
            raise ValueError(f"the model {gmsh.model.getCurrent()!r} has no mesh; make one by "
                             "gmsh.model.mesh.generate()")
        self.tags = np.concatenate([tags for tags, _ in parts]).astype(np.int64)
        self.points = np.concatenate([xyz for _, xyz in parts])
        self._sorted, self._order = np.unique(self.tags, return_index=True)
        self._order = self._order.astype(np.int32)
        self._table: Optional[Array] = None  # [largest number + 1] of indices, if numbers are dense
        if self._sorted[-1] <= _MOST_NUMBERS_PER_NODE * n:
            self._table = np.full(self._sorted[-1] + 1, -1, dtype=np.int32)
            self._table[self._sorted] = self._order

    def index(self, tags: Any) -> Array:
        """Return the indices of nodes with these numbers of Gmsh's."""
        tags = np.asarray(tags).astype(np.int64, copy=False)
        if self._table is not None and (not tags.size or 0 <= tags.min() and tags.max() < len(self._table)):
            found: Array = self._table[tags]
        else:
            at = np.minimum(np.searchsorted(self._sorted, tags), len(self._sorted) - 1)
            found = np.where(self._sorted[at] == tags, self._order[at], np.int32(-1))
        if (found < 0).any():
            raise ValueError(f"the model has no node {tags[found < 0][0]}")
        return found

    def _blocks(self, dim: int, tag: int) -> Iterable[_Block]:
        """Yield the elements of an entity, type by type."""
        for number, tags, nodes in zip(*gmsh.model.mesh.getElements(dim, tag)):
            kind, order = _type_of(int(number))
            rows = self.index(nodes).reshape(len(tags), -1)
            yield _Block(kind, rows if order is None else rows[:, order], np.asarray(tags))

    def _choose(self, dim: Optional[int]) -> None:
        """Set the dimension of the elements; raise ValueError if dim is not the highest that the mesh has."""
        highest = max((dimension for dimension, tag, *_ in self.entities
                       if len(gmsh.model.mesh.getElementTypes(dimension, tag))), default=0)
        if dim not in (None, 2, 3):
            raise ValueError(f"dim must be 2, 3 or None, not {dim!r}")
        if dim is not None and dim != highest:
            raise ValueError(f"dim is {dim}, but the mesh has elements of dimension {highest}, whose nodes these are; "
                             "planish moves the nodes of the elements of the highest dimension" if dim < highest else
                             f"dim is {dim}, but the mesh has no elements of that dimension")
        self.dim = highest

    def periodic(self) -> Array:
        """Return the indices of the nodes on periodic entities and of their partners."""
        found = [np.zeros(0, dtype=np.int64)]
        for dim, tag in gmsh.model.getEntities():
            if dim < 3:
                master, tags, masters, _ = gmsh.model.mesh.getPeriodicNodes(dim, tag, True)
                if master != tag:
                    found += [self.index(tags), self.index(masters)]
        return np.concatenate(found)


def _region(dim: int, tag: int) -> Optional[int]:
    """Return the entity that a partitioned entity is a part of; None for an interface between parts."""
    parent_dim, parent = gmsh.model.getParent(dim, tag)
    return tag if parent_dim < 0 else parent if parent_dim == dim else None


def _type_of(number: int) -> tuple[Any, Optional[list[int]]]:
    """Return planish's type for a number of Gmsh's, and the order of nodes (None: the same order)."""
    if number in _TYPES:
        return _TYPES[number]
    name, _, order, *_ = gmsh.model.mesh.getElementProperties(number)
    if order > _HIGHEST_ORDER:
        raise ValueError(f"the mesh has elements of order {order} ({name}), but planish smooths those of order 1 "
                         "and 2; smooth first, gmsh.model.mesh.setOrder() then")
    return f"{name} of Gmsh", None


# ---- nodes that users choose by Gmsh's names and numbers -----------------------------------------------


def _entities_of(choice: Any) -> list[tuple[int, int]]:
    """Return the entities that a choice means.

    A choice is (dim, tag), or a tag of the program: the name or number of a physical group, the number of an entity, or
    DIM:NUMBER.
    """
    entities, groups = gmsh.model.getEntities(), gmsh.model.getPhysicalGroups()
    if isinstance(choice, tuple):
        found = [entity for entity in entities if entity == choice]
    else:
        *dims, number = choice.split(":")
        chosen = [group for group in groups if gmsh.model.getPhysicalName(*group) == choice] or [
            group for group in groups if [str(group[0])] in (dims, dims or [str(group[0])]) and str(group[1]) == number]
        found = [(group[0], int(tag)) for group in chosen for tag in gmsh.model.getEntitiesForPhysicalGroup(*group)]
        found = found or [entity for entity in entities if dims in ([], [str(entity[0])]) and str(entity[1]) == number]
    if not found:
        known = [gmsh.model.getPhysicalName(*group) or f"{group[0]}:{group[1]}" for group in groups]
        raise ValueError(f"fix: the model has no group or entity {choice!r}; its groups: {', '.join(known) or 'none'}")
    return found


def _is_choice(choice: Any) -> bool:
    """Whether choice is a tag in a text, or (dim, tag)."""
    return isinstance(choice, str) or (isinstance(choice, tuple) and len(choice) == 2
                                       and all(isinstance(number, (int, np.integer)) for number in choice))


def _chosen_nodes(mesh: _Mesh, chosen: Any, what: str) -> Array:
    """Return the indices of nodes that Gmsh's numbers, or a mask, choose. what: the argument, for messages."""
    nodes = np.asarray(chosen).ravel()
    if nodes.dtype == bool:
        if nodes.shape != mesh.tags.shape:
            raise ValueError(f"{what} is a mask of shape {nodes.shape}, not {mesh.tags.shape}")
        return np.flatnonzero(nodes)
    if nodes.size and nodes.dtype.kind not in "iu":
        raise TypeError(f"{what} must be Gmsh's numbers of nodes or a mask, not {nodes.dtype}")
    return mesh.index(nodes)


def _nodes_to_fix(mesh: _Mesh, fix: Any) -> Array:
    """Return the indices of the nodes that fix chooses by groups, entities, Gmsh's numbers, or a mask."""
    choices = [fix] if _is_choice(fix) else fix
    if isinstance(choices, (list, tuple, set, frozenset)) and all(map(_is_choice, choices)):
        found = [gmsh.model.mesh.getNodes(dim, tag, True, False)[0] for choice in choices
                 for dim, tag in _entities_of(choice)]
        return mesh.index(np.concatenate([np.zeros(0, dtype=np.int64), *found]))
    return _chosen_nodes(mesh, fix, "fix")


def _translated(mesh: _Mesh, options: dict[str, Any]) -> dict[str, Any]:
    """Return the options of planish.smooth for a mesh.

    Names and numbers of Gmsh's become indices of nodes. Periodic nodes are added to fix.
    """
    options = dict(options)
    held = mesh.periodic()
    if options.get("fix") is not None:
        held = np.concatenate([held, _nodes_to_fix(mesh, options["fix"])])
    options["fix"] = np.unique(held)
    if options.get("around") is not None:
        options["around"] = _chosen_nodes(mesh, options["around"], "around")
    return options


# ---- nodes that moved ------------------------------------------------------------------------------


def _parameters(dim: int, tag: int, xyz: Array) -> Optional[Array]:
    """Return the parameters [k, dim] of points on a curve or surface; None if Gmsh has none."""
    if dim not in (1, 2):
        return None
    held = gmsh.model.mesh.getNodes(dim, tag, False, True)[2]
    try:
        found = gmsh.model.getParametrization(dim, tag, xyz.ravel()) if len(held) else ()
    except Exception:  # pylint: disable=broad-except  # Gmsh raises nothing more particular
        found = ()
    return np.reshape(found, (-1, dim)) if len(found) == dim * len(xyz) else None


def _node_setter() -> Any:
    """Return the function of Gmsh's C interface that sets a node; gmsh.model.mesh.setNode takes ten times as long.

    Arguments: number of the node, address of the coordinates, 3, address of the parameters, their number, address of an
    error.
    """
    prototype = ctypes.CFUNCTYPE(None, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p,
                                 ctypes.c_size_t, ctypes.c_void_p)
    return prototype(ctypes.cast(gmsh.lib.gmshModelMeshSetNode, ctypes.c_void_p).value or 0)


def _write_nodes(mesh: _Mesh, before: Array) -> None:
    """Set the moved nodes in Gmsh, with their parameters on curves and surfaces."""
    has_moved, set_node, error = (mesh.points != before).any(axis=1), _node_setter(), ctypes.c_int()
    failed = ctypes.addressof(error)
    for dim, tag, first, last in mesh.entities:
        chosen = first + np.flatnonzero(has_moved[first:last])
        if not len(chosen):
            continue
        xyz = mesh.points[chosen]
        uv = _parameters(dim, tag, xyz)
        n = 0 if uv is None else dim
        for node, at, parameters in zip(mesh.tags[chosen].tolist(), _addresses(xyz), _addresses(uv)):
            set_node(node, at, 3, parameters, n, failed)
            if error.value:
                raise RuntimeError(f"Gmsh did not take the node {node}: {gmsh.logger.getLastError()}")


def _addresses(rows: Optional[Array]) -> Iterable[Optional[int]]:
    """Return an iterator over the addresses of the rows of an array; without an array over None, without end."""
    if rows is None:
        return itertools.repeat(None)
    return range(rows.ctypes.data, rows.ctypes.data + rows.nbytes, rows.strides[0])


# ---- what people call ------------------------------------------------------------------------------


class _Current:
    """Context in which a model is Gmsh's current one; None: the present one."""

    def __init__(self, name: Optional[str]) -> None:
        self.name, self.before = name, gmsh.model.getCurrent()

    def __enter__(self) -> None:
        if self.name is not None:
            gmsh.model.setCurrent(self.name)

    def __exit__(self, *_: object) -> None:
        if self.name is not None:
            gmsh.model.setCurrent(self.before)


def smooth(model: Optional[str] = None, dim: Optional[int] = None, **options: Any) -> planish.Result:
    """Smooth the mesh of a Gmsh model in place.

    Args:
        model: name of the model; None: the current one
        dim: dimension of the elements, 2 or 3; None: the highest that the mesh has
        options: those of planish.smooth, with two differences. fix takes one or a list of: names and numbers of
            physical groups, numbers of entities, DIM:NUMBER, (dim, tag). Or it takes Gmsh's numbers of nodes, or a
            mask. around takes Gmsh's numbers of nodes. Arrays of nodes are in the order of
            gmsh.model.mesh.getNodes()

    Return a Result, as planish.smooth does. Periodic nodes stay. Nodes that moved on curves and surfaces get new
    parameters there. If planish refuses the mesh or an option, smooth raises an error and nothing changes.
    """
    with _Current(model):
        mesh = _Mesh(dim)
        before = mesh.points.copy()
        result = planish.smooth(mesh, **_translated(mesh, options))
        _write_nodes(mesh, before)
    return result


def quality(model: Optional[str] = None, dim: Optional[int] = None, **options: Any) -> planish.Quality:
    """Measure the mesh of a Gmsh model.

    Args:
        model: as for smooth
        dim: as for smooth
        options: those of planish.quality, with fix as for smooth

    Return a Quality, as planish.quality does. With per_element, elements.number has Gmsh's numbers of the elements.
    """
    with _Current(model):
        mesh = _Mesh(dim)
        found = planish.quality(mesh, **_translated(mesh, options))
        if found.elements is not None:
            tags = np.concatenate([block.tags for block in mesh.cells])
            found.elements = found.elements._replace(number=tags[found.elements.number])
    return found
