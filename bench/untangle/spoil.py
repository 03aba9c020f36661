"""spoil: tangles the inside of a mesh; the boundary stays. A spoiler takes the random numbers, the
mesh and its amounts, and changes mesh.points."""
import numpy as np

PATCHED = 0.1  # of the free nodes are in patches


class Mesh:
    """points [n][dim] to be spoilt, free nodes, edges between these, lengths [n] of the edges at
    a node."""

    def __init__(self, points, free, pairs, lengths):
        self.points, self.free, self.lengths = points.copy(), np.flatnonzero(free), lengths
        self.pairs = pairs[free[pairs].all(axis=1)]
        self.dim = points.shape[1]


def some(random, nodes, percent):
    """At least one."""
    count = max(1, round(len(nodes) * percent / 100))
    return random.permutation(nodes)[:count]


def directions(random, count, dim):
    vectors = random.standard_normal((count, dim))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def disjoint(random, pairs, count):
    """Up to count of the pairs, no two of them with a common node."""
    taken, chosen = set(), []
    for i, j in random.permutation(pairs).tolist():
        if i not in taken and j not in taken:
            taken.update((i, j))
            chosen.append((i, j))
            if len(chosen) == count:
                break
    return np.array(chosen, int).reshape(-1, 2).T


def neighbours(random, mesh, percent):
    """Pairs of neighbours that hold this share of the free nodes."""
    return disjoint(random, mesh.pairs, max(1, round(len(mesh.free) * percent / 200)))


def move(random, mesh, lengths, percent):
    """By so many lengths of the edges."""
    nodes = some(random, mesh.free, percent)
    way = directions(random, len(nodes), mesh.dim) * mesh.lengths[nodes, None]
    mesh.points[nodes] += lengths * way


def pairs(random, mesh, percent):
    """Neighbours at one point."""
    i, j = neighbours(random, mesh, percent)
    mesh.points[i] = mesh.points[j] = (mesh.points[i] + mesh.points[j]) / 2


def patch(links, seed, size, taken):
    """A connected set of up to size free nodes around seed."""
    found, queue = [seed], [seed]
    taken.add(seed)
    for node in queue:
        for other in links.get(node, ()):
            if other not in taken and len(found) < size:
                taken.add(other)
                found.append(other)
                queue.append(other)
    return found


def patches(random, mesh, size):
    """Groups of so many nodes, each at one point."""
    links, taken, count = {}, set(), 0
    for i, j in mesh.pairs.tolist():
        links.setdefault(i, []).append(j)
        links.setdefault(j, []).append(i)
    for seed in random.permutation(mesh.free).tolist():
        if count >= max(size, PATCHED * len(mesh.free)):
            break
        if seed not in taken:
            nodes = patch(links, seed, size, taken)
            mesh.points[nodes] = mesh.points[nodes].mean(axis=0)
            count += len(nodes)


def centre(_, mesh):
    """All nodes at one point."""
    mesh.points[mesh.free] = mesh.points[mesh.free].mean(axis=0)


def exchange(mesh, i, j):
    both = np.concatenate([i, j]), np.concatenate([j, i])
    mesh.points[both[0]] = mesh.points[both[1]]


def swapnear(random, mesh, percent):
    exchange(mesh, *neighbours(random, mesh, percent))


def swapfar(random, mesh, percent):
    nodes = some(random, mesh.free, percent)
    half = max(1, len(nodes) // 2)
    if len(nodes) == 1:
        nodes = random.permutation(mesh.free)[:2]
    exchange(mesh, nodes[:half], nodes[half:2 * half])


def throw(random, mesh, diameters, percent):
    """Out of the domain."""
    middle = (mesh.points.min(axis=0) + mesh.points.max(axis=0)) / 2
    diameter = np.linalg.norm(np.ptp(mesh.points, axis=0))
    nodes = some(random, mesh.free, percent)
    distance = diameter * random.uniform(1, 1 + diameters, len(nodes))
    mesh.points[nodes] = middle + directions(random, len(nodes), mesh.dim) * distance[:, None]


def mixed(random, mesh, percent):
    throw(random, mesh, 1, percent / 10)
    swapnear(random, mesh, percent)
    pairs(random, mesh, percent)
    patches(random, mesh, 20)
    move(random, mesh, 2, percent)


SPOILERS = {spoiler.__name__: spoiler for spoiler in
            (move, pairs, patches, centre, swapnear, swapfar, throw, mixed)}
RAISABLE = ("move", "throw")  # whose first amount may be raised until something is inverted
