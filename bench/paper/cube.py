"""cube: example 3 of the paper, a cube with a smaller cube cut out of it.

A grid of 5^3 cells without 2^3, cut into five tetrahedra each, made irregular: one more free node,
random flips of faces, nodes of the outer surface merged until the count is right. A change is kept
if the free nodes can still give every element its minimum volume. Needs numpy and scipy.
"""
import numpy as np
from scipy.optimize import minimize

from simplices import faces_of, normals, radius_ratios, volumes
from spoil import spoil

LEAST_FRACTION = 1e-3  # of the domain's volume: delta of the paper
ROOM = 1.02            # kept above it while the mesh is made
ATTEMPTS = 400
CELLS, HOLE_FROM, HOLE_TO = 5, 2, 4  # a cube of 5^3 cells without the 2^3 from (2,2,2) to (4,4,4)


def cut_cell(corner):
    """Five tetrahedra of a cell: one at each corner with an even sum, and the rest."""
    nodes = [tuple(corner[d] + bits[d] for d in range(3)) for bits in np.ndindex(2, 2, 2)]
    even = [node for node in nodes if sum(node) % 2 == 0]
    odd = [node for node in nodes if sum(node) % 2 == 1]
    near = [[b for b in odd if sum(abs(np.subtract(a, b))) == 1] for a in even]
    return [[a] + others for a, others in zip(even, near)] + [odd]


def grid_of_cells():
    """points, elements and the free nodes of the cube in a cube, as a grid."""
    cells = [cell for cell in np.ndindex(CELLS, CELLS, CELLS)
             if not all(HOLE_FROM <= c < HOLE_TO for c in cell)]
    tetrahedra = [tetrahedron for cell in cells for tetrahedron in cut_cell(cell)]
    nodes = sorted({node for tetrahedron in tetrahedra for node in tetrahedron})
    index = {node: i for i, node in enumerate(nodes)}
    on_boundary = [any(c in (0, CELLS) for c in node)
                   or all(HOLE_FROM <= c <= HOLE_TO for c in node) for node in nodes]
    elements = oriented(np.array(nodes, float),
                        np.array([[index[n] for n in t] for t in tetrahedra]))
    return np.array(nodes) / CELLS, elements, np.flatnonzero(~np.array(on_boundary))


def oriented(points, elements):
    turned = volumes(points, elements) < 0
    elements[turned] = elements[turned][:, [0, 1, 3, 2]]
    return elements


INVERTED = 1e3  # stands for the energy of a mesh with inverted elements


def even_out(points, elements, free, power=8, iterations=60):
    """Move the free nodes so that no volume is small: minimise log sum (mean / V)^power."""
    def energy(x):
        here = points.copy()
        here[free] = x.reshape(-1, 3)
        v = volumes(here, elements)
        if v.min() <= 0:
            return INVERTED, np.zeros_like(x)
        terms = (v.mean() / v) ** power
        push = (-power / terms.sum()) * terms / v / 6
        gradient = np.zeros_like(points)
        for j, normal in enumerate(np.moveaxis(normals(here, elements), 1, 0)):
            np.add.at(gradient, elements[:, j], push[:, None] * normal)
        return np.log(terms.sum()), gradient[free].ravel()

    found = minimize(energy, points[free].ravel(), jac=True, method="L-BFGS-B",
                     options={"maxiter": iterations})
    result = points.copy()
    result[free] = found.x.reshape(-1, 3)
    return result


def insert_node(points, elements, free):
    """One more free node in the middle of the element with the most free nodes."""
    element = int(np.isin(elements, free).sum(axis=1).argmax())
    new, corners = len(points), elements[element]
    split = np.tile(corners, (4, 1))
    np.fill_diagonal(split, new)
    points = np.vstack([points, points[corners].mean(axis=0)])
    return points, np.vstack([np.delete(elements, element, 0), split]), np.append(free, new)


def flip_face(elements, face, pair):
    """Two tetrahedra at an inner face become three at the edge between their apices (2-3 flip)."""
    apices = [next(n for n in elements[k] if n not in face) for k in pair]
    three = np.array([[face[i], face[(i + 1) % 3], *apices] for i in range(3)])
    return np.vstack([np.delete(elements, pair, 0), three])


def inner_faces(elements):
    owners = {}
    for k, element in enumerate(elements):
        for face in faces_of(element):
            owners.setdefault(tuple(sorted(face)), []).append(k)
    return [(face, pair) for face, pair in owners.items() if len(pair) == 2]


def collapse(elements, node, target):
    """Elements after node has been moved onto target; those between the two are gone."""
    both = (elements == node).any(axis=1) & (elements == target).any(axis=1)
    result = elements[~both].copy()
    result[result == node] = target
    return result


def flat_neighbours(points, elements, node):
    """Neighbours of a node of the outer surface that lie in the one face that the node is in."""
    sides = [(d, v) for d in range(3) for v in (0.0, 1.0) if points[node, d] == v]
    if len(sides) != 1:
        return []
    axis, value = sides[0]
    around = np.unique(elements[(elements == node).any(axis=1)])
    return [n for n in around if n != node and points[n, axis] == value]


def least_fraction(points, elements):
    v = volumes(points, elements)
    return v.min() / v.sum()


def flip_somewhere(random, points, elements):
    """A random 2-3 flip, or None where one of the three would be inverted."""
    faces = inner_faces(elements)
    flipped = oriented(points, flip_face(elements, *faces[random.integers(len(faces))]))
    before, after = volumes(points, elements).sum(), volumes(points, flipped).sum()
    return flipped if after < before * (1 + 1e-12) else None


def collapse_somewhere(random, points, elements):
    """A random node of the outer surface merged with a neighbour there."""
    near = []
    while not near:
        node = random.integers(len(points))
        near = flat_neighbours(points, elements, node)
    return collapse(elements, node, near[random.integers(len(near))])


def changed(random, points, elements, free, change):
    """Points and elements after a random change that leaves every element room for its least
    volume; None if this one does not."""
    result = change(random, points, elements)
    if result is None or least_fraction(points, result) < 1e-6:
        return None
    evened = even_out(points, result, free)
    return (evened, result) if least_fraction(evened, result) > ROOM * LEAST_FRACTION else None


def make_irregular(random, points, elements, free, count, flips):
    """Flips of faces, then merged nodes until the count is right; RuntimeError where that fails."""
    for _ in range(ATTEMPTS):
        if flips == 0 and len(elements) == count:
            return points, elements
        change = flip_somewhere if flips > 0 else collapse_somewhere
        result = changed(random, points, elements, free, change)
        if result is not None and len(result[1]) >= count:
            points, elements = result
            flips = max(flips - 1, 0)
    raise RuntimeError("this seed does not lead to the count")


def shrunken(points, elements, free, fraction):
    """Points with one element shrunk to a fraction of the domain: of those with three free nodes,
    whose face is drawn together, the one that harms its neighbours least. Also the three nodes."""
    v = volumes(points, elements)
    best = (np.inf, None, None)
    for k in np.flatnonzero(np.isin(elements, free).sum(axis=1) == 3):
        face = np.intersect1d(elements[k], free)
        middle = points[face].mean(axis=0)
        moved = points.copy()
        moved[face] = middle + np.sqrt(fraction * v.sum() / v[k]) * (points[face] - middle)
        if volumes(moved, elements).min() > 0:
            worst = radius_ratios(moved, elements).max()
            best = min(best, (worst, moved, face), key=lambda b: b[0])
    return best[1:]


def compact(points, elements, free):
    """The same without the nodes that no element has."""
    used, corners = np.unique(elements, return_inverse=True)
    return points[used], corners.reshape(elements.shape), np.searchsorted(used, free)


def cube_example(seed, flips, count, worst, least):
    """The cube in a cube with count elements, largest radius ratio worst, smallest volume least."""
    random = np.random.default_rng(seed)
    points, elements, free = insert_node(*grid_of_cells())
    elements = oriented(points, elements)
    points, elements = make_irregular(random, even_out(points, elements, free), elements, free,
                                      count, flips)
    points, elements, free = compact(points, elements, free)
    feasible = points
    points, held = shrunken(points, elements, free, least)
    direction = random.normal(size=(len(free), 3))
    direction[np.isin(free, held)] = 0
    return spoil(points, free, elements, direction, worst), elements, feasible
