"""layers_second.py DIM BUMP: rows of quadrilaterals (DIM 2) or wedges (3) of second order over a wall, triangles or tetrahedra
over these. Mids of the wall are up by BUMP first heights in two places, where the first row is not valid then. Columns inside
are bent."""
import itertools
import random
import sys
import box_file

EDGES = {"quads": [(0, 1), (1, 2), (2, 3), (3, 0)], "triangles": [(0, 1), (1, 2), (2, 0)],
         "prisms": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
         "tets": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}
VTK = {"quads": 23, "triangles": 22, "prisms": 26, "tets": 24}
WALL = {2: [((3, 0), (4, 0)), ((8, 0), (9, 0))], 3: [((2, 2, 0), (3, 2, 0)), ((2, 3, 0), (3, 3, 0))]}
SIDES = {2: [16], 3: [6, 6]}

dim, bump = int(sys.argv[1]), float(sys.argv[2])
n = SIDES[dim][0]
first, growth, thin, rows = (0.004, 1.3, 6, 16) if dim == 2 else (0.01, 1.2, 4, 16)
heights = [first * (growth ** r - 1) / (growth - 1) for r in range(rows + 1)]
if dim == 2:
    heights[thin + 1:] = [heights[thin] + i / n for i in range(1, rows - thin + 1)]
random.seed(2)
points, number, mid_of, cells = [], {}, {}, []
for at in itertools.product(*(range(s + 1) for s in SIDES[dim] + [rows])):
    inside = all(0 < c < s for c, s in zip(at, SIDES[dim] + [rows]))
    push = 0.2 / n * random.uniform(-1, 1) if dim == 2 else 0.03 * (-1) ** at[0]
    number[at] = len(points)
    points.append([at[0] / n + inside * push, *(c / n for c in at[1:-1]), heights[at[-1]]] + [0.0] * (3 - dim))


def mid(a, b):
    edge = min(a, b), max(a, b)
    if edge not in mid_of:
        mid_of[edge] = len(points)
        points.append([(p + q) / 2 for p, q in zip(points[a], points[b])])
    return mid_of[edge]


above = {at: number[(*at[:-1], at[-1] + thin)] for at in number if at[-1] + thin <= rows}
for kind, height, numbers in zip(("quads", "triangles") if dim == 2 else ("prisms", "tets"), (thin, rows - thin), (number, above)):
    for e in box_file.elements(kind, SIDES[dim] + [height], numbers):
        cells.append((VTK[kind], list(e) + [mid(e[a], e[b]) for a, b in EDGES[kind]]))
for a, b in WALL[dim]:
    points[mid(number[a], number[b])][dim - 1] += bump * first
print("# vtk DataFile Version 3.0\nlayers\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", len(points), "double")
print("\n".join(" ".join(map(repr, p)) for p in points))
print("CELLS", len(cells), sum(len(nodes) + 1 for _, nodes in cells))
print("\n".join(" ".join(map(str, [len(nodes)] + nodes)) for _, nodes in cells))
print("CELL_TYPES", len(cells))
print("\n".join(str(t) for t, _ in cells))
