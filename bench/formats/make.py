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
        "tetgen.node": lambda path: meshio.tetgen.write(path, mesh),
    }
    for name, write in writers.items():
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            write(path)


if __name__ == "__main__":
    main()
