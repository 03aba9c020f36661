"""Files in HDF5 by meshio and h5py.

    convert_hdf5.py make MESH     plain.med and *.vtkhdf in this folder
    convert_hdf5.py compare A B   all data but coordinates, all attributes and their storage are the
                                  same, and coordinates have changed
"""
import sys

import h5py
import meshio
import numpy


def vtkhdf(name, mesh, real, **storage):
    """A grid in one partition; storage: of its points."""
    blocks = [b for b in mesh.cells if b.type in ("tetra", "triangle")]
    types = numpy.concatenate(
        [numpy.full(len(b.data), {"tetra": 10, "triangle": 5}[b.type], "u1") for b in blocks])
    sizes = numpy.concatenate([numpy.full(len(b.data), b.data.shape[1]) for b in blocks])
    nodes = numpy.concatenate([b.data.ravel() for b in blocks]).astype("i8")
    with h5py.File(name, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"] = numpy.array([1, 0])
        group.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        group["NumberOfPoints"] = numpy.array([len(mesh.points)])
        group["NumberOfCells"] = numpy.array([len(types)])
        group["NumberOfConnectivityIds"] = numpy.array([len(nodes)])
        group.create_dataset("Points", data=mesh.points.astype(real), **storage)
        group.create_dataset("Connectivity", data=nodes)
        group.create_dataset("Types", data=types)
        group.create_dataset("Offsets", data=numpy.concatenate([[0], numpy.cumsum(sizes)]))
        group.create_dataset("CellData/quality", data=numpy.arange(len(types)) / 7)
        group.create_dataset("PointData/heat", data=mesh.points[:, 0] ** 2, compression="gzip")


def make(path):
    mesh = meshio.read(path)
    chunk = (max(1, len(mesh.points) // 5), 3)
    cells = [(kind, numpy.concatenate([b.data for b in mesh.cells if b.type == kind]))
             for kind in ("tetra", "triangle")]
    mesh = meshio.Mesh(mesh.points, cells)
    meshio.write("plain.med", mesh)
    vtkhdf("plain.vtkhdf", mesh, "f8")
    vtkhdf("chunked.vtkhdf", mesh, "f8", chunks=chunk)
    vtkhdf("single.vtkhdf", mesh, "f4", chunks=chunk)
    vtkhdf("packed.vtkhdf", mesh, "f8", chunks=chunk, compression="gzip", shuffle=True)


def describe(path):
    """All objects of a file: their attributes and, of data, type, storage and values."""
    objects = {}

    def visit(name, item):
        attributes = {key: repr(value) for key, value in item.attrs.items()}
        if isinstance(item, h5py.Dataset):
            kind = (item.dtype.str, item.chunks, item.compression, item.shuffle)
            objects[name] = (attributes, kind, item[()])
        else:
            objects[name] = (attributes, None, None)

    with h5py.File(path) as file:
        file.visititems(visit)
    return objects


def compare(first, second):
    a, b = describe(first), describe(second)
    assert a.keys() == b.keys(), "other objects"
    for name, (attributes, kind, values) in a.items():
        assert attributes == b[name][0] and kind == b[name][1], name
        same = numpy.array_equal(values, b[name][2])
        is_moved = name.endswith(("/Points", "/COO"))
        assert same != is_moved, name
    if first.endswith(".med"):
        old, new = meshio.read(first), meshio.read(second)
        assert all(numpy.array_equal(x.data, y.data) for x, y in zip(old.cells, new.cells))


if sys.argv[1] == "make":
    make(sys.argv[2])
else:
    compare(sys.argv[2], sys.argv[3])
