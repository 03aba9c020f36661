"""Boxes of elements for tests of the program: rows of a grid, along the last coordinate.

elements(kind, sides, number): of quads, triangles, hexes, prisms or tets; number: of the node at each place.
medit(kind, points, elements): the text of a file, nodes numbered from 1.
"""
import itertools

NAMES = {"quads": "Quadrilaterals", "triangles": "Triangles", "hexes": "Hexahedra", "tets": "Tetrahedra",
         "prisms": "Prisms"}
SQUARE = (0, 0), (1, 0), (1, 1), (0, 1)
CUBE = tuple((*at, z) for z in (0, 1) for at in SQUARE)
RING = 1, 2, 3, 7, 4, 5, 1  # around the diagonal from 0 to 6
PARTS = {
    "quads": ((0, 1, 2, 3),),
    "triangles": ((0, 1, 2), (0, 2, 3)),
    "hexes": (tuple(range(8)),),
    "prisms": ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)),
    "tets": tuple((0, a, b, 6) for a, b in zip(RING, RING[1:])),
}


def dimension(kind):
    return 2 if kind in ("quads", "triangles") else 3


def elements(kind, sides, number):
    corners = SQUARE if dimension(kind) == 2 else CUBE
    found = []
    for at in itertools.product(*map(range, sides)):
        nodes = [number[tuple(a + b for a, b in zip(at, corner))] for corner in corners]
        found += [[nodes[i] for i in part] for part in PARTS[kind]]
    return found


def medit(kind, points, listed):
    rows = ["MeshVersionFormatted 2\nDimension %d\nVertices %d" % (dimension(kind), len(points))]
    rows += [" ".join(map(repr, p)) + " 0" for p in points]
    rows += ["%s %d" % (NAMES[kind], len(listed))]
    rows += [" ".join(map(str, e)) + " 1" for e in listed]
    return "\n".join(rows) + "\nEnd"
