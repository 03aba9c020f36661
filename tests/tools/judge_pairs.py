"""judge_pairs: pairs of meshes that planish has smoothed have no fault, and each way of spoiling one is found.

    judge_pairs.py PLANISH FOLDER"""
import copy
import json
import pathlib
import subprocess
import sys

import numpy as np

import judge

RANDOM = np.random.default_rng(3)
failures = []
seen = set()


class Pair:
    """A mesh in FOLDER, and what planish made of it. A VTK file by write(): points are in lines of their own."""

    def __init__(self, planish, source, way, *options):
        self.source, self.target, self.way = source, source.with_name(f"{source.stem}_{way}.vtk"), way
        report = self.target.with_suffix(".json")
        done = subprocess.run([planish, "smooth", source, "-o", self.target, "-q", "--json", report, *options], check=False)
        self.status, self.report = done.returncode, json.loads(report.read_text(encoding="utf-8"))
        self.text = self.target.read_text(encoding="ascii")

    def points(self):
        lines = self.text.splitlines()
        begin = next(i for i, line in enumerate(lines) if line.startswith("POINTS")) + 1
        end = next(i for i, line in enumerate(lines) if line.startswith("CELLS"))
        return np.array([line.split() for line in lines[begin:end]], float), lines, begin

    def judge(self, text=None, report=None, status=None):
        """Faults of the pair, with another output, report or status."""
        self.target.write_text(self.text if text is None else text, encoding="ascii")
        return judge.judge(self.source, self.target, report or self.report, self.way,
                           self.status if status is None else status)["faults"]

    def moved(self, node, place):
        """The output with a node elsewhere."""
        points, lines, begin = self.points()
        del points
        lines[begin + node] = " ".join(map(repr, map(float, place)))
        return "\n".join(lines) + "\n"


def write(path, points, cells, kind, data=()):
    """A VTK file of one type of elements, with data of cells."""
    rows = "\n".join(" ".join(map(str, (len(cell), *cell))) for cell in cells.tolist())
    text = (f"# vtk DataFile Version 3.0\na mesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n"
            + "\n".join(" ".join(map(repr, row)) for row in points.tolist())
            + f"\nCELLS {len(cells)} {cells.size + len(cells)}\n{rows}\nCELL_TYPES {len(cells)}\n"
            + "\n".join([str(kind)] * len(cells)) + f"\nCELL_DATA {len(cells)}\n")
    for name, values in data:
        text += f"SCALARS {name} int 1\nLOOKUP_TABLE default\n" + "\n".join(map(str, values)) + "\n"
    path.write_text(text, encoding="ascii")


def cube(n, shake):
    """A cube of n^3 cells, its inner nodes moved at random: points, nodes of the cells, mask of the surface."""
    axis = np.linspace(0, 1, n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([index[i:n + i, j:n + j, k:n + k].ravel() for i, j, k in corners], axis=1)
    outside = ((points == 0) | (points == 1)).any(axis=1)
    points[~outside] += RANDOM.uniform(-shake, shake, (int((~outside).sum()), 3)) / n
    return points, cells, outside


def tetrahedra(cells):
    ways = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    return np.concatenate([cells[:, way] for way in ways])


def expect_good(pair, what):
    faults = pair.judge()
    if faults:
        failures.append(f"{what}: {faults}")


def expect_fault(pair, kinds, what, **spoiled):
    """All these kinds are found, and with them only kinds that follow."""
    found = {fault.split(":")[0] for fault in pair.judge(**spoiled)}
    seen.update(found & set(kinds))
    if not set(kinds) <= found:
        failures.append(f"{what}: found {sorted(found)} instead of {kinds}")


def with_figure(report, where, key, value):
    changed = copy.deepcopy(report)
    (changed[where] if where else changed)[key] = value
    return changed


def spoil_file(pair):
    """What is no coordinate changes."""
    lines = pair.text.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("CELLS")) + 1
    one = lines[first].split()
    one[1], one[2] = one[2], one[1]
    expect_fault(pair, ["connectivity"], "two nodes exchanged", text="\n".join([*lines[:first], " ".join(one), *lines[first + 1:]]))
    expect_fault(pair, ["data", "bytes"], "a value of the data", text="\n".join([*lines[:-1], "7", ""]))
    expect_fault(pair, ["bytes"], "the title", text=pair.text.replace("a mesh", "my mesh"))
    expect_fault(pair, ["bytes"], "a word more", text=pair.text.replace("a mesh", "a fine mesh"))


def spoil_nodes(pair, outside, middle):
    """Nodes are where they must not be."""
    points, _, _ = pair.points()
    face = int(np.flatnonzero(outside)[40])
    expect_fault(pair, ["boundary", "figures"], "a node of the boundary",
                 text=pair.moved(face, points[face] * 0.999 + 0.0005))
    expect_fault(pair, ["boundary"], "a node between regions", text=pair.moved(middle, points[middle] + (0.001, 0, 0)))
    inner = int(np.flatnonzero(~outside)[0])
    away = pair.moved(inner, points[inner] + 1)
    expect_fault(pair, ["invalid", "status", "figures"], "an inner node far away", text=away)
    expect_fault(pair, ["invalid"], "the same without a report's certificate", text=away,
                 report=with_figure(pair.report, None, "certified", False), status=1)
    low, high = 0.02, 0.3
    for _ in range(6):  # as near to a facet as it stays valid
        step = (low + high) / 2
        near = pair.moved(inner, points[inner] + (step, step / 3, 0))
        if "invalid" in {fault.split(":")[0] for fault in pair.judge(text=near)}:
            high = step
        else:
            low, bad = step, near
    expect_fault(pair, ["worst", "angle", "figures"], "an inner node near a facet", text=bad)


def spoil_others(pair, outside):
    """One element is repaired, another one spoiled: only untangling may do that."""
    points, _, _ = pair.points()
    first = pair.source.read_text(encoding="ascii")
    away = [pair.moved(node, points[node] + 1) for node in np.flatnonzero(~outside)[:2]]
    report = with_figure(pair.report, None, "certified", False)
    untangling = with_figure(report, None, "sweeps", [{"phase": "untangle"}])
    n_allowed = 0
    for before, after in (away, away[::-1]):
        pair.source.write_text(before, encoding="ascii")
        expect_fault(pair, ["invalid"], "another element spoiled", text=after, report=report, status=1)
        faults = pair.judge(text=after, report=untangling, status=1)
        n_allowed += not any(fault.startswith("invalid") for fault in faults)
    if n_allowed == 0:
        failures.append("untangling may invert no element")
    pair.source.write_text(first, encoding="ascii")


def spoil_report(pair):
    for where, key in (("after", "rms_radius_ratio"), ("before", "max_radius_ratio"), ("after", "min_dihedral_deg")):
        value = pair.report[where][key] * (1 + 1e-7)
        expect_fault(pair, ["figures"], f"{where} {key}", report=with_figure(pair.report, where, key, value))
    for where, key in (("after", "inverted"), ("before", "inverted"), (None, "moved_nodes"), ("mesh", "elements")):
        value = (pair.report[where] if where else pair.report)[key] + 1
        expect_fault(pair, ["figures"], f"{where} {key}", report=with_figure(pair.report, where, key, value))


def spoil_back(pair):
    """The result for the input, and the other way round."""
    first = pair.source.read_text(encoding="ascii")
    pair.source.write_text(pair.text, encoding="ascii")
    expect_fault(pair, ["rms", "worst"], "smoothing undone", text=first)
    pair.source.write_text(first, encoding="ascii")


def spoil_slide(pair, outside):
    """Nodes that slide leave their planes."""
    points, _, _ = pair.points()
    for node in np.flatnonzero(outside)[[0, 3, 40]]:
        inward = np.where(points[node] == 0, 1, np.where(points[node] == 1, -1, 0))
        expect_fault(pair, ["plane"], f"sliding node {node}", text=pair.moved(node, points[node] + 1e-5 * inward))


def spoil_surface(pair):
    """A surface that is farther off than the report and the tolerance say."""
    distance = pair.report["surface"]["distance"]
    expect_fault(pair, ["surface"], "the distance of the report",
                 report=with_figure(pair.report, "surface", "distance", distance / 20))
    expect_fault(pair, ["surface"], "the distance back",
                 report=with_figure(pair.report, "surface", "distance_back", distance / 20))
    expect_fault(pair, ["surface"], "the tolerance", report=with_figure(pair.report, "surface", "distance_in_edges", 0.051))
    points, _, _ = pair.points()
    top = int(np.argmax(points[:, 2]))
    expect_fault(pair, ["surface"], "a node off the surface", text=pair.moved(top, points[top] * 1.1))


def ball(points):
    """A cube as a ball around the origin."""
    points = 2 * points - 1
    length = np.linalg.norm(points, axis=1)
    return points * (np.abs(points).max(axis=1) / np.where(length > 0, length, 1))[:, None]


def main():
    planish, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    points, cells, outside = cube(4, 0.3)
    tets = tetrahedra(cells)
    region = (points[tets].mean(axis=1)[:, 2] > 0.5).astype(int)
    points[np.abs(points[:, 2] - 0.5) < 0.1, 2] = 0.5  # the plane between the regions
    middle = int(np.flatnonzero((points[:, 2] == 0.5) & ~outside)[0])
    data = [("region", region), ("number", np.arange(len(tets)))]
    write(folder / "tets.vtk", points, tets, 10, data)
    pair = Pair(planish, folder / "tets.vtk", "default")
    expect_good(pair, "tetrahedra")
    spoil_file(pair)
    spoil_nodes(pair, outside, middle)
    spoil_others(pair, outside)
    spoil_report(pair)
    spoil_back(pair)
    slide = Pair(planish, folder / "tets.vtk", "slide", "--slide", "auto")
    expect_good(slide, "tetrahedra that slide")
    spoil_slide(slide, outside)
    write(folder / "hexes.vtk", points, cells, 12)
    hexes = Pair(planish, folder / "hexes.vtk", "default")
    expect_good(hexes, "hexahedra")
    inner = int(np.flatnonzero(~outside)[0])
    expect_fault(hexes, ["invalid", "status", "figures"], "a hexahedron's node far away", text=hexes.moved(inner, (1.5, 1, 1)))
    expect_fault(hexes, ["figures"], "a scaled Jacobian", report=with_figure(hexes.report, "after", "min_scaled_jacobian", 0.9))
    write(folder / "ball.vtk", ball(points), tets, 10)
    curved = Pair(planish, folder / "ball.vtk", "best", "--best")
    expect_good(curved, "a ball")
    spoil_surface(curved)
    missing = set(judge.KINDS) - seen
    if missing:
        failures.append(f"kinds that no spoiled pair had: {sorted(missing)}")
    for failure in failures:
        print("FAILED:", failure)
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
