"""view: what is seen of a mesh as polygons in the plane of the picture, those in front last.

A face has corners [4] and mids [4] of the edges that begin there, -1 where it has none."""
from collections import namedtuple

import numpy as np

import cells

SHARP = np.cos(np.radians(30))          # edges that bend by more are lines
LIGHT = np.array([-0.35, 0.5, 0.79])    # from there, in the picture's frame: right, up, towards the eye
SHADES = 8                              # of a colour
DARKEST = 0.72

MIDS_OF_TETRAHEDRON = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}
TETRAHEDRON10 = 24
FACES = {5: ((0, 1, 2),), 9: ((0, 1, 2, 3),), TETRAHEDRON10: cells.KINDS["tet"].faces,
         **{cells.KINDS[name].vtk: cells.KINDS[name].faces for name in ("tet", "hex", "wedge", "pyramid")}}

# points [n][3]; types [m] are VTK's numbers; nodes: of each element; values and is_inverted [m]; regions [m] or None
Mesh = namedtuple("Mesh", "points types nodes values is_inverted regions")
# corners and mids [f][4]; elements [f]: whose they are
Faces = namedtuple("Faces", "corners mids elements")
# right, up and towards the eye: unit vectors of the picture in space
Camera = namedtuple("Camera", "right up towards")

FLAT = Camera(*np.eye(3))


def camera(azimuth, elevation):
    """The eye's direction, in degrees from the x axis and above the x y plane; z is up."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0])
    return Camera(right, np.cross(towards, right), towards)


def in_picture(camera, points):
    """Right, up and towards the eye [n][3]."""
    return points @ np.stack(camera).T


def faces_of_element(kind, nodes):
    """Corners and mids of the faces of elements [k][nodes] of VTK's type: [faces k][4]; and how many faces."""
    corners, mids = [], []
    for face in FACES[kind]:
        found = np.full((2, len(nodes), 4), -1)
        found[0, :, :len(face)] = nodes[:, face]
        if kind == TETRAHEDRON10:
            around = [tuple(sorted((face[j], face[(j + 1) % 3]))) for j in range(3)]
            found[1, :, :3] = nodes[:, [MIDS_OF_TETRAHEDRON[edge] for edge in around]]
        corners.append(found[0])
        mids.append(found[1])
    return np.concatenate(corners), np.concatenate(mids), len(corners)


def outer_faces(mesh, is_kept):
    """Faces that one kept element alone has."""
    corners, mids, elements = [np.empty((0, 4), int)], [np.empty((0, 4), int)], [np.empty(0, int)]
    for kind in np.unique(mesh.types[is_kept]):
        chosen = np.flatnonzero(is_kept & (mesh.types == kind))
        found = faces_of_element(kind, np.stack([mesh.nodes[element] for element in chosen]))
        corners.append(found[0])
        mids.append(found[1])
        elements.append(np.tile(chosen, found[2]))
    corners, mids, elements = map(np.concatenate, (corners, mids, elements))
    _, first, count = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True)
    once = np.sort(first[count == 1])
    return Faces(corners[once], mids[once], elements[once])


def normals(mesh, faces):
    """Unit normals [f][3] of faces, by their diagonals or two edges."""
    corners = faces.corners.copy()
    is_triangle = corners[:, 3] < 0
    corners[is_triangle, 3] = corners[is_triangle, 0]
    x = mesh.points[corners]
    found = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    length = np.linalg.norm(found, axis=1)[:, None]
    return found / np.where(length > 0, length, 1)


def outline(face, mids, places):
    """Points around a face, those of its mids among them."""
    found = []
    for corner, mid in zip(face, mids):
        if corner >= 0:
            found.append(places[corner])
        if mid >= 0:
            found.append(places[mid])
    return np.array(found)


def seen(outlines, size):
    """Mask of the outlines [.][3] in pixels that own a pixel of a picture of this size (width, height)."""
    depth = np.full((size[1] + 1, size[0] + 1), -np.inf)
    owner = np.full(depth.shape, -1)
    for face, around in enumerate(outlines):
        for k in range(1, len(around) - 1):
            fill(depth, owner, face, around[[0, k, k + 1]])
    found = np.zeros(len(outlines), bool)
    found[owner[owner >= 0]] = True
    return found


def fill(depth, owner, face, triangle):
    """Give a face the pixels of its triangle [3][3] that are nearer to the eye than what has them."""
    limit = np.array(depth.shape)[::-1] - 1
    low = np.clip(np.floor(triangle[:, :2].min(axis=0)), 0, limit).astype(int)
    high = np.clip(np.ceil(triangle[:, :2].max(axis=0)), 0, limit).astype(int)
    (a, b), (c, d) = triangle[1, :2] - triangle[0, :2], triangle[2, :2] - triangle[0, :2]
    area = a * d - b * c
    if area == 0 or (high < low).any():
        return
    x = np.arange(low[0], high[0] + 1)[None, :] - triangle[0, 0]
    y = np.arange(low[1], high[1] + 1)[:, None] - triangle[0, 1]
    s, t = (x * d - y * c) / area, (a * y - b * x) / area
    z = triangle[0, 2] + s * (triangle[1, 2] - triangle[0, 2]) + t * (triangle[2, 2] - triangle[0, 2])
    at = slice(low[1], high[1] + 1), slice(low[0], high[0] + 1)
    is_nearer = (s >= 0) & (t >= 0) & (s + t <= 1) & (z > depth[at])
    depth[at][is_nearer] = z[is_nearer]
    owner[at][is_nearer] = face


def shades(mesh, faces, camera, darkest=DARKEST):
    """Brightness [f] of faces, in SHADES steps from darkest to 1."""
    light = np.abs(in_picture(camera, normals(mesh, faces)) @ (LIGHT / np.linalg.norm(LIGHT)))
    return darkest + (1 - darkest) * np.round(light * (SHADES - 1)) / (SHADES - 1)


def chosen(faces, which):
    return Faces(faces.corners[which], faces.mids[which], faces.elements[which])


def visible(faces, places, size):
    """The faces that are seen, the farthest first; places [n][3]: of points in pixels, and their depth."""
    outlines = [outline(*face, places) for face in zip(faces.corners, faces.mids)]
    depths = np.array([around[:, 2].mean() for around in outlines])
    order = np.argsort(depths, kind="stable")
    return chosen(faces, order[seen(outlines, size)[order]])


def edges(faces):
    """Edges of faces: corners and mid [e][3], and of each the two faces that have it; -1 where there is one alone."""
    rows = []
    for j in range(4):
        following = faces.corners[:, (j + 1) % 4]
        following = np.where(following < 0, faces.corners[:, 0], following)
        rows.append(np.column_stack([faces.corners[:, j], following, faces.mids[:, j], np.arange(len(following))]))
    rows = np.concatenate(rows)
    rows = rows[rows[:, 0] >= 0]
    _, first, inverse, count = np.unique(np.sort(rows[:, :2], axis=1), axis=0, return_index=True, return_inverse=True,
                                         return_counts=True)
    last = np.full(len(first), -1)
    last[inverse.ravel()] = rows[:, 3]
    return rows[first, :3], np.column_stack([rows[first, 3], np.where(count > 1, last, -1)])


def creases(mesh, faces):
    """Edges [e][3] where faces bend sharply."""
    found, sides = edges(faces)
    normal = normals(mesh, faces)
    return found[(sides[:, 1] >= 0) & ((normal[sides[:, 0]] * normal[sides[:, 1]]).sum(axis=1) < SHARP)]


def rims(faces):
    """Edges [e][3] of one face alone."""
    found, sides = edges(faces)
    return found[sides[:, 1] < 0]


def borders(mesh, faces):
    """Edges [e][3] between regions."""
    found, sides = edges(faces)
    region = mesh.regions[faces.elements]
    return found[(sides[:, 1] >= 0) & (region[sides[:, 0]] != region[sides[:, 1]])]
