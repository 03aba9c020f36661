"""exodus_mesh: Exodus files, made without planish and without the netCDF library.

exodus_mesh.py from MESH.msh OUT.exo              the tetrahedra and triangles of a Gmsh file of MSH 2.2 (text), with sets
exodus_mesh.py netcdf4 MESH.msh PLAIN.e PACKED.e  the same as netCDF-4
exodus_mesh.py types FOLDER                       a file for each type of element, bent; as netCDF-4, too, if h5py is there.
                                                  Prints their names
exodus_mesh.py compare FILE.exo COPY.vtu ...      VTK reads the same elements in both
exodus_mesh.py written GROUPS.e DATA.e             VTK, the Exodus library and netCDF's read converted files: blocks, sets,
                                                  values
exodus_mesh.py sides FILE.e COPY.vtu ...          the side sets that VTK reads are the facets of the copies
exodus_mesh.py same BEFORE.exo AFTER.exo ...      VTK reads the same, but for the places of nodes inside
"""
import collections
import itertools
import os
import struct
import sys

TEXT, INT, DOUBLE = 2, 4, 6
TIME = "time_whole", DOUBLE, ("time_step",), [], None


class File:
    """Dimensions and variables of an Exodus file."""

    def __init__(self, points, version=2):
        self.version = version
        self.dims = {"len_string": 33, "len_name": 33, "len_line": 81, "four": 4, "num_dim": len(points[0]),
                     "num_nodes": len(points), "time_step": 0}
        self.variables = []
        self.n_elements = self.n_blocks = 0
        for axis, values in zip("xyz", zip(*points)):
            self.put("coord" + axis, DOUBLE, ("num_nodes",), values)

    def put(self, name, kind, dims, values, elem_type=None):
        self.variables.append((name, kind, dims, list(values), elem_type))

    def put_names(self, name, dim, names):
        self.put(name, TEXT, (dim, "len_name"), b"".join(n.encode().ljust(33, b"\0") for n in names))

    def put_blocks(self, blocks):
        """blocks: (number, name, type, elements by numbers of nodes from 1)."""
        self.dims.update(num_elem=sum(len(b[3]) for b in blocks), num_el_blk=len(blocks))
        self.put("eb_prop1", INT, ("num_el_blk",), [b[0] for b in blocks])
        self.put_names("eb_names", "num_el_blk", [b[1] for b in blocks])
        for k, (_, _, kind, elements) in enumerate(blocks, 1):
            dims = "num_el_in_blk%d" % k, "num_nod_per_el%d" % k
            self.dims.update({dims[0]: len(elements), dims[1]: len(elements[0])})
            self.put("connect%d" % k, INT, dims, itertools.chain(*elements), kind)

    def put_sets(self, prefix, sets):
        """prefix: ns or ss; sets: (number, name, nodes) or (number, name, (element, side) of each)."""
        dim, lists = ("num_node_sets", ("node_ns",)) if prefix == "ns" else ("num_side_sets", ("elem_ss", "side_ss"))
        self.dims[dim] = len(sets)
        self.put(prefix + "_prop1", INT, (dim,), [s[0] for s in sets])
        self.put_names(prefix + "_names", dim, [s[1] for s in sets])
        for k, (_, _, members) in enumerate(sets, 1):
            length = "num_%s%d" % ("nod_ns" if prefix == "ns" else "side_ss", k)
            self.dims[length] = len(members)
            rows = [members] if prefix == "ns" else zip(*members)
            for name, values in zip(lists, rows):
                self.put("%s%d" % (name, k), INT, (length,), values)

    def classic(self):
        """The bytes of a netCDF file: CDF-1, CDF-2 or CDF-5."""
        wide = ">q" if self.version == 5 else ">i"

        def padded(data):
            return data + b"\0" * (-len(data) % 4)

        def name(text):
            return struct.pack(wide, len(text)) + padded(text.encode())

        def listed(tag, items):
            return struct.pack(">i", tag if items else 0) + struct.pack(wide, len(items)) + b"".join(items)

        def attribute(key, value):
            if isinstance(value, str):
                return name(key) + struct.pack(">i", TEXT) + name(value)
            return name(key) + struct.pack(">i", 4 if isinstance(value, int) else 5) + struct.pack(wide, 1) + \
                struct.pack(">i" if isinstance(value, int) else ">f", value)

        order = list(self.dims)
        variables = self.variables + [TIME]  # what is by time steps comes last
        data = []
        for _, kind, _, values, _ in variables:
            data.append(padded(bytes(values) if kind == TEXT else
                               struct.pack(">%d%s" % (len(values), "i" if kind == INT else "d"), *values)))

        def header(begins):
            rows = []
            for (key, kind, dims, _, elem_type), values, begin in zip(variables, data, begins):
                rows.append(name(key) + struct.pack(wide, len(dims)) +
                            b"".join(struct.pack(wide, order.index(d)) for d in dims) +
                            listed(12, [attribute("elem_type", elem_type)] if elem_type else []) +
                            struct.pack(">i", kind) + struct.pack(wide, len(values) if self.dims[dims[0]] else 8) +
                            struct.pack(">i" if self.version == 1 else ">q", begin))
            head = {"api_version": 8.11, "version": 8.11, "floating_point_word_size": 8, "file_size": 1, "title": "planish"}
            return (b"CDF" + bytes([self.version]) + struct.pack(wide, 0) +
                    listed(10, [name(d) + struct.pack(wide, n) for d, n in self.dims.items()]) +
                    listed(12, [attribute(k, v) for k, v in head.items()]) + listed(11, rows))

        at = len(header([0] * len(data)))
        begins = list(itertools.accumulate((len(d) for d in data), initial=at))
        return header(begins) + b"".join(data)

    def netcdf4(self, path, packed):
        """Write a netCDF-4 file: HDF5 with dimension scales."""
        import h5py
        import numpy as np
        kinds = {TEXT: "S1", INT: "<i4", DOUBLE: "<f8"}
        with h5py.File(path, "w", libver=("earliest", "v110"), track_order=True) as file:
            for k, v in dict(api_version=8.11, version=8.11, floating_point_word_size=8, file_size=1).items():
                file.attrs.create(k, np.array([v], dtype="<i4" if isinstance(v, int) else "<f4"))
            for k, (dim, n) in enumerate(self.dims.items()):
                scale = file.create_dataset(dim, (n,), dtype=">f4", maxshape=(None,) if n == 0 else None)
                scale.make_scale("This is a netCDF dimension but not a netCDF variable. %9d" % n)
                scale.attrs["_Netcdf4Dimid"] = np.int32(k)
            for key, kind, dims, values, elem_type in self.variables + [TIME]:
                shape = [self.dims[d] for d in dims]
                array = (np.frombuffer(bytes(values), dtype="S1") if kind == TEXT else np.array(values, dtype=kinds[kind]))
                options = dict(compression=4, shuffle=True) if packed and kind != TEXT and len(values) else {}
                made = file.create_dataset(key, data=array.reshape(shape), dtype=kinds[kind],
                                           maxshape=[None if n == 0 else n for n in shape], **options)
                if elem_type:
                    made.attrs.create("elem_type", elem_type, dtype="S%d" % len(elem_type))
                for i, d in enumerate(dims):
                    made.dims[i].attach_scale(file[d])


# ---- types of elements ---------------------------------------------------------------------------------------------

CORNERS = {"TRI": [(0, 0, 0), (1, 0, 0), (0, 1, 0)], "QUAD": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
           "TETRA": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
           "PYRAMID": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (.5, .5, 1)],
           "WEDGE": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
           "HEX": [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]}
CORNERS["SHELL"] = CORNERS["QUAD"]
# The corners, from 1, that further nodes are in the middle of.
WEDGE15 = "12 23 31 14 25 36 45 56 64"
HEX20 = "12 23 34 41 15 26 37 48 56 67 78 85"
TYPES = {"TRI3": "", "TRI6": "12 23 31", "QUAD4": "", "QUAD8": "12 23 34 41", "QUAD9": "12 23 34 41 1234", "SHELL4": "",
         "TETRA4": "", "TETRA10": "12 23 31 14 24 34", "PYRAMID5": "", "PYRAMID13": "12 23 34 41 15 25 35 45",
         "WEDGE6": "", "WEDGE15": WEDGE15, "WEDGE18": WEDGE15 + " 1254 2365 3146", "HEX8": "", "HEX20": HEX20,
         "HEX27": HEX20 + " 12345678 1234 5678 4158 2376 1265 3487"}


def nodes_of(kind):
    corners = CORNERS[kind.rstrip("0123456789")]
    for middle in TYPES[kind].split():
        rows = [corners[int(c) - 1] for c in middle]
        yield tuple(sum(r[d] for r in rows) / len(rows) for d in range(3))


def bent(p):
    x, y, z = p
    return x + .11 * y * y - .07 * z * z + .03 * x * z, y + .09 * x * z - .05 * x * x, z + .08 * x * y + .04 * y * y


def of_type(kind):
    """A file of two elements of a type, that far apart that they have no node together."""
    first = CORNERS[kind.rstrip("0123456789")] + list(nodes_of(kind))
    is_flat = kind[:2] in ("TR", "QU", "SH")
    places = [bent(p) for p in first] + [bent((x + 3, y, z)) for x, y, z in first]
    n = len(first)
    file = File([(p[0], p[1]) if is_flat else p for p in places], 5 if n % 2 else 1)
    name = kind.rstrip("0123456789") if n < 9 else kind.lower()
    file.put_blocks([(7, "", name if "SHELL" not in kind else kind, [range(1, n + 1), range(n + 1, 2 * n + 1)])])
    return file


def write_types(folder):
    for kind in TYPES:
        file = of_type(kind)
        path = os.path.join(folder, kind + ".exo")
        with open(path, "wb") as out:
            out.write(file.classic())
        print(path)
        try:
            file.netcdf4(path + ".e", kind in ("TETRA4", "HEX20"))
            print(path + ".e")
        except ImportError:
            pass


# ---- VTK -----------------------------------------------------------------------------------------------------------

def cells_of(path):
    """Count the elements of the highest dimension, as VTK reads them, by their types and places as floats."""
    import vtk
    vtk.vtkObject.GlobalWarningDisplayOff()
    is_copy = path.endswith(".vtu")
    reader = vtk.vtkXMLUnstructuredGridReader() if is_copy else vtk.vtkExodusIIReader()
    reader.SetFileName(path)
    if not is_copy:
        reader.ApplyDisplacementsOff()
    reader.Update()
    found = collections.Counter()

    def walk(data):
        if data and data.IsA("vtkMultiBlockDataSet"):
            for i in range(data.GetNumberOfBlocks()):
                walk(data.GetBlock(i))
        elif data:
            for i in range(data.GetNumberOfCells()):
                cell = data.GetCell(i)
                ids = [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())]
                places = [struct.unpack("f", struct.pack("f", x))[0] + 0. for k in ids for x in data.GetPoint(k)]
                found[cell.GetCellDimension(), data.GetCellType(i), tuple(places)] += 1
    walk(reader.GetOutput() if is_copy else reader.GetOutput().GetBlock(0))
    most = max(found, default=(0,))[0]
    return collections.Counter({key: n for key, n in found.items() if key[0] == most})


def compare(paths):
    for exodus, copy in zip(paths[::2], paths[1::2]):
        expected, got = cells_of(exodus), cells_of(copy)
        if not expected or expected != got:
            sys.exit("%s: VTK reads %s, planish %s" % (exodus, sorted(expected), sorted(got)))


def same(paths):
    for before, after in zip(paths[::2], paths[1::2]):
        a, b = cells_of(before), cells_of(after)
        if len(a) < 2 or sum(a.values()) != sum(b.values()) or a == b or not a & b:
            sys.exit("%s: %d elements, %d then, %d the same" % (before, sum(a.values()), sum(b.values()), len(a & b)))


def facets_of(path):
    """The facets that VTK reads, by the places of their corners in any order: of side sets, or cells of a copy."""
    import vtk
    is_copy = path.endswith(".vtu")
    reader = vtk.vtkXMLUnstructuredGridReader() if is_copy else vtk.vtkExodusIIReader()
    reader.SetFileName(path)
    if not is_copy:
        reader.UpdateInformation()
        for i in range(reader.GetNumberOfObjects(reader.SIDE_SET)):
            reader.SetObjectStatus(reader.SIDE_SET, i, 1)
    reader.Update()
    sets = [reader.GetOutput()] if is_copy else [reader.GetOutput().GetBlock(4).GetBlock(i) for i in
                                                 range(reader.GetOutput().GetBlock(4).GetNumberOfBlocks())]
    found = collections.Counter()
    for data in sets:
        most = max(data.GetCell(i).GetCellDimension() for i in range(data.GetNumberOfCells()))
        for i in range(data.GetNumberOfCells()):
            cell = data.GetCell(i)
            if cell.GetCellDimension() == most - is_copy:
                places = [struct.pack("3f", *(x + 0. for x in data.GetPoint(cell.GetPointId(k))))
                          for k in range(cell.GetNumberOfPoints())]
                found[tuple(sorted(places))] += 1
    return found


def sides(paths):
    for exodus, copy in zip(paths[::2], paths[1::2]):
        expected, got = facets_of(copy), facets_of(exodus)
        if not expected or expected != got:
            sys.exit("%s: VTK reads %d sides, %d of them facets of the mesh, which has %d" % (
                exodus, sum(got.values()), sum((expected & got).values()), sum(expected.values())))


def written(groups, data):
    import vtk
    reader = vtk.vtkExodusIIReader()
    reader.SetFileName(groups)
    reader.UpdateInformation()
    for kind in reader.SIDE_SET, reader.NODE_SET:
        for i in range(reader.GetNumberOfObjects(kind)):
            reader.SetObjectStatus(kind, i, 1)
    reader.Update()
    names = [reader.GetObjectName(reader.ELEM_BLOCK, i).split(" ID:")[0]
             for i in range(reader.GetNumberOfObjects(reader.ELEM_BLOCK))]
    assert names == ["lower part", "upper part"], names
    sides = reader.GetOutput().GetBlock(4).GetBlock(0)
    assert reader.GetObjectName(reader.SIDE_SET, 0).startswith("skin"), reader.GetObjectName(reader.SIDE_SET, 0)
    assert sides.GetNumberOfCells() == 308, sides.GetNumberOfCells()
    if hasattr(vtk, "vtkIOSSReader"):  # by the Exodus library
        reader = vtk.vtkIOSSReader()
        reader.AddFileName(groups)
        reader.UpdateInformation()
        blocks = reader.GetEntitySelection(reader.ELEMENTBLOCK)
        names = [blocks.GetArrayName(i).replace("_", " ") for i in range(blocks.GetNumberOfArrays())]
        assert names == ["lower part", "upper part"], names
    try:
        import netCDF4
    except ImportError:
        return
    for path in groups, data:
        with netCDF4.Dataset(path) as file:
            assert file.data_model == "NETCDF3_64BIT_OFFSET" and file.file_size == 1, file.data_model
            for variable in file.variables.values():
                variable[:]


# ---- a mesh of Gmsh ------------------------------------------------------------------------------------------------

def from_gmsh(path):
    """A file of the volumes as blocks, the surfaces as side sets, and a node set, with the names of physical groups."""
    lines = iter(open(path))
    names, blocks, facets = {}, collections.defaultdict(list), collections.defaultdict(list)
    for line in lines:
        if line.startswith("$PhysicalNames"):
            for _ in range(int(next(lines))):
                dim, number, name = next(lines).split(None, 2)
                names[int(dim), int(number)] = name.strip().strip('"')
        elif line.startswith("$Nodes"):
            points = [tuple(map(float, next(lines).split()[1:])) for _ in range(int(next(lines)))]
        elif line.startswith("$Elements"):
            for _ in range(int(next(lines))):
                _, kind, n_tags, physical, *rest = map(int, next(lines).split())
                nodes = rest[n_tags - 1:]
                if kind == 4:
                    blocks[physical].append(nodes)
                elif kind == 2:
                    facets[physical].append(frozenset(nodes))
    side = {}
    number = 0
    for _, elements in sorted(blocks.items()):
        for a, b, c, d in elements:
            number += 1
            for k, corners in enumerate(((a, b, d), (b, c, d), (a, d, c), (a, c, b)), 1):
                side[frozenset(corners)] = number, k
    file = File(points)
    file.put_blocks([(k, names.get((3, k), ""), "TETRA4", e) for k, e in sorted(blocks.items())])
    file.put_sets("ns", [(1, "corner", [1])])
    file.put_sets("ss", [(k, names.get((2, k), ""), [side[f] for f in s]) for k, s in sorted(facets.items())])
    return file


if __name__ == "__main__":
    command, *arguments = sys.argv[1:]
    if command == "from":
        with open(arguments[1], "wb") as out:
            out.write(from_gmsh(arguments[0]).classic())
    elif command == "netcdf4":
        for k in (1, 2):
            from_gmsh(arguments[0]).netcdf4(arguments[k], k == 2)
    elif command == "types":
        write_types(*arguments)
    elif command == "compare":
        compare(arguments)
    elif command == "sides":
        sides(arguments)
    elif command == "written":
        written(*arguments)
    else:
        same(arguments)
