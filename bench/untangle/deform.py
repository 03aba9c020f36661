"""deform: smooth maps of a whole domain. A map takes the domain and its strength; the largest
strength is that up to which the piecewise linear image of the mesh is valid (or a limit, where
every strength would do)."""
from collections import namedtuple

import numpy as np

import cells

GROWTH = 1.15     # from one strength tried to the next, until one is invalid
FIRST = 0.01
BISECTIONS = 20

# limit_of_grids: of grids, whose bricks stay valid in waves that no mesh would be made for.
Map = namedtuple("Map", "at limit limit_of_grids", defaults=(None,))


class Domain:
    """The frame that the maps work in: along [n], from 0 to 1 on the longest axis; across
    [n][dim - 1], from the middle, in halves of the second longest; order: of the axes."""

    def __init__(self, base):
        self.points, self.hole = base.points, base.hole
        low, self.extent = base.points.min(axis=0), np.ptp(base.points, axis=0)
        self.middle = low + self.extent / 2
        self.order = np.argsort(-self.extent, kind="stable")
        centred = base.points - self.middle
        self.length = self.extent[self.order[0]]
        self.width = self.extent[self.order[1]]
        self.along = centred[:, self.order[0]] / self.length + 0.5
        self.across = centred[:, self.order[1:]] / (self.width / 2)

    def back(self, along, across):
        """The points of such lengths."""
        result = np.empty_like(self.points)
        result[:, self.order[0]] = along
        result[:, self.order[1:]] = across
        return result + self.middle

    def placed(self):
        """along and across as lengths from the middle."""
        return (self.along - 0.5) * self.length, self.across * (self.width / 2)


def rotated(x, y, angle):
    return np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y


def bend(domain, angle):
    """The longest axis becomes an arc."""
    along, across = domain.placed()
    radius, across = domain.length / angle, across.copy()
    turn = along / radius
    along, across[:, 0] = ((radius - across[:, 0]) * np.sin(turn),
                           radius - (radius - across[:, 0]) * np.cos(turn))
    return domain.back(along, across)


def twist(domain, angle):
    """Around the longest axis; in the plane around the middle, less and less outwards."""
    if domain.points.shape[1] == 2:
        from_middle = domain.points - domain.middle
        decay = np.exp(-4 * ((from_middle / (domain.extent / 2)) ** 2).sum(axis=1))
        return np.stack(rotated(*from_middle.T, angle * decay), axis=1) + domain.middle
    along, across = domain.placed()
    return domain.back(along, np.stack(rotated(*across.T, angle * domain.along), axis=1))


def bulge(domain, height):
    """One side is blown up, the opposite one stays."""
    along, across = domain.placed()
    bump = np.sin(np.pi * domain.along) ** 2
    across = across.copy()
    across[:, 0] *= 1 + height * bump * (domain.across[:, 0] + 1) / 2
    return domain.back(along, across)


def pinch(domain, depth):
    """A waist in the middle."""
    along, across = domain.placed()
    return domain.back(along, across * (1 - depth * np.sin(np.pi * domain.along) ** 2)[:, None])


def wave(domain, height):
    along, across = domain.placed()
    across = across.copy()
    across[:, 0] += height * domain.width * np.sin(2 * np.pi * domain.along)
    return domain.back(along, across)


def stretch(domain, factor):
    """Longer along, thinner across."""
    along, across = domain.placed()
    return domain.back(along * (1 + factor), across / (1 + factor) ** 0.5)


def shear(domain, slope):
    along, across = domain.placed()
    return domain.back(along + slope * across[:, 0], across)


def turn(domain, angle):
    """The hole turns about z, the outside stays."""
    centre, axes, inner, outer = domain.hole
    from_centre = domain.points - centre
    distance = np.linalg.norm(from_centre[:, :axes], axis=1)
    share = np.clip((outer - distance) / (outer - inner), 0, 1)
    x, y = rotated(from_centre[:, 0], from_centre[:, 1], angle * share)
    return np.column_stack([x, y, *from_centre[:, 2:].T]) + centre


MAPS = {
    "bend": Map(bend, 1.9 * np.pi),
    "twist": Map(twist, 20 * np.pi),
    "bulge": Map(bulge, 20),
    "pinch": Map(pinch, 0.98),
    "wave": Map(wave, 20, 2),
    "stretch": Map(stretch, 9),
    "shear": Map(shear, 6),
    "turn": Map(turn, 20 * np.pi),
}


def names(base):
    return [name for name in MAPS if name != "turn" or base.hole]


def largest_strength(base, domain, name):
    """Up to it, as far as was tried, the image of the whole mesh is valid."""
    def valid(strength):
        return cells.is_valid(MAPS[name].at(domain, strength), base.elements)

    limit, good = MAPS[name].limit, 0
    if isinstance(base.elements, cells.Cells):
        limit = MAPS[name].limit_of_grids or limit
    bad = FIRST
    while valid(bad):
        if bad == limit:
            return limit
        good, bad = bad, min(bad * GROWTH, limit)
    for _ in range(BISECTIONS):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if valid(middle) else (good, middle)
    return good


def deformed(base, name, share):
    """The points at this share of the largest strength."""
    domain = Domain(base)
    strength = share * largest_strength(base, domain, name)
    return MAPS[name].at(domain, strength)
