"""judge_validity: the decisions of bench/public/validity.py against samples of det J, and on elements that are known."""
import itertools
import sys

import numpy as np

import measures
import validity
from shapes import SHAPES, SQUARE

RANDOM = np.random.default_rng(7)
N = 25
PLACES = {  # corners of the reference elements
    "triangle": [(0, 0), (1, 0), (0, 1)], "quad": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "hexahedron": [(i, j, k) for k in (0, 1) for i, j in SQUARE],
    "wedge": [(i, j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (0, 1))],
    "pyramid": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)],
}
VOLUMES = {"triangle": 1 / 2, "quad": 1, "tetra": 1 / 6, "hexahedron": 1, "wedge": 1 / 2, "pyramid": 1 / 3}
SAMPLES = np.linspace(0, 1, 7)
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)


def nodes_of(name):
    corners = np.array(PLACES[SHAPES[name].base], float)
    return np.array([corners[list(ends)].mean(axis=0) for ends in SHAPES[name].between])


def exponents(name):
    """Of the monomials of the type's shape functions."""
    shape = SHAPES[name]
    powers = itertools.product(range(shape.order + 1), repeat=shape.dim)
    if shape.base in ("triangle", "tetra"):
        return [p for p in powers if sum(p) <= shape.order]
    if shape.base == "wedge":
        powers = [p for p in powers if p[0] + p[1] <= shape.order]
        return [p for p in powers if p[0] + p[1] <= 1 or p[2] <= 1] if name == "wedge15" else powers
    return [p for p in powers if sum(e for e in p if e > 1) <= 2] if name in ("quad8", "hexahedron20") else list(powers)


def slope(point, power, along):
    factors = [x ** e for x, e in zip(point, power)]
    factors[along] = power[along] * point[along] ** max(power[along] - 1, 0)
    return np.prod(factors)


def least_sample(name, elements):
    """Least det J at the samples, of elements [elements][nodes][dim]."""
    shape, powers = SHAPES[name], exponents(name)
    points = [p for p in itertools.product(SAMPLES, repeat=shape.dim)
              if not (shape.base in ("triangle", "tetra") and sum(p) > 1 + 1e-12
                      or shape.base == "wedge" and p[0] + p[1] > 1 + 1e-12)]
    functions = np.linalg.inv([[np.prod([x ** e for x, e in zip(node, p)]) for p in powers] for node in nodes_of(name)])
    slopes = np.array([[[slope(point, p, i) for i in range(shape.dim)] for p in powers] for point in points])
    jacobians = np.einsum("end,spm,pn->esdm", elements, slopes, functions)
    return np.linalg.det(jacobians).min(axis=1)


def compare_with_samples():
    for name, shape in SHAPES.items():
        spread = 0.4 if shape.order == 1 else 0.14
        elements = nodes_of(name) + RANDOM.uniform(-spread, spread, (N, len(shape.between), shape.dim))
        found = validity.states(name, elements, np.ones(N, int))
        turned = validity.states(name, elements * np.array([-1] + [1] * (shape.dim - 1)), -np.ones(N, int))
        expect((found == turned).all(), f"{name}: mirrored elements are judged otherwise")
        expect((found != validity.UNKNOWN).all(), f"{name}: not decided")
        expect(validity.decide(name, elements[0], 1) == found[0], f"{name}: whole numbers decide otherwise")
        if shape.base != "pyramid":
            least = least_sample(name, elements)
            expect(not ((least < -1e-12) & (found == validity.VALID)).any(), f"{name}: a bad element passes for valid")
            bad = found == validity.INVALID
            expect((least[bad] < 0.1).all() and (least[~bad] > -1e-12).all(), f"{name}: samples disagree")
        volume = measures.volumes(name, nodes_of(name)[None])[0]
        expect(abs(volume - VOLUMES[shape.base]) < 1e-12, f"{name}: volume {volume}")
        aspect, jacobian = measures.cell(name, nodes_of(name)[None], np.ones(1, int))
        expect(aspect[0] >= 1 - 1e-12 and 0 < jacobian[0] <= 1.42, f"{name}: aspect ratio {aspect}, {jacobian}")


def known_elements():
    """Elements that need more than corners, or more than doubles."""
    def state(name, nodes, sign=1):
        return validity.states(name, np.array([nodes], float), np.array([sign]))[0]
    many = nodes_of("hexahedron") + RANDOM.uniform(-0.45, 0.45, (3000, 8, 3))
    corners = np.min([np.linalg.det(np.stack([many[:, i] - many[:, at] for i in others], axis=2))
                      for at, *others in SHAPES["hexahedron"].corners], axis=0)
    inside = many[corners > 0.01]
    inside = inside[least_sample("hexahedron", inside) < -0.01]
    expect(len(inside) > 0, "no hexahedron with positive corners is bad inside")
    for nodes in inside[:5]:
        expect(state("hexahedron", nodes) == validity.INVALID, "hexahedron with positive corners that is bad inside")
    flat = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1 / 3, 1 / 3, 0)]
    expect(state("tetra", flat) == validity.INVALID, "flat tetrahedron")
    expect(state("tetra", [*flat[:3], (1 / 3, 1 / 3, 5e-324)]) == validity.VALID, "tetrahedron of the least height")
    expect(state("tetra", [*flat[:3], (1 / 3, 1 / 3, 5e-324)], -1) == validity.INVALID, "the same, to be negative")
    far = np.array([(1, 1), (1 + 2.0 ** -52, 1), (1, 1 + 2.0 ** -52)])
    expect(state("triangle", far) == validity.VALID, "triangle of the last digits")
    ends = np.array([(0.1, 0.1), (0.3, 0.3), (0.7, 0.7)])
    expect(state("triangle", ends) == validity.decide("triangle", ends, 1), "triangle that is nearly flat")
    bent = nodes_of("triangle6")
    bent[4] = (0.2, 0.2)
    expect(state("triangle6", bent) == validity.INVALID, "triangle whose edge comes through")
    bent[4] = (0.45, 0.45)
    expect(state("triangle6", bent) == validity.VALID, "triangle with an edge that is bent a little")
    tet = nodes_of("tetra10")
    tet[4] += (0.26, 0, 0)
    expect(state("tetra10", tet) == validity.INVALID, "mid beyond three quarters of its edge")
    regular = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)[[0, 2, 1, 3]]
    ratio, angle = measures.simplex("tetra", regular[None])
    expect(abs(ratio[0] - 1) < 1e-12 and abs(angle[0] - np.degrees(np.arccos(1 / 3))) < 1e-9, "regular tetrahedron")
    ratio, angle = measures.simplex("triangle", np.array([[(0, 0), (4, 0), (0, 3)]], float))
    expect(abs(ratio[0] - 1.25) < 1e-12 and abs(angle[0] - np.degrees(np.arctan(0.75))) < 1e-9, "triangle 3, 4, 5")


compare_with_samples()
known_elements()
for failure in failures:
    print("FAILED:", failure)
sys.exit(bool(failures))
