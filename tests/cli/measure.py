"""measure.py MESH QUALITY.json: figures of a mesh of tetrahedra from textbook formulas, compared with
those of planish. MESH: Gmsh MSH ASCII or Medit."""
import json
import math
import sys

from mesh_file import corners, cross, dot, minus, radius_ratio, read, volume


def dihedral_angles(t):
    """At each edge, between the components of the other two vertices across it."""
    for i, j, k, l in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2),
                       (2, 3, 0, 1)):
        e = minus(t[j], t[i])
        a, b = (minus(x, [dot(x, e) / dot(e, e) * c for c in e])
                for x in (minus(t[k], t[i]), minus(t[l], t[i])))
        yield math.degrees(math.atan2(math.hypot(*cross(a, b)), dot(a, b)))


tetrahedra = corners(read(sys.argv[1]))
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
