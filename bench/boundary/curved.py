"""curved: nodes that slide on curved surfaces, judged without planish; called by run.

    curved.py BUILD [MESH ...]

Two tables. Of each MESH: nodes that slide, worst and RMS of radius ratios, the smallest dihedral angle, elements without a
movable node, with --slide auto and with --slide curved --slide-interfaces; distances both ways, sampled at 15 points of
each facet, beside those that planish certifies, in local mean edges; and the ratio of user seconds. Of models of Gmsh whose
shape is known: how far samples of the surface are off the true shape (RMS), in the input, after one run, and after five in
a row with --surface-of.
"""
import contextlib
import io
import itertools
import json
import math
import os
import pathlib
import subprocess
import sys

import meshio
import numpy as np

import machine

MODELS = {  # h: size of edges
    "sphere": (0.15, "Sphere(1) = {0, 0, 0, 1};"),
    "torus": (0.1, "Torus(1) = {0, 0, 0, 1, 0.3};"),
    "cylinder": (0.1, "Cylinder(1) = {0, 0, 0, 0, 0, 2, 0.5};"),
    "tee": (0.1, "Cylinder(1) = {-1, 0, 0, 2, 0, 0, 0.5}; Cylinder(2) = {0, 0, 0, 0, 0, 1.2, 0.35};\n"
                 "BooleanUnion(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};"),
    "fillet": (0.08, "Box(1) = {0, 0, 0, 2, 1, 0.6}; f() = Abs(Boundary{Volume{1};}); e() = Unique(Abs(Boundary{Surface{f()};}));\n"
                     "Fillet{1}{e()}{0.2} Cylinder(2) = {0.7, 0.5, -0.1, 0, 0, 0.8, 0.2};\n"
                     "BooleanDifference(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};"),
}
IN_A_ROW = 5
MOST_SAMPLED = 20000  # facets; of larger surfaces as many at random
CHUNK = 1000
WEIGHTS = np.array([(a, b, 4 - a - b) for a in range(5) for b in range(5 - a)]) / 4


# ---- true shapes ---------------------------------------------------------------------------------


def off_cylinder(p, axis, radius, low, high):
    """Distance from the surface of a cylinder around an axis of coordinates through the origin."""
    along, around = p[:, axis], np.linalg.norm(np.delete(p, axis, axis=1), axis=1) - radius
    ends = np.maximum(low - along, along - high)
    outside = np.hypot(np.maximum(around, 0), np.maximum(ends, 0))
    return np.abs(np.where((around > 0) | (ends > 0), outside, np.maximum(around, ends)))


def off_fillet(p):
    q = np.abs(p - (1, 0.5, 0.3)) - (np.array((1, 0.5, 0.3)) - 0.2)
    box = np.abs(np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0) - 0.2)
    hole = np.abs(np.hypot(p[:, 0] - 0.7, p[:, 1] - 0.5) - 0.2)
    return np.minimum(box, hole)


TRUE = {
    "sphere": lambda p: np.abs(np.linalg.norm(p, axis=1) - 1),
    "torus": lambda p: np.abs(np.hypot(np.hypot(p[:, 0], p[:, 1]) - 1, p[:, 2]) - 0.3),
    "cylinder": lambda p: off_cylinder(p, 2, 0.5, 0, 2),
    "tee": lambda p: np.minimum(off_cylinder(p, 0, 0.5, -1, 1), off_cylinder(p, 2, 0.35, -9, 1.2)),
    "fillet": off_fillet,
}

# ---- the judge -----------------------------------------------------------------------------------


def read(path):
    """Points and tetrahedra."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        mesh = meshio.read(path)
    return mesh.points[:, :3].astype(float), np.concatenate([b.data for b in mesh.cells if b.type == "tetra"])


def surface_of(tets):
    faces = np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 3, 2]], tets[:, [0, 1, 3]], tets[:, [0, 2, 1]]])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def quality(x, tets):
    """Worst and RMS of R / (3 r), the smallest dihedral angle in degrees, volume."""
    p = x[tets]
    a, b, c = (p[:, i] - p[:, 0] for i in (1, 2, 3))
    volume = np.abs(np.einsum("ij,ij->i", np.cross(a, b), c)) / 6
    normals = [np.cross(p[:, j] - p[:, i], p[:, k] - p[:, i]) for i, j, k in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))]
    area = sum(np.linalg.norm(n, axis=1) / 2 for n in normals)
    squares = [np.einsum("ij,ij->i", e, e)[:, None] for e in (a, b, c)]
    radius = np.linalg.norm(squares[0] * np.cross(b, c) + squares[1] * np.cross(c, a) + squares[2] * np.cross(a, b),
                            axis=1) / (12 * volume)
    ratio = radius * area / (9 * volume)
    largest = -np.inf
    for m, n in itertools.combinations(normals, 2):
        largest = np.maximum(largest, -np.einsum("ij,ij->i", m, n) / (np.linalg.norm(m, axis=1) * np.linalg.norm(n, axis=1)))
    return {"worst": float(ratio.max()), "rms": float(np.sqrt((ratio ** 2).mean())),
            "angle": math.degrees(math.acos(min(1, largest.max()))), "volume": float(volume.sum())}


def distances(points, a, b, c):
    """Distances of points to triangles, of the same leading shape."""
    n = np.cross(b - a, c - a)
    square = np.maximum((n * n).sum(-1), 1e-300)
    height = ((points - a) * n).sum(-1) / square
    foot = points - height[..., None] * n
    inside = np.ones(height.shape, bool)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, foot - u) * n).sum(-1) >= 0
    best = np.where(inside, np.abs(height) * np.sqrt(square), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        e = v - u
        t = np.clip(((points - u) * e).sum(-1) / np.maximum((e * e).sum(-1), 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - u - t[..., None] * e, axis=-1))
    return best


def facets_at(facets, n):
    """Facets of each node, padded by -1."""
    order = np.argsort(facets.ravel(), kind="stable")
    nodes = facets.ravel()[order]
    begin = np.searchsorted(nodes, np.arange(n + 1))
    table = np.full((n, int((begin[1:] - begin[:-1]).max())), -1)
    table[nodes, np.arange(len(nodes)) - begin[nodes]] = order // 3
    return table


def apart(new, old, facets, table, chosen, h):
    """Largest distance of samples of facets from a surface of the same facets, nearby ones, absolute and in h [facets]."""
    most = most_h = 0
    for part in np.array_split(chosen, len(chosen) // CHUNK + 1):
        first = table[facets[part]].reshape(len(part), -1)
        second = table[facets[first]]
        second[first < 0] = -1
        near = np.sort(second.reshape(len(part), -1), axis=1)
        near[:, 1:][near[:, 1:] == near[:, :-1]] = -1
        near = -np.sort(-near, axis=1)
        near = near[:, :int((near >= 0).sum(axis=1).max())]
        near[near < 0] = np.broadcast_to(near[:, :1], near.shape)[near < 0]
        corners = old[facets[near]][:, :, None]
        samples = np.einsum("sk,ekd->esd", WEIGHTS, new[facets[part]])[:, None]
        least = distances(samples, corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]).min(axis=1).max(axis=1)
        most, most_h = max(most, float(least.max())), max(most_h, float((least / h[part]).max()))
    return most, most_h


def off_true(name, path):
    """RMS over samples of the surface of their distance from the true shape."""
    x, tets = read(path)
    samples = np.einsum("sk,ekd->esd", WEIGHTS, x[surface_of(tets)]).reshape(-1, 3)
    return float(np.sqrt((TRUE[name](samples) ** 2).mean()))


# ---- runs ------------------------------------------------------------------------------------------


def smooth(planish, source, target, *options):
    """The JSON of a run, and its user seconds."""
    before = os.times().children_user
    report = target.with_suffix(".json")
    subprocess.run([planish, "smooth", source, "-o", target, "--json", report, "-q", "-j", "1", *options], check=True)
    return json.loads(report.read_text(encoding="utf-8")), os.times().children_user - before


def compare(planish, source, folder):
    flat, curved = folder / ("flat" + source.suffix), folder / ("curved" + source.suffix)
    was, seconds = smooth(planish, source, flat, "--slide", "auto")
    now, seconds_curved = smooth(planish, source, curved, "--slide", "curved", "--slide-interfaces")
    x, tets = read(source)
    y, _ = read(curved)
    facets = surface_of(tets)
    table = facets_at(facets, len(x))
    chosen = np.arange(len(facets))
    if len(chosen) > MOST_SAMPLED:
        chosen = np.random.default_rng(53).choice(chosen, MOST_SAMPLED, replace=False)
    a, b = quality(read(flat)[0], tets), quality(y, tets)
    h = np.mean([np.linalg.norm(x[facets[:, i]] - x[facets[:, i - 1]], axis=1) for i in range(3)], axis=0)
    there, back = apart(y, x, facets, table, chosen, h), apart(x, y, facets, table, chosen, h)
    surface = now["surface"]
    for sampled, proved in ((there, surface["distance"]), (back, surface["distance_back"])):
        if proved is not None and sampled[0] > proved * (1 + 1e-9):
            print(f"{source.stem}: a sample is {sampled[0]:.6g} away, which beats the bound {proved:.6g}", file=sys.stderr)
    return {"mesh": source.stem, "elements": len(tets), "sliding": (was["mesh"]["sliding_nodes"], now["mesh"]["sliding_nodes"]),
            "worst": (a["worst"], b["worst"]), "rms": (a["rms"], b["rms"]), "angle": (a["angle"], b["angle"]),
            "fixed": (was["fixed"]["count"], now["fixed"]["count"]), "volume": b["volume"] / quality(x, tets)["volume"] - 1,
            "sampled": there[1], "sampled_back": back[1], "certified": surface["distance_in_edges"],
            "certified_back": surface["distance_back_in_edges"],
            "seconds": (seconds, seconds_curved)}


def repeat(planish, name, source, folder):
    target = folder / ("again" + source.suffix)
    off, given = [off_true(name, source)], source
    for _ in range(IN_A_ROW):
        smooth(planish, given, target, "--slide", "curved", "--surface-of", source)
        off.append(off_true(name, target))
        given = target
    return {"mesh": name, "off": off}


def make(name, folder):
    size, text = MODELS[name]
    script, mesh = folder / f"{name}.geo", folder / f"{name}.msh"
    script.write_text(f'SetFactory("OpenCASCADE");\n{text}\nMesh.Optimize = 0; Mesh.MeshSizeMin = {size};\n'
                      f"Mesh.MeshSizeMax = {size};\n", encoding="ascii")
    subprocess.run(["gmsh", "-3", "-v", "1", "-nt", "1", script, "-format", "msh41", "-o", mesh], check=True)
    return mesh


def from_to(pair, digits=4):
    return " -> ".join(f"{value:.{digits}g}" for value in pair)


def main(build, *meshes):
    build = pathlib.Path(build)
    folder, planish, about = build / "meshes", build / "planish", machine.description()
    for needed in (folder, build / "results"):
        needed.mkdir(exist_ok=True)
    models = {name: make(name, folder) for name in MODELS}
    rows, shapes = [], []
    print(f"{machine.line(about)}\n\n| mesh (elements) | nodes sliding | worst RR | RMS | smallest dihedral | immovable | "
          "off, sampled | certified | back, sampled | certified | volume | s |\n" + "| --- " + "| --: " * 11 + "|")
    for source in [*map(pathlib.Path, meshes), *models.values()]:
        r = compare(planish, source, folder)
        rows.append(r)
        print(f"| {r['mesh']} ({r['elements']}) | {from_to(r['sliding'], 9)} | {from_to(r['worst'])} | {from_to(r['rms'])} | "
              f"{from_to(r['angle'], 3)} | {from_to(r['fixed'], 9)} | {r['sampled']:.3f} | {r['certified']:.3f} | "
              f"{r['sampled_back']:.3f} | {r['certified_back'] or math.inf:.3f} | {r['volume']:.1e} | x {r['seconds'][1] / r['seconds'][0]:.2f} |",
              flush=True)
    print(f"\n| model | input is off its true shape (RMS) | after a run | after {IN_A_ROW} |\n| --- | --: | --: | --: |")
    for name, source in models.items():
        r = repeat(planish, name, source, folder)
        shapes.append(r)
        first, once, last = r["off"][0], r["off"][1], r["off"][-1]
        print(f"| {name} | {first:.2e} | {100 * (once / first - 1):+.1f} % | {100 * (last / first - 1):+.1f} % |", flush=True)
    (build / "results" / "curved.json").write_text(json.dumps({"machine": about, "rows": rows, "shapes": shapes}, indent=1),
                                                   encoding="ascii")


if __name__ == "__main__":
    main(*sys.argv[1:])
