"""shapes: element types as VTK numbers their nodes: where the nodes are, facets, corners, ideal corners.

The reference element is a product of simplices (factors). A point of the lattice is a tuple with one tuple of
barycentric counts per factor, such as ((1, 1), (0, 2)) for a mid of a quadrilateral of second order."""
import itertools
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np

HALF, THIRD_ROOT = np.sqrt(3) / 2, np.sqrt(3) / 6
IDEAL = {  # columns: the edges of an ideal corner
    "triangle": np.array([[1, 0.5], [0, HALF]]),
    "quad": np.eye(2),
    "tetra": np.array([[1, 0.5, 0.5], [0, HALF, THIRD_ROOT], [0, 0, np.sqrt(2 / 3)]]),
    "hexahedron": np.eye(3),
    "wedge": np.array([[1, 0.5, 0], [0, HALF, 0], [0, 0, 1]]),
    "pyramid": np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, np.sqrt(0.5)]]),
}
SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))
FACTORS = {"triangle": (2,), "quad": (1, 1), "tetra": (3,), "hexahedron": (1, 1, 1), "wedge": (2, 1), "pyramid": (1, 1)}
# A corner and its neighbours, right-handed.
CORNERS = {
    "triangle": [(0, 1, 2), (1, 2, 0), (2, 0, 1)],
    "quad": [(0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2)],
    "tetra": [(0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 0, 2, 1)],
    "hexahedron": [(0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7),
                   (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)],
    "wedge": [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)],
    "pyramid": [(0, 1, 3, 4), (1, 2, 0, 4), (2, 3, 1, 4), (3, 0, 2, 4)],
}
# Facets by their corners, seen from outside; in the plane edges around the element.
FACETS = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetra": [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)],
    "hexahedron": [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
    "wedge": [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "pyramid": [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
}
# Nodes of second order: the corners that each is between.
EDGES = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
}
SIDES = {
    "quad": [(0, 1, 2, 3)],
    "hexahedron": [(0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7),
                   tuple(range(8))],
    "wedge": [(0, 1, 3, 4), (1, 2, 4, 5), (0, 2, 3, 5)],
    "pyramid": [(0, 1, 2, 3)],
}
SECOND_ORDER = {"triangle6": ("triangle", 0), "quad8": ("quad", 0), "quad9": ("quad", 1), "tetra10": ("tetra", 0),
                "hexahedron20": ("hexahedron", 0), "hexahedron27": ("hexahedron", 1), "wedge15": ("wedge", 0),
                "wedge18": ("wedge", 1), "pyramid13": ("pyramid", 0), "pyramid14": ("pyramid", 1)}


@dataclass(frozen=True)
class Shape:
    """Type of an element: its base (the type of first order), dimension, order, and the corners that each node is
    between (a corner: itself)."""
    name: str
    base: str
    dim: int
    order: int
    between: tuple

    @property
    def n_corners(self):
        return len(CORNERS[self.base]) + (self.base == "pyramid")

    @property
    def corners(self):
        return CORNERS[self.base]

    @property
    def ideal(self):
        return IDEAL[self.base]

    @property
    def facets(self):
        return FACETS[self.base]

    def facet_nodes(self, facet):
        """All nodes of a facet: its corners, and the nodes between corners that are all its own."""
        return [i for i, ends in enumerate(self.between) if set(ends) <= set(facet)]

    def facet_in_order(self, facet):
        """The corners of a facet, then the mids of its edges."""
        if self.order == 1:
            return list(facet)
        ends = [{a, b} for a, b in zip(facet, (*facet[1:], facet[0]))]
        return list(facet) + [next(i for i, e in enumerate(self.between) if set(e) == edge) for edge in ends]


def _shape(name):
    base, has_sides = SECOND_ORDER.get(name, (name, 0))
    between = [(i,) for i in range(len(CORNERS[base]) + (base == "pyramid"))]
    if name in SECOND_ORDER:
        between += EDGES[base] + (SIDES.get(base, []) if has_sides else [])
    return Shape(name, base, 2 if base in ("triangle", "quad") else 3, 1 + (name in SECOND_ORDER), tuple(between))


SHAPES = {name: _shape(name) for name in (*CORNERS, *SECOND_ORDER)}


def vertices(base):
    """Of the corners, in order, the vertex of each factor. A pyramid's are those of its base."""
    if base in ("quad", "pyramid"):
        return [(i, j) for i, j in SQUARE]
    if base == "hexahedron":
        return [(i, j, k) for k in (0, 1) for i, j in SQUARE]
    if base == "wedge":
        return [(i, k) for k in (0, 1) for i in range(3)]
    return [(i,) for i in range(FACTORS[base][0] + 1)]


def lattice(sizes, degrees):
    """All points of the lattice of factors with so many parameters and such degrees."""
    one = [[p for p in itertools.product(range(n + 1), repeat=k + 1) if sum(p) == n] for k, n in zip(sizes, degrees)]
    return list(itertools.product(*one))


def _place(base, ends, order):
    """The point of the lattice in the middle of these corners."""
    vertex = [vertices(base)[i] for i in ends]
    point = []
    for factor, k in enumerate(FACTORS[base]):
        counts = [sum(Fraction(order, len(ends)) for v in vertex if v[factor] == i) for i in range(k + 1)]
        point.append(tuple(map(int, counts)))
    return tuple(point)


def _mean_of_side(base, corners):
    """A node that the type lacks, as its serendipity functions have it: weights of points of the lattice."""
    edges = [e for e in EDGES[base] if set(e) <= set(corners)]
    weight = {_place(base, (i,), 2): Fraction(-1, 4) for i in corners}
    share = Fraction(2 if len(corners) == 4 else 1, 4)
    return {**weight, **{_place(base, e, 2): share for e in edges}}


@lru_cache(None)
def control_matrix(name):
    """The Bernstein control points of an element's map by its nodes: the points of the lattice, and whole numbers
    [points][nodes], a common positive multiple of the true weights."""
    shape = SHAPES[name]
    base, order = shape.base, shape.order
    sizes, degrees = FACTORS[base], (order,) * len(FACTORS[base])
    points = lattice(sizes, degrees)
    n_placed = len(shape.between) - (base == "pyramid")
    value = {_place(base, ends, order): {i: Fraction(1)} for i, ends in enumerate(shape.between[:n_placed])}
    for side in SIDES.get(base, ()) if order == 2 else ():
        if _place(base, side, 2) not in value:
            total = {}
            for point, weight in _mean_of_side(base, side).items():
                for node, w in value[point].items():
                    total[node] = total.get(node, 0) + weight * w
            value[_place(base, side, 2)] = total
    rows = [[Fraction(0)] * len(shape.between) for _ in points]
    for row, point in zip(rows, points):
        for terms in itertools.product(*(_control_terms(p) for p in point)):
            weight, at = Fraction(1), []
            for w, p in terms:
                weight, at = weight * w, at + [p]
            for node, w in value[tuple(at)].items():
                row[node] += weight * w
    scale = np.lcm.reduce([w.denominator for row in rows for w in row])
    return points, [[int(w * int(scale)) for w in row] for row in rows]


def _control_terms(point):
    """A control point of one factor by values at points of the lattice: of a mid 2 m - (a + b) / 2."""
    ends = [i for i, count in enumerate(point) if count == 1]
    if sum(point) == 1 or len(ends) != 2:
        return [(Fraction(1), point)]
    corner = [tuple(2 * (i == e) for i in range(len(point))) for e in ends]
    return [(Fraction(2), point), (Fraction(-1, 2), corner[0]), (Fraction(-1, 2), corner[1])]
