"""check_report.py SMOOTH.json QUALITY.json SMOOTH.json: keys, types and relations of the reports."""
import json
import math
import sys

NUMBER = (int, float)
QUALITY = {
    "inverted": int, "reversed_elements": int, "below_min_volume": int, "min_volume": NUMBER,
    "max_volume": NUMBER,
    "total_volume": NUMBER, "rms_radius_ratio": NUMBER, "rms_radius_ratio_movable": NUMBER,
    "mean_radius_ratio": NUMBER, "max_radius_ratio": NUMBER, "min_dihedral_deg": NUMBER,
    "max_dihedral_deg": NUMBER, "histogram": {"edges": list, "counts": list},
    "angle_histogram": {"edges": list, "counts": list},
}
HELD = ("boundary", "lines_and_points", "faces_inside", "interface", "other_elements", "periodic",
        "fix", "required", "doubled_points", "nonmanifold", "layers", "wrapped", "not_chosen")
MESH = {"dimension": int, "plane": (dict, type(None)), "nodes": int, "elements": int, "free_nodes": int, "sliding_nodes": int,
        "could_slide": (int, type(None)), "layer_elements": (int, type(None)),
        "free_layer_elements": (int, type(None)),
        "fixed_elements": int, "colours": int, "nodes_with_parameters": int,
        "reversed_elements": int, "wrapped_elements": int, "held": dict.fromkeys(HELD, int),
        "mid_side_nodes": int, "unused_nodes": int, "doubled_nodes": int}
VOLUMES = {"min_volume": (int, float, type(None)), "unfixable": list, "below_min": list,
           "reversed": list, "wrapped": list}
SMOOTH = {
    "planish": str, "input": str, "output": str, "format": str, "mesh": MESH, "target": str, "layer_heights": (dict, type(None)),
    "method": str,
    "objective": {"name": str, "area_weight": NUMBER, "size_weight": NUMBER, "before": NUMBER, "after": NUMBER},
    "before": QUALITY, "after": QUALITY, "sweeps": list, "untangling_sweeps": int, "stop": str,
    "certified": bool, "input_checksum": str, "checksum": str, "max_displacement": NUMBER,
    "moved_nodes": int, "returned_nodes": int, "node_visits": int, "evaluations": int, "held_outside": int,
    "kkt": type(None), "threads": int, "binding": str, "isa": str,
    "seconds": dict.fromkeys(("read", "shape", "setup", "smooth", "write", "total"), NUMBER),
    "fixed": {"count": int, "rms_radius_ratio": NUMBER, "max_radius_ratio": NUMBER},
    "reason": str, "peak_memory_bytes": int, "surface": type(None), **VOLUMES,
}
SWEEP = {"phase": str, "rms": NUMBER, "rms_movable": NUMBER, "objective": NUMBER, "inverted": int,
         "below_min_volume": int, "visits": int, "seconds": NUMBER}


def check(value, shape, where):
    if isinstance(shape, dict):
        missing = set(shape) - set(value)
        assert not missing, "%s lacks %s" % (where, missing)
        for key in shape:
            check(value[key], shape[key], where + "." + key)
    else:
        assert isinstance(value, shape), "%s is %r" % (where, value)


BAD = {"element": int, "radius_ratio": (int, float, type(None)), "min_angle_deg": NUMBER,
       "max_angle_deg": NUMBER, "place": list, "nodes": list, "region": (str, type(None)),
       "movable": (bool, type(None)), "held": (str, type(None))}


def check_histogram(quality, elements):
    edges, counts = quality["histogram"]["edges"], quality["histogram"]["counts"]
    assert len(edges) == len(counts) + 1 and edges[0] <= 1 and edges[-1] is None
    assert edges[:-1] == sorted(edges[:-1])
    assert sum(counts) == elements - quality["inverted"]
    edges, counts = quality["angle_histogram"]["edges"], quality["angle_histogram"]["counts"]
    assert edges == list(range(0, 80, 5)) and len(counts) == len(edges) - 1
    assert sum(counts) == elements - quality["inverted"]
    smallest = next(i for i, count in enumerate(counts) if count)
    assert edges[smallest] <= quality["min_dihedral_deg"] * (1 + 1e-9)
    assert quality["min_dihedral_deg"] < edges[smallest + 1]


def same(a, b):
    """Numbers alike but for rounding, or objects of such numbers."""
    if isinstance(a, dict):
        return set(a) == set(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    if not isinstance(a, NUMBER):
        return a == b
    return math.isclose(a, b, rel_tol=1e-12)


smooth, quality, printed = (json.load(open(name)) for name in sys.argv[1:4])
check(smooth, SMOOTH, "smooth")
assert set(quality) == {"planish", "input", "format", "mesh", "target", "layer_heights", "quality", "checksum", "surface",
                        *VOLUMES}
check(quality, {"mesh": MESH, "quality": QUALITY, **VOLUMES}, "quality")

before, after, mesh = smooth["before"], smooth["after"], smooth["mesh"]
for state in (before, after, quality["quality"]):
    check_histogram(state, mesh["elements"])
    for bad in state["worst_elements"]:
        check(bad, BAD, "worst element")
    assert len(state["worst_elements"]) == 10
    assert same(state["worst_elements"][0]["radius_ratio"], state["max_radius_ratio"])
assert before["worst_elements"] != after["worst_elements"]
assert mesh == quality["mesh"] and mesh["dimension"] == 3
assert mesh["mid_side_nodes"] == 0
assert (mesh["free_nodes"] + mesh["sliding_nodes"] + mesh["unused_nodes"]
        + sum(mesh["held"].values()) == mesh["nodes"])
assert 0 < mesh["free_nodes"] < mesh["nodes"] and 0 < mesh["colours"] <= 14

# The mesh that was written is the one that was reported.
for key in after:
    if key not in ("histogram", "angle_histogram"):
        assert same(after[key], quality["quality"][key]), key
assert smooth["checksum"] == quality["checksum"]

# By default volumes only stay positive, and F is the RMS of the radius ratio.
for report in (smooth, quality):
    assert report["min_volume"] is None and report["below_min"] == report["unfixable"] == []
assert smooth["method"] == "planish" and smooth["held_outside"] == 0
objective = smooth["objective"]
assert objective["name"] == "radius-ratio" and objective["area_weight"] == 0
for when, state in (("before", before), ("after", after)):
    assert same(objective[when], state["rms_radius_ratio"])
assert smooth["evaluations"] >= smooth["node_visits"] > 0

assert smooth["untangling_sweeps"] == 0
assert smooth["stop"] == "converged" and smooth["certified"] and smooth["reason"] == ""
assert after["rms_radius_ratio"] < 0.9 * before["rms_radius_ratio"]
assert after["max_radius_ratio"] <= before["max_radius_ratio"]
assert same(after["total_volume"], before["total_volume"])
assert smooth["fixed"]["count"] == mesh["fixed_elements"]
assert 1 <= smooth["fixed"]["rms_radius_ratio"] < smooth["fixed"]["max_radius_ratio"] <= after["max_radius_ratio"]
assert 0 < smooth["moved_nodes"] <= mesh["free_nodes"] and smooth["max_displacement"] > 0

sweeps = smooth["sweeps"]
for sweep in sweeps:
    check(sweep, SWEEP, "sweep")
    assert sweep["phase"] == "smooth" and sweep["objective"] == sweep["rms"]
    assert sweep["inverted"] == sweep["below_min_volume"] == 0
rms = [before["rms_radius_ratio"]] + [sweep["rms"] for sweep in sweeps]
assert all(b <= a * (1 + 1e-12) for a, b in zip(rms, rms[1:])), "F rises: %s" % rms
assert same(rms[-1], after["rms_radius_ratio"])
assert sum(sweep["visits"] for sweep in sweeps) == smooth["node_visits"]
parts = smooth["seconds"]
assert all(s >= 0 for s in parts.values()) and smooth["peak_memory_bytes"] > 0

# A second run says the same, times and places aside.
for report in (smooth, printed):
    for key in ("output", "seconds", "peak_memory_bytes"):
        del report[key]
    for sweep in report["sweeps"]:
        del sweep["seconds"]
assert smooth == printed
