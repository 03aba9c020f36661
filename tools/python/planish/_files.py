"""Mesh files: read without loss, written with the same bytes but for coordinates, converted."""

from __future__ import annotations

import ctypes
import errno
import os
import warnings
from ctypes import byref, c_double, c_int, c_int64, c_size_t, c_void_p
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from ._arrays import Array, address, borrow, pointer
from ._cell_types import KNOWN, WEDGE_OF_MESHIO
from ._elements import Elements, Layout, corners_of_simplices
from ._errors import ConversionWarning, Error, FileError, MissingFileError
from ._io import hold_of, io, text_of, texts, texts_of, values_of
from ._io_structures import ConvertOptions, Data, DataInfo, FileInfo, Group, OpenOptions, Plane, WriteOptions
from ._library import call, files, threads_to_use
from ._structures import Cells, MeshView, Surface
from ._tables import Rows, html_table, text_table

_WEDGE = 13
_TEXT = 512  # bytes of the list of what a conversion leaves out
_OF_MESH = 1 | 2 | 4  # planish_file_reason: lines, faces and interfaces, which a conversion keeps as such

# Why a file holds a node, by the names in the program's reports: bits of planish_file_reason.
REASONS = {"lines_and_points": 1, "faces_inside": 2, "interface": 4, "other_elements": 8, "periodic": 16, "fix": 32,
           "required": 64}


class Handle:
    """A planish_file. The library closes it with its last reference."""

    def __init__(self, path: str, options: OpenOptions) -> None:
        """Open the file at path; raise FileError if that fails."""
        self.file = c_void_p()
        self.close = io("close")
        try:
            call(io("open_with"), text_of(path), byref(options), byref(self.file))
        except FileError as error:
            if os.path.lexists(path):
                raise
            missing = MissingFileError(str(error), error.code)
            missing.errno, missing.filename = errno.ENOENT, os.fspath(path)
            raise missing from None

    def __del__(self) -> None:
        """Close the file."""
        if getattr(self, "file", None):
            self.close(self.file)


class Mesh:
    """A mesh of a file. Smooth it and write it: only its coordinates change, and the rest of the file stays.

    points are the coordinates, to be changed in place: [n, 2] for flat elements in a plane, else [n, 3]. cells are the
    elements, arrays by meshio's names of types. format is the name of the file's format.
    """

    def __init__(self, path: str, options: OpenOptions) -> None:
        """Read the file at path. Callers use planish.read."""
        self.path = path
        self.handle = Handle(path, options)
        self.threads = options.threads
        self.info = FileInfo()
        io("get_info")(self.handle.file, byref(self.info))
        self.structure: MeshView = io("mesh")(self.handle.file)
        self.dim = int(self.structure.dim)
        self.format = (self.info.format or b"").decode()
        shape = int(self.structure.n_nodes), self.dim
        self._points = borrow(self.handle, io("coordinates")(self.handle.file), shape, np.float64)
        self._chosen: Optional[list[str]] = None

    # ---- nodes and elements ---------------------------------------------------------------------------

    @property
    def points(self) -> NDArray[np.float64]:
        """Coordinates of the nodes [n, 2 or 3], to be changed in place."""
        return self._points

    @property
    def cells(self) -> dict[str, Array]:
        """Elements: an array [m, k] of nodes in meshio's order for each type, by meshio's name of the type."""
        layout, found = self.layout(), {}
        for number in np.flatnonzero(np.bincount(layout.types, minlength=256)).tolist():
            kind = KNOWN[number]
            at = layout.offsets[:-1][layout.types == number]
            nodes = layout.nodes[at[:, None] + np.arange(kind.n_nodes)]
            found[kind.name] = nodes[:, WEDGE_OF_MESHIO] if number == _WEDGE else nodes
        return found

    def layout(self) -> Layout:
        """Return the elements as in planish_cells. The file owns the arrays, and nobody may change them."""
        cells = Cells()
        call(io("cells"), self.handle.file, byref(cells))
        offsets = self._fixed(cells.offset, (cells.n + 1,), np.int64)
        return Layout(self._fixed(cells.type, (cells.n,), np.uint8), offsets,
                      self._fixed(cells.node, (int(offsets[-1]),), np.int32))

    def _fixed(self, at: Optional[int], shape: tuple[int, ...], dtype: Any) -> Array:
        """Return an array over memory of the file, read-only."""
        array = borrow(self.handle, at, shape, dtype)
        array.flags.writeable = False
        return array

    def elements(self) -> Elements:
        """Return the elements as the library smooths them."""
        n = int(self.structure.n_elements)
        if self.structure.elements:
            simple = self._fixed(self.structure.elements, (n, self.dim + 1), np.int32)
            return Elements(self.dim, simple, None, simple, np.arange(n), {}, [])
        layout, dim = self.layout(), 2 if self.is_in_space else self.dim
        return Elements(dim, None, layout, corners_of_simplices(layout, dim), np.arange(n), {}, [])

    @property
    def is_in_space(self) -> bool:
        """Whether the mesh is a surface in space: flat elements that lie in no common plane."""
        if self.dim == 2 or self.structure.elements:
            return False
        types = self.layout().types
        return len(types) > 0 and KNOWN[int(types[0])].dim == 2

    def plane(self) -> Optional[Plane]:
        """Return the plane in which points are coordinates; None: points are the first columns of the file."""
        plane = Plane()
        return plane if io("plane")(self.handle.file, byref(plane)) else None

    def space_points(self) -> NDArray[np.float64]:
        """Return the coordinates [n, 3] in space of a mesh of flat elements, else a copy of points."""
        found = np.zeros((len(self.points), 3))
        call(io("space_coordinates"), self.handle.file, c_int64(0), c_int64(len(found)), pointer(self.points),
             pointer(found))
        return found

    def element_number(self, element: int) -> int:
        """Return the file's number of the element with this index; raise IndexError if there is none."""
        return int(io("element_number")(self.handle.file, c_int64(range(self.structure.n_elements)[element])))

    def node_number(self, node: int) -> int:
        """Return the file's number of the node with this index; raise IndexError if there is none."""
        return int(io("node_number")(self.handle.file, c_int64(range(len(self.points))[node])))

    # ---- regions, data, held nodes ----------------------------------------------------------------------

    @property
    def cell_arrays(self) -> list[str]:
        """Names of the arrays with one whole number per element."""
        return texts(io("cell_arrays")(self.handle.file))

    @property
    def region_arrays(self) -> list[str]:
        """Names of the cell_arrays whose values are regions."""
        return texts(io("region_arrays")(self.handle.file))

    def choose_regions(self, names: Sequence[str]) -> None:
        """Let these arrays be the regions, instead of the arrays that look like regions.

        Raise ValueError if other arrays were chosen before.
        """
        if self._chosen is not None and self._chosen != list(names):
            raise ValueError("regions were chosen for this mesh; read it again to choose others")
        if self._chosen is None:
            call(io("choose_regions"), self.handle.file, texts_of(names), c_int(len(names)))
            self._chosen = list(names)

    @property
    def regions(self) -> Optional[NDArray[np.int32]]:
        """Region number of each element [m]; None: the mesh is one region."""
        regions = self._region_numbers()
        return None if regions is None else regions.copy()  # another choice of arrays frees the file's own

    def _region_numbers(self) -> Optional[NDArray[np.int32]]:
        surface: Surface = io("surface")(self.handle.file, None)
        return self._fixed(surface.region, (int(self.structure.n_elements),), np.int32) if surface.region else None

    @property
    def region_names(self) -> dict[int, str]:
        """Names of regions by their numbers, as fix takes them. Regions without a name are left out."""
        regions = self._region_numbers()
        if regions is None:
            return {}
        numbers, first = np.unique(regions, return_index=True)
        named = [(int(number), self._region_name(int(at))) for number, at in zip(numbers, first)]
        return {number: name for number, name in named if name}

    def _region_name(self, element: int) -> str:
        text = ctypes.create_string_buffer(_TEXT)
        io("element_region")(self.handle.file, c_int64(element), text, c_size_t(_TEXT))
        return text.value.decode(errors="surrogateescape")

    @property
    def data_arrays(self) -> list[str]:
        """Names of the arrays that data reads: numbers at nodes or elements."""
        info = DataInfo()
        names: list[str] = []
        while io("data_info")(self.handle.file, c_int64(len(names)), byref(info)):
            names.append((info.name or b"").decode(errors="surrogateescape"))
        return names

    def data(self, name: str) -> tuple[NDArray[np.float64], bool]:
        """Return the array with this name [n or m, components], and whether its values are of elements."""
        data = Data()
        call(io("data"), self.handle.file, text_of(name), byref(data))
        return values_of(data)

    @property
    def groups(self) -> list[tuple[int, str]]:
        """Dimension and tag of each group. fix, slide and min_volume take the tags. Groups with names come first."""
        found, n = ctypes.POINTER(Group)(), c_int64(0)
        call(io("groups"), self.handle.file, byref(found), byref(n))
        return [(int(found[i].dim), (found[i].tag or b"").decode(errors="surrogateescape")) for i in range(n.value)]

    def held(self, fix: Union[str, Sequence[str]] = ()) -> dict[str, NDArray[np.bool_]]:
        """Return masks [n] of the nodes that the file and fix hold, by reason. Reasons without a node are left out.

        A node may have several reasons: faces_inside has the nodes of all facets that the file lists, on the boundary, too.

        Args:
            fix: names of groups
        """
        reason = np.zeros(len(self.points), dtype=np.uint8)
        names = [fix] if isinstance(fix, str) else list(fix)
        hold, _kept = hold_of(names)
        call(io("get_held"), self.handle.file, byref(hold), pointer(reason))
        return {name: reason & bit != 0 for name, bit in REASONS.items() if (reason & bit).any()}

    # ---- writing ------------------------------------------------------------------------------------------

    def write(self, path: Union[str, "os.PathLike[str]"], *, threads: int = 0) -> None:
        """Write a copy of the file with the coordinates of moved nodes replaced.

        If the path has the extension of another format, convert the mesh. A ConversionWarning lists the data that this
        format cannot store. Raise FileError if the file cannot be written; an older file then stays.

        Args:
            path: the new file, perhaps the one that was read; a folder if that is a folder
            threads: as for read
        """
        self.tell(path, self.write_quietly(path, threads), 3)

    def write_quietly(self, path: Union[str, "os.PathLike[str]"], threads: int) -> str:
        """Write the mesh as write does. Return the list of data that a conversion loses, or an empty text."""
        encoded = text_of(path)
        can_write = bool(io("can_write")(self.handle.file, encoded))
        if not can_write and io("can_convert")(self.handle.file, encoded):
            return self._convert(encoded)
        try:
            call(io("write"), self.handle.file, encoded, pointer(self.points),
                 byref(WriteOptions(threads=threads_to_use(threads))))
        except Error as error:  # for the library a wrong extension is a wrong argument, here an error of the file
            if can_write or isinstance(error, FileError):
                raise
            raise FileError(str(error), error.code) from None
        return ""

    @staticmethod
    def tell(path: Any, lost: str, depth: int) -> None:
        """Warn the caller, depth calls away, of the data that a conversion lost."""
        if lost:
            warnings.warn(f"{os.fspath(path)} lacks {lost}", ConversionWarning, stacklevel=depth)

    def _convert(self, path: bytes) -> str:
        """Write the mesh in another format. Return the list of data that this loses."""
        reason = np.zeros(len(self.points), dtype=np.uint8)
        call(io("get_held"), self.handle.file, None, pointer(reason))
        held = (reason & ~np.uint8(_OF_MESH) != 0).astype(np.uint8)
        lost = ctypes.create_string_buffer(_TEXT)
        options = ConvertOptions(constraint=address(held if held.any() else None), lost=ctypes.addressof(lost),
                                 lost_size=_TEXT)
        call(io("convert"), self.handle.file, path, pointer(self.points), byref(options))
        return lost.value.decode(errors="replace")

    # ---- shown ----------------------------------------------------------------------------------------------

    def rows(self) -> Rows:
        """Return the names and values of the table that print shows."""
        types = self.layout().types
        counts = [(KNOWN[number].name, int((types == number).sum())) for number in np.unique(types).tolist()]
        return [("format", self.format), ("dimension", self.dim), ("nodes", len(self.points)), *counts,
                ("regions", int(self.info.n_regions))]

    def __repr__(self) -> str:
        """Return the path and the numbers of nodes and elements."""
        return f"<planish.Mesh of {self.path!r}: {len(self.points)} nodes, {self.structure.n_elements} elements>"

    def __str__(self) -> str:
        """Return a short table."""
        return text_table(self.rows())

    def _repr_html_(self) -> str:
        """Return the table for notebooks."""
        return html_table(self.rows())

    def __reduce__(self) -> Any:
        """Raise TypeError: a mesh cannot be copied or pickled."""
        raise TypeError("a mesh of a file can be neither copied nor pickled; read it again")


def read(path: Union[str, "os.PathLike[str]"], *, format: Optional[str] = None,  # pylint: disable=redefined-builtin
         threads: int = 0, isolated: bool = True, plane_tolerance: float = 0) -> Mesh:
    """Read a mesh file, or the folder of a format that is a folder (docs/formats.md). Raise FileError if that fails.

    Args:
        path: the file
        format: name of the format; None: found by content, then by extension
        threads: number of threads; 0: all
        isolated: open a file in HDF5 in a child process first, because a damaged file can end the process. This takes
            twice the time, and no other thread may use the HDF5 library meanwhile
        plane_tolerance: largest distance of nodes of flat elements from their common plane, as a fraction of the
            bounding box's diagonal. Flat elements farther off are a surface in space. 0: as the file's digits say
    """
    options = OpenOptions(format=None if format is None else text_of(format), isolated=bool(isolated),
                          threads=threads_to_use(threads).value, plane_tolerance=plane_tolerance)
    return Mesh(os.fspath(path), options)


def opened(given: Any) -> Any:
    """Return the mesh at a path; anything else is returned as it is."""
    return read(given) if isinstance(given, (str, os.PathLike)) else given


def write(mesh: Mesh, path: Union[str, "os.PathLike[str]"], *, threads: int = 0) -> None:
    """Write a mesh of planish.read, as its method write does. Raise TypeError for other meshes.

    Args:
        mesh: the mesh
        path: as for Mesh.write
        threads: as for read
    """
    if not isinstance(mesh, Mesh):
        raise TypeError(f"write is for meshes of planish.read, not {type(mesh).__name__}; other packages write theirs")
    mesh.tell(path, mesh.write_quietly(path, threads), 3)


def read_sizes(mesh: Mesh, path: Union[str, "os.PathLike[str]"]) -> NDArray[np.float64]:
    """Return the values [n, components] of a solution file of Medit's for the nodes of a mesh."""
    data = Data()
    call(files().planish_sol_read, text_of(path), c_int(mesh.dim), c_int64(len(mesh.points)), byref(data))
    return values_of(data)[0]


def min_volumes(mesh: Mesh, volumes: Mapping[str, float]) -> NDArray[np.float64]:
    """Return the minimum volume of each element [m] from the volumes of groups; 0: its groups have none."""
    found, tags = np.zeros(int(mesh.structure.n_elements)), list(volumes)
    values = (c_double * max(len(tags), 1))(*volumes.values())
    call(io("min_volumes"), mesh.handle.file, texts_of(tags), values, c_int(len(tags)), pointer(found))
    return found
