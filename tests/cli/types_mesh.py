"""types_mesh.py OUT.vtk OUT.json SIMPLICES.vtk: a mesh with elements of every type in three dimensions, each with points of
its own, and their measures by formulas that share no code with planish; and the tetrahedra of both orders alone, by their
corners.

types_mesh.py second DIM KIND OUT [SEED]: a square (DIM 2) or cube (3) of elements of second order with curved edges on its
boundary. KIND: plain, folded (two mids of the boundary turn elements inside out), tilted (in a tilted plane, as floats), or
rough (2 alone; in a tilted plane, all mids far off, in Nastran's fields of eight characters, to which results are rounded).
types_mesh.py check BEFORE.vtk AFTER.vtk REPORT.json: what smoothing promises of such a mesh.

types_mesh.py block KIND N AMOUNT OUT: a cube or square of N cells along each axis, cut into elements of KIND (hexahedron,
wedge, pyramid, quadrilateral; mixed, flat: several), whose inner nodes are pushed by up to AMOUNT of a cell. KIND layered:
hexahedra, the lowest three rows of which are thin. After public reports: bent (quadrilaterals and triangles in a narrow
bow, which averages tangle), projected (hexahedra whose top was projected onto a surface below the next nodes), wall (rows
of wedges as thin as in layered, whose wall has moved by four of their heights).
types_mesh.py judge BEFORE.vtk AFTER.vtk REPORT.json: what smoothing promises of that mesh, and whether the report is right."""
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

# ---- second order: smoothed with its mid-side nodes ----------------------------------------------------------------

MIDS = {2: [(0, 1), (1, 2), (2, 0)], 3: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]}
DATA_TYPES = {"plain": "double", "folded": "double", "tilted": "float"}


def second(dim, kind, path, seed="51"):
    """Write a mesh whose inner corners are pushed by up to a quarter of a cell."""
    random.seed(int(seed))
    n = 3 if dim == 3 else 7
    x, number, mid_of = [], {}, {}
    for at in itertools.product(range(n + 1), repeat=dim):
        inside = all(0 < c < n for c in at)
        number[at] = len(x)
        x.append([(c + inside * random.uniform(-0.25, 0.25)) / n for c in at] + [0.0] * (3 - dim))
    elements = []
    for at in itertools.product(range(n), repeat=dim):
        for order in itertools.permutations(range(dim)):
            steps = [at]
            for d in order:
                steps.append(tuple(c + (d == e) for e, c in enumerate(steps[-1])))
            if sum(a > b for a, b in itertools.combinations(order, 2)) % 2 == 1:
                steps[1:3] = steps[2:0:-1]  # all have one orientation
            elements.append([number[s] for s in steps])
    n_curved = n_folded = 0
    on_ground = {p for at, p in number.items() if at[-1] == 0}
    for nodes in elements:
        for a, b in MIDS[dim]:
            edge = tuple(sorted((nodes[a], nodes[b])))
            if edge in mid_of:
                continue
            mid = middle([x[edge[0]], x[edge[1]]])
            if on_ground.issuperset(edge) and n_curved < 6:  # the ends stay, and so does the curve
                mid[dim - 1] += 0.04 / n
                n_curved += 1
                if kind == "folded" and n_folded < 2:
                    mid = [p + 0.6 * (q - p) for p, q in zip(mid, x[edge[1]])]
                    n_folded += 1
            mid_of[edge] = len(x)
            x.append(mid)
        nodes += [mid_of[tuple(sorted((nodes[a], nodes[b])))] for a, b in MIDS[dim]]
    if kind == "rough":
        for mid in mid_of.values():
            x[mid][:2] = [c + random.uniform(-0.25, 0.25) / n for c in x[mid][:2]]
    if kind in ("tilted", "rough"):
        x = [[0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1] - 1, 0.3 * p[0] + 0.2 * p[1]] for p in x]
    if kind == "rough":
        write_nastran(path, [[p[0] + 3, p[1] + 3, p[2] + 1] for p in x], elements)
    else:
        write(path, x, [(24 if dim == 3 else 22, nodes) for nodes in elements], DATA_TYPES[kind])


def write_nastran(path, x, elements):
    with open(path, "w") as out:
        print("BEGIN BULK", file=out)
        for i, p in enumerate(x, 1):
            print("GRID    %8d%8s%8.5f%8.5f%8.5f" % (i, "", *p), file=out)
        for i, nodes in enumerate(elements, 1):
            print("CTRIA6  %8d%8d" % (i, 1) + "".join("%8d" % (p + 1) for p in nodes), file=out)
        print("ENDDATA", file=out)


def read_second(path):
    """Points and elements of a file that second() has written, or planish from it."""
    words = open(path).read().split()
    at = words.index("POINTS")
    n, at = int(words[at + 1]), at + 3
    x = [[float(w) for w in words[at + 3 * i:at + 3 * i + 3]] for i in range(n)]
    at = words.index("CELLS")
    m, at, elements = int(words[at + 1]), at + 3, []
    for _ in range(m):
        size = int(words[at])
        elements.append([int(w) for w in words[at + 1:at + 1 + size]])
        at += 1 + size
    return x, elements


def least_det(before, x, nodes):
    """The least determinant of an element at the points of a grid, in units of that of its corners before."""
    dim, steps = (2, 6) if len(nodes) == 6 else (3, 4)
    p, normals = [x[i] for i in nodes], []
    if dim == 2:
        u, v = (minus(before[nodes[i]], before[nodes[0]]) for i in (1, 2))
        normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        normals = [[c / length(normal) for c in normal]]
    least = math.inf
    for share in itertools.product(range(steps + 1), repeat=dim):
        if sum(share) > steps:
            continue
        at = [1 - sum(share) / steps] + [s / steps for s in share]
        # dx / d(at[j]) - dx / d(at[0]), of x = sum at_i (2 at_i - 1) p_i + sum 4 at_i at_j mid_ij
        rates = [[(4 * at[j] - 1) * p[j][d] for d in range(3)] for j in range(dim + 1)]
        for k, (a, b) in enumerate(MIDS[dim]):
            for d in range(3):
                rates[a][d] += 4 * at[b] * p[dim + 1 + k][d]
                rates[b][d] += 4 * at[a] * p[dim + 1 + k][d]
        rows = [minus(rates[j], rates[0]) for j in range(1, dim + 1)] + normals
        corners = [minus(before[nodes[j]], before[nodes[0]]) for j in range(1, dim + 1)]
        least = min(least, det(rows) / det(corners + normals))
    return least


def check(before, after, report):
    with open(report) as text:
        r = json.load(text)
    (x, elements), (y, _) = read_second(before), read_second(after)
    dim = 2 if len(elements[0]) == 6 else 3
    rounding = 4e-6 if r["mesh"]["plane"] and r["mesh"]["plane"]["tilted"] else 1e-12
    faces = {}
    for e in elements:
        for face in itertools.combinations(sorted(e[:dim + 1]), dim):
            faces[face] = faces.get(face, 0) + 1
    boundary = {p for face, n in faces.items() if n == 1 for p in face}
    slides = r["mesh"]["sliding_nodes"] > 0
    n_moved, off = 0, set()
    for e in elements:
        for k, (a, b) in enumerate(MIDS[dim]):
            mid, ends = e[dim + 1 + k], (e[a], e[b])
            ways = [minus(y[p], x[p]) for p in ends]
            wanted = [c + (u + v) / 2 for c, u, v in zip(x[mid], *ways)]
            if math.dist(y[mid], wanted) > rounding:
                off.add(mid)
            n_moved += any(ways[0]) or any(ways[1])
    assert len(off) <= r["released_mids"], "a mid follows by half of the way of both ends"
    assert n_moved > 10 and (slides or all(x[p] == y[p] for p in boundary))
    states = [[least_det(x, z, e) > 0 for e in elements] for z in (x, y)]
    assert all(new or not old for old, new in zip(*states)), "an element that was valid is not"
    assert r["before"]["inverted"] == states[0].count(False), (r["before"]["inverted"], states[0].count(False))
    assert r["after"]["inverted"] == states[1].count(False)
    left = [i for i, valid in enumerate(states[1]) if not valid]
    assert r["inverted_inside"] == left and r["after"]["inverted_inside"] == len(left)
    assert r["certified"] == (not left) and r["after"]["uncertified"] == 0 and r["refused_moves"] >= 0
    assert [w["element"] for w in r["after"]["worst_elements"] if w["radius_ratio"] is None] == left[:10]
    name = "tetrahedron10" if dim == 3 else "triangle6"
    assert r["after"]["counts"] == {name: len(elements)} and list(r["after"]["by_type"]) == [name]
    n_curved = sum(any(math.dist(x[e[dim + 1 + k]], middle([x[e[a]], x[e[b]]])) > 1e-3 for k, (a, b) in
                       enumerate(MIDS[dim])) for e in elements)
    assert r["before"]["curved"] == n_curved > 2, n_curved
    assert r["after"]["curved"] == n_curved or r["released_mids"] > 0, r["after"]["curved"]
    mesh = r["mesh"]
    assert (mesh["free_nodes"] + mesh["sliding_nodes"] + mesh["mid_side_nodes"] + sum(mesh["held"].values())
            == mesh["nodes"] and mesh["unused_nodes"] == 0 < mesh["mid_side_nodes"])
    assert r["after"]["rms_radius_ratio"] < r["before"]["rms_radius_ratio"]


def write(path, points, cells, data_type="double"):
    with open(path, "w") as out:
        print("# vtk DataFile Version 3.0\ntypes\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", len(points), data_type,
              file=out)
        for p in points:
            print(*(map("%.9g".__mod__, p) if data_type == "float" else map(repr, p)), file=out)
        print("CELLS", len(cells), sum(len(n) + 1 for _, n in cells), file=out)
        for _, nodes in cells:
            print(len(nodes), *nodes, file=out)
        print("CELL_TYPES", len(cells), file=out)
        for number, _ in cells:
            print(number, file=out)


# ---- blocks of elements of first order -----------------------------------------------------------------------------

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
SHAPE_OF = {5: "triangle", 9: "quadrilateral", 10: "tetrahedron", 12: "hexahedron", 13: "wedge", 14: "pyramid"}
CORNERS.update(triangle=[(0, 0, 0), (1, 0, 0), (HALF, ROOT, 0)],
               quadrilateral=[(*p, 0) for p in SQUARE])
EDGES.update(triangle=[(0, 1), (1, 2), (2, 0)], quadrilateral=[(0, 1), (1, 2), (2, 3), (3, 0)])


def cut(kind, at, add, place):
    """Elements of a cell with the corners at; add(point) makes a node, place: the cell's."""
    if len(at) == 4:
        halves = [(5, [at[0], at[1], at[2]]), (5, [at[0], at[2], at[3]])]
        return halves if kind == "flat" and place % 3 else [(9, at)]
    if kind == "wedge" or (kind == "mixed" and place % 4 == 1):
        return [(13, [at[i] for i in (0, 1, 2, 4, 5, 6)]), (13, [at[i] for i in (0, 2, 3, 4, 6, 7)])]
    if kind == "pyramid" or (kind == "mixed" and place % 4 == 2):
        tip = add(at)
        sides = (0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)
        return [(14, [*(at[i] for i in side), tip]) for side in sides]
    return [(12, at)]


def move(kind, n, p):
    """Where a point of the unit cube is in a mesh made after a report."""
    bump = math.sin(math.pi * p[0]) * math.sin(math.pi * p[1])
    if kind == "bent":
        r, angle = 0.2 + 0.8 * p[1], 5.5 * p[0]
        return [-r * math.cos(angle), r * math.sin(angle), 0.0]
    if kind == "projected" and p[2] == 1:
        return [p[0], p[1], 1 - 0.6 * bump]
    if kind == "wall" and p[2] == 0:
        return [p[0], p[1], 0.4 / n * bump]
    return p


def block(kind, n, amount, path):
    n, amount, report = int(n), float(amount), kind
    kind = {"bent": "flat", "projected": "hexahedron", "wall": "wedge"}.get(kind, kind)
    layered = report in ("layered", "wall")
    dim = 2 if kind in ("quadrilateral", "flat") else 3
    x, number, cells = [], {}, []
    for at in itertools.product(range(n + 1), repeat=dim):
        number[at] = len(x)
        inside = all(0 < c < n for c in at) and not (layered and at[2] <= 3)
        x.append([(c + inside * random.uniform(-amount, amount)) / n for c in at] + [0.0] * (3 - dim))
    if layered:
        for at, p in number.items():
            x[p][2] = at[2] / n / 10 if at[2] <= 3 else 0.3 / n + (x[p][2] - 3 / n) / (1 - 3 / n) * (1 - 0.3 / n)

    x = [move(report, n, p) for p in x]

    def add(corners):
        x.append(middle([x[p] for p in corners]))
        return len(x) - 1

    for place, at in enumerate(itertools.product(range(n), repeat=dim)):
        flat = SQUARE if dim == 2 else [(*p, z) for z in (0, 1) for p in SQUARE]
        cells += cut(kind, [number[tuple(map(sum, zip(at, p)))] for p in flat], add, at[0] if kind == "mixed" else place)
    write(path, x, cells)


def read_block(path):
    words = open(path).read().split()
    at = words.index("CELL_TYPES")
    types = [int(w) for w in words[at + 2:at + 2 + int(words[at + 1])]]
    x, elements = read_second(path)
    return x, [(SHAPE_OF[t], e) for t, e in zip(types, elements)]


def point_of(shape, x, u, v, w):
    """Where the map of an element takes a point; linear in each of u, v and w."""
    if shape in ("triangle", "tetrahedron"):
        weights = [1 - u - v - (w if shape == "tetrahedron" else 0), u, v, w]
    elif shape == "wedge":
        weights = [c * s for s in (1 - w, w) for c in (1 - u - v, u, v)]
    else:
        base = [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
        weights = base if shape == "quadrilateral" else [c * (1 - w) for c in base] + (
            [w] if shape == "pyramid" else [c * w for c in base])
    return [sum(c * p[d] for c, p in zip(weights, x)) for d in range(3)]


def least_sampled(shape, x):
    """Least determinant of an element at points of a grid; of one sign in height in a pyramid."""
    least, steps = math.inf, [i / 2 for i in range(3)]
    is_flat = shape in ("triangle", "quadrilateral")
    for u, v, w in itertools.product(steps, steps, [0] if is_flat or shape == "pyramid" else steps):
        if shape in ("triangle", "tetrahedron", "wedge") and u + v > 1:
            continue
        p = point_of(shape, x, u, v, w)
        j = [minus(point_of(shape, x, *q), p) for q in ((u + 1, v, w), (u, v + 1, w), (u, v, w + 1))]
        least = min(least, det([*j[:2], [0, 0, 1]] if is_flat else j))
    return least


def mean_ratio(shape, x):
    """AR of an element with positive corners, and its least scaled Jacobian."""
    if shape not in ("triangle", "quadrilateral"):
        _, square, scaled, _ = measure(shape, x)
        return square ** 0.5, scaled
    squares, scaled, n = [], [], len(x)
    for c in range(n):
        a, b = (minus(x[i], x[c]) for i in ((c + 1) % n, (c - 1) % n))
        area = a[0] * b[1] - a[1] * b[0]
        product = a[0] * b[0] + a[1] * b[1]
        scaled.append(area / length(a) / length(b) / (1 if n == 4 else ROOT))
        edges = sum(v * v for v in a + b)
        # |T|^2 / (2 det T): T is J for a right angle, and takes edges of 60 degrees to it.
        squares.append((edges / (2 * area) if n == 4 else (edges - product) / (2 * ROOT * area)) ** 2)
    return math.sqrt(sum(squares) / n), min(scaled)


def judge(before, after, report):
    with open(report) as text:
        r = json.load(text)
    (x, elements), (y, same) = read_block(before), read_block(after)
    assert same == elements
    sides = {}
    for shape, e in elements:
        faces = [tuple(e[i] for i in f) for f in FACES.get(shape, [])]
        if shape == "wedge":
            faces += [e[:3], e[3:]]
        if shape == "pyramid":
            faces = [e[:4]] + [[e[i], e[(i + 1) % 4], e[4]] for i in range(4)]
        if shape in ("triangle", "quadrilateral"):
            faces = [(e[a], e[b]) for a, b in EDGES[shape]]
        for face in faces:
            key = tuple(sorted(face))
            sides[key] = sides.get(key, 0) + 1
    held = {p for face, n in sides.items() if n == 1 for p in face}
    assert r["mesh"]["free_nodes"] == len(x) - len(held) - r["mesh"]["held"]["layers"], r["mesh"]
    assert all(x[p] == y[p] for p in held) and sum(p != q for p, q in zip(x, y)) == r["moved_nodes"] > 0
    states = [[least_sampled(shape, [z[p] for p in e]) > 0 for shape, e in elements] for z in (x, y)]
    assert r["before"]["inverted"] >= states[0].count(False) and r["after"]["inverted"] >= states[1].count(False)
    assert r["certified"] == (r["after"]["inverted"] == 0)
    assert r["objective"]["measure"] == "aspect-ratio"
    for of in r["before"], r["after"]:
        assert of["rms_radius_ratio"] is of["min_dihedral_deg"] is of["histogram"] is None
        assert sum(of["counts"].values()) == r["mesh"]["elements"] == len(elements)
        assert of["corner_inverted"] > 0 or sum(of["aspect_histogram"]["counts"]) == len(elements)
    if not r["certified"]:
        return
    found = [mean_ratio(shape, [y[p] for p in e]) for shape, e in elements]
    rms = math.sqrt(sum(ratio ** 2 for ratio, _ in found) / len(found))
    if r["target"] == "regular":
        assert math.isclose(rms, r["after"]["rms_aspect_ratio"], rel_tol=1e-9), (rms, r["after"]["rms_aspect_ratio"])
        assert math.isclose(max(found)[0], r["after"]["max_aspect_ratio"], rel_tol=1e-9)
    assert math.isclose(min(s for _, s in found), r["after"]["min_scaled_jacobian"], rel_tol=1e-9)
    if r["before"]["inverted"] == 0:
        for key, sign in (("rms_aspect_ratio", 1), ("max_aspect_ratio_movable", 1), ("min_scaled_jacobian", -1)):
            assert sign * r["after"][key] <= sign * r["before"][key] + 1e-12, key


if sys.argv[1] == "block":
    block(*sys.argv[2:])
    sys.exit()
if sys.argv[1] == "judge":
    judge(*sys.argv[2:])
    sys.exit()
if sys.argv[1] == "second":
    second(int(sys.argv[2]), *sys.argv[3:])
    sys.exit()
if sys.argv[1] == "check":
    check(*sys.argv[2:])
    sys.exit()

points, cells, expected = [], [], {}
for name, (number, shape, has_mids, has_faces, has_middle) in TYPES.items():
    of = {"elements": 0, "inverted": 0, "corner_inverted": 0, "curved": 0, "squares": [], "scaled": [], "edges": []}
    expected[name] = of
    # A tangled one (of single tetrahedra the orientation is open), and one with a mid that is a little or much off the
    # middle of its edge.
    for kind in ["plain"] * 5 + ["tangled"] * (shape != "tetrahedron") + (["curved", "folded"] if has_mids else []):
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


write(sys.argv[1], points, cells)
write(sys.argv[3], points, [(10, c[1][:4]) for c in cells if c[0] in (10, 24)])
with open(sys.argv[2], "w") as out:
    json.dump({"counts": {name: of["elements"] for name, of in expected.items()}, "all": total(expected.values()),
               "by_type": {name: total([of]) for name, of in expected.items()}}, out)
