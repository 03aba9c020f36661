#!/usr/bin/env python3
"""make: the mesh in the formats that Gmsh does not write.   make.py MESH FOLDER"""
import os
import sys

import h5py
import meshio
import numpy as np


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


def main():
    source, folder = sys.argv[1:]
    mesh = meshio.read(source)
    cells = [("tetra", np.concatenate([c.data for c in mesh.cells if c.type == "tetra"]))]
    mesh = meshio.Mesh(mesh.points, cells)
    writers = {
        "medit.meshb": lambda path: meshio.write(path, mesh),
        "vtu_ascii.vtu": lambda path: meshio.vtu.write(path, mesh, binary=False),
        "vtu_base64.vtu": lambda path: meshio.vtu.write(path, mesh, compression=None),
        "vtu_zlib.vtu": lambda path: meshio.vtu.write(path, mesh),
        "netgen.vol": lambda path: meshio.netgen.write(path, mesh),
        "med.med": lambda path: meshio.med.write(path, mesh),
        "vtkhdf.vtkhdf": lambda path: vtkhdf(path, mesh.points, cells[0][1]),
        "dmplex.h5": lambda path: dmplex(path, mesh.points, cells[0][1]),
        "mfem.mfem": lambda path: mfem(path, mesh.points, cells[0][1]),
        "tetgen.node": lambda path: meshio.tetgen.write(path, mesh),
    }
    for name, write in writers.items():
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            write(path)


if __name__ == "__main__":
    main()
