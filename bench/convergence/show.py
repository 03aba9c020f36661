#!/usr/bin/env python3
"""show: the figures of converge.py as a plot and, on standard output, as Markdown.

   show.py IN.csv OUT.svg"""
import csv
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "planish", "svg.fonttype": "none"})
from matplotlib import pyplot  # noqa: E402: after the choice of the backend

STYLES = {"as meshed": ("o", "#2a6f97"), "warp": ("s", "#d7301f"), "twist": ("^", "#6a994e"),
          "stretch": ("v", "#8e6c8a"), "left behind": ("D", "#bc6c25")}


def print_table(rows):
    """A row for each mesh: sweeps and seconds for each error."""
    print("| tetrahedra | free nodes | " + " | ".join(STYLES) + " |")
    print("| --: | --: |" + " --: |" * len(STYLES))
    for mesh in dict.fromkeys(row["mesh"] for row in rows):
        of_error = {row["error"]: row for row in rows if row["mesh"] == mesh}
        cells = [f"{row['sweeps']}, {float(row['seconds']):.3g} s"
                 for row in (of_error[error] for error in STYLES)]
        size = of_error["as meshed"]
        print(f"| {int(size['elements']):,} | {int(size['free']):,} | " + " | ".join(cells) + " |")


def plot(rows, path):
    """Sweeps, and seconds by those as meshed, against the number of tetrahedra."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4.2))
    base = {row["mesh"]: float(row["seconds"]) for row in rows if row["error"] == "as meshed"}
    for error, (marker, colour) in STYLES.items():
        mine = [row for row in rows if row["error"] == error]
        size = [int(row["elements"]) for row in mine]
        left.plot(size, [int(row["sweeps"]) for row in mine], marker=marker, color=colour, label=error)
        right.plot(size, [float(row["seconds"]) / base[row["mesh"]] for row in mine], marker=marker,
                   color=colour, label=error)
    for axis, title in ((left, "sweeps"), (right, "seconds, by those of the mesh as meshed")):
        axis.set_xscale("log")
        axis.set_ylim(bottom=0)
        axis.set_xlabel("tetrahedra")
        axis.set_title(title)
        axis.grid(True, linewidth=0.3)
    left.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main():
    source, picture = sys.argv[1:]
    with open(source, encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    print_table(rows)
    plot(rows, picture)


if __name__ == "__main__":
    main()
