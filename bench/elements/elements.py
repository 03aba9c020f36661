"""elements: meshes of every type of elements, smoothed by programs and judged here; see run.

    elements.py PLANISH RESULTS.json [--quick] [FOLDER ...]
"""
import gzip
import itertools
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

import numpy as np

import machine

REPEATS = 3
MOST_SECONDS = 300  # of one run
SAMPLES = np.linspace(0, 1, 9)

# ---- types -------------------------------------------------------------------------------------

ROOT_2, ROOT_3 = np.sqrt(2), np.sqrt(3)


def powers(bounds, most):
    """Exponents up to bounds with at most that much in all: of monomials."""
    return [p for p in itertools.product(*(range(b + 1) for b in bounds)) if sum(p) <= most]


def serendipity(dim):
    """Exponents up to 2, of which at most one is 2."""
    return [p for p in itertools.product(range(3), repeat=dim) if p.count(2) <= 1]


@dataclass
class Shape:
    """corners: where dim edges meet, each with its neighbours, right-handed; places of the corners in
    the reference element; edges whose middles are nodes; inside: whether a point of the unit cube is
    in the element; ideal: edges of the ideal corner, as columns."""
    dim: int
    places: list
    corners: list
    edges: list
    ideal: np.ndarray
    inside: object = staticmethod(lambda p: True)

    def points(self):
        return np.array([p for p in itertools.product(SAMPLES, repeat=self.dim) if self.inside(p)])


def in_triangle(p):
    return p[0] + p[1] <= 1 + 1e-12


SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
SHAPES = {
    "triangle": Shape(2, [(0, 0), (1, 0), (0, 1)], [(0, 1, 2), (1, 2, 0), (2, 0, 1)], [(0, 1), (1, 2), (2, 0)],
                      np.array([[1, 0.5], [0, ROOT_3 / 2]]), in_triangle),
    "quadrilateral": Shape(2, SQUARE, [(i, (i + 1) % 4, (i + 3) % 4) for i in range(4)],
                           [(i, (i + 1) % 4) for i in range(4)], np.eye(2)),
    "tetrahedron": Shape(3, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
                         [(0, 1, 2, 3), (1, 2, 0, 3), (2, 0, 1, 3), (3, 0, 2, 1)],
                         [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
                         np.array([[1, 0.5, 0.5], [0, ROOT_3 / 2, ROOT_3 / 6], [0, 0, ROOT_2 / ROOT_3]]),
                         lambda p: sum(p) <= 1 + 1e-12),
    "hexahedron": Shape(3, [(*p, z) for z in (0, 1) for p in SQUARE],
                        [(i, (i + 1) % 4, (i + 3) % 4, i + 4) for i in range(4)]
                        + [(4 + i, 4 + (i + 3) % 4, 4 + (i + 1) % 4, i) for i in range(4)],
                        [(z + i, z + (i + 1) % 4) for z in (0, 4) for i in range(4)] + [(i, i + 4) for i in range(4)],
                        np.eye(3)),
    "wedge": Shape(3, [(*p, z) for z in (0, 1) for p in ((0, 0), (1, 0), (0, 1))],
                   [(i, (i + 1) % 3, (i + 2) % 3, i + 3) for i in range(3)]
                   + [(3 + i, 3 + (i + 2) % 3, 3 + (i + 1) % 3, i) for i in range(3)],
                   [(z + i, z + (i + 1) % 3) for z in (0, 3) for i in range(3)] + [(i, i + 3) for i in range(3)],
                   np.array([[1, 0.5, 0], [0, ROOT_3 / 2, 0], [0, 0, 1]]), in_triangle),
    "pyramid": Shape(3, [(*p, 0) for p in SQUARE] + [(0.5, 0.5, 1)],
                     [(i, (i + 1) % 4, (i + 3) % 4, 4) for i in range(4)],
                     [(i, (i + 1) % 4) for i in range(4)] + [(i, 4) for i in range(4)],
                     np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, ROOT_2 / 2]])),
}
FACES = {"hexahedron": [(0, 7), (1, 6), (0, 5), (3, 6), (0, 2), (4, 6)], "wedge": [(0, 4), (1, 5), (2, 3)],
         "quadrilateral": [(0, 2)]}  # opposite corners of faces, in VTK's order


@dataclass
class Type:
    """Elements by VTK's number: shape, nodes beside the corners between corners, monomials."""
    shape: str
    between: list
    monomials: list

    @property
    def nodes(self):
        return len(SHAPES[self.shape].places) + len(self.between)

    def gradients(self, points):
        """Of the shape functions: [points][nodes][dim]."""
        shape = SHAPES[self.shape]
        places = np.array(shape.places + [np.mean([shape.places[i] for i in pair], axis=0)
                                          for pair in self.between], float)
        exponents = np.array(self.monomials)
        values = np.prod(places[:, None] ** exponents, axis=2)
        slopes = []
        for d in range(shape.dim):
            lower = exponents.copy()
            lower[:, d] = np.maximum(lower[:, d] - 1, 0)
            slopes.append(exponents[:, d] * np.prod(points[:, None] ** lower, axis=2))
        return np.einsum("pmd,mn->pnd", np.stack(slopes, axis=-1), np.linalg.inv(values))


def types():
    def edges(name):
        return SHAPES[name].edges

    def product(flat, upright):
        return [(*p, z) for p in flat for z in range(upright + 1)]

    linear, square = powers((1, 1), 1), powers((2, 2), 2)
    return {
        5: Type("triangle", [], linear), 22: Type("triangle", edges("triangle"), square),
        9: Type("quadrilateral", [], powers((1, 1), 2)),
        23: Type("quadrilateral", edges("quadrilateral"), serendipity(2)),
        28: Type("quadrilateral", edges("quadrilateral") + FACES["quadrilateral"], powers((2, 2), 4)),
        10: Type("tetrahedron", [], powers((1,) * 3, 1)),
        24: Type("tetrahedron", edges("tetrahedron"), powers((2,) * 3, 2)),
        12: Type("hexahedron", [], powers((1,) * 3, 3)),
        25: Type("hexahedron", edges("hexahedron"), serendipity(3)),
        29: Type("hexahedron", edges("hexahedron") + FACES["hexahedron"] + [(0, 6)], powers((2,) * 3, 6)),
        13: Type("wedge", [], product(linear, 1)),
        26: Type("wedge", edges("wedge"), product(square, 1) + [(*p, 2) for p in linear]),
        32: Type("wedge", edges("wedge") + FACES["wedge"], product(square, 2)),
        14: Type("pyramid", [], []),
    }


TYPES = types()

# ---- files -------------------------------------------------------------------------------------


@dataclass
class Mesh:
    """cells: nodes [k][nodes of the type] by VTK's number."""
    points: np.ndarray
    cells: dict


def read_vtk(text):
    words = text.split()
    at = words.index("POINTS")
    n = int(words[at + 1])
    points = np.array(words[at + 3:at + 3 + 3 * n], float).reshape(n, 3)
    at = words.index("CELLS")
    lists = np.array(words[at + 3:at + 3 + int(words[at + 2])], int)
    at = words.index("CELL_TYPES")
    numbers = np.array(words[at + 2:at + 2 + int(words[at + 1])], int)
    cells, place = {}, 0
    for number in numbers:
        nodes = lists[place + 1:place + 1 + lists[place]]
        place += 1 + lists[place]
        if number == 11:  # a voxel
            number, nodes = 12, nodes[[0, 1, 3, 2, 4, 5, 7, 6]]
        cells.setdefault(int(number), []).append(nodes)
    return Mesh(points, {number: np.array(nodes) for number, nodes in cells.items() if number in TYPES})


# Gmsh's types by VTK's, and the order of their nodes where it is another.
GMSH = {2: 5, 9: 22, 3: 9, 16: 23, 10: 28, 4: 10, 11: 24, 5: 12, 17: 25, 12: 29, 6: 13, 18: 26, 13: 32, 7: 14}
ORDER = {24: [*range(8), 9, 8], 25: [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
         29: [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26],
         26: [*range(6), 6, 9, 7, 12, 14, 13, 8, 10, 11], 32: [*range(6), 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16]}


def read_msh(text):
    lines = text.splitlines()
    at = lines.index("$Nodes")
    n = int(lines[at + 1])
    rows = [line.split() for line in lines[at + 2:at + 2 + n]]
    index = {int(row[0]): i for i, row in enumerate(rows)}
    points = np.array([row[1:4] for row in rows], float)
    at, cells = lines.index("$Elements"), {}
    for line in lines[at + 2:at + 2 + int(lines[at + 1])]:
        row = list(map(int, line.split()))
        number = GMSH.get(row[1])
        if number:
            nodes = [index[node] for node in row[3 + row[2]:]]
            cells.setdefault(number, []).append([nodes[i] for i in ORDER.get(number, range(len(nodes)))])
    return Mesh(points, {number: np.array(nodes) for number, nodes in cells.items()})


def read(path):
    """The elements of the highest dimension."""
    with (gzip.open(path, "rt") if str(path).endswith(".gz") else open(path, encoding="ascii", errors="replace")) as file:
        text = file.read()
    mesh = read_msh(text) if text.startswith("$MeshFormat") else read_vtk(text)
    dim = max(SHAPES[TYPES[number].shape].dim for number in mesh.cells)
    mesh.cells = {number: nodes for number, nodes in mesh.cells.items() if SHAPES[TYPES[number].shape].dim == dim}
    mesh.points = mesh.points[:, :dim]
    return mesh


def write(path, points, cells):
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    with open(path, "w", encoding="ascii") as file:
        file.write(f"# vtk DataFile Version 2.0\n{path.stem}\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                   f"POINTS {len(points)} double\n")
        file.writelines("%.17g %.17g %.17g\n" % tuple(p) for p in points)
        n, size = sum(map(len, cells.values())), sum(nodes.size + len(nodes) for nodes in cells.values())
        file.write(f"CELLS {n} {size}\n")
        for nodes in cells.values():
            file.writelines(f"{nodes.shape[1]} {' '.join(map(str, row))}\n" for row in nodes)
        file.write(f"CELL_TYPES {n}\n" + "".join(f"{number}\n" * len(nodes) for number, nodes in cells.items()))


# ---- the judge -----------------------------------------------------------------------------------


def sampled(kind, places):
    """Determinants [elements][samples] of elements with nodes at places."""
    shape = SHAPES[kind.shape]
    if kind.shape != "pyramid":
        return np.linalg.det(np.einsum("enk,pnl->epkl", places, kind.gradients(shape.points())))
    # Bilinear over the base, of one sign at any height.
    base, flat = TYPES[9], np.array(list(itertools.product(SAMPLES, repeat=2)))
    along = np.einsum("enk,pnl->epkl", places[:, :4], base.gradients(flat))
    x, y = flat.T
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)
    up = places[:, 4, None] - np.einsum("enk,pn->epk", places[:, :4], weights)
    return np.linalg.det(np.concatenate([along, up[..., None]], axis=-1))


def by_corner(kind, places, sign):
    """AR [elements], NAN where a corner is not positive, and the least scaled Jacobian of each."""
    shape = SHAPES[kind.shape]
    scale = np.linalg.det(shape.ideal)
    squares, least = 0, np.inf
    for corner, *others in shape.corners:
        edges = np.stack([places[:, i] - places[:, corner] for i in others], axis=-1)
        det = sign * np.linalg.det(edges) / scale
        lengths = np.prod(np.linalg.norm(edges, axis=1), axis=1)
        least = np.minimum(least, det / np.maximum(lengths, 1e-300))
        with np.errstate(invalid="ignore", divide="ignore"):
            mu = ((edges @ np.linalg.inv(shape.ideal)) ** 2).sum(axis=(1, 2)) / (
                shape.dim * np.where(det > 0, det, np.nan) ** (2 / shape.dim))
        squares = squares + mu ** 2 / len(shape.corners)
    return np.sqrt(squares), least


def judge(mesh):
    invalid, ratios, least = 0, [], np.inf
    for number, nodes in mesh.cells.items():
        kind = TYPES[number]
        for part in np.array_split(nodes, len(nodes) // 4000 + 1):
            places = mesh.points[part]
            low = sampled(kind, places)
            middle = np.median(low, axis=1)
            sign = 1 if (middle > 0).sum() * 2 >= len(middle) else -1
            invalid += int(((sign * low).min(axis=1) <= 0).sum())
            ratio, jacobian = by_corner(kind, places, sign)
            ratios.append(ratio)
            least = min(least, float(jacobian.min()))
    ratio = np.concatenate(ratios)
    ratio = ratio[np.isfinite(ratio)]
    return {"invalid": invalid, "least_scaled_jacobian": least,
            "rms_aspect_ratio": float(np.sqrt((ratio ** 2).mean())) if len(ratio) else float("nan")}


# ---- meshes that are made ------------------------------------------------------------------------


def grid(kind, n):
    """The unit cube or square of n^dim cells: points, cells, mask of the nodes on its surface."""
    dim = 2 if kind == "quadrilateral" else 3
    points = np.array(list(itertools.product(range(n + 1), repeat=dim)), float)[:, ::-1] / n
    index = np.arange((n + 1) ** dim).reshape((n + 1,) * dim)
    if dim == 2:
        cells = {9: np.stack([index[j:j + n, i:i + n].ravel() for i, j in SQUARE], axis=1)}
    else:
        hexes = np.stack([index[k:k + n, j:j + n, i:i + n].ravel()
                          for i, j, k in SHAPES["hexahedron"].places], axis=1)
        cells = {12: hexes}
        if kind == "wedge":
            cells = {13: np.concatenate([hexes[:, [0, 1, 2, 4, 5, 6]], hexes[:, [0, 2, 3, 4, 6, 7]]])}
        if kind == "pyramid":
            middle = np.arange(len(points), len(points) + len(hexes))
            points = np.concatenate([points, points[hexes].mean(axis=1)])
            sides = (0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)
            cells = {14: np.concatenate([np.column_stack([hexes[:, side], middle]) for side in sides])}
    return points, cells, ((points < 1e-9) | (points > 1 - 1e-9)).any(axis=1)


def bend(p):
    x, y, z = p.T
    return np.stack([(1 + z) * np.sin(2.5 * x) / 1.25, y, (1 + z) * np.cos(2.5 * x)], axis=1) - (0, 0, 1)


def pinch(p):
    return p * np.stack([*2 * [1 - 0.8 * np.exp(-(p[:, 2] / 0.25) ** 2)], np.ones(len(p))], axis=1)


def twist(p):
    x, y, z = p.T
    angle = np.radians(160) * z
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z], axis=1)


def make(folder, quick):
    """Paths of meshes that are made."""
    random, paths = np.random.default_rng(52), []
    sizes = {"hexahedron": 20, "wedge": 16, "pyramid": 14, "quadrilateral": 60}
    for kind, n in sizes.items():
        for percent in (25, 60):
            points, cells, on_surface = grid(kind, n // 2 if quick else n)
            size = 1 / (n // 2 if quick else n)
            points[~on_surface] += random.uniform(-1, 1, points[~on_surface].shape) * percent / 100 * size
            paths.append(folder / f"{kind}_{percent}.vtk")
            write(paths[-1], points, cells)
    for kind, n in (("hexahedron", 16), ("wedge", 12)):
        for deform in (bend, pinch, twist):
            points, cells, on_surface = grid(kind, n // 2 if quick else n)
            points -= 0.5
            points[on_surface] = deform(points[on_surface])
            paths.append(folder / f"left_{kind}_{deform.__name__}.vtk")
            write(paths[-1], points, cells)
    return paths


# ---- programs ------------------------------------------------------------------------------------

ON_ONE_CORE = ["taskset", "--cpu-list", str(max(os.sched_getaffinity(0)))]


def gmsh_command(source, mesh, folder):
    kinds = [TYPES[number] for number in mesh.cells]
    how = "HighOrder" if any(kind.between for kind in kinds) else "Relocate3D"
    script = folder / "step.geo"
    script.write_text(f'Merge "{source}";\nOptimizeMesh "{how}";\n', encoding="ascii")
    return ["gmsh", script, "-v", "2", "-nt", "1", "-save", "-format", "msh22", "-o", folder / "gmsh.msh"]


def programs(planish, mesh, source, folder):
    """Command and result of each program that is there and takes the mesh."""
    is_vtk, is_straight = source.suffix == ".vtk", not any(TYPES[number].between for number in mesh.cells)
    found = {"planish": ([planish, "smooth", source, "-o", folder / ("planish" + source.suffix), "-q", "-j", "1",
                          "--layers", "ignore"], folder / ("planish" + source.suffix))}
    if shutil.which("gmsh") and mesh.points.shape[1] == 3:
        found["gmsh"] = gmsh_command(source, mesh, folder), folder / "gmsh.msh"
    if shutil.which("mixedSmoothing") and is_vtk and is_straight and mesh.points.shape[1] == 3:
        found["hexsmoothing"] = ["mixedSmoothing", source, folder / "hex.vtk", "20"], folder / "hex.vtk"
    if shutil.which("msqshape") and is_vtk and is_straight:
        found["msqshape"] = ["msqshape", source, folder / "msq.vtk"], folder / "msq.vtk"
    return found


def run(command, result, repeats):
    """User seconds, or None: it failed."""
    least = None
    for _ in range(repeats):
        result.unlink(missing_ok=True)
        before = os.times()
        begin = time.monotonic()
        try:
            subprocess.run([*ON_ONE_CORE, *command], check=False, timeout=MOST_SECONDS, stdin=subprocess.DEVNULL,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            return None
        seconds = os.times().children_user - before.children_user
        if not result.exists():
            return None
        least = seconds if least is None else min(least, seconds)
        if time.monotonic() - begin > 10:
            break
    return least


def compare(planish, path, folder, repeats):
    """Rows of a mesh."""
    source = folder / path.name.removesuffix(".gz")
    if path.suffix == ".gz":
        source.write_bytes(gzip.decompress(path.read_bytes()))
    else:
        shutil.copyfile(path, source)
    mesh = read(source)
    rows = [{"mesh": source.stem, "program": "input", "elements": sum(map(len, mesh.cells.values())), **judge(mesh)}]
    for name, (command, result) in programs(planish, mesh, source, folder).items():
        seconds = run(command, result, repeats)
        row = {"mesh": source.stem, "program": name, "seconds": seconds}
        if seconds is not None:
            row.update(judge(read(result)))
        rows.append(row)
    return rows


def print_rows(rows):
    for row in rows:
        n = f"{row['mesh']} ({row['elements']})" if "elements" in row else ""
        if "invalid" in row:
            seconds = "" if row.get("seconds") is None else f"{row['seconds']:.2f}"
            print(f"| {n} | {row['program']} | {row['invalid']} | {row['least_scaled_jacobian']:.3f} | "
                  f"{row['rms_aspect_ratio']:.4f} | {seconds} |", flush=True)
        else:
            print(f"| {n} | {row['program']} | failed | | | |", flush=True)


def main(planish, results, *others):
    quick = "--quick" in others
    about, rows = machine.description(), []
    print(f"{machine.line(about)}\n\n| mesh (elements) | by | invalid | least SJ | RMS AR | s |\n"
          "| --- | --- | --: | --: | --: | --: |")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "made").mkdir()
        (folder / "work").mkdir()
        paths = make(folder / "made", quick)
        for other in others:
            if not other.startswith("--"):
                paths += [p for p in sorted(pathlib.Path(other).iterdir())
                          if p.name.endswith((".vtk", ".vtk.gz", ".msh"))]
        for path in paths:
            rows += (new := compare(planish, path, folder / "work", 1 if quick else REPEATS))
            print_rows(new)
    with open(results, "w", encoding="ascii") as file:
        json.dump({"machine": about, "rows": rows}, file, indent=1)


if __name__ == "__main__":
    main(*sys.argv[1:])
