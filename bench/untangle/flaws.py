"""flaws: plant elements that no position of the free nodes can repair in a valid mesh.

    ear      a new element glued to a boundary facet, its tip inside instead of outside
    flat     an element of boundary nodes alone, one of them moved through its opposite facet
    fold     a boundary node without free neighbours, moved far inside
    fan      a crooked region of the mesh becomes one free node and fixed ones around it; no point
             sees all of them
    island   such a fan as a component of its own beside the mesh

Others look similar but can be repaired, to detect false reports:

    narrow   a free node and fixed ones around it that can be seen from a small place only"""
import numpy as np

import simplex

TRIES = 400
NARROW = 1e-5, 0.02  # the height over the lowest facet, in sizes of the region, for a narrow one
MOST = 60      # elements in a region of that kind
CIRCLE = {2: (80, 400), 3: (700, 3000)}  # elements in the circle or ball that a fan is cut from
BLIND = 0.02   # every point is behind some facet by at least this share of a fan's size


class Planted:
    """The mesh while it is changed. flaws: lists of elements; fixed [n] of bool: held by the
    file; solved: the good places of nodes that stand at bad ones."""

    def __init__(self, mesh):
        self.points, self.elements = mesh.points.copy(), mesh.elements.copy()
        self.fixed = np.zeros(len(self.points), bool)
        self.flaws, self.solved = [], {}
        self.used = np.zeros(len(self.points), bool)  # nodes near a flaw: no other is planted there

    def boundary(self):
        return simplex.on_boundary(len(self.points), self.elements)

    def held(self):
        return self.fixed | self.boundary()

    def add_nodes(self, points):
        """Their numbers."""
        first = len(self.points)
        self.points = np.vstack([self.points, points])
        self.fixed = np.append(self.fixed, np.zeros(len(points), bool))
        self.used = np.append(self.used, np.ones(len(points), bool))
        return np.arange(first, len(self.points))

    def add_elements(self, elements):
        first = len(self.elements)
        self.elements = np.vstack([self.elements, elements])
        return list(range(first, len(self.elements)))

    def star(self, node):
        return np.flatnonzero((self.elements == node).any(axis=1))

    def use(self, nodes):
        """With their neighbours."""
        near = np.isin(self.elements, nodes).any(axis=1)
        self.used[self.elements[near]] = True


def tip_over(points, facet, height):
    """The point at that height, in sizes of the facet, over its middle: on its outer side."""
    corner = points[facet]
    if len(facet) == 2:
        along = corner[1] - corner[0]
        normal = np.array([along[1], -along[0]])
    else:
        normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    size = np.linalg.norm(corner[1] - corner[0])
    return corner.mean(axis=0) + height * size * normal / np.linalg.norm(normal)


def plant_ear(random, planted):
    facets = simplex.boundary_facets(planted.elements)
    free = facets[~planted.used[facets].any(axis=1)]
    facet = free[random.randint(len(free))]
    planted.use(facet)
    tip = planted.add_nodes(tip_over(planted.points, facet, 0.7)[None])
    ear = simplex.oriented(planted.points, np.append(facet, tip)[None])
    planted.flaws.append(planted.add_elements(ear))
    planted.points[tip] = tip_over(planted.points, facet, -random.uniform(0.2, 3))
    return True


def would_invert(planted, node, place):
    """Elements that would be inverted with the node at that place; None if one were in doubt."""
    star = planted.star(node)
    points = planted.points.copy()
    points[node] = place
    shapes = simplex.shapes(points, planted.elements[star])
    return None if (abs(shapes) < 1e-4).any() else star[shapes < 0]


def plant_flat(random, planted):
    boundary = planted.boundary()
    fixed = boundary[planted.elements].all(axis=1) & ~planted.used[planted.elements].any(axis=1)
    for element in random.permutation(np.flatnonzero(fixed)):
        nodes = planted.elements[element]
        for j in random.permutation(len(nodes)):
            node, others = nodes[j], planted.points[np.delete(nodes, j)]
            normal = np.cross(others[1] - others[0], others[2] - others[0])
            normal /= np.linalg.norm(normal)
            height = (planted.points[node] - others[0]) @ normal
            place = planted.points[node] - (1 + random.uniform(0.05, 0.5)) * height * normal
            inverted = would_invert(planted, node, place)
            if inverted is not None and inverted.tolist() == [element]:
                planted.points[node] = place
                planted.use(nodes)
                planted.flaws.append([int(element)])
                return True
    return False


def plant_fold(random, planted):
    boundary = planted.boundary()
    has_free = np.zeros(len(boundary), bool)
    has_free[planted.elements[~boundary[planted.elements].all(axis=1)]] = True
    for node in random.permutation(np.flatnonzero(~has_free & ~planted.used)):
        near = np.unique(planted.elements[planted.star(node)])
        way = planted.points[near].mean(axis=0) - planted.points[node]
        place = planted.points[node] + random.uniform(3, 6) * way
        inverted = would_invert(planted, node, place)
        if inverted is not None and len(inverted):
            planted.points[node] = place
            planted.use(near)
            planted.flaws += [[int(element)] for element in inverted]
            return True
    return False


def arc(random, planted, turn):
    """Elements along this part of a circle, of random place and size."""
    middles = planted.points[planted.elements].mean(axis=1)
    centre = middles[random.randint(len(middles))]
    offset = middles - centre
    distance = np.linalg.norm(offset[:, :2], axis=1)
    nearest = np.sort(np.linalg.norm(offset, axis=1))
    radius = nearest[random.randint(*CIRCLE[planted.points.shape[1]])]
    angle = np.arctan2(offset[:, 1], offset[:, 0]) + np.pi
    inside = (distance < radius) & (distance > 0.45 * radius) & (angle < turn)
    return inside & (abs(offset[:, 2:]) < 0.35 * radius).all(axis=1)


def crooked_region(random, planted):
    return arc(random, planted, 1.5 * np.pi)


def small_region(random, planted):
    """In space, elements around one of them: the surface is rough. In the plane, a bent strip."""
    if planted.points.shape[1] == 2:
        return arc(random, planted, random.uniform(0.3, 1.5) * np.pi)
    middles = planted.points[planted.elements].mean(axis=1)
    distance = np.linalg.norm(middles - middles[random.randint(len(middles))], axis=1)
    return distance < np.partition(distance, MOST)[random.randint(MOST)]


def without_dents(elements, inside):
    """The region with the elements filled in that it surrounds but for one facet."""
    owner = np.tile(np.arange(len(elements)), elements.shape[1])
    _, key = np.unique(np.sort(simplex.facets(elements), axis=1), axis=0, return_inverse=True)
    for _ in range(10):
        neighbours = np.bincount(key.ravel(), inside[owner])[key.ravel()] - inside[owner]
        surrounded = np.bincount(owner, neighbours) >= elements.shape[1] - 1
        if not (surrounded & ~inside).any():
            break
        inside = inside | surrounded
    return inside


def is_sphere(surface):
    """A closed surface of one piece without pinches; in the plane a closed curve."""
    nodes, faces = np.unique(surface, return_inverse=True)
    faces = faces.reshape(surface.shape)
    reached = faces == 0
    for _ in range(len(nodes)):
        before = reached.sum()
        reached = np.isin(faces, faces[reached.any(axis=1)])
        if reached.sum() == before:
            break
    if not reached.all():
        return False
    if surface.shape[1] == 2:
        return bool((np.bincount(faces.ravel()) == 2).all())
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    sides, count = np.unique(sides, axis=0, return_counts=True)
    return bool((count == 2).all()) and len(nodes) - len(sides) + len(faces) == 2


def best_view(points, surface):
    """The point that is highest over the lowest facet, and this height in sizes of the surface:
    negative where no point sees all facets. A linear program."""
    from scipy.optimize import linprog  # other cases do without
    corner = points[surface]
    if surface.shape[1] == 2:
        along = corner[:, 1] - corner[:, 0]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    else:
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    middle = corner.mean(axis=(0, 1))
    size = np.ptp(corner.reshape(-1, points.shape[1]), axis=0).max()
    offset = np.einsum("ij,ij->i", normal, corner[:, 0] - middle) / size
    # maximise height subject to normal . x + height <= offset
    found = linprog(np.append(np.zeros(points.shape[1]), -1),
                    np.column_stack([normal, np.ones(len(normal))]), offset,
                    bounds=[(-5, 5)] * points.shape[1] + [(None, 1)])
    if found.status != 0:
        raise SystemExit(f"flaws: {found.message}")
    return middle + size * found.x[:-1], found.x[-1]


def region_of_view(random, planted, shape, lowest, highest):
    """Elements [m] of bool, the surface and the best point of a region that the height over the
    lowest facet lies between these bounds for; None if none is found."""
    for _ in range(TRIES):
        inside = without_dents(planted.elements, shape(random, planted))
        if not inside.any() or planted.used[planted.elements[inside]].any():
            continue
        surface = simplex.boundary_facets(planted.elements[inside])
        if is_sphere(surface):
            point, height = best_view(planted.points, surface)
            if lowest < height < highest:
                return inside, surface, point
    return None


def blind_region(random, planted):
    return region_of_view(random, planted, crooked_region, -np.inf, -BLIND)


def fan_of(surface, centre):
    """Elements from the outward facets to the centre."""
    inward = surface[:, ::-1] if surface.shape[1] == 3 else surface
    return np.column_stack([inward, np.full(len(surface), centre)])


def replace_by_fan(planted, inside, surface):
    """By a node in the middle, whose number is returned, and elements, which are; the nodes of the
    surface are held."""
    planted.use(np.unique(surface))
    planted.fixed[surface] = True
    centre = planted.add_nodes(planted.points[np.unique(surface)].mean(axis=0)[None])[0]
    kept = np.cumsum(~inside) - 1
    planted.flaws = [kept[flaw].tolist() for flaw in planted.flaws]
    planted.elements = planted.elements[~inside]
    return centre, planted.add_elements(fan_of(surface, centre))


def plant_fan(random, planted):
    region = blind_region(random, planted)
    if region is None:
        return False
    _, fan = replace_by_fan(planted, *region[:2])
    planted.flaws.append(fan)
    return True


def plant_narrow(random, planted):
    region = region_of_view(random, planted, small_region, *NARROW)
    if region is None:
        return False
    inside, surface, point = region
    centre, _ = replace_by_fan(planted, inside, surface)
    planted.solved[centre] = point
    return True


def plant_island(random, planted):
    region = blind_region(random, planted)
    if region is None:
        return False
    _, surface, _ = region
    nodes, faces = np.unique(surface, return_inverse=True)
    aside = np.zeros(planted.points.shape[1])
    aside[0] = 1.2 * np.ptp(planted.points[:, 0])
    copies = planted.add_nodes(planted.points[nodes] + aside)
    centre = planted.add_nodes(planted.points[copies].mean(axis=0)[None])
    copied = copies[faces.reshape(surface.shape)]
    planted.flaws.append(planted.add_elements(fan_of(copied, centre[0])))
    return True


def finish(planted):
    """Drop the nodes of no element; see that what is planted is bad and everything else is not."""
    used = np.unique(planted.elements)
    solved = planted.points.copy()
    for node, point in planted.solved.items():
        solved[node] = point
    planted.points = planted.points[used]
    planted.fixed, planted.solved = planted.fixed[used], solved[used]
    planted.elements = np.searchsorted(used, planted.elements)
    flawed = np.zeros(len(planted.elements), bool)
    for flaw in planted.flaws:
        flawed[flaw] = True
        if not simplex.n_inverted(planted.points, planted.elements[flaw]):
            raise SystemExit("flaws: a flaw has no inverted element")
    if not simplex.is_valid(planted.solved, planted.elements[~flawed]):
        raise SystemExit("flaws: something else is not valid")
    return planted


# kind: planter, how many in one mesh, bases
KINDS = {
    "ear": (plant_ear, 3, ("box", "shell", "plate", "ring", "square")),
    "flat": (plant_flat, 3, ("box", "bracket", "bar", "star")),
    "fold": (plant_fold, 2, ("box", "bracket", "bar", "star")),
    "fan": (plant_fan, 1, ("box", "hole", "plate", "corner", "square")),
    "island": (plant_island, 2, ("box", "angle", "ring", "strip")),
    "narrow": (plant_narrow, 5, ("box", "hole", "star", "plate", "corner", "square")),
}


def names():
    return [f"{base}_{'narrow' if kind == 'narrow' else f'flaw-{kind}'}"
            for kind, (_, _, bases) in KINDS.items() for base in bases]


def plant(random, mesh, kind):
    """None if nothing could be planted."""
    planter, count, _ = KINDS[kind]
    planted = Planted(mesh)
    planters = [planter(random, planted) for _ in range(count)]
    return finish(planted) if any(planters) else None
