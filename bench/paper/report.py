#!/usr/bin/env python3
"""report: what experiments.py found, as tables in docs/paper.md and as pictures.

    report.py FOLDER DOCS     reads FOLDER/results.json; replaces what is between the markers of
                              DOCS/paper.md, writes FOLDER/convergence-*.csv and the pictures of
                              DOCS/pictures

Needs matplotlib. The same results give the same bytes.
"""
import csv
import json
import os
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend first)
from simplices import read_mesh  # noqa: E402

BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"
TITLES = {"square": "square", "holes": "square with holes", "cube": "cube in cube",
          "box": "box"}
PAPER = {  # Table 1 and the text of the paper
    "square": {"variables": 98, "constraints": 124, "seconds": "4.0"},
    "holes": {"variables": 90, "constraints": 160, "seconds": "13.4",
              "before": "22.489", "after": "2.7103"},
    "cube": {"variables": 114, "constraints": 580, "seconds": "1902", "before": "18.22",
             "after": "4.88", "volume": "0.0003 → 0.1"},
}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |",
             "| --- |" + " --: |" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def percent(value):
    return f"{100 * value:.4f}"


def f_of(run):
    return run["objective"]["after"]


def milliseconds(run):
    return f"{1e3 * run['seconds']:.2f}"


# ---- tables -----------------------------------------------------------------------------------

def paper_table(results):
    rows = []
    for name, paper in PAPER.items():
        mesh = results["examples"][name]
        run = dict(results["methods"][name])["planish, radius-ratio"]
        whole = dict((r["name"], r["global"]) for r in results["references"] if r["fraction"])[name]
        rows.append([f"{TITLES[name]}, paper", paper["variables"], paper["constraints"],
                     paper.get("before", ""), paper.get("after", ""), paper.get("volume", ""),
                     paper["seconds"] + " s"])
        for label, r in (("planish", run), ("all at once", whole)):
            rows.append([f"{TITLES[name]}, {label}", paper["variables"], paper["constraints"],
                         f"{mesh['max']:.3f}", f"{r['after']['max']:.4f}",
                         f"{percent(mesh['min_volume'])} → {percent(r['after']['min_volume'])}",
                         milliseconds(r) + " ms"])
    return table(["example", "variables", "elements", "max RR before", "after",
                  "smallest volume, % of the domain", "CPU time"], rows)


def methods_table(results, name):
    mesh = results["methods"][name][0][1]["before"]
    rows = [["the initial mesh", "", f"{mesh['rms']:.4f}", f"{mesh['max']:.3f}",
             percent(mesh["min_volume"]), mesh["inverted"], mesh["below"], "", "", ""]]
    for label, run in results["methods"][name] + reference_rows(results, name):
        after = run["after"]
        rows.append([label, f"{run['objective']['before']:.4f} → {f_of(run):.4f}",
                     f"{after['rms']:.4f}", f"{after['max']:.3f}", percent(after["min_volume"]),
                     after["inverted"], after["below"], run.get("sweeps", run.get("iterations")),
                     evaluations(run), milliseconds(run)])
    return table(["method", "its F", "RMS of RR", "max RR", "smallest volume, %", "inverted",
                  "below δ", "sweeps", "evaluations", "ms"], rows)


def reference_rows(results, name):
    plain = next(r for r in results["references"] if r["name"] == name and r["fraction"])
    weighted = next(r for r in results["weighted"] if r["name"] == name)
    return [("all at once (IPOPT)", plain["global"]),
            ("all at once (IPOPT), μ₂ = 0.5", weighted["global"])]


def evaluations(run):
    """Of stars, or, by IPOPT, of the mesh: values + gradients + Hessians."""
    count = run["evaluations"]
    if isinstance(count, dict):
        return f"{count['values']} + {count['gradients']} + {count['hessians']} meshes"
    return f"{count} stars"


def starts_table(results):
    rows = []
    for name in ("holes", "cube"):
        for start, weight, run in results["starts"][name]:
            after = run["after"]
            rows.append([f"{TITLES[name]}, {start}", weight, run["before"]["inverted"],
                         f"{run['before']['max']:.3f}", f"{f_of(run):.5f}", f"{after['max']:.4f}",
                         percent(after["min_volume"]), after["inverted"] + after["below"],
                         run["sweeps"]])
    return table(["start", "μ₂", "inverted at first", "max RR at first", "F", "max RR",
                  "smallest volume, %", "bad at last", "sweeps"], rows)


def reference_table(results):
    rows = []
    for r in results["references"] + results["weighted"]:
        local, whole = r["local"], r["global"]
        label = TITLES[r["name"]] + ("" if "fraction" in r else ", μ₂ = 0.5")
        fraction = r.get("fraction", 1e-3)
        rows.append([label, whole["variables"], f"{100 * fraction:.4g}" if fraction else "none",
                     f"{f_of(local):.5f}", f"{f_of(r['tight']):.5f}" if "tight" in r else "",
                     f"{f_of(whole):.5f}", f"{100 * (f_of(local) / f_of(whole) - 1):+.3f}",
                     f"{f_of(r['again']):.5f}" if "again" in r else "",
                     f"{local['after']['max']:.3f}", f"{whole['after']['max']:.3f}",
                     milliseconds(local), f"{1e3 * whole['seconds']:.1f}",
                     f"{whole['seconds'] / local['seconds']:.0f}"])
    return table(["mesh", "variables", "δ, %", "F planish", "tolerance 1e-10", "F all at once",
                  "difference, %", "planish from there", "max RR planish", "all at once",
                  "ms planish", "ms all at once", "times faster"], rows)


def connectivity_table(results):
    rows = [[f"{r['flips']} flips, seed {r['seed']}", f"{f_of(r['local']):.4f}",
             f"{f_of(r['global']):.4f}",
             f"{100 * (f_of(r['local']) / f_of(r['global']) - 1):+.2f}",
             f"{r['local']['after']['max']:.3f}", f"{r['global']['after']['max']:.3f}",
             r["local"]["after"]["below"], r["laplacian"]["inverted"]]
            for r in results["connectivities"]]
    return table(["cube in cube", "F planish", "F all at once", "difference, %", "max RR planish",
                  "all at once", "below δ, planish", "inverted by the Laplacian"], rows)


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        model = next((line.split(":", 1)[1].strip() for line in info
                      if line.startswith("model name")), "unknown")
    return f"{model}, {os.cpu_count()} cores; one thread."


def all_tables(results):
    parts = [f"Machine: {machine()}\n", "### Beside the paper\n", paper_table(results)]
    for name in PAPER:
        parts += [f"### Every method: {TITLES[name]}\n", methods_table(results, name)]
    parts += ["### From three starts\n", starts_table(results),
              "### Node by node and all at once\n", reference_table(results),
              "### Other connectivities of the cube in a cube\n", connectivity_table(results)]
    return "\n".join(parts)


def replace_tables(path, text):
    with open(path, encoding="utf-8") as file:
        old = file.read()
    before, rest = old.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"{before}{BEGIN}\n{text}\n{END}{after}")


# ---- pictures -----------------------------------------------------------------------------------

def histories(results, name):
    methods = dict(results["methods"][name])
    reference = next(r for r in results["references"] if r["name"] == name and r["fraction"])
    return [("planish, Newton", methods["planish, radius-ratio"]["history"]),
            ("planish, Fletcher-Reeves",
             methods["planish, radius-ratio, Fletcher-Reeves"]["history"]),
            ("all at once (IPOPT)", reference["global"]["history"])]


def write_histories(results, folder):
    for name in PAPER:
        with open(f"{folder}/convergence-{name}.csv", "w", encoding="ascii", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["method", "iteration", "F"])
            for label, values in histories(results, name):
                writer.writerows([label, i, repr(value)] for i, value in enumerate(values))


def save(figure, path):
    figure.savefig(path, format="svg", metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


def draw_histories(results, path):
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    for axis, name, letter in zip(axes, PAPER, "abc"):
        for (label, values), style in zip(histories(results, name), ("-o", "--s", ":^")):
            axis.plot(range(len(values)), values, style, markersize=3, linewidth=1, label=label)
        axis.set_title(f"({letter}) {TITLES[name]}")
        axis.set_xlabel("sweep, or iteration")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("F")
    axes[0].legend()
    save(figure, path)


def draw_meshes(folder, path):
    panels = [("initial", "holes"), ("planish", "holes.radius-ratio0"),
              ("Laplacian", "holes.laplacian"), ("a node outside", "holes.outside"),
              ("planish, from there", "holes.outside.start0")]
    figure, axes = plt.subplots(1, len(panels), figsize=(15, 3.3), layout="constrained")
    for axis, (title, name) in zip(axes, panels):
        points, triangles = read_mesh(f"{folder}/{name}.msh")
        axis.triplot(points[:, 0], points[:, 1], triangles, linewidth=0.6, color="#33475b")
        axis.set_title(title)
        axis.set_aspect("equal")
        axis.axis("off")
    save(figure, path)


def main():
    folder, docs = sys.argv[1:]
    with open(f"{folder}/results.json", encoding="utf-8") as file:
        results = json.load(file)
    plt.rcParams.update({"svg.hashsalt": "planish", "font.size": 9})
    write_histories(results, folder)
    draw_histories(results, f"{docs}/pictures/paper_convergence.svg")
    draw_meshes(folder, f"{docs}/pictures/paper_holes.svg")
    replace_tables(f"{docs}/paper.md", all_tables(results))


if __name__ == "__main__":
    main()
