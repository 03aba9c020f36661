#!/usr/bin/env python3
"""show: the table of docs/examples/swing.c as a plot.   show.py SWING.csv PLOT.svg"""
import csv
import sys

import matplotlib
matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    swings = [row["swings"] for row in rows]
    matplotlib.rcParams.update({"svg.hashsalt": "planish", "font.size": 9})
    figure, (turned, quality) = pyplot.subplots(2, 1, sharex=True, figsize=(7, 4.2),
                                                height_ratios=(1, 2))
    turned.bar(swings, [row["turned_over"] for row in rows], width=0.014, color="0.6",
               label="turned over by the step")
    turned.plot(swings, [row["left"] for row in rows], color="tab:red", label="left by planish")
    turned.set_ylabel("elements")
    turned.set_ylim(0, 150)
    turned.legend(fontsize=8, loc="upper right", ncols=2)
    quality.plot(swings, [row["worst"] for row in rows], label="worst radius ratio after the step")
    quality.plot(swings, [row["rms"] for row in rows], label="RMS of radius ratios")
    quality.set_yscale("log")
    quality.set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    quality.minorticks_off()
    quality.set_ylim(1, 30)
    quality.set_xlabel("swings of the cylinder")
    quality.grid(alpha=0.3)
    quality.legend(fontsize=8, loc="upper right")
    figure.tight_layout()
    figure.savefig(sys.argv[2], metadata={"Date": None})


if __name__ == "__main__":
    main()
