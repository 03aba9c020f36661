"""measure.py MESH QUALITY.json: figures of a mesh of tetrahedra from textbook formulas, compared with
those of planish. MESH: Gmsh MSH 4.1 ASCII or Medit."""
import json
import math
import sys


def read_gmsh(words):
    """Nodes by number, and tetrahedra, of MSH 4.1 ASCII."""
    at = words.index("$Nodes") + 1
    blocks, at, nodes = int(words[at]), at + 4, {}
    for _ in range(blocks):
        count, at = int(words[at + 3]), at + 4
        numbers, at = words[at:at + count], at + count
        for number in numbers:
            nodes[number] = [float(x) for x in words[at:at + 3]]
            at += 3
    at = words.index("$Elements") + 1
    blocks, at, tetrahedra = int(words[at]), at + 4, []
    size = {"15": 1, "1": 2, "2": 3, "4": 4}
    for _ in range(blocks):
        kind, count, at = words[at + 2], int(words[at + 3]), at + 4
        for _ in range(count):
            if kind == "4":
                tetrahedra.append([nodes[n] for n in words[at + 1:at + 5]])
            at += 1 + size[kind]
    return tetrahedra


def read_medit(words):
    at = words.index("Vertices") + 2
    nodes = [[float(x) for x in words[i:i + 3]] for i in range(at, at + 4 * int(words[at - 1]), 4)]
    at = words.index("Tetrahedra") + 2
    return [[nodes[int(n) - 1] for n in words[i:i + 4]]
            for i in range(at, at + 5 * int(words[at - 1]), 5)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def volume(t):
    return dot(minus(t[1], t[0]), cross(minus(t[2], t[0]), minus(t[3], t[0]))) / 6


def radius_ratio(t):
    """R/(3r): 24 V R = sqrt of a product like Heron's of the three products of opposite edges;
    r = 3 V / (sum of the faces' areas)."""
    def edge(i, j):
        return math.dist(t[i], t[j])
    p, q, s = edge(0, 1) * edge(2, 3), edge(0, 2) * edge(1, 3), edge(0, 3) * edge(1, 2)
    v = abs(volume(t))
    circum = math.sqrt(max(0, (p + q + s) * (q + s - p) * (p + s - q) * (p + q - s))) / (24 * v)
    area = sum(math.hypot(*cross(minus(t[j], t[i]), minus(t[k], t[i]))) / 2
               for i, j, k in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)))
    return circum * area / (9 * v)


def dihedral_angles(t):
    """At each edge, between the components of the other two vertices across it."""
    for i, j, k, l in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2),
                       (2, 3, 0, 1)):
        e = minus(t[j], t[i])
        a, b = (minus(x, [dot(x, e) / dot(e, e) * c for c in e])
                for x in (minus(t[k], t[i]), minus(t[l], t[i])))
        yield math.degrees(math.atan2(math.hypot(*cross(a, b)), dot(a, b)))


words = open(sys.argv[1]).read().split()
tetrahedra = read_gmsh(words) if words[0] == "$MeshFormat" else read_medit(words)
volumes = [volume(t) for t in tetrahedra]
valid = [t for t, v in zip(tetrahedra, volumes) if v > 0]
ratios = [radius_ratio(t) for t in valid]
angles = [angle for t in valid for angle in dihedral_angles(t)]
expected = {
    "inverted": len(tetrahedra) - len(valid),
    "min_volume": min(volumes), "max_volume": max(volumes), "total_volume": math.fsum(volumes),
    "rms_radius_ratio": math.sqrt(math.fsum(r * r for r in ratios) / len(ratios)),
    "mean_radius_ratio": math.fsum(ratios) / len(ratios), "max_radius_ratio": max(ratios),
    "min_dihedral_deg": min(angles), "max_dihedral_deg": max(angles),
}
report = json.load(open(sys.argv[2]))
wrong = 0
for key, value in expected.items():
    # Slivers magnify rounding; what they magnify it by is their radius ratio.
    if not math.isclose(report["quality"][key], value, rel_tol=1e-12 * max(ratios) ** 2 + 1e-10):
        print("%s: planish says %r, it is %r" % (key, report["quality"][key], value))
        wrong += 1
sys.exit(wrong > 0 or report["mesh"]["elements"] != len(tetrahedra))
