"""meshfile: the mesh that all smoothers start from: the tetrahedra and triangles of a file that
planish reads (by meshio), and binary MSH 2.2 files of it, which all of them read and write."""
import contextlib
import sys

import meshio
import numpy as np

HEADER = b"$MeshFormat\n2.2 1 8\n\1\0\0\0\n$EndMeshFormat\n"
NODE = np.dtype([("number", "<i4"), ("x", "<f8", 3)])
CORNERS = {2: 3, 4: 4}  # by type of element in MSH files


class Mesh:
    """points, double[n][3]; tetrahedra, int[m][4], from 0, positive (most of them); triangles
    [k][3]: the boundary and those of the file; is_fixed [n]: nodes of triangles."""

    def __init__(self, points, tetrahedra, triangles):
        self.points = np.ascontiguousarray(points, float)
        self.tetrahedra = oriented(self.points, tetrahedra)
        facets, count = distinct(np.concatenate([np.delete(tetrahedra, i, 1) for i in range(4)]))
        self.triangles, _ = distinct(np.concatenate([facets[count == 1], triangles]))
        self.is_fixed = np.zeros(len(points), bool)
        self.is_fixed[self.triangles] = True


def oriented(points, tetrahedra):
    """All of them turned round if most are negative."""
    a, b, c, d = points[tetrahedra].transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
    return tetrahedra if volumes.sum() > 0 else tetrahedra[:, [0, 1, 3, 2]]


def distinct(facets):
    """Each facet once, its nodes in order, and how often it was there."""
    facets = np.sort(facets, axis=1)
    facets = facets[np.lexsort(facets.T)]
    is_first = np.ones(len(facets), bool)
    is_first[1:] = (facets[1:] != facets[:-1]).any(axis=1)
    first = np.flatnonzero(is_first)
    return facets[first], np.diff(first, append=len(facets))


def load(path):
    """The Mesh of a file; ValueError if it has no tetrahedra."""
    try:
        with contextlib.redirect_stdout(sys.stderr):  # for its warnings
            found = meshio.read(path)
    except (meshio.ReadError, SystemExit, LookupError) as reason:
        raise ValueError(f"meshio cannot read it: {reason}") from reason
    blocks = {kind: [np.empty((0, corners), int)] + [
        cells.data for cells in found.cells if cells.type == kind]
        for kind, corners in (("triangle", 3), ("tetra", 4))}
    tetrahedra = np.concatenate(blocks["tetra"]).astype(int)
    if not len(tetrahedra):
        raise ValueError("no tetrahedra")
    return Mesh(found.points, tetrahedra, np.concatenate(blocks["triangle"]).astype(int))


def write(path, mesh, points):
    """mesh with these points."""
    nodes = np.zeros(len(points), NODE)
    nodes["number"] = np.arange(len(points)) + 1
    nodes["x"] = points
    with open(path, "wb") as file:
        file.write(HEADER + b"$Nodes\n%d\n" % len(nodes) + nodes.tobytes() + b"\n$EndNodes\n")
        file.write(b"$Elements\n%d\n" % (len(mesh.triangles) + len(mesh.tetrahedra)))
        first = 1
        for kind, elements in (2, mesh.triangles), (4, mesh.tetrahedra):
            count = len(elements)
            numbers = np.arange(first, first + count)
            tags = np.tile([0, 1], (count, 1))  # no physical group, the only entity
            file.write(np.array([kind, count, 2], "<i4").tobytes())
            file.write(np.column_stack([numbers, tags, elements + 1]).astype("<i4").tobytes())
            first += count
        file.write(b"\n$EndElements\n")


def read(path, mesh):
    """Points [n][3] and tetrahedra [m][4] of a file that was written, changed and written back;
    nodes that it leaves out are where they were."""
    with open(path, "rb") as file:
        data = file.read()
    count, at = section(data, b"$Nodes\n")
    nodes = np.frombuffer(data, NODE, count, at)
    points = mesh.points.copy()
    points[nodes["number"] - 1] = nodes["x"]
    count, at = section(data, b"$Elements\n")
    tetrahedra = [np.empty((0, 5), int)]
    while count > 0:
        kind, here, n_tags = np.frombuffer(data, "<i4", 3, at)
        columns = 1 + n_tags + CORNERS[kind]
        rows = np.frombuffer(data, "<i4", here * columns, at + 12).reshape(here, columns)
        if kind == 4:
            tetrahedra.append(rows[:, [0, -4, -3, -2, -1]])
        at += 12 + rows.nbytes
        count -= here
    tetrahedra = np.concatenate(tetrahedra)
    return points, tetrahedra[np.argsort(tetrahedra[:, 0]), 1:] - 1


def by_old_numbers(mesh, points, tetrahedra):
    """The same as the mesh numbers its nodes, where a program has numbered them anew: told from the
    tetrahedra, which are the mesh's again if only that has changed."""
    if tetrahedra.shape != mesh.tetrahedra.shape:
        return points, tetrahedra
    used = np.unique(mesh.tetrahedra)
    new, old = np.zeros((2, len(points)), int)
    new[mesh.tetrahedra] = tetrahedra
    old[new[used]] = used
    moved = mesh.points.copy()
    moved[used] = points[new[used]]
    return moved, old[tetrahedra]


def section(data, name):
    """The count of a section and where its numbers begin."""
    begin = data.index(name) + len(name)
    end = data.index(b"\n", begin)
    return int(data[begin:end]), end + 1
