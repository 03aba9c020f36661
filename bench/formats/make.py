#!/usr/bin/env python3
"""make: the mesh in the formats that Gmsh does not write.   make.py MESH FOLDER"""
import os
import shutil
import sys

import h5py
import meshio
import netCDF4
import numpy as np

CORNERS = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])  # of faces whose normals leave a tetrahedron


def vtkhdf(path, points, tetrahedra):
    """A VTKHDF file of one partition."""
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Version"] = [1, 0]
        group.attrs.create("Type", b"UnstructuredGrid", dtype="S16")
        n = len(tetrahedra)
        group["NumberOfPoints"] = [len(points)]
        group["NumberOfCells"] = [n]
        group["NumberOfConnectivityIds"] = [4 * n]
        group["Points"] = points
        group["Connectivity"] = tetrahedra.ravel()
        group["Offsets"] = np.arange(0, 4 * n + 1, 4)
        group["Types"] = np.full(n, 10, dtype=np.uint8)


def number(rows):
    """The different rows, as they first come, and which of these each row is."""
    key = np.sort(rows, axis=1)
    _, first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rows[first[order]], rank[which.ravel()]


def dmplex(path, points, tetrahedra):
    """A mesh with faces and edges as DMView of PETSc 3.18 writes it."""
    corners = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [2, 1, 3]])
    wanted = tetrahedra[:, corners].reshape(-1, 3)
    faces, face_of = number(wanted)
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, edge_of = number(sides)
    # An element goes round its face from node o on, or backwards, from node 1 - o on.
    turn = (faces[face_of] == wanted[:, :1]).argmax(axis=1)
    is_back = faces[face_of, (turn + 1) % 3] != wanted[:, 1]
    turn = np.where(is_back, -((turn - 2) % 3) - 1, turn)
    n = len(tetrahedra), len(points), len(faces), len(edges)
    begin = np.cumsum((0, *n))
    zero = np.zeros(len(edges) * 2, "i4")
    sizes = np.repeat(np.array([4, 0, 3, 2], "i4"), n)
    cones = np.concatenate([face_of + begin[2], edge_of + begin[3], edges.ravel() + begin[1]])
    turns = np.concatenate([turn, np.where(edges[edge_of, 0] == sides[:, 0], 0, -1), zero])
    with h5py.File(path, "w") as file:
        topology = file.create_group("topology")
        for name, data in (("order", np.arange(begin[-1])), ("cones", sizes), ("cells", cones),
                           ("orientation", turns)):
            topology.create_dataset(name, data=data.astype("i4")[:, None], chunks=(len(data), 1))
        topology["cells"].attrs["cell_dim"] = 3
        file.create_dataset("geometry/vertices", data=points, chunks=points.shape)
        file.create_group("labels")


def mfem(path, points, tetrahedra):
    """An MFEM mesh without boundary elements."""
    n = len(tetrahedra)
    with open(path, "w") as file:
        file.write("MFEM mesh v1.0\n\ndimension\n3\n\nelements\n%d\n" % n)
        np.savetxt(file, np.hstack([np.full((n, 1), 1), np.full((n, 1), 4), tetrahedra]), fmt="%d")
        file.write("\nboundary\n0\n\nvertices\n%d\n3\n" % len(points))
        np.savetxt(file, points, fmt="%.16g")


def exodus(path, points, tetrahedra, kind):
    """An Exodus file of one block; kind is the format of netCDF."""
    with netCDF4.Dataset(path, "w", format=kind) as file:
        file.api_version = file.version = np.float32(8.11)
        file.floating_point_word_size = np.int32(8)
        for name, size in (("num_dim", 3), ("num_nodes", len(points)), ("num_elem", len(tetrahedra)),
                           ("num_el_blk", 1), ("num_el_in_blk1", len(tetrahedra)), ("num_nod_per_el1", 4)):
            file.createDimension(name, size)
        file.createVariable("eb_prop1", "i4", ("num_el_blk",))[:] = 1
        connect = file.createVariable("connect1", "i4", ("num_el_in_blk1", "num_nod_per_el1"))
        connect.elem_type = "TETRA4"
        connect[:] = tetrahedra + 1
        for axis, values in zip("xyz", points.T):
            file.createVariable("coord" + axis, "f8", ("num_nodes",))[:] = values


def numbered(*columns):
    """The columns behind numbers from 1."""
    rows = np.column_stack(columns)
    return np.column_stack([np.arange(1, len(rows) + 1), rows])


def ucd(path, points, tetrahedra):
    with open(path, "w") as file:
        file.write("%d %d 0 0 0\n" % (len(points), len(tetrahedra)))
        np.savetxt(file, numbered(points), fmt="%d %.16g %.16g %.16g")
        np.savetxt(file, numbered(tetrahedra + 1), fmt="%d 1 tet %d %d %d %d")


def ucd_binary(path, points, tetrahedra):
    n = len(tetrahedra)
    with open(path, "wb") as file:
        file.write(b"\7" + np.array([len(points), n, 0, 0, 0, 4 * n], "<i4").tobytes())
        file.write(numbered(np.full(n, 1), np.full(n, 4), np.full(n, 4)).astype("<i4").tobytes())
        file.write((tetrahedra + 1).astype("<i4").tobytes())
        file.write(points.T.astype("<f4").tobytes())


def su2(path, points, tetrahedra):
    n, m = len(points), len(tetrahedra)
    with open(path, "w") as file:
        file.write("NDIME= 3\nNELEM= %d\n" % m)
        np.savetxt(file, np.column_stack([tetrahedra, np.arange(m)]), fmt="10 %d %d %d %d %d")
        file.write("NPOIN= %d\n" % n)
        np.savetxt(file, np.column_stack([points, np.arange(n)]), fmt="%.16g %.16g %.16g %d")
        file.write("NMARK= 0\n")


def unv(path, points, tetrahedra):
    with open(path, "w") as file:
        file.write("    -1\n  2411\n")
        np.savetxt(file, numbered(points), fmt="%10d         1         1        11\n%25.16E%25.16E%25.16E")
        file.write("    -1\n    -1\n  2412\n")
        np.savetxt(file, numbered(tetrahedra + 1),
                   fmt="%10d       111         1         1         7         4\n%10d%10d%10d%10d")
        file.write("    -1\n")


def faces_of(tetrahedra):
    """Faces inside and on the surface, in OpenFOAM's order: nodes, owners, neighbours inside."""
    faces = tetrahedra[:, CORNERS].reshape(-1, 3)
    owner = np.repeat(np.arange(len(tetrahedra)), 4)
    order = np.lexsort((owner, *np.sort(faces, axis=1).T))
    key = np.sort(faces[order], axis=1)
    is_pair = (key[1:] == key[:-1]).all(axis=1)
    first, second = order[:-1][is_pair], order[1:][is_pair]
    is_inside = np.zeros(len(faces), bool)
    is_inside[first] = is_inside[second] = True
    inside = np.lexsort((owner[second], owner[first]))
    first, second, skin = first[inside], second[inside], np.flatnonzero(~is_inside)
    every = np.concatenate([first, skin])
    return faces[every], owner[every], owner[second]


def elmer(path, points, tetrahedra):
    faces, owner, neighbour = faces_of(tetrahedra)
    faces, owner = faces[len(neighbour):] + 1, owner[len(neighbour):] + 1
    with open(path + "/mesh.header", "w") as file:
        file.write("%d %d %d\n2\n504 %d\n303 %d\n" % (len(points), len(tetrahedra), len(faces), len(tetrahedra),
                                                     len(faces)))
    np.savetxt(path + "/mesh.nodes", numbered(points), fmt="%d -1 %.16g %.16g %.16g")
    np.savetxt(path + "/mesh.elements", numbered(tetrahedra + 1), fmt="%d 1 504 %d %d %d %d")
    np.savetxt(path + "/mesh.boundary", numbered(owner, faces), fmt="%d 1 %d 0 303 %d %d %d")


def openfoam(path, points, tetrahedra, is_binary):
    faces, owner, neighbour = faces_of(tetrahedra)

    def write(name, kind, *lists):
        """Each list: its length, its values, the format of a line."""
        with open(f"{path}/{name}", "wb") as file:
            file.write(b'FoamFile\n{\n    version 2.0;\n    format %s;\n    arch "LSB;label=32;scalar=64";\n'
                       b"    class %s;\n    object %s;\n}\n\n"
                       % (b"binary" if is_binary else b"ascii", kind.encode(), name.encode()))
            for n, values, fmt in lists:
                file.write(b"%d\n(" % n)
                if is_binary:
                    file.write(values.astype("<f8" if values.dtype.kind == "f" else "<i4").tobytes())
                else:
                    file.write(b"\n")
                    np.savetxt(file, values, fmt=fmt)
                file.write(b")\n")

    write("points", "vectorField", (len(points), points, "(%.16g %.16g %.16g)"))
    if is_binary:
        write("faces", "faceCompactList", (len(faces) + 1, np.arange(0, faces.size + 1, 3), ""),
              (faces.size, faces.ravel(), ""))
    else:
        write("faces", "faceList", (len(faces), faces, "3(%d %d %d)"))
    write("owner", "labelList", (len(owner), owner, "%d"))
    write("neighbour", "labelList", (len(neighbour), neighbour, "%d"))
    with open(path + "/boundary", "w") as file:
        file.write("FoamFile\n{\n    version 2.0;\n    format ascii;\n    class polyBoundaryMesh;\n"
                   "    object boundary;\n}\n\n1\n(\n    skin\n    {\n        type patch;\n"
                   "        nFaces %d;\n        startFace %d;\n    }\n)\n"
                   % (len(faces) - len(neighbour), len(neighbour)))


def in_folder(write):
    """A writer that fills a new folder and gives it its name when it is whole."""
    def write_folder(path):
        part = os.path.join(os.path.dirname(path), "part-" + os.path.basename(path))
        shutil.rmtree(part, ignore_errors=True)
        os.mkdir(part)
        write(part)
        os.rename(part, path)
    return write_folder


def main():
    source, folder = sys.argv[1:]
    mesh = meshio.read(source)
    cells = [("tetra", np.concatenate([c.data for c in mesh.cells if c.type == "tetra"]))]
    mesh = meshio.Mesh(mesh.points, cells)
    box = mesh.points, cells[0][1].astype("i8")
    writers = {
        "medit.meshb": lambda path: meshio.write(path, mesh),
        "vtu_ascii.vtu": lambda path: meshio.vtu.write(path, mesh, binary=False),
        "vtu_base64.vtu": lambda path: meshio.vtu.write(path, mesh, compression=None),
        "vtu_zlib.vtu": lambda path: meshio.vtu.write(path, mesh),
        "netgen.vol": lambda path: meshio.netgen.write(path, mesh),
        "med.med": lambda path: meshio.med.write(path, mesh),
        "vtkhdf.vtkhdf": lambda path: vtkhdf(path, *box),
        "dmplex.h5": lambda path: dmplex(path, *box),
        "mfem.mfem": lambda path: mfem(path, *box),
        "tetgen.node": lambda path: meshio.tetgen.write(path, mesh),
        "exodus_classic.exo": lambda path: exodus(path, *box, "NETCDF3_64BIT_OFFSET"),
        "exodus_netcdf4.exo": lambda path: exodus(path, *box, "NETCDF4"),
        "ucd_ascii.avs": lambda path: ucd(path, *box),
        "ucd_binary.ucd": lambda path: ucd_binary(path, *box),
        "su2.su2": lambda path: su2(path, *box),
        "unv.unv": lambda path: unv(path, *box),
        "elmer": in_folder(lambda path: elmer(path, *box)),
        "openfoam_ascii": in_folder(lambda path: openfoam(path, *box, False)),
        "openfoam_binary": in_folder(lambda path: openfoam(path, *box, True)),
    }
    for name, write in writers.items():
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            write(path)


if __name__ == "__main__":
    main()
