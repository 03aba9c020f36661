"""simplices: measures of many triangles or tetrahedra at once, and Gmsh 2.2 ASCII files of them.

points [n][dim], elements [m][dim + 1] of int; needs numpy. For the making of the examples: what is
reported of results comes from `planish quality`.
"""
import itertools

import numpy as np


def edges_from_first(points, elements):
    corner = points[elements]
    return corner[:, 1:] - corner[:, :1]


def volumes(points, elements):
    """Signed volumes, or areas."""
    edges = edges_from_first(points, elements)
    return np.linalg.det(edges) / (6 if points.shape[1] == 3 else 2)


def normals(points, elements):
    """dD/dv_j, D = 6 V, of the corners of tetrahedra: [m][4][3]."""
    e = edges_from_first(points, elements)
    own = [np.cross(e[:, (j + 1) % 3], e[:, (j + 2) % 3]) for j in range(3)]
    return np.stack([-(own[0] + own[1] + own[2])] + own, axis=1)


def radius_ratios(points, elements):
    """R/(3r) of tetrahedra, R/(2r) of triangles; volumes must be positive."""
    corner = points[elements]
    v = volumes(points, elements)
    if points.shape[1] == 2:
        a, b, c = (np.linalg.norm(corner[:, i] - corner[:, j], axis=1)
                   for i, j in ((0, 1), (1, 2), (2, 0)))
        return a * b * c * (a + b + c) / (16 * v * v)
    normal = normals(points, elements)
    surface = np.linalg.norm(normal, axis=2).sum(axis=1) / 2
    squares = (edges_from_first(points, elements) ** 2).sum(axis=2)
    alpha = (squares[:, :, None] * normal[:, 1:]).sum(axis=1)
    return np.linalg.norm(alpha, axis=1) / (12 * v) * surface / (9 * v)


def faces_of(element):
    return itertools.combinations(element, len(element) - 1)


def write_mesh(path, points, elements):
    dim = points.shape[1]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n")
        for number, point in enumerate(points, 1):
            place = list(point) + [0.0] * (3 - dim)
            file.write(f"{number} " + " ".join(repr(float(x)) for x in place) + "\n")
        file.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        kind = {2: 2, 3: 4}[dim]
        for number, element in enumerate(elements, 1):
            file.write(f"{number} {kind} 2 1 1 " + " ".join(str(n + 1) for n in element) + "\n")
        file.write("$EndElements\n")


def read_mesh(path):
    """points and elements of a file that write_mesh wrote (or planish, from one)."""
    with open(path, encoding="ascii") as file:
        lines = file.read().split("\n")
    nodes, elements = lines.index("$Nodes"), lines.index("$Elements")
    points = np.array([line.split()[1:] for line in
                       lines[nodes + 2:nodes + 2 + int(lines[nodes + 1])]], float)
    corners = np.array([line.split()[5:] for line in
                        lines[elements + 2:elements + 2 + int(lines[elements + 1])]], int) - 1
    return points[:, :corners.shape[1] - 1], corners


def free_nodes(elements):
    """Nodes that are on no facet of one element only."""
    owners = {}
    for element in elements:
        for face in faces_of(element):
            key = tuple(sorted(face))
            owners[key] = owners.get(key, 0) + 1
    boundary = {node for face, count in owners.items() if count == 1 for node in face}
    return np.array([node for node in np.unique(elements) if node not in boundary])
