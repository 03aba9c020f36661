"""reading: mesh files as meshio or Gmsh read them, and what two versions of a file differ in as bytes."""
import contextlib
import io
import pathlib
import re
from dataclasses import dataclass, field

import meshio
import numpy as np

from shapes import SHAPES

KNOWN_REGIONS = ("gmsh:physical", "gmsh:geometrical", "medit:ref")
# Files that may change their size, or whose numbers are not written as text.
PACKED = {".h5", ".hdf", ".vtkhdf", ".med", ".mmed", ".rmed", ".cgns", ".vtu", ".xdmf", ".xmf", ".gz"}
COLUMNS = {".bdf", ".nas", ".fem", ".unv", ".uff"}  # numbers without blanks between them
# Nodes of Gmsh's types in VTK's order.
GMSH_TYPES = {2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge", 7: "pyramid", 9: "triangle6",
              10: "quad9", 11: "tetra10", 13: "wedge18", 16: "quad8", 17: "hexahedron20", 18: "wedge15", 1: "line",
              8: "line3", 15: "vertex"}
GMSH_ORDER = {"tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
              "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
              "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
              "wedge18": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16]}
VTK_TYPES = {1: "vertex", 3: "line", 5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron", 13: "wedge", 14: "pyramid",
             21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20", 26: "wedge15", 27: "pyramid13",
             28: "quad9", 29: "hexahedron27", 32: "wedge18"}

MFEM_TYPES = {1: ("line", 2), 2: ("triangle", 3), 3: ("quad", 4), 4: ("tetra", 4), 5: ("hexahedron", 8), 6: ("wedge", 6),
              7: ("pyramid", 5)}


class NotRead(Exception):
    """No reader takes the file."""


@dataclass
class Mesh:
    """Points [n][3], all blocks (type, cells), and arrays of data by name."""
    points: np.ndarray
    blocks: list
    data: dict = field(default_factory=dict)
    regions: dict = field(default_factory=dict)  # name: a list with an array for each block

    @property
    def dim(self):
        return max((SHAPES[name].dim if name in SHAPES else dim_of_other(name) for name, _ in self.blocks), default=0)

    def elements(self):
        """Numbers of the blocks whose elements can be judged: those of the highest dimension."""
        return [i for i, (name, _) in enumerate(self.blocks) if name in SHAPES and SHAPES[name].dim == self.dim]


def dim_of_other(name):
    """Dimension of a type that is not judged, by its name."""
    return next((dim for start, dim in (("vertex", 0), ("line", 1), ("triangle", 2), ("quad", 2), ("polygon", 2))
                 if name.startswith(start)), 3)


def files_of(path):
    """The files that a mesh consists of."""
    path = pathlib.Path(path)
    if path.suffix in (".node", ".ele"):
        return [p for p in (path.with_suffix(s) for s in (".node", ".ele", ".face", ".edge")) if p.exists()]
    return [path]


def read(path):
    """The mesh in a file; NotRead with the reasons."""
    reasons = []
    # Gmsh mistakes the nodes of wedges of second order in VTK's files.
    for reader in READERS.get(pathlib.Path(path).suffix, (_by_meshio, _by_gmsh)):
        try:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                mesh = reader(path)
            if mesh.elements():
                return mesh
            reasons.append("no elements")
        except (Exception, SystemExit) as error:  # pylint: disable=broad-except # readers fail in many ways
            reasons.append(type(error).__name__)
    raise NotRead(f"{pathlib.Path(path).suffix}: {', '.join(reasons)}")


def _by_meshio(path):
    path = pathlib.Path(path)
    found = meshio.read(path.with_suffix(".node") if path.suffix == ".ele" else path)
    points = np.zeros((len(found.points), 3), found.points.dtype)
    points[:, :found.points.shape[1]] = found.points
    data = {f"point {k}": np.asarray(v) for k, v in found.point_data.items()}
    data |= {f"cell {k} {i}": np.asarray(one) for k, v in found.cell_data.items() for i, one in enumerate(v)}
    data |= {f"field {k}": np.asarray(v) for k, v in found.field_data.items()}
    for kind, sets in (("points", found.point_sets), ("cells", found.cell_sets)):
        data |= {f"{kind} {k}": np.concatenate([np.ravel(one) for one in v if one is not None] or [[]])
                 if isinstance(v, list) else np.asarray(v) for k, v in sets.items()}
    blocks = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in found.cells]
    if path.suffix == ".msh":  # of which meshio leaves some nodes in Gmsh's order
        blocks = [(name, cells[:, GMSH_ORDER[name]] if name == "wedge18" else cells) for name, cells in blocks]
    return Mesh(points, blocks, data, dict(found.cell_data))


def _by_vtk(path):
    import vtk  # pylint: disable=import-outside-toplevel # slow, and few files need it
    from vtk.util.numpy_support import vtk_to_numpy  # pylint: disable=import-outside-toplevel
    reader = vtk.vtkUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    return Mesh(vtk_to_numpy(grid.GetPoints().GetData()), _blocks_of_vtk(grid))


def _blocks_of_vtk(grid):
    from vtk.util.numpy_support import vtk_to_numpy  # pylint: disable=import-outside-toplevel
    offset, node = (vtk_to_numpy(a).astype(np.int64) for a in (grid.GetCells().GetOffsetsArray(),
                                                               grid.GetCells().GetConnectivityArray()))
    kind = vtk_to_numpy(grid.GetCellTypesArray())
    blocks = []
    for number in np.unique(kind):
        chosen = np.flatnonzero(kind == number)
        n = offset[chosen[0] + 1] - offset[chosen[0]]
        blocks.append((VTK_TYPES[int(number)], node[offset[chosen][:, None] + np.arange(n)]))
    return blocks


def _exodus(path):
    """Exodus by VTK: each block has all points, in the file's order."""
    import vtk  # pylint: disable=import-outside-toplevel
    from vtk.util.numpy_support import vtk_to_numpy  # pylint: disable=import-outside-toplevel
    reader = vtk.vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.SetSqueezePoints(False)
    reader.SetApplyDisplacements(False)
    reader.UpdateInformation()
    reader.Update()
    blocks, points = [], None
    walk = reader.GetOutput().NewIterator()
    while not walk.IsDoneWithTraversal():
        grid = walk.GetCurrentDataObject()
        blocks += _blocks_of_vtk(grid)
        points = vtk_to_numpy(grid.GetPoints().GetData())
        walk.GoToNextItem()
    return Mesh(points, blocks)


def _mfem(path):
    """MFEM of first order: elements in VTK's order, and vertices behind all of them."""
    content = re.sub(r"#.*", "", pathlib.Path(path).read_text(encoding="ascii"))
    if not content.startswith("MFEM mesh v1.") or re.search(r"\bnodes\b", content):
        return _by_meshio(path)
    section = {name: words.split() for name, words in re.findall(r"(?m)^([a-z]+)$\s([^a-z]*)", content)}
    rows = iter(map(int, section["elements"][1:]))
    cells = {}
    for _ in range(int(section["elements"][0])):
        next(rows)
        name, n = MFEM_TYPES[next(rows)]
        cells.setdefault(name, []).append([next(rows) for _ in range(n)])
    n, columns = map(int, section["vertices"][:2])
    points = np.zeros((n, 3))
    points[:, :columns] = np.array(section["vertices"][2:2 + n * columns], float).reshape(n, columns)
    return Mesh(points, [(name, np.array(block, np.int64)) for name, block in cells.items()])


def _su2(path):
    """SU2, of several zones, too; meshio takes the numbers behind coordinates for coordinates."""
    lines = iter(re.sub(r"%.*", "", pathlib.Path(path).read_text(encoding="latin1")).splitlines())
    points, cells, dim, first = [], {}, 0, 0
    for line in lines:
        key, _, value = line.partition("=")
        rows = (next(lines).split() for _ in range(int(value.split()[0]))) if key.strip() in ("NELEM", "NPOIN") else ()
        if key.strip() == "NDIME":
            dim, first = int(value), len(points)
        elif key.strip() == "NPOIN":
            points += [(list(map(float, row[:dim])) + [0.0])[:3] for row in rows]
        for row in rows:
            name = VTK_TYPES[int(row[0])]
            n = SHAPES[name].n_corners if name in SHAPES else 2
            cells.setdefault(name, []).append([first + int(node) for node in row[1:1 + n]])
    return Mesh(np.array(points), [(name, np.array(block, np.int64)) for name, block in cells.items()])


def _stl(path):
    """Equal points are one node, and nodes come as in the file: meshio sorts them."""
    content = pathlib.Path(path).read_bytes()
    if is_text(content):
        places = np.array([line.split()[1:] for line in content.splitlines() if line.split()[:1] == [b"vertex"]], float)
    else:
        rows = np.frombuffer(content[84:], np.dtype([("normal", "<f4", 3), ("corners", "<f4", 9), ("attribute", "<u2")]))
        places = rows["corners"].reshape(-1, 3)
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return Mesh(places[np.sort(first)], [("triangle", rank[number.ravel()].reshape(-1, 3))])


def _by_gmsh(path):
    import gmsh  # pylint: disable=import-outside-toplevel # slow, and few files need it
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Verbosity", 0)
        gmsh.open(str(path))
        tags, points, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        number = np.zeros(int(tags.max()) + 1, np.int64)
        number[tags[order]] = np.arange(len(tags))
        blocks = []
        for dim, entity in gmsh.model.getEntities():
            for kind, _, nodes in zip(*gmsh.model.mesh.getElements(dim, entity)):
                if int(kind) not in GMSH_TYPES:
                    raise NotRead(f"Gmsh's type {kind}")
                name = GMSH_TYPES[int(kind)]
                n = gmsh.model.mesh.getElementProperties(kind)[3]
                cells = number[nodes.astype(np.int64)].reshape(-1, n)
                blocks.append((name, cells[:, GMSH_ORDER.get(name, range(n))]))
        return Mesh(points.reshape(-1, 3)[order], blocks)
    finally:
        gmsh.finalize()


READERS = {".stl": (_stl,), ".su2": (_su2,), ".vtk": (_by_meshio, _by_vtk), ".mesh": (_mfem, _by_gmsh),
           **dict.fromkeys((".exo", ".e", ".ex2", ".exii", ".exoii", ".g", ".gen", ".genesis"), (_exodus,))}


# ---- bytes ---------------------------------------------------------------------------------------------


def _number(token):
    try:
        return float(re.sub(rb"(?i)d", b"e", token))
    except ValueError:
        return None


def changed_numbers(before, after):
    """Pairs of numbers that differ between two texts, as a set; a sentence if anything else differs."""
    if before == after:
        return set()
    old, new = (re.split(rb"([\s,;()\[\]]+)", text) for text in (before, after))
    if len(old) != len(new):
        return "the text has another number of words"
    found = set()
    for i, (a, b) in enumerate(zip(old, new)):
        if a != b:
            pair = _number(a), _number(b)
            if i % 2 or None in pair:
                return f"{a[:30]!r} became {b[:30]!r}"
            found.add(pair)
    return found


def is_text(content):
    return b"\0" not in content


def changes(path, before, after, points, moved):
    """What is wrong with the bytes that changed, or None. points: those of the mesh before; moved: after."""
    if before == after:
        return None
    if path.suffix in PACKED:
        return None
    if not is_text(before):
        if len(before) != len(after):
            return f"the file has {len(after)} bytes instead of {len(before)}"
        n_bytes = int((np.frombuffer(before, np.uint8) != np.frombuffer(after, np.uint8)).sum())
        most = points.dtype.itemsize * int((points != moved).sum())
        if path.suffix != ".stl" and n_bytes > most:
            return f"{n_bytes} bytes changed, those of moved coordinates are {most}"
        return None
    if path.suffix in COLUMNS:
        if before.count(b"\n") != after.count(b"\n"):
            return "the text has another number of lines"
        return None
    pairs = changed_numbers(before, after)
    if isinstance(pairs, str) or path.suffix == ".stl":
        return pairs if isinstance(pairs, str) else None
    kind = points.dtype.type
    pairs = {(float(kind(a)), float(kind(b))) for a, b in pairs}
    differ = points != moved
    wanted = set(zip(points[differ].astype(float).tolist(), moved[differ].astype(float).tolist()))
    extra = pairs - wanted - {(a, b) for a, b in pairs if a == b}
    if extra:
        return f"a number that is no moved coordinate changed: {sorted(extra)[0]}"
    return None
