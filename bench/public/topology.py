"""topology: facets, boundary and orientation of a mesh. A mesh is a list of blocks (type, cells [elements][nodes]); its
elements are numbered on through the blocks."""
from dataclasses import dataclass

import numpy as np

from shapes import SHAPES


@dataclass
class Facets:
    """All facets of all elements, those of the same corners beside one another."""
    owner: np.ndarray   # element
    is_turned: np.ndarray  # which way the element goes around the facet
    place: np.ndarray   # [facets][2]: block, and facet of its type
    first: np.ndarray   # where each group of equal facets begins
    count: np.ndarray   # facets in the group


def facets_of(blocks):
    keys, owners, turns, places, begin = [], [], [], [], 0
    for number, (name, cells) in enumerate(blocks):
        for which, corners in enumerate(SHAPES[name].facets):
            nodes = cells[:, corners]
            key = np.full((len(cells), 4), -1)
            key[:, 4 - len(corners):] = np.sort(nodes, axis=1)
            keys.append(key)
            owners.append(np.arange(begin, begin + len(cells)))
            turns.append(_is_turned(nodes))
            places.append(np.tile([number, which], (len(cells), 1)))
        begin += len(cells)
    key, owner, turn, place = map(np.concatenate, (keys, owners, turns, places))
    order = np.lexsort(key.T)
    key = key[order]
    first = np.flatnonzero(np.concatenate([[True], (key[1:] != key[:-1]).any(axis=1)]))
    return Facets(owner[order], turn[order], place[order], first, np.diff(np.append(first, len(key))))


def _is_turned(nodes):
    """Which of two ways the loops of nodes go."""
    if nodes.shape[1] == 2:
        return nodes[:, 0] > nodes[:, 1]
    least = np.argmin(nodes, axis=1)
    rows = np.arange(len(nodes))
    n = nodes.shape[1]
    return nodes[rows, (least + 1) % n] < nodes[rows, (least - 1) % n]


def nodes_of_facets(blocks, facets, chosen):
    """Numbers of all nodes, also between corners, of the chosen facets (indices)."""
    starts = np.cumsum([0] + [len(cells) for _, cells in blocks])
    found = []
    for number, (name, cells) in enumerate(blocks):
        shape = SHAPES[name]
        for which, corners in enumerate(shape.facets):
            mine = chosen[(facets.place[chosen] == (number, which)).all(axis=1)]
            found.append(cells[facets.owner[mine] - starts[number]][:, shape.facet_nodes(corners)].ravel())
    return np.unique(np.concatenate(found))


def boundary(facets):
    """Facets of one element."""
    return facets.first[facets.count == 1]


def between(facets, label):
    """Facets between two elements of different labels."""
    pair = facets.first[facets.count == 2]
    return pair[label[facets.owner[pair]] != label[facets.owner[pair + 1]]]


def _components(n, a, b):
    """The least number of each vertex's component."""
    label = np.arange(n)
    while True:
        least = np.minimum(label[a], label[b])
        new = label.copy()
        np.minimum.at(new, label[a], least)
        np.minimum.at(new, label[b], least)
        while (new[new] != new).any():
            new = new[new]
        if (new == label).all():
            return label
        label = new


def signs(n_elements, facets, measure):
    """The sign that each element's measure has where the mesh is valid, 0 where it cannot be oriented: neighbours go
    around their facet in opposite directions, and the sum of a component's measures is positive.

    Each element is two vertices of a graph, as it is listed and the other way round."""
    pair = facets.first[facets.count == 2]
    a, b = facets.owner[pair], facets.owner[pair + 1]
    swap = np.where(facets.is_turned[pair] == facets.is_turned[pair + 1], 1, 0)
    label = _components(2 * n_elements, np.concatenate([2 * a, 2 * a + 1]),
                        np.concatenate([2 * b + swap, 2 * b + 1 - swap]))
    as_listed, turned = label[0::2], label[1::2]
    relative = np.sign(turned - as_listed)
    component = np.minimum(as_listed, turned)
    total = np.zeros(2 * n_elements)
    np.add.at(total, component, relative * measure)
    return relative * np.where(total[component] < 0, -1, 1)
