"""outside: put one free node of a mesh outside of the domain, as the paper's Fig. 8(a) does.

The node goes through the nearest facet of the boundary, from which it ends half as far as it was;
of all such moves the one that inverts two elements, or else the fewest more than that. Needs numpy.
"""
import numpy as np

from simplices import faces_of, free_nodes, volumes


def boundary_facets(elements):
    """(facet, the node opposite) of each facet of one element only."""
    owners = {}
    for element in elements:
        for face in faces_of(element):
            apex = next(node for node in element if node not in face)
            owners.setdefault(tuple(sorted(face)), []).append(apex)
    return [(list(face), apices[0]) for face, apices in owners.items() if len(apices) == 1]


def with_node_outside(points, elements):
    free = set(free_nodes(elements))
    already = int((volumes(points, elements) <= 0).sum())
    best = None
    for facet, apex in boundary_facets(elements):
        if apex not in free:
            continue
        moved = points.copy()
        moved[apex] += 1.5 * (points[facet].mean(axis=0) - points[apex])
        inverted = int((volumes(moved, elements) <= 0).sum()) - already
        if inverted >= 2 and (best is None or inverted < best[0]):
            best = (inverted, moved)
    if best is None:
        raise RuntimeError("no node can be put outside")
    return best[1]
