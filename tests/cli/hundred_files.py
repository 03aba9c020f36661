"""hundred_files.py PROGRAM FOLDER [I...]: makes, in a new folder, files I (0 to 99) of each of eight formats from arrays: elements of all types, of
first and second order, in text and in binary, of several precisions, packed and in regions. PROGRAM measures each: the
number of its elements and their whole volume must be what numpy finds in the arrays. Prints a table. Needs numpy, meshio,
h5py, vtk and Gmsh's module.
"""
import itertools
import json
import os
import shutil
import struct
import subprocess
import sys

import gmsh
import meshio
import numpy as np
import vtk
from meshio._vtk_common import vtk_to_meshio_type
from vtk.util.numpy_support import vtk_to_numpy

import folder_meshes

FACES = {"hexahedron": ("0321", "4567", "0154", "1265", "2376", "3047"),
         "wedge": ("021", "345", "0143", "1254", "2035"), "pyramid": ("0321", "014", "124", "234", "304"),
         "tetra": ("021", "013", "123", "203")}
CORNERS = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8, "triangle": 3, "quad": 4}
EDGES = {"tetra": "01 12 20 03 13 23", "hexahedron": "01 12 23 30 45 56 67 74 04 15 26 37",
         "wedge": "01 12 20 34 45 53 03 14 25", "triangle": "01 12 20", "quad": "01 12 23 30"}
SECOND = {"tetra": "tetra10", "hexahedron": "hexahedron20", "wedge": "wedge15", "triangle": "triangle6", "quad": "quad8"}
FIRST = {second: first for first, second in SECOND.items()}
KUHN = [[0, *(int(c) for c in way), 6] for way in ("12", "23", "37", "74", "45", "51")]


class Mesh:
    """Points, and elements: [(type as of meshio, nodes in VTK's order)]."""

    def __init__(self, seed, kinds, second=False):
        random = np.random.default_rng(seed)
        flat = kinds[0] in ("triangle", "quad")
        sizes = [int(n) for n in random.integers(1, 4, 3)]
        if flat:
            sizes[2] = 0
        axes = np.meshgrid(*(np.arange(n + 1.) for n in sizes), indexing="ij")
        points = np.stack(axes, -1).reshape(-1, 3)
        inside = ((points > 0) & (points < sizes))[:, :3 - flat].all(axis=1)
        points[inside, :3 - flat] += random.uniform(-.15, .15, (inside.sum(), 3 - flat))
        at = np.arange(len(points)).reshape([n + 1 for n in sizes])
        points, cells = list(points), []
        for n, (i, j, k) in enumerate(itertools.product(*(range(max(n, 1)) for n in sizes))):
            low = [at[i, j, k], at[i + 1, j, k], at[i + 1, j + 1, k], at[i, j + 1, k]]
            kind = kinds[(i if kinds[-1] == "wedge" else n) % len(kinds)]
            if flat:
                cells += [("quad", low)] if kind == "quad" else [("triangle", low[:3]), ("triangle", low[2:] + low[:1])]
                continue
            cube = low + [at[a, b, k + 1] for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
            if kind == "pyramid":
                middle = len(points)
                points.append(np.mean([points[c] for c in cube], axis=0))
                cells += [(kind, [cube[int(c)] for c in face[::-1]] + [middle]) for face in FACES["hexahedron"]]
            elif kind == "wedge":
                cells += [(kind, [cube[c] for c in way]) for way in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))]
            else:
                cells += [(kind, cube)] if kind == "hexahedron" else [(kind, [cube[c] for c in way]) for way in KUHN]
        if second:
            cells = self.with_mids(points, cells)
        turn = np.eye(3) + random.uniform(-.2, .2, (3, 3))
        if flat:
            turn[2], turn[:, 2] = 0, 0
        self.dim, self.points, self.cells = 3 - flat, np.array(points) @ turn, cells

    @staticmethod
    def with_mids(points, cells):
        mids, found = {}, []
        for kind, nodes in cells:
            more = []
            for edge in EDGES[kind].split():
                ends = [nodes[int(c)] for c in edge]
                if frozenset(ends) not in mids:
                    mids[frozenset(ends)] = len(points)
                    points.append((points[ends[0]] + points[ends[1]]) / 2)
                more.append(mids[frozenset(ends)])
            found.append((SECOND[kind], nodes + more))
        return found

    def volume(self, points):
        """Of all elements, whose facets are cut at their middles."""
        whole = 0
        for kind, nodes in self.cells:
            first = FIRST.get(kind, kind)
            x = points[nodes[:CORNERS[first]]]
            if self.dim == 2:
                whole += np.cross(x[1:-1] - x[0], x[2:] - x[0])[:, 2].sum() / 2
                continue
            for face in FACES[first]:
                f = x[[int(c) for c in face]] - x[0]
                whole += np.linalg.det(np.stack([f, np.roll(f, -1, 0), np.tile(f.mean(0), (len(f), 1))], 1)).sum() / 6
        return whole

    def blocks(self):
        """Elements by type: [(type, array)]."""
        kinds = sorted({kind for kind, _ in self.cells})
        return [(kind, np.array([nodes for other, nodes in self.cells if other == kind])) for kind in kinds]

    def meshio(self):
        return meshio.Mesh(self.points[:, :self.dim] if self.dim == 2 else self.points, self.blocks())


def text(path, *parts):
    with open(path, "w") as file:
        file.writelines(parts)


def lines(rows):
    return "".join(" ".join(map(repr, map(lambda v: getattr(v, "item", lambda: v)(), row))) + "\n" for row in rows)


LINEAR = [("tetra",), ("hexahedron",), ("wedge",), ("pyramid",), ("hexahedron", "wedge"), ("triangle",), ("quad",),
          ("triangle", "quad")]
ONE_SECOND = [(("tetra",), 1), (("hexahedron",), 1), (("triangle",), 1), (("quad",), 1)]
BOTH = [(kinds, 0) for kinds in LINEAR] + ONE_SECOND + [(("wedge",), 1)]
VERTICAL_FIRST = {"hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
                  "wedge15": [*range(9), *range(12, 15), *range(9, 12)]}  # Exodus and Elmer


def netcdf(path, version, dims, variables):
    """Classic netCDF; variables: (name, dims, values, attributes)."""
    def name(of):
        data = of.encode()
        return struct.pack(">i", len(data)) + data + b"\0" * (-len(data) % 4)
    order = list(dims)
    head = b"CDF%c\0\0\0\0" % version + struct.pack(">ii", 10, len(dims)) + b"".join(
        name(d) + struct.pack(">i", n) for d, n in dims.items())
    head += struct.pack(">ii", 12, 2) + name("api_version") + struct.pack(">iif", 5, 1, 8.0) + \
        name("floating_point_word_size") + struct.pack(">iii", 4, 1, 8) + struct.pack(">ii", 11, len(variables))
    entries, data = [], []
    for title, of, values, attributes in variables:
        entry = name(title) + struct.pack(">i", len(of)) + b"".join(struct.pack(">i", order.index(d)) for d in of)
        entry += struct.pack(">ii", 12 if attributes else 0, len(attributes)) + b"".join(
            name(key) + struct.pack(">ii", 2, len(value)) + value.encode() + b"\0" * (-len(value) % 4)
            for key, value in attributes.items())
        form, number = {"i": (">i4", 4), "f4": (">f4", 5)}.get("i" if values.dtype.kind == "i" else values.dtype.str[1:],
                                                              (">f8", 6))
        body = values.astype(form).tobytes()
        entries.append(entry + struct.pack(">ii", number, len(body)))
        data.append(body)
    size = 4 if version == 1 else 8
    at = len(head) + sum(len(e) + size for e in entries)
    with open(path, "wb") as file:
        file.write(head)
        for entry, body in zip(entries, data):
            file.write(entry + struct.pack(">i" if size == 4 else ">q", at))
            at += len(body)
        file.write(b"".join(data))


def exodus(path, i):
    kinds, second = BOTH[i % len(BOTH)]
    mesh, real = Mesh(i, kinds, second), ("f4" if i % 3 == 2 else "f8")
    names = {"tetra": "TETRA", "hexahedron": "HEX", "wedge": "WEDGE", "pyramid": "PYRAMID", "triangle": "TRI", "quad": "QUAD"}
    dims = {"num_dim": mesh.dim, "num_nodes": len(mesh.points), "num_elem": len(mesh.cells), "num_el_blk": len(mesh.blocks())}
    variables = []
    for b, (kind, nodes) in enumerate(mesh.blocks(), 1):
        dims["num_el_in_blk%d" % b], dims["num_nod_per_el%d" % b] = nodes.shape
        nodes = nodes[:, VERTICAL_FIRST.get(kind, slice(None))] + 1
        variables.append(("connect%d" % b, ("num_el_in_blk%d" % b, "num_nod_per_el%d" % b), nodes,
                          {"elem_type": names[FIRST.get(kind, kind)] + str(nodes.shape[1])}))
    variables.append(("eb_prop1", ("num_el_blk",), np.arange(1, dims["num_el_blk"] + 1), {}))
    for d in range(mesh.dim):
        variables.append(("coord" + "xyz"[d], ("num_nodes",), mesh.points[:, d].astype(real), {}))
    netcdf(path + ".exo", 1 + i % 2, dims, variables)
    return path + ".exo", mesh


def mfem(path, i):
    mesh = Mesh(i, LINEAR[i % len(LINEAR)])
    code = {"triangle": 2, "quad": 3, "tetra": 4, "hexahedron": 5, "wedge": 6, "pyramid": 7}
    text(path + ".mesh", "MFEM mesh v1.0\n\ndimension\n%d\n\nelements\n%d\n" % (mesh.dim, len(mesh.cells)),
         lines((1 + k % 3, code[kind], *nodes) for k, (kind, nodes) in enumerate(mesh.cells)),
         "\nboundary\n0\n\nvertices\n%d\n%d\n" % (len(mesh.points), mesh.dim), lines(mesh.points[:, :mesh.dim]))
    return path + ".mesh", mesh


UCD = {"triangle": (2, "tri"), "quad": (3, "quad"), "tetra": (4, "tet"), "pyramid": (5, "pyr"), "wedge": (6, "prism"),
       "hexahedron": (7, "hex")}


def to_ucd(kind, nodes):
    """UCD's solids have their upper side first, pyramids their tip."""
    return {"hexahedron": nodes[4:] + nodes[:4], "wedge": nodes[3:] + nodes[:3],
            "pyramid": nodes[4:] + nodes[:4]}.get(kind, nodes)


def ucd(path, i):
    mesh, n = Mesh(i, LINEAR[i % len(LINEAR)]), 0
    if i % 3 == 0:
        meshio.write(path + ".avs", mesh.meshio(), file_format="avsucd")
    elif i % 3 == 1:
        text(path + ".inp", "# by hand\n%d %d 0 0 0\n" % (len(mesh.points), len(mesh.cells)),
             lines((k + 1, *p) for k, p in enumerate(mesh.points)),
             "".join("%d 1 %s %s\n" % (k + 1, UCD[kind][1], " ".join(str(n + 1) for n in to_ucd(kind, nodes)))
                     for k, (kind, nodes) in enumerate(mesh.cells)))
    else:
        cells = [(kind, to_ucd(kind, nodes)) for kind, nodes in mesh.cells]
        n = sum(len(nodes) for _, nodes in cells)
        with open(path + ".ucd", "wb") as file:
            file.write(b"\7" + struct.pack("<6i", len(mesh.points), len(cells), 0, 0, 0, n))
            for k, (kind, nodes) in enumerate(cells):
                file.write(struct.pack("<4i", k + 1, 1, len(nodes), UCD[kind][0]))
            file.write(np.array([n + 1 for _, nodes in cells for n in nodes], "<i4").tobytes())
            file.write(mesh.points.T.astype("<f4").tobytes())
    return path + (".avs", ".inp", ".ucd")[i % 3], mesh


def su2(path, i):
    mesh = Mesh(i, LINEAR[i % len(LINEAR)])
    if i % 2:
        meshio.write(path + ".su2", mesh.meshio())
        return path + ".su2", mesh
    code = {"triangle": 5, "quad": 9, "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}
    text(path + ".su2", "NDIME= %d\nNELEM= %d\n" % (mesh.dim, len(mesh.cells)),
         lines((code[kind], *nodes, k) for k, (kind, nodes) in enumerate(mesh.cells)),
         "NPOIN= %d\n" % len(mesh.points), lines((*p[:mesh.dim], k) for k, p in enumerate(mesh.points)), "NMARK= 0\n")
    return path + ".su2", mesh


def unv(path, i):
    """By Gmsh, which leaves out pyramids."""
    types = [(kinds, second) for kinds, second in BOTH if kinds != ("pyramid",)]
    kinds, second = types[i % len(types)]
    mesh = Mesh(i, kinds, second)
    gmsh.clear()
    gmsh.model.addDiscreteEntity(mesh.dim, 1)
    gmsh.model.addPhysicalGroup(mesh.dim, [1], 1)
    gmsh.model.mesh.addNodes(mesh.dim, 1, range(1, len(mesh.points) + 1), mesh.points.ravel())
    code = {"triangle": 2, "quad": 3, "tetra": 4, "hexahedron": 5, "wedge": 6, "pyramid": 7, "triangle6": 9, "quad8": 16,
            "tetra10": 11, "hexahedron20": 17, "wedge15": 18}
    order = {"tetra10": [*range(8), 9, 8], "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14],
             "wedge15": [0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10]}
    first = 1
    for kind, nodes in mesh.blocks():
        nodes = nodes[:, order.get(kind, slice(None))]
        gmsh.model.mesh.addElementsByType(1, code[kind], range(first, first + len(nodes)), nodes.ravel() + 1)
        first += len(nodes)
    gmsh.write(path + ".unv")
    return path + ".unv", mesh


def xdmf(path, i):
    kinds, second = BOTH[i % (len(BOTH) - 1)]  # meshio knows no wedge15
    mesh = Mesh(i, kinds, second)
    meshio.write(path + ".xdmf", mesh.meshio(), data_format=("XML", "Binary", "HDF")[i % 3])
    return path + ".xdmf", mesh


def elmer(path, i):
    kinds, second = ([(kinds, 0) for kinds in LINEAR] + ONE_SECOND)[i % (len(LINEAR) + len(ONE_SECOND))]
    mesh = Mesh(i, kinds, second)
    family = {"triangle": 3, "quad": 4, "tetra": 5, "pyramid": 6, "wedge": 7, "hexahedron": 8}
    cells = [(100 * family[FIRST.get(kind, kind)] + len(nodes), [nodes[k] for k in VERTICAL_FIRST.get(kind, range(len(nodes)))])
             for kind, nodes in mesh.cells]
    codes = sorted({code for code, _ in cells})
    os.makedirs(path, exist_ok=True)
    text(path + "/mesh.header", "%d %d 0\n%d\n" % (len(mesh.points), len(cells), len(codes)),
         "".join("%d %d\n" % (code, sum(c == code for c, _ in cells)) for code in codes))
    text(path + "/mesh.nodes", lines((k + 1, -1, *p) for k, p in enumerate(mesh.points)))
    text(path + "/mesh.elements", lines((k + 1, 1 + k % 2, code, *(n + 1 for n in nodes)) for k, (code, nodes) in enumerate(cells)))
    text(path + "/mesh.boundary")
    return path, mesh


def openfoam(path, i):
    kinds = LINEAR[:5]
    mesh = Mesh(i, kinds[i % len(kinds)])
    how = [[], ["binary"]][i % 2] + [[], ["label=64"]][i // 2 % 2] + [[], ["scalar=32"]][i // 4 % 2] + [[], ["gz"]][i // 8 % 2]
    folder = path + ("/constant/fluid/polyMesh" if i % 3 == 0 else "/constant/polyMesh")
    zones = {"even": range(0, len(mesh.cells), 2)} if i % 4 == 0 else {}
    folder_meshes.foam(folder, [[repr(float(x)) for x in p] for p in mesh.points],
                       [[int(n) for n in nodes] for _, nodes in mesh.cells],
                       lambda face: "side%d" % (face[0] % 3), {"side1": "wall"}, zones, how)
    return path, mesh


def judge(program, path, mesh, points):
    """Whether a file is read, and what is wrong: its elements by type, the volume of planish's copy of it, or its
    quality."""
    copy = path + "-copy.vtu"
    done = subprocess.run([program, "quality", path, "-q", "-j", "1", "-o", copy, "--json", "-"], capture_output=True, check=False)
    if done.returncode > 1:
        return 0, done.stderr.decode().strip()
    quality, read = json.loads(done.stdout)["quality"], Mesh.__new__(Mesh)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(copy)
    reader.Update()
    grid = reader.GetOutput()
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()), vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    read.dim, read.cells = mesh.dim, [(vtk_to_meshio_type[kind], nodes) for kind, nodes in
                                      zip(vtk_to_numpy(grid.GetCellTypesArray()), np.split(cells[0], cells[1][1:-1]))]
    if read.dim == 3:  # faces of the boundary are none of these
        read.cells = [cell for cell in read.cells if FIRST.get(cell[0], cell[0]) in FACES]
    counts = [{kind: len(nodes) for kind, nodes in m.blocks()} for m in (read, mesh)]
    if counts[0] != counts[1]:
        return 1, "%s, not %s" % tuple(counts)
    volumes = abs(read.volume(vtk_to_numpy(grid.GetPoints().GetData()).astype("f8"))), abs(mesh.volume(points))
    if abs(volumes[0] - volumes[1]) > 1e-12 * volumes[1]:
        return 1, "volume %r, not %r" % volumes
    faults = [quality.get(key) or 0 for key in ("inverted", "uncertified", "curved", "reversed_elements")]
    return 1, "inverted, uncertified, curved, reversed: %s" % faults if any(faults) else ""


def main():
    program, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
    numbers = [int(word) for word in sys.argv[3:]] or range(100)
    os.makedirs(folder)
    os.chdir(folder)  # meshio has files of XDMF name others as it is told
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    n_wrong = 0
    print("| format | files | read | wrong |\n| --- | --: | --: | --: |")
    for make in (exodus, mfem, ucd, su2, unv, xdmf, elmer, openfoam):
        read = wrong = 0
        for i in numbers:
            path, mesh = make("%s%d" % (make.__name__, i), i)
            is_single = i % 3 == 2 if make in (ucd, exodus) else make is openfoam and i // 4 % 2
            is_read, problem = judge(program, path, mesh,
                                     mesh.points.astype("f4").astype("f8") if is_single else mesh.points)
            read += is_read
            if problem:
                wrong += 1
                print("%s: %s" % (path, problem), file=sys.stderr)
        n_wrong += wrong
        print("| %s | %d | %d | %d |" % (make.__name__, len(numbers), read, wrong), flush=True)
        for name in os.listdir():
            shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)
    gmsh.finalize()
    return n_wrong > 0


if __name__ == "__main__":
    sys.exit(main())
