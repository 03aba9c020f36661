#!/usr/bin/python3
"""judge: compare a mesh before and after smoothing, without planish.

    judge.py IN OUT [--report REPORT.json] [--way default|slide|best]

Prints a JSON object: faults (a list of sentences, each begins with a kind of KINDS), unknown (what could not be decided),
and figures of both meshes. Exit status 1 if there are faults. IN and OUT are read by meshio or Gmsh. REPORT is planish's
own JSON; the judge computes its figures anew. The promises are those of docs/program.md, docs/elements.md and
docs/surfaces.md. Needs numpy and meshio (Debian: python3-meshio)."""
import argparse
import json
import pathlib
import sys

import numpy as np

import measures
import reading
import stays
import topology
import validity
from shapes import SHAPES

KINDS = {
    "bytes": "something else than coordinates changed in the file",
    "connectivity": "the elements are not those of the input",
    "data": "arrays of data or groups changed",
    "boundary": "a held node moved",
    "plane": "a sliding node left its plane or line",
    "surface": "the surface is farther off than the report or the tolerance says",
    "invalid": "a valid element is not valid any more though no sweep untangles, or more elements are invalid than before",
    "worst": "the worst element got worse",
    "rms": "the RMS rose",
    "angle": "the smallest angle, or the least scaled Jacobian, got smaller",
    "figures": "the report has other figures",
    "status": "exit status or certificate do not fit the mesh",
}
WORST_RISE = 0.01  # --worst-rise


class Meshes:
    """The elements of both meshes that the promises are about."""

    def __init__(self, before, after, report):
        self.before, self.after, self.report = before, after, report or {}
        numbers = before.elements()
        self.blocks = [before.blocks[i] for i in numbers]
        self.names = [name for name, _ in self.blocks]
        self.numbers = numbers
        self.x, self.y = before.points.astype(float), after.points.astype(float)
        self.dim = before.dim
        self.axes, self.is_in_space = _axes(self.x, self.blocks, self.dim)
        self.facets = topology.facets_of(self.blocks)
        self.n = sum(len(cells) for _, cells in self.blocks)
        self.moved = (before.points != after.points).any(axis=1)
        self.is_simplices = all(SHAPES[name].base in ("triangle", "tetra") for name in self.names)
        self.sign = None
        if not self.is_in_space:
            volume = np.concatenate([measures.volumes(name, self.x[cells][:, :, self.axes]) for name, cells in self.blocks])
            self.sign = topology.signs(self.n, self.facets, volume)

    def parts(self):
        """Type, cells and signs of each block."""
        begin = 0
        for name, cells in self.blocks:
            yield name, cells, None if self.sign is None else self.sign[begin:begin + len(cells)]
            begin += len(cells)


def _axes(points, blocks, dim):
    """The axes in which a mesh is measured, and whether it is a surface in space."""
    if dim == 3:
        return [0, 1, 2], False
    used = points[np.unique(np.concatenate([cells.ravel() for _, cells in blocks]))]
    span = np.ptp(used, axis=0)
    if span.min() <= 1e-8 * span.max():
        return [i for i in range(3) if i != int(np.argmin(span))], False
    centred = used - used.mean(axis=0)
    _, _, directions = np.linalg.svd(centred, full_matrices=False)
    off = np.abs(centred @ directions[2]).max()
    return [i for i in range(3) if i != int(np.argmax(np.abs(directions[2])))], off > 1e-5 * np.linalg.norm(span)


def _figures(meshes, points):
    """States and measures of all elements at points, and the figures that reports have, too."""
    states, ratios, least = [], [], []
    for name, cells, sign in meshes.parts():
        places = points[cells]
        flat = places[:, :, meshes.axes]
        states.append(validity.states(name, flat, sign) if sign is not None else np.ones(len(cells), int))
        aspect, jacobian = measures.cell(name, places if sign is None else flat, sign)
        if meshes.is_simplices:
            ratio, angle = measures.simplex(name, places)
            ratios.append(np.where(np.isfinite(aspect), ratio, np.inf))
            least.append(np.where(np.isfinite(aspect), angle, np.nan))
        else:
            ratios.append(aspect)
            least.append(jacobian)
    state, ratio, low = map(np.concatenate, (states, ratios, least))
    good = np.isfinite(ratio) & ((state != validity.INVALID) | meshes.is_simplices)  # simplices count by their corners
    whole = {"elements": len(state), "inverted": int((state == validity.INVALID).sum()),
             "unknown": int((state == validity.UNKNOWN).sum()),
             "worst": float(ratio[good].max()) if good.any() else None,
             "rms": float(np.sqrt((ratio[good] ** 2).mean())) if good.any() else None,
             "least": float(np.nanmin(low)) if not np.isnan(low).all() else None}
    return whole, state, ratio, low


def _untangles(report):
    """Whether a sweep may have untangled: it may invert elements, if it repairs more. Without a report it may have."""
    return any(sweep["phase"] == "untangle" for sweep in report.get("sweeps", [{"phase": "untangle"}]))


# ---- what may not get worse ----------------------------------------------------------------------------


def _slack(worst):
    """Of a ratio in doubles: its errors grow with the ratio."""
    return 1 + 1e-9 + 1e-13 * min(worst or 0, 1e12) ** 2


def not_worse(meshes, before, after, way):
    """Faults of validity and measures. before, after: what _figures returns."""
    (a, old_state, ratio, low), (b, state, new_ratio, new_low) = before, after
    spoiled = np.flatnonzero((old_state == validity.VALID) & (state == validity.INVALID))
    if b["inverted"] > a["inverted"] + a["unknown"]:
        yield f"invalid: {a['inverted']} elements before, {b['inverted']} after, such as {int(np.argmin(state))}"
    elif spoiled.size and not _untangles(meshes.report):
        yield f"invalid: {spoiled.size} valid elements are not valid any more, such as {int(spoiled[0])}"
    if a["inverted"] or a["unknown"] or b["inverted"] or meshes.report.get("mesh", {}).get("wrapped_elements"):
        return
    if meshes.report.get("target", "regular") != "regular" or a["worst"] is None:
        return
    if b["rms"] > a["rms"] * (1 + WORST_RISE * (way == "best")) * _slack(1):
        yield f"rms: {a['rms']:.9g} became {b['rms']:.9g}"
    changed = np.zeros(meshes.n, bool)
    begin = 0
    for _, cells in meshes.blocks:
        changed[begin:begin + len(cells)] = meshes.moved[cells].any(axis=1)
        begin += len(cells)
    if not changed.any():
        return
    said = meshes.report.get("before", {})
    worst = said.get("max_radius_ratio_movable") or said.get("max_aspect_ratio_movable") or ratio.max()
    worst = min(worst, ratio.max())
    if new_ratio[changed].max() > worst * _slack(worst):
        yield f"worst: {worst:.9g} became {new_ratio[changed].max():.9g}"
    least = said.get("min_dihedral_movable_deg") if meshes.is_simplices else None
    least = max(np.nanmin(low), least if least is not None else -np.inf)
    if np.nanmin(new_low[changed]) < least - 1e-9 * max(1, abs(least)) - 1e-13 * worst:
        yield f"angle: {least:.9g} became {np.nanmin(new_low[changed]):.9g}"


def same_figures(meshes, report, before, after):
    """The report's figures, computed anew."""
    names = {"worst": "max_radius_ratio", "rms": "rms_radius_ratio", "least": "min_dihedral_deg"}
    if not meshes.is_simplices:
        names = {"worst": "max_aspect_ratio", "rms": "rms_aspect_ratio", "least": "min_scaled_jacobian"}
    if report["mesh"]["elements"] != meshes.n:
        yield f"figures: {report['mesh']['elements']} elements, there are {meshes.n}"
        return
    if report["mesh"]["nodes"] == len(meshes.x) and report["moved_nodes"] != int(meshes.moved.sum()):
        yield f"figures: {report['moved_nodes']} moved nodes, there are {int(meshes.moved.sum())}"
    for when, mine in (("before", before), ("after", after)):
        said = report[when]
        if not mine["inverted"] <= said["inverted"] <= mine["inverted"] + mine["unknown"]:
            yield f"figures: {when}: {said['inverted']} inverted elements, there are {mine['inverted']}"
        if report["target"] != "regular" and not meshes.is_simplices:
            continue
        for own, key in names.items():
            a, b = mine[own], said[key]
            if a is not None and b is not None and abs(a - b) > 1e-9 + abs(a) * (_slack(mine["worst"]) - 1):
                yield f"figures: {when}: {key} {b:.12g}, it is {a:.12g}"


def fitting_status(report, status, after):
    if report["certified"] and after["inverted"]:
        yield f"status: certified, and {after['inverted']} elements are not valid"
    if status == 0 and after["inverted"]:
        yield f"status: 0, and {after['inverted']} elements are not valid"


def judge(source, target, report=None, way="default", status=None):
    """Faults, what is unknown, and the figures before and after, of a smoothed file."""
    before, after = reading.read(source), reading.read(target)
    faults = list(stays.same_mesh(before, after))
    if any(fault.startswith("connectivity") for fault in faults):
        return {"faults": faults, "unknown": [], "before": None, "after": None}
    faults += stays.same_bytes(source, target, before, after)
    meshes = Meshes(before, after, report)
    old, new = _figures(meshes, meshes.x), _figures(meshes, meshes.y)
    if meshes.is_in_space or (way == "best" and meshes.dim == 3):
        faults += stays.on_surface(meshes)
        if not meshes.is_in_space:  # where regions end at curves
            faults += stays.in_planes(meshes, False)
    elif way == "default":
        faults += stays.held_nodes(meshes)
    else:
        faults += stays.in_planes(meshes, True)
    faults += not_worse(meshes, old, new, way)
    if report:
        faults += same_figures(meshes, report, old[0], new[0])
        faults += fitting_status(report, status, new[0])
    unknown = [f"{n} elements {when}" for when, n in (("before", old[0]["unknown"]), ("after", new[0]["unknown"])) if n]
    if meshes.sign is not None and (meshes.sign == 0).any():
        unknown.append("elements that cannot be oriented")
    if way == "best" and meshes.report.get("surface") and stays.surface_groups(meshes) is None:
        unknown.append("distances of facets with nodes inside")
    return {"faults": faults, "unknown": unknown, "before": old[0], "after": new[0], "moved": int(meshes.moved.sum())}


def main():
    parser = argparse.ArgumentParser(prog="judge.py", description="Compare a mesh before and after smoothing.")
    parser.add_argument("source", metavar="IN")
    parser.add_argument("target", metavar="OUT")
    parser.add_argument("--report", metavar="REPORT.json")
    parser.add_argument("--way", choices=("default", "slide", "best"), default="default")
    parser.add_argument("--status", type=int)
    chosen = parser.parse_args()
    report = json.loads(pathlib.Path(chosen.report).read_text(encoding="utf-8")) if chosen.report else None
    found = judge(chosen.source, chosen.target, report, chosen.way, chosen.status)
    print(json.dumps(found, indent=1))
    return int(bool(found["faults"]))


if __name__ == "__main__":
    sys.exit(main())
