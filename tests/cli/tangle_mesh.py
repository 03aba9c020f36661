"""tangle_mesh.py IN.mesh OUT.mesh KIND...: spoil a mesh of the unit square or cube, one KIND after the other.

moved      every interior node pushed at random by up to 0.9 of its mean edge length
collapsed  the interior nodes of one half all on one point
centroid   all interior nodes on the centroid of the mesh
thrown     one interior node ten times the size of the mesh away
doubled    every third interior node exactly on a neighbour, which may be one of the boundary
ear        the corner (1, 0) or (1, 0, 0) pushed in through the only facet behind it: one element without
           a free node is inverted
islands    twelve parts more, each a U (extruded in 3-D) with one free node in it that cannot see all of
           its boundary
float      coordinates rounded to single precision

OUT.vtk: the same as legacy VTK with points in single precision.
"""
import math
import random
import struct
import sys

from mesh_file import boundary, read

ISLANDS = 12
U = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
U_TRIANGLES = [(5, 6, 7), (0, 5, 7), (2, 3, 4), (1, 2, 4), (0, 4, 5), (0, 1, 4)]


def neighbours(mesh):
    around = [set() for _ in mesh.points]
    for element in mesh.elements:
        for node in element:
            around[node].update(element)
    return [sorted(nodes - {i}) for i, nodes in enumerate(around)]


def moved(mesh, interior):
    around, old = neighbours(mesh), [list(p) for p in mesh.points]
    for i in interior:
        reach = 0.9 * sum(math.dist(old[i], old[j]) for j in around[i]) / len(around[i])
        mesh.points[i] = [x + random.uniform(-reach, reach) for x in old[i]]


def collapsed(mesh, interior):
    for i in interior:
        if mesh.points[i][0] < 0.5:
            mesh.points[i] = [0.3] * mesh.dim


def centroid(mesh, interior):
    for i in interior:
        mesh.points[i] = [0.5] * mesh.dim


def thrown(mesh, interior):
    mesh.points[interior[len(interior) // 3]] = [10.0] * mesh.dim


def doubled(mesh, interior):
    around = neighbours(mesh)
    for i in interior[::3]:
        mesh.points[i] = list(mesh.points[random.choice(around[i])])


def ear(mesh, interior):
    """Both meshes are cut along the diagonals from the lower to the upper corner of their cells: behind
    the corner there is one triangle, or two tetrahedra, of which one is inverted."""
    points = mesh.points
    corner = points.index([1.0] + [0.0] * (mesh.dim - 1))
    cell = min(math.dist(points[corner], p) for p in points if p != points[corner])
    place = [0.4, 0.6, 0.2][:mesh.dim]
    points[corner] = [x + cell * (p - (x == 1)) for x, p in zip(points[corner], place)]


def facets_of_u(dim):
    """Nodes and facets around one U, facets in the order that is positive seen from inside."""
    n = len(U)
    if dim == 2:
        return [list(p) for p in U], [(i, (i + 1) % n) for i in range(n)]
    facets = [(a, b, c) for a, b, c in U_TRIANGLES] + [(a + n, c + n, b + n) for a, b, c in U_TRIANGLES]
    for i in range(n):
        j = (i + 1) % n
        facets += [(i, j + n, j), (i, i + n, j + n)]
    return [[*p, z] for z in (0, 3) for p in U], facets


def islands(mesh, interior):
    points, facets = facets_of_u(mesh.dim)
    for k in range(ISLANDS):
        first = len(mesh.points)
        offset = [2 + 0.5 * k] + [0] * (mesh.dim - 1)
        mesh.points.extend([o + x / 10 for o, x in zip(offset, p)] for p in points)
        mesh.points.append([o + 0.15 for o in offset])
        for facet in facets:
            mesh.elements.append([first + i for i in facet] + [len(mesh.points) - 1])


def single(mesh, interior):
    mesh.points[:] = [list(struct.unpack("%df" % mesh.dim, struct.pack("%df" % mesh.dim, *p)))
                      for p in mesh.points]


def write_medit(mesh, path):
    with open(path, "w") as file:
        file.write("MeshVersionFormatted 2\nDimension %d\nVertices\n%d\n" % (mesh.dim, len(mesh.points)))
        for point in mesh.points:
            file.write(" ".join("%r" % x for x in point) + " 0\n")
        file.write("%s\n%d\n" % ("Tetrahedra" if mesh.dim == 3 else "Triangles", len(mesh.elements)))
        for element in mesh.elements:
            file.write(" ".join("%d" % (node + 1) for node in element) + " 1\n")
        file.write("End\n")


def write_vtk(mesh, path):
    with open(path, "w") as file:
        file.write("# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\n")
        file.write("POINTS %d float\n" % len(mesh.points))
        for point in mesh.points:
            file.write(" ".join("%.9g" % x for x in point + [0.0] * (3 - mesh.dim)) + "\n")
        corners = mesh.dim + 1
        file.write("CELLS %d %d\n" % (len(mesh.elements), (corners + 1) * len(mesh.elements)))
        for element in mesh.elements:
            file.write("%d %s\n" % (corners, " ".join(map(str, element))))
        file.write("CELL_TYPES %d\n" % len(mesh.elements))
        file.write("%d\n" % (10 if mesh.dim == 3 else 5) * len(mesh.elements))


KINDS = {f.__name__: f for f in (moved, collapsed, centroid, thrown, doubled, ear, islands)}
KINDS["float"] = single

if __name__ == "__main__":
    random.seed(1)
    spoiled, target = read(sys.argv[1]), sys.argv[2]
    held = boundary(spoiled)
    free = [i for i in range(len(spoiled.points)) if i not in held]
    for kind in sys.argv[3:]:
        KINDS[kind](spoiled, free)
    (write_vtk if target.endswith(".vtk") else write_medit)(spoiled, target)
