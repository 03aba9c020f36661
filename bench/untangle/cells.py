"""cells: elements of every type, and whether they are valid: decided, not sampled, without planish.

Elements are an array [m][dim + 1] of simplices (simplex.py), or Cells. The determinant of a cell's
map is a polynomial; where its Bezier coefficients are positive it is, and what they leave open is
cut in halves until a corner is not positive or all coefficients are."""
from collections import namedtuple

import numpy as np

import simplex

LEVELS = 24  # of halving; what is open then counts as inverted

# vtk: its number; faces: of corners, in the plane the edges. Nodes are in VTK's order, and such that
# determinants are positive in a valid element.
Kind = namedtuple("Kind", "dim vtk medit faces")
KINDS = {
    "triangle": Kind(2, 5, "Triangles", ((0, 1), (1, 2), (2, 0))),
    "quad": Kind(2, 9, "Quadrilaterals", ((0, 1), (1, 2), (2, 3), (3, 0))),
    "tet": Kind(3, 10, "Tetrahedra", ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))),
    "hex": Kind(3, 12, "Hexahedra", ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5),
                                     (2, 3, 7, 6), (3, 0, 4, 7))),
    "wedge": Kind(3, 13, "Prisms", ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4),
                                    (2, 0, 3, 5))),
    "pyramid": Kind(3, 14, "Pyramids", ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))),
}
MOST_CORNERS = 4  # of a face


class Cells:
    """blocks: pairs of a kind's name and its elements [k][corners], counted one after the other."""

    def __init__(self, *blocks):
        self.blocks = [(name, np.asarray(nodes)) for name, nodes in blocks if len(nodes)]
        self.dim = KINDS[self.blocks[0][0]].dim

    def __len__(self):
        return sum(len(nodes) for _, nodes in self.blocks)

    def faces(self):
        """Of all elements: corners [.][4], -1 where there are fewer."""
        found = []
        for name, nodes in self.blocks:
            for face in KINDS[name].faces:
                corners = np.full((len(nodes), MOST_CORNERS), -1)
                corners[:, :len(face)] = nodes[:, face]
                found.append(corners)
        return np.concatenate(found)


def blocks_of(elements):
    if isinstance(elements, Cells):
        return elements.blocks
    return [({3: "triangle", 4: "tet"}[elements.shape[1]], elements)]


# ---- validity ----------------------------------------------------------------------------------

def determinant(*columns):
    """Of the matrices of these columns [...][dim]."""
    if len(columns) == 2:
        a, b = columns
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    a, b, c = columns
    return (np.cross(a, b) * c).sum(axis=-1)


def with_middle(values, axis):
    """At both ends of an axis of two, and between."""
    first, last = np.split(values, 2, axis=axis)
    return np.concatenate([first, (first + last) / 2, last], axis=axis)


def to_bezier(values, axis):
    """Of a quadratic polynomial, from its values at both ends and between."""
    first, middle, last = np.split(values, 3, axis=axis)
    return np.concatenate([first, 2 * middle - (first + last) / 2, last], axis=axis)


def halves(bezier, axis):
    """Coefficients of both halves."""
    a, b, c = np.split(bezier, 3, axis=axis)
    ab, bc = (a + b) / 2, (b + c) / 2
    middle = (ab + bc) / 2
    return (np.concatenate([a, ab, middle], axis=axis), np.concatenate([middle, bc, c], axis=axis))


def bezier_of_hex(x):
    """Coefficients [m][3][3][3]; x [m][8][3]."""
    x = x[:, [0, 1, 3, 2, 4, 5, 7, 6]].reshape(-1, 2, 2, 2, 3)  # by z, y, x
    along = [np.diff(x, axis=axis) for axis in (3, 2, 1)]
    for i, axis in enumerate((3, 2, 1)):
        for other in {1, 2, 3} - {axis}:
            along[i] = with_middle(along[i], other)
    values = determinant(*np.broadcast_arrays(*along))
    for axis in (1, 2, 3):
        values = to_bezier(values, axis)
    return values


def bezier_of_wedge(x):
    """Coefficients [m][3 upright edges][3]; x [m][6][3]."""
    x = with_middle(x.reshape(-1, 2, 3, 3), 1)  # by height
    a, b = x[:, :, 1] - x[:, :, 0], x[:, :, 2] - x[:, :, 0]
    upright = x[:, 2] - x[:, 0]
    values = determinant(*np.broadcast_arrays(a[:, None], b[:, None], upright[:, :, None]))
    return to_bezier(values, 2)


def at_corners(x, n, apex=None):
    """The determinants at the n corners of a face, whose edges lead around it: all there is where
    the map is bilinear (and then goes straight to an apex)."""
    found = []
    for j in range(n):
        edges = [x[:, (j + 1) % n] - x[:, j], x[:, j - 1 if j else n - 1] - x[:, j]]
        edges += [x[:, apex] - x[:, j]] if apex else []
        found.append(determinant(*edges))
    return np.stack(found, axis=1)


# name: the coefficients, and the axes in which they are quadratic
BEZIER = {"quad": (lambda x: at_corners(x, 4), ()), "hex": (bezier_of_hex, (1, 2, 3)),
          "pyramid": (lambda x: at_corners(x, 4, 4), ()), "wedge": (bezier_of_wedge, (2,))}


def is_positive(bezier, axes, levels=LEVELS):
    """[m] of bool."""
    corners = bezier
    for axis in axes:
        corners = np.delete(corners, 1, axis=axis)
    every = tuple(range(1, bezier.ndim))
    found = (bezier > 0).all(axis=every)
    undecided = np.flatnonzero(~found & (corners > 0).all(axis=every))
    if levels and axes and len(undecided):
        pieces = [bezier[undecided]]
        for axis in axes:
            pieces = [half for piece in pieces for half in halves(piece, axis)]
        found[undecided] = np.all([is_positive(piece, axes, levels - 1) for piece in pieces],
                                  axis=0)
    return found


def inverted(points, elements):
    """[m] of bool: the determinant is not positive everywhere in the element."""
    found = []
    for name, nodes in blocks_of(elements):
        if name in BEZIER:
            coefficients, axes = BEZIER[name]
            found.append(~is_positive(coefficients(points[nodes]), axes))
        else:
            found.append(simplex.inverted(points, nodes))
    return np.concatenate(found)


def n_inverted(points, elements):
    return int(inverted(points, elements).sum())


def shapes_at_corners(points, name, nodes):
    """At each corner where dim edges meet: the determinant of edges of length 1."""
    if name not in BEZIER:
        return simplex.shapes(points, nodes)
    found = []
    faces = KINDS[name].faces if KINDS[name].dim == 3 else (tuple(range(nodes.shape[1])),)
    if name == "pyramid":
        faces = faces[:1]
    for face in faces:  # each corner is seen from three faces, which does no harm
        for j, node in enumerate(face):
            ends = [face[j - 1], face[(j + 1) % len(face)]]
            if KINDS[name].dim == 2:
                ends.reverse()
            else:
                around = {corner for other in KINDS[name].faces if node in other
                          for k, corner in enumerate(other)
                          if node in (other[k - 1], other[(k + 1) % len(other)])}
                ends += around - {node, *ends}
            edges = [points[nodes[:, end]] - points[nodes[:, node]] for end in ends]
            lengths = np.prod([np.linalg.norm(edge, axis=1) for edge in edges], axis=0)
            found.append(determinant(*edges) / np.where(lengths > 0, lengths, 1))
    return np.min(found, axis=0)


def is_valid(points, elements):
    """Beyond doubt."""
    beyond = all((shapes_at_corners(points, name, nodes) > simplex.SAFE).all()
                 for name, nodes in blocks_of(elements))
    return beyond and not n_inverted(points, elements)


# ---- what elements share -----------------------------------------------------------------------

def boundary_faces(elements):
    """Of Cells, the faces that one element has: corners [.][4], -1 where there are fewer."""
    every = elements.faces()
    _, first, count = np.unique(np.sort(every, axis=1), axis=0, return_index=True,
                                return_counts=True)
    return every[first[count == 1]]


def on_boundary(n_points, elements):
    """[n] of bool."""
    if not isinstance(elements, Cells):
        return simplex.on_boundary(n_points, elements)
    outside = boundary_faces(elements)
    found = np.zeros(n_points, bool)
    found[outside[outside >= 0]] = True
    return found


def edges(elements):
    """Each once [e][2], sorted."""
    if not isinstance(elements, Cells):
        return simplex.edges(elements)
    pairs = [nodes[:, [face[j - 1], face[j]]] for name, nodes in elements.blocks
             for face in KINDS[name].faces for j in range(len(face))]
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
