#!/usr/bin/env python3
"""show: the figures of converge.py as a plot and, on standard output, as Markdown.

   show.py IN.csv OUT.svg"""
import csv
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "planish", "svg.fonttype": "none", "font.size": 9})
from matplotlib import pyplot, ticker  # noqa: E402: after the choice of the backend

STYLES = {"as meshed": ("o", "#2a6f97"), "warp": ("s", "#d7301f"), "twist": ("^", "#6a994e"),
          "stretch": ("v", "#8e6c8a"), "left behind": ("D", "#bc6c25")}
OTHER = "left behind"  # its boundary is another one, and so is its least RMS
EXCESS = 1e-3  # of the RMS, that the table tells
TYPES = {"tet": "tetrahedra", "triangle": "triangles", "quad": "quadrilaterals", "hex": "hexahedra",
         "wedge": "wedges"}


def shape(row):
    return row["mesh"].split("_")[0]


def cell_of(row, least):
    """Sweeps, seconds, and by how much the RMS is above the least, where that is worth a word."""
    excess = float(row["rms"]) / least - 1
    above = f" (+{excess:.1%})".replace("%", " %") if excess >= EXCESS and row["error"] != OTHER else ""
    return f"{row['sweeps']}, {float(row['seconds']):.3g} s{above}"


def print_table(rows):
    """A row for each mesh, with a cell for each error."""
    print("| mesh | elements | free nodes | " + " | ".join(STYLES) + " |")
    print("| --- | --: | --: |" + " --: |" * len(STYLES))
    for mesh in dict.fromkeys(row["mesh"] for row in rows):
        of_error = {row["error"]: row for row in rows if row["mesh"] == mesh}
        least = min(float(row["rms"]) for row in of_error.values() if row["error"] != OTHER)
        size = of_error["as meshed"]
        print(f"| {shape(size)}: {TYPES[size['type']]} | {int(size['elements']):,} | {int(size['free']):,} | "
              + " | ".join(cell_of(of_error[error], least) for error in STYLES) + " |")


def plot_type(above, below, rows):
    """Sweeps, and seconds by those as meshed, against the number of elements: a line for each error and
    shape."""
    base = {row["mesh"]: float(row["seconds"]) for row in rows if row["error"] == "as meshed"}
    for error, (marker, colour) in STYLES.items():
        for one in dict.fromkeys(map(shape, rows)):
            mine = [row for row in rows if row["error"] == error and shape(row) == one]
            size = [int(row["elements"]) for row in mine]
            style = {"marker": marker, "color": colour, "markersize": 5, "linewidth": 1.2,
                     "markerfacecolor": colour if len(mine) > 1 else "none"}
            above.plot(size, [int(row["sweeps"]) for row in mine], **style)
            below.plot(size, [float(row["seconds"]) / base[row["mesh"]] for row in mine], **style)


def plot(rows, path):
    """A column for each type of element."""
    types = list(dict.fromkeys(row["type"] for row in rows))
    figure, axes = pyplot.subplots(2, len(types), figsize=(2.3 * len(types), 5.4), sharex=True,
                                   sharey="row", squeeze=False)
    for name, (above, below) in zip(types, axes.T):
        plot_type(above, below, [row for row in rows if row["type"] == name])
        above.set_title(TYPES[name])
        below.set_xlabel("elements")
        for axis in above, below:
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
            axis.yaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
            axis.yaxis.set_minor_locator(ticker.NullLocator())
            axis.grid(True, linewidth=0.3)
    axes[0][0].set_ylabel("sweeps")
    axes[1][0].set_ylabel("seconds, by those as meshed")
    handles = [pyplot.Line2D([], [], marker=marker, color=colour, label=error)
               for error, (marker, colour) in STYLES.items()]
    figure.legend(handles=handles, loc="lower center", ncol=len(STYLES), frameon=False)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, metadata={"Date": None})


def main():
    source, picture = sys.argv[1:]
    with open(source, encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    print_table(rows)
    plot(rows, picture)


if __name__ == "__main__":
    main()
