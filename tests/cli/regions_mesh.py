"""Write a box of 6 unit cubes (squares) a side, cut into tetrahedra (triangles), inner nodes off their
places, with arrays of cells.

usage: regions_mesh.py DIM FILE HOW NAME:TYPE:RULE ...

HOW: of FILE.vtk ascii, binary, field or binary-field; of FILE.vtu ascii, base64, packed, raw or
pieces; of FILE.vtkhdf anything; of FILE.msh (2.2, two entities) ascii or binary. TYPE: int8 ..
uint64, float32, float64. RULE: the values (below). A line or triangle beside the elements has a
value of its own in each array.
"""
import base64
import itertools
import random
import struct
import sys
import zlib

SIDE = 6
CODES = {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I",
         "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}
LEGACY = {"int8": "char", "uint8": "unsigned_char", "int16": "short", "uint16": "unsigned_short",
          "int32": "int", "uint32": "unsigned_int", "int64": "vtktypeint64",
          "uint64": "vtktypeuint64", "float32": "float", "float64": "double"}
RULES = {
    "halves": lambda i, low: 3 + (low[0] >= SIDE // 2),
    "quarters": lambda i, low: low[1] >= SIDE // 2,
    "number": lambda i, low: i,
    "same": lambda i, low: 4,
    "parity": lambda i, low: i % 2,
    "fraction": lambda i, low: 0.5 + (low[0] >= SIDE // 2),
    "huge": lambda i, low: 2 ** 53 + (low[0] >= SIDE // 2),
    "negative": lambda i, low: -100000 * (low[0] >= SIDE // 2) - 1,
    "one_nan": lambda i, low: float("nan") if i == 50 else low[0] >= SIDE // 2,
}


def make(dim):
    n = SIDE + 1
    points = [list(p) for p in itertools.product(range(n), repeat=dim)]
    cells, lows = [], []
    for low in itertools.product(range(SIDE), repeat=dim):
        for order in itertools.permutations(range(dim)):
            at = list(low)
            path = [tuple(at)]
            for axis in order:
                at[axis] += 1
                path.append(tuple(at))
            cells.append([sum(c * n ** (dim - 1 - d) for d, c in enumerate(p)) for p in path])
            lows.append(low)
    draw = random.Random(1)
    for p in points:
        if all(0 < c < SIDE for c in p):
            for d in range(p[0] == SIDE // 2, dim):  # between halves the interface is plane
                p[d] += draw.uniform(-0.12, 0.12)
    return [p + [0] * (3 - dim) for p in points], cells, lows


def numbers_of(array, lows, lower):
    name, kind, rule = array.rsplit(":", 2)
    convert = float if kind.startswith("float") else int
    values = [convert(RULES[rule](i, low)) for i, low in enumerate(lows)]
    strange = [float("nan")] if convert is float else [77]
    return name, kind, strange * lower + values


def text_of(values):
    return "\n".join(repr(v) for v in values) + "\n"


def write_vtk(path, how, points, cells, types, arrays):
    binary = how.startswith("binary")
    with open(path, "wb") as f:
        def put(text):
            f.write(text.encode())

        def numbers(code, values, row=1):
            if binary:
                f.write(struct.pack(">%d%s" % (len(values), code), *values) + b"\n")
            else:
                put("\n".join(" ".join(map(repr, values[i:i + row]))
                              for i in range(0, len(values), row)) + "\n")

        put("# vtk DataFile Version 3.0\nbox\n%s\nDATASET UNSTRUCTURED_GRID\nPOINTS %d double\n"
            % ("BINARY" if binary else "ASCII", len(points)))
        numbers("d", [float(c) for p in points for c in p], 3)
        flat = [v for c in cells for v in [len(c)] + c]
        put("CELLS %d %d\n" % (len(cells), len(flat)))
        numbers("i", flat)
        put("CELL_TYPES %d\n" % len(cells))
        numbers("i", types)
        put("CELL_DATA %d\n" % len(cells))
        put("SCALARS of_words float 3\nLOOKUP_TABLE default\n")
        numbers("f", [1.0] * (3 * len(cells)), 3)
        if "field" in how:
            put("FIELD data %d\n" % len(arrays))
        for name, kind, values in arrays:
            name = name.replace(" ", "%20")
            put("%s 1 %d %s\n" % (name, len(values), LEGACY[kind]) if "field" in how else
                "SCALARS %s %s 1\nLOOKUP_TABLE default\n" % (name, LEGACY[kind]))
            numbers(CODES[kind], values)


class Vtu:
    """One piece or two of the elements, the numbers of arrays in any form."""

    def __init__(self, how):
        self.how, self.appended = how, b""

    def array(self, name, kind, values, width=1):
        head = '<DataArray type="%s" Name="%s" NumberOfComponents="%d"' % (
            {"u": "UInt", "i": "Int", "f": "Float"}[kind[0]] + kind.strip("uintfloa"), name, width)
        data = struct.pack("<%d%s" % (len(values), CODES[kind]), *values)
        if self.how in ("ascii", "pieces"):
            return '%s format="ascii">\n%s</DataArray>\n' % (head, text_of(values))
        if self.how == "raw":
            offset = len(self.appended)
            self.appended += struct.pack("<I", len(data)) + data
            return '%s format="appended" offset="%d"/>\n' % (head, offset)
        if self.how == "packed":
            packed = zlib.compress(data)
            text = base64.b64encode(struct.pack("<4I", 1, len(data), len(data), len(packed)))
            text += base64.b64encode(packed)
        else:
            text = base64.b64encode(struct.pack("<I", len(data)) + data)
        return '%s format="binary">%s</DataArray>\n' % (head, text.decode())

    def piece(self, points, cells, types, arrays):
        ends = list(itertools.accumulate(len(c) for c in cells))
        text = '<Piece NumberOfPoints="%d" NumberOfCells="%d">\n<Points>%s</Points>\n<Cells>%s%s%s' \
            "</Cells>\n<CellData>%s" % (
                len(points), len(cells),
                self.array("Points", "float64", [float(c) for p in points for c in p], 3),
                self.array("connectivity", "int64", [v for c in cells for v in c]),
                self.array("offsets", "int64", ends), self.array("types", "uint8", types),
                self.array("of words", "float64", [0.5] * (3 * len(cells)), 3))
        return text + "".join(self.array(*a_swap) for a_swap in arrays) + "</CellData>\n</Piece>\n"


def write_vtu(path, how, points, cells, types, arrays):
    v = Vtu(how)
    packer = ' compressor="vtkZLibDataCompressor"' if how == "packed" else ""
    body = v.piece(points, cells, types, [(n, k, values) for n, k, values in arrays])
    if how == "pieces":  # a second one that touches nothing, and an empty one before
        copy = [[c + 20.0 for c in p[:2]] + [p[2]] for p in points]
        body = v.piece([], [], [], []) + body + v.piece(
            copy, cells, types, [(n, k, values) for n, k, values in reversed(arrays)])
    with open(path, "wb") as f:
        f.write(('<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"%s>\n'
                 "<UnstructuredGrid>\n%s</UnstructuredGrid>\n" % (packer, body)).encode())
        if how == "raw":
            f.write(b'<AppendedData encoding="raw">\n_' + v.appended + b"\n</AppendedData>\n")
        f.write(b"</VTKFile>\n")


def write_vtkhdf(path, points, cells, types, arrays):
    import h5py
    import numpy
    with h5py.File(path, "w") as f:
        g = f.create_group("VTKHDF")
        g.attrs["Version"] = numpy.array([1, 0])
        g.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        flat = [v for c in cells for v in c]
        ends = [0] + list(itertools.accumulate(len(c) for c in cells))
        for name, values in (("NumberOfPoints", [len(points)]), ("NumberOfCells", [len(cells)]),
                             ("NumberOfConnectivityIds", [len(flat)]), ("Connectivity", flat),
                             ("Offsets", ends)):
            g[name] = numpy.array(values, dtype=numpy.int64)
        g["Types"] = numpy.array(types, dtype=numpy.uint8)
        g["Points"] = numpy.array(points, dtype=float)
        data = g.create_group("CellData")
        data["of words"] = numpy.full((len(cells), 3), 0.5)
        for name, kind, values in arrays:
            data[name] = numpy.array(values, dtype=kind)


def write_msh(path, how, points, cells, entities, arrays):
    binary = how == "binary"
    with open(path, "wb") as f:
        def put(text):
            f.write(text.encode())

        def row(code, *values):
            if binary:
                f.write(struct.pack("<" + code, *values))
            else:
                put(" ".join(map(repr, values)) + "\n")

        put("$MeshFormat\n2.2 %d 8\n" % binary)
        if binary:
            f.write(struct.pack("<i", 1) + b"\n")
        put("$EndMeshFormat\n$Nodes\n%d\n" % len(points))
        for i, p in enumerate(points):
            row("iddd", i + 1, *map(float, p))
        put("\n$EndNodes\n$Elements\n%d\n" % len(cells))
        for i, c in enumerate(cells):
            kind = {2: 1, 3: 2, 4: 4}[len(c)]
            nodes = [v + 1 for v in c]
            if binary:
                row("iii", kind, 1, 2)
                row("%di" % (3 + len(c)), i + 1, 0, entities[i], *nodes)
            else:
                row("", i + 1, kind, 2, 0, entities[i], *nodes)
        put("\n$EndElements\n")
        for name, kind, values in arrays:
            put('$ElementData\n1\n"%s"\n1\n0.0\n3\n0\n1\n%d\n' % (name, len(values)))
            for i, v in enumerate(values):
                row("id", i + 1, float(v))
            put("\n$EndElementData\n")


def main():
    dim, path, how = int(sys.argv[1]), sys.argv[2], sys.argv[3]
    points, cells, lows = make(dim)
    lower = [[0, 1], [1, 2]] if dim == 2 else [[0, 1, 8], [1, 8, 2]]
    arrays = [numbers_of(a, lows, len(lower)) for a in sys.argv[4:]]
    types = [3 if dim == 2 else 5] * len(lower) + [5 if dim == 2 else 10] * len(cells)
    cells = lower + cells
    if path.endswith(".vtk"):
        write_vtk(path, how, points, cells, types, arrays)
    elif path.endswith(".msh"):
        entities = [1] * len(lower) + [1 + RULES["quarters"](0, low) for low in lows]
        write_msh(path, how, points, cells, entities, arrays)
    elif path.endswith(".vtu"):
        write_vtu(path, how, points, cells, types, arrays)
    else:
        write_vtkhdf(path, points, cells, types, arrays)


main()
