"""Readers of mesh files and formulas of textbooks, for the tests: they share no code with planish.

read(path): a Mesh from Medit, or from Gmsh MSH 2.2 or 4.1 in ASCII.
"""
import itertools
import math
from collections import namedtuple

# points: their coordinates; elements: their nodes, as indices of points; numbers: the file's element
# numbers; regions: Medit's references, Gmsh's elementary entities.
Mesh = namedtuple("Mesh", "dim points elements numbers regions")

CORNERS = {"15": 1, "1": 2, "2": 3, "4": 4}


def read(path):
    words = open(path).read().split()
    if words[0] != "$MeshFormat":
        return read_medit(words)
    return read_gmsh4(words) if words[1].startswith("4") else read_gmsh2(words)


def read_medit(words):
    dim = int(words[words.index("Dimension") + 1])
    at = words.index("Vertices") + 2
    rows = range(at, at + (dim + 1) * int(words[at - 1]), dim + 1)
    points = [[float(x) for x in words[i:i + dim]] for i in rows]
    at = words.index("Tetrahedra" if dim == 3 else "Triangles") + 2
    rows = range(at, at + (dim + 2) * int(words[at - 1]), dim + 2)
    elements = [[int(n) - 1 for n in words[i:i + dim + 1]] for i in rows]
    regions = [int(words[i + dim + 1]) for i in rows]
    return Mesh(dim, points, elements, list(range(1, len(elements) + 1)), regions)


def make(nodes, cells):
    """nodes: coordinates by the file's number; cells: (kind, number, region, numbers of nodes)."""
    dim = 3 if any(kind == "4" for kind, *_ in cells) else 2
    index = {number: i for i, number in enumerate(nodes)}
    chosen = [cell for cell in cells if CORNERS[cell[0]] == dim + 1]
    return Mesh(dim, [xyz[:dim] for xyz in nodes.values()],
                [[index[n] for n in cell[3]] for cell in chosen],
                [int(cell[1]) for cell in chosen], [int(cell[2]) for cell in chosen])


def read_gmsh2(words):
    at = words.index("$Nodes") + 2
    rows = range(at, at + 4 * int(words[at - 1]), 4)
    nodes = {words[i]: [float(x) for x in words[i + 1:i + 4]] for i in rows}
    at, cells = words.index("$Elements") + 2, []
    for _ in range(int(words[at - 1])):
        number, kind, tags = words[at], words[at + 1], int(words[at + 2])
        begin = at + 3 + tags
        at = begin + CORNERS[kind]
        cells.append((kind, number, words[begin - tags + 1], words[begin:at]))
    return make(nodes, cells)


def read_gmsh4(words):
    at = words.index("$Nodes") + 1
    blocks, at, nodes = int(words[at]), at + 4, {}
    for _ in range(blocks):
        count, at = int(words[at + 3]), at + 4
        numbers, at = words[at:at + count], at + count
        for number in numbers:
            nodes[number] = [float(x) for x in words[at:at + 3]]
            at += 3
    at = words.index("$Elements") + 1
    blocks, at, cells = int(words[at]), at + 4, []
    for _ in range(blocks):
        region, kind, count, at = words[at + 1], words[at + 2], int(words[at + 3]), at + 4
        for _ in range(count):
            cells.append((kind, words[at], region, words[at + 1:at + 1 + CORNERS[kind]]))
            at += 1 + CORNERS[kind]
    return make(nodes, cells)


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return math.fsum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def volume(t):
    """Signed; the area of a triangle in the plane."""
    a, b = minus(t[1], t[0]), minus(t[2], t[0])
    if len(t) == 3:
        return (a[0] * b[1] - a[1] * b[0]) / 2
    return dot(a, cross(b, minus(t[3], t[0]))) / 6


def edges(t):
    return [math.dist(t[i], t[j]) for i in range(len(t)) for j in range(i)]


def radius_ratio(t):
    """R/(3r): 24 V R = sqrt of a product like Heron's of the three products of opposite edges;
    r = 3 V / (sum of the faces' areas). R/(2r) of a triangle of sides a, b, c and area A:
    R = abc/(4A), r = 2A/(a + b + c)."""
    v = abs(volume(t))
    if len(t) == 3:
        return math.prod(edges(t)) * math.fsum(edges(t)) / (16 * v * v)

    def edge(i, j):
        return math.dist(t[i], t[j])
    p, q, s = edge(0, 1) * edge(2, 3), edge(0, 2) * edge(1, 3), edge(0, 3) * edge(1, 2)
    circum = math.sqrt(max(0, (p + q + s) * (q + s - p) * (p + s - q) * (p + q - s))) / (24 * v)
    area = sum(math.hypot(*cross(minus(t[j], t[i]), minus(t[k], t[i]))) / 2
               for i, j, k in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)))
    return circum * area / (9 * v)


def mean_ratio(t):
    """Mean square edge by that of the regular element of the same volume."""
    v, squares = abs(volume(t)), [e * e for e in edges(t)]
    regular = 4 * v / math.sqrt(3) if len(t) == 3 else (6 * math.sqrt(2) * v) ** (2 / 3)
    return math.fsum(squares) / len(squares) / regular


def edge_ratio(t):
    """Longest edge by shortest with the extremes smoothed: means of the 32nd powers of the squares."""
    squares = [e * e for e in edges(t)]
    longest, shortest = max(squares), min(squares)
    means = (sum((s / longest) ** 32 for s in squares) / len(squares)
             * sum((shortest / s) ** 32 for s in squares) / len(squares))
    return math.sqrt(longest / shortest * means ** (1 / 32))


RATIOS = {"radius-ratio": radius_ratio, "mean-ratio": mean_ratio, "edge-ratio": edge_ratio}


def corners(mesh):
    """The points of each element."""
    return [[mesh.points[n] for n in element] for element in mesh.elements]


def volumes(mesh):
    """Of all elements; those of a file whose order is the negative one come out positive as well."""
    signed = [volume(t) for t in corners(mesh)]
    return signed if math.fsum(signed) > 0 else [-v for v in signed]


def rms(values):
    values = list(values)
    return math.sqrt(math.fsum(v * v for v in values) / len(values))


def boundary(mesh):
    """Nodes of facets that only one element has."""
    count = {}
    for element in mesh.elements:
        for left_out in element:
            facet = frozenset(n for n in element if n != left_out)
            count[facet] = count.get(facet, 0) + 1
    return {n for facet, times in count.items() if times == 1 for n in facet}


def split_cube(index, x, y, z):
    """The six positive tetrahedra of a cube around its diagonal; index: nodes by their places, (x, y, z) and one more."""
    elements = []
    for path in itertools.permutations(range(3)):
        at, corners = [x, y, z], [index[x, y, z]]
        for axis in path:
            at[axis] += 1
            corners.append(index[tuple(at)])
        is_odd = path in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        elements.append(corners[:2] + corners[:1:-1] if is_odd else corners)
    return elements
