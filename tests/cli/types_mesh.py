"""types_mesh.py OUT.vtk OUT.json TETRAHEDRA.vtk: a mesh with elements of every type in three dimensions, each with points of
its own, and their measures by formulas that share no code with planish; and the straight tetrahedra alone."""
import itertools
import json
import math
import random
import sys

random.seed(51)
HALF, ROOT = 0.5, math.sqrt(3) / 2
CORNERS = {  # of the ideal element
    "tetrahedron": [(0, 0, 0), (1, 0, 0), (HALF, ROOT, 0), (HALF, ROOT / 3, math.sqrt(2 / 3))],
    "hexahedron": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (HALF, ROOT, 0), (0, 0, 1), (1, 0, 1), (HALF, ROOT, 1)],
    "pyramid": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (HALF, HALF, math.sqrt(HALF))],
}
EDGES = {
    "tetrahedron": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
}
FACES = {
    "hexahedron": [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)],
    "wedge": [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
}
TYPES = {  # VTK's number, shape, whether edges, faces and the middle have a node
    "tetrahedron": (10, "tetrahedron", 0, 0, 0), "hexahedron": (12, "hexahedron", 0, 0, 0),
    "wedge": (13, "wedge", 0, 0, 0), "pyramid": (14, "pyramid", 0, 0, 0),
    "tetrahedron10": (24, "tetrahedron", 1, 0, 0), "hexahedron20": (25, "hexahedron", 1, 0, 0),
    "wedge15": (26, "wedge", 1, 0, 0), "hexahedron27": (29, "hexahedron", 1, 1, 1),
    "wedge18": (32, "wedge", 1, 1, 0),
}


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def det(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def length(a):
    return math.sqrt(sum(x * x for x in a))


def middle(points):
    return [sum(p[d] for p in points) / len(points) for d in range(3)]


def neighbours(shape, corner):
    return sorted({a + b - corner for a, b in EDGES[shape] if corner in (a, b)})


def measure(shape, x):
    """Corners with det <= 0, AR^2, least scaled Jacobian, edge ratio; a mirrored type has another sign."""
    bad, squares, scaled = 0, [], []
    for c in range(len(x)):
        around = neighbours(shape, c)
        if len(around) > 3:
            continue
        j = [minus(x[n], x[c]) for n in around]
        w = [minus(CORNERS[shape][n], CORNERS[shape][c]) for n in around]
        d = det(j) / det(w)
        scaled.append(d * math.prod(map(length, w)) / math.prod(map(length, j)))
        bad += d <= 0
        # Rows of W^-1 T = J: T by Cramer's rule, column by column.
        t = [[det([[j[r][k] if q == col else w[r][q] for q in range(3)] for r in range(3)]) / det(w)
              for k in range(3)] for col in range(3)]
        if d > 0:
            squares.append((sum(v * v for row in t for v in row) / (3 * d ** (2 / 3))) ** 2)
    lengths = [length(minus(x[a], x[b])) for a, b in EDGES[shape]]
    return bad, sum(squares) / len(squares) if not bad else None, min(scaled), max(lengths) / min(lengths)


points, cells, expected = [], [], {}
for name, (number, shape, has_mids, has_faces, has_middle) in TYPES.items():
    of = {"elements": 0, "inverted": 0, "corner_inverted": 0, "curved": 0, "squares": [], "scaled": [], "edges": []}
    expected[name] = of
    # A tangled one (of straight tetrahedra in no other the orientation is open), and one with a mid that is a little or
    # much off the middle of its edge.
    for kind in ["plain"] * 5 + ["tangled"] * (number != 10) + (["curved", "folded"] if has_mids else []):
        shift = [3.0 * len(cells), 0, 0]
        noise = 0 if kind in ("curved", "folded") else 0.14
        ideal = [[v + random.uniform(-noise, noise) for v in p] for p in CORNERS[shape]]
        if kind == "tangled":
            far = max(neighbours(shape, 1))
            ideal[1] = [a + 1.6 * (b - a) for a, b in zip(ideal[1], middle(ideal))]
        bad, square, scaled, edges = measure(shape, ideal)
        x = [[a + b for a, b in zip(p, shift)] for p in ideal]
        if name in ("pyramid", "wedge15"):  # the whole type mirrored
            x = [[a, b, -c] for a, b, c in x]
        assert (bad > 0) == (kind == "tangled")
        of["elements"] += 1
        of["inverted"] += kind in ("tangled", "folded")
        of["corner_inverted"] += bad
        of["curved"] += kind in ("curved", "folded")
        of["scaled"].append(scaled)
        of["edges"].append(edges)
        if kind in ("plain", "curved"):
            of["squares"].append(square)
        nodes = x[:]
        if has_mids:
            nodes += [middle([x[a], x[b]]) for a, b in EDGES[shape]]
            if kind in ("curved", "folded"):
                a, b = EDGES[shape][0]
                share = 0.02 if kind == "curved" else 0.8
                nodes[len(x)] = [p + share * (q - r) for p, q, r in zip(nodes[len(x)], x[b], x[a])]
        if has_faces:
            nodes += [middle([x[i] for i in face]) for face in FACES[shape]]
        if has_middle:
            nodes.append(middle(x))
        cells.append((number, list(range(len(points), len(points) + len(nodes)))))
        points += nodes


def total(parts):
    squares = list(itertools.chain(*(p["squares"] for p in parts)))
    return {"inverted": sum(p["inverted"] for p in parts),
            "corner_inverted": sum(p["corner_inverted"] for p in parts), "uncertified": 0,
            "curved": sum(p["curved"] for p in parts),
            "rms_aspect_ratio": math.sqrt(sum(squares) / len(squares)),
            "mean_aspect_ratio": sum(map(math.sqrt, squares)) / len(squares),
            "max_aspect_ratio": math.sqrt(max(squares)),
            "min_scaled_jacobian": min(v for p in parts for v in p["scaled"]),
            "max_edge_ratio": max(v for p in parts for v in p["edges"])}


def write(path, cells):
    with open(path, "w") as out:
        print("# vtk DataFile Version 3.0\ntypes\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", len(points), "double",
              file=out)
        for p in points:
            print(*map(repr, p), file=out)
        print("CELLS", len(cells), sum(len(n) + 1 for _, n in cells), file=out)
        for _, nodes in cells:
            print(len(nodes), *nodes, file=out)
        print("CELL_TYPES", len(cells), file=out)
        for number, _ in cells:
            print(number, file=out)


write(sys.argv[1], cells)
write(sys.argv[3], [c for c in cells if c[0] == 10])
with open(sys.argv[2], "w") as out:
    json.dump({"counts": {name: of["elements"] for name, of in expected.items()}, "all": total(expected.values()),
               "by_type": {name: total([of]) for name, of in expected.items()}}, out)
