#!/usr/bin/env python3
"""show: the figures of badness.py as a plot and, on standard output, as Markdown.

   show.py IN.csv OUT.svg"""
import csv
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "planish", "svg.fonttype": "none"})
from matplotlib import pyplot  # noqa: E402: after the choice of the backend

SERIES = (("moved", "o", "#2a6f97"), ("1 % pushed", "^", "#6a994e"), ("pushed", "s", "#d7301f"))


def number(value):
    """Few digits, without an exponent where that is short."""
    value = float(value)
    return f"{value:.4g}" if value < 1e5 else f"{value:.1e}".replace("e+", "e")


def print_table(rows):
    print("| start | RMS at the start | worst RR | bad elements % | sweeps to 0.4 % "
          "| visits to 0.4 % | s | all sweeps | visits | evaluations per visit | s | final RMS | final worst RR |")
    print("| --- |" + " --: |" * 12)
    for row in rows:
        visits = int(row["visits"])
        start = f"{row['series']} {row['amount']}".strip()
        print(f"| {start} | {number(row['rms'])} | {number(row['max_rr'])} "
              f"| {100 * int(row['bad']) / int(row['elements']):.2f} | {row['sweeps_near']} "
              f"| {row['visits_near']} | {float(row['seconds_near']):.3f} "
              f"| {row['sweeps']} | {visits} | {int(row['evaluations']) / visits:.2f} | {float(row['seconds']):.3f} "
              f"| {float(row['final_rms']):.5f} | {float(row['final_max_rr']):.2f} |")


def draw(axis, rows, suffix, title):
    """Visits to 0.4 % (hollow) and in all (filled) against the RMS at the start."""
    for name, marker, colour in SERIES:
        mine = [row for row in rows if row["series"] == name]
        start = [float(row["rms"]) for row in mine]
        for key, fill, what in (("", colour, "converged"), ("_near", "white", "to 0.4 %")):
            axis.plot(start, [suffix(row, key) for row in mine], marker=marker, color=colour,
                      markerfacecolor=fill, linewidth=1, label=f"{name}, {what}")
    axis.set_xscale("log")
    axis.set_ylim(bottom=0)
    axis.set_xlabel("RMS of the radius ratios at the start")
    axis.set_title(title)
    axis.grid(True, linewidth=0.3)


def plot(rows, path):
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4.4))
    draw(left, rows, lambda row, key: int(row["visits" + key]) / 1e3, "thousand node visits")
    draw(right, rows, lambda row, key: float(row["seconds" + key]), "seconds of the sweeps")
    figure.legend(*left.get_legend_handles_labels(), loc="lower center", ncol=3, fontsize=8)
    figure.tight_layout(rect=(0, 0.13, 1, 1))
    figure.savefig(path, metadata={"Date": None})


def main():
    source, picture = sys.argv[1:]
    with open(source, encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    print_table(rows)
    plot(rows, picture)


if __name__ == "__main__":
    main()
