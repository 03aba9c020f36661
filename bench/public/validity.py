"""validity: is the determinant of an element's Jacobian positive everywhere? Decided, not sampled.

The determinant is a polynomial. It lies between its least and its largest Bernstein coefficient, and those at corners are
values of it. Coefficients are computed in doubles with a bound of their error; where it does not do, in whole
numbers, which scaled coordinates are. An element whose coefficients do not decide is cut until those of all pieces
do, or until there are too many pieces: then nothing is known."""
import itertools
from functools import lru_cache
from math import factorial, prod

import numpy as np

from shapes import FACTORS, SHAPES, control_matrix, lattice

VALID, INVALID, UNKNOWN = 1, -1, 0
MOST_PIECES = 3000
# Of a coefficient, relative to the sum of the absolute values of its terms: there are fewer than 2000 operations.
ROUNDING = 2000 * 2.0 ** -53
CUTTING = 1e-12
SMALLEST = 1e-280
CHUNK = 20000


def _multinomial(point):
    return prod(factorial(sum(p)) // prod(map(factorial, p)) for p in point)


def _derivative(control, factor, j):
    """Of a scaled Bernstein polynomial (coefficients times multinomials) by parameter j of a factor, but for a positive
    number. control: coefficients without multinomials."""
    def raised(point, i):
        one = list(point[factor])
        one[i] += 1
        return (*point[:factor], tuple(one), *point[factor + 1:])
    lower = {tuple(tuple(c - (f == factor and i == 0) for i, c in enumerate(p)) for f, p in enumerate(point))
             for point in control if point[factor][0] > 0}
    return {point: (control[raised(point, j)], control[raised(point, 0)]) for point in lower}


def _times(f, g):
    """The product of two scaled Bernstein polynomials."""
    product = {}
    for (a, x), (b, y) in itertools.product(f.items(), g.items()):
        at = tuple(tuple(map(sum, zip(p, q))) for p, q in zip(a, b))
        product[at] = product[at] + x * y if at in product else x * y
    return product


def _plus(f, g, sign):
    return {at: f[at] + sign * g[at] for at in f}


def _determinant(columns, sign):
    """Of columns of polynomials: columns[parameter][axis]. sign -1: the determinant; 1: the sum of its terms' absolute
    values, if the columns are absolute values."""
    if len(columns) == 2:
        (a, b), (c, d) = columns
        return _plus(_times(a, d), _times(b, c), sign)
    first, second, third = columns
    total = None
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        minor = _plus(_times(second[j], third[k]), _times(second[k], third[j]), sign)
        term = _times(first[i], minor)
        total = term if total is None else _plus(total, term, 1)
    return total


def _columns(name, nodes, is_size):
    """The derivatives of the map: [parameter][axis], scaled Bernstein polynomials of arrays [elements]. nodes
    [elements][nodes][dim], relative to the first node; is_size: bounds of the absolute values instead."""
    base = SHAPES[name].base
    points, matrix = control_matrix(base if base == "pyramid" else name)
    dim, n = nodes.shape[2], len(matrix[0])
    sign = 1 if is_size else -1
    def combined(row):
        total = 0
        for w, i in zip(row, range(n)):
            if w:
                total = total + (abs(w) if is_size else w) * nodes[:, i]
        return total + np.zeros_like(nodes[:, 0])
    control = {point: combined(row) for point, row in zip(points, matrix)}
    columns = []
    for factor, k in enumerate(FACTORS[base]):
        for j in range(1, k + 1):
            columns.append({at: (a + sign * b) * _multinomial(at) for at, (a, b) in
                            _derivative(control, factor, j).items()})
    if base == "pyramid":  # to the tip, from the base
        columns.append({at: (nodes[:, 4] + sign * value) * _multinomial(at) for at, value in control.items()})
    return [[{at: value[:, axis] for at, value in column.items()} for axis in range(dim)] for column in columns]


def coefficients(name, nodes):
    """Points of the lattice, and Bernstein coefficients [elements][points] times a positive number common to all."""
    poly = _determinant(_columns(name, nodes, False), -1)
    points = sorted(poly)
    scale = np.lcm.reduce([_multinomial(p) for p in points])
    return points, np.stack([poly[p] * int(scale // _multinomial(p)) for p in points], axis=1)


def _bounded(name, nodes):
    """Coefficients in doubles and a bound of their error, both [elements][points]."""
    points, value = coefficients(name, nodes)
    poly = _determinant(_columns(name, np.abs(nodes), True), 1)
    scale = np.lcm.reduce([_multinomial(p) for p in points])
    size = np.stack([poly[p] * int(scale // _multinomial(p)) for p in points], axis=1)
    return points, value, ROUNDING * size + SMALLEST


def _is_corner(point):
    return all(max(p) == sum(p) for p in point)


def whole_numbers(places):
    """Doubles [nodes][dim] times a power of two, as whole numbers relative to the first node."""
    mantissa, exponent = np.frexp(places)
    mantissa = (mantissa * 2.0 ** 53).astype(np.int64)
    least = exponent[mantissa != 0].min() if mantissa.any() else 0
    whole = np.array([[int(m) << int(max(e - least, 0)) for m, e in zip(*row)] for row in zip(mantissa, exponent)],
                     dtype=object)
    return whole - whole[:1]


@lru_cache(None)
def _pieces(k):
    """Vertices of the pieces of a simplex with k parameters, halved: rows of twice the barycentric coordinates."""
    unit = [tuple(int(i == j) for j in range(k + 1)) for i in range(k + 1)]
    mid = {(i, j): tuple(a + b for a, b in zip(unit[i], unit[j])) for i in range(k + 1) for j in range(i, k + 1)}
    corner = [[mid[min(i, j), max(i, j)] for j in range(k + 1)] for i in range(k + 1)]
    if k == 2:
        return corner + [[mid[0, 1], mid[1, 2], mid[0, 2]]]
    if k == 3:  # around the diagonal between the mids of two opposite edges
        ring = [mid[0, 1], mid[0, 3], mid[2, 3], mid[1, 2]]
        return corner + [[mid[0, 2], mid[1, 3], ring[i], ring[(i + 1) % 4]] for i in range(4)]
    return corner


@lru_cache(None)
def _to_piece(k, degree, piece, is_whole):
    """Coefficients of a piece by those of the whole: doubles [points][points]; or whole numbers, times 2^degree."""
    points = [p for (p,) in lattice((k,), (degree,))]
    index = {p: i for i, p in enumerate(points)}
    matrix = np.zeros((len(points), len(points)), dtype=object)
    for i, point in enumerate(points):
        terms = {(0,) * (k + 1): 1}
        for vertex, count in zip(_pieces(k)[piece], point):
            for _ in range(count):
                grown = {}
                for at, w in terms.items():
                    for j, share in enumerate(vertex):
                        if share:
                            key = tuple(c + (n == j) for n, c in enumerate(at))
                            grown[key] = grown.get(key, 0) + w * share
                terms = grown
        for at, w in terms.items():
            matrix[i, index[at]] = w
    return matrix if is_whole else matrix.astype(float) / 2 ** degree


def _cut(values, sizes, degrees):
    """Coefficients of all pieces, every factor halved."""
    shape = [len(lattice((k,), (n,))) for k, n in zip(sizes, degrees)]
    is_whole = values.dtype == object
    for which in itertools.product(*(range(len(_pieces(k))) for k in sizes)):
        piece = values.reshape(shape)
        for axis, (k, n, p) in enumerate(zip(sizes, degrees, which)):
            piece = np.moveaxis(np.tensordot(_to_piece(k, n, p, is_whole), piece, (1, axis)), 0, axis)
        yield piece.ravel()


def _search(name, points, value, error):
    """VALID, INVALID or UNKNOWN by coefficients [points] that are wrong by at most error (whole numbers: 0)."""
    sizes, degrees = FACTORS[SHAPES[name].base], tuple(sum(p) for p in points[0])
    order = lattice(sizes, degrees)
    corners = np.array([_is_corner(p) for p in order])
    left, most = [value[[points.index(p) for p in order]]], MOST_PIECES if error else MOST_PIECES // 10
    for _ in range(most):
        if not left:
            return VALID
        piece = left.pop(0)
        least = piece[corners].min()
        if least <= -error:
            return INVALID
        if least <= error:  # in doubles nothing is known; of whole numbers this is not reached
            return UNKNOWN
        if piece.min() <= error:
            left += _cut(piece, sizes, degrees)
    return UNKNOWN


def decide(name, places, sign):
    """VALID, INVALID or UNKNOWN, of one element with nodes at places [nodes][dim], in whole numbers. sign: 1, or -1 if
    the determinant should be negative."""
    points, value = coefficients(name, whole_numbers(places)[None])
    return _search(name, points, value[0] * sign, 0)


def states(name, places, sign):
    """VALID, INVALID or UNKNOWN of elements of one type: places [elements][nodes][dim], sign [elements]."""
    found = np.zeros(len(places), int)
    for begin in range(0, len(places), CHUNK):
        part = slice(begin, begin + CHUNK)
        near = places[part] - places[part][:, :1]
        size = np.abs(near).max(axis=(1, 2), keepdims=True)
        near = near / np.exp2(np.floor(np.log2(np.where(size > 0, size, 1))))
        points, value, error = _bounded(name, near)
        value = value * sign[part][:, None]
        corner = np.array([_is_corner(p) for p in points])
        state = np.where((value > error).all(axis=1), VALID, UNKNOWN)
        state[(value[:, corner] < -error[:, corner]).any(axis=1)] = INVALID
        for i in np.flatnonzero(state == UNKNOWN):
            state[i] = (_search(name, points, value[i], error[i].max() + CUTTING * np.abs(value[i]).max())
                        or decide(name, places[begin + i], int(sign[begin + i])))
        found[part] = state
    return found
