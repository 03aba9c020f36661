#!/usr/bin/env python3
"""show: the results of scaling.py as Markdown, and as a plot.   show.py RESULT.json PLOT.svg"""
import sys

import matplotlib
matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

import machine  # noqa: E402
import results  # noqa: E402


def speed_up(row, rows, key):
    """Of a row over the one of one thread, for the same mesh and binding."""
    one = next(r for r in rows if r["threads"] == 1 and r["bound"] == row["bound"]
               and r["elements"] == row["elements"])
    return one[key] / row[key]


def strong_table(rows):
    print("| tetrahedra | threads | --bind | set-up ms | speed-up | in sweeps | ten sweeps ms | speed-up "
          "| efficiency | visits/s |")
    print("| --: | --: | --- | --: | --: | --: | --: | --: | --: | --: |")
    for row in rows:
        gain = speed_up(row, rows, "sweeps_s")
        print(f"| {row['elements']} | {row['threads']} | {'auto' if row['bound'] else 'none'} "
              f"| {row['setup_s'] * 1e3:.1f} | {speed_up(row, rows, 'setup_s'):.2f} "
              f"| {row['setup_s'] / row['sweeps_s'] * row['sweeps']:.1f} | {row['sweeps_s'] * 1e3:.0f} "
              f"| {gain:.2f} | {gain / row['threads']:.0%} | {row['visits_per_s'] / 1e6:.2f} M |")


def weak_table(rows):
    print("| tetrahedra | threads | set-up ms | ten sweeps ms | visits/s per thread | efficiency |")
    print("| --: | --: | --: | --: | --: | --: |")
    for row in rows:
        rate, first = (r["visits_per_s"] / r["threads"] for r in (row, rows[0]))
        print(f"| {row['elements']} | {row['threads']} | {row['setup_s'] * 1e3:.1f} "
              f"| {row['sweeps_s'] * 1e3:.0f} | {rate / 1e6:.2f} M | {rate / first:.0%} |")


def plot(result, path):
    figure, (strong, weak) = pyplot.subplots(1, 2, figsize=(9, 3.6))
    most = max(row["threads"] for row in result["strong"])
    strong.plot([1, most], [1, most], color="0.7", label="ideal")
    for elements in sorted({row["elements"] for row in result["strong"]}):
        rows = [r for r in result["strong"] if r["elements"] == elements and r["bound"]]
        for key, name, style in (("sweeps_s", "sweeps", "o-"), ("setup_s", "set-up", "s--")):
            strong.plot([r["threads"] for r in rows], [speed_up(r, rows, key) for r in rows], style,
                        label=f"{elements / 1e6:.1f} M, {name}")
    strong.set(title="the same mesh", xlabel="threads", ylabel="speed-up")
    rates = [r["visits_per_s"] / r["threads"] / 1e6 for r in result["weak"]]
    weak.plot([r["threads"] for r in result["weak"]], rates, "o-")
    weak.set(title="0.4 M tetrahedra per thread", xlabel="threads", ylim=(0, 1.2 * max(rates)),
             ylabel="million visits per second and thread")
    for axes in (strong, weak):
        axes.set_xticks(sorted({r["threads"] for r in result["strong"]}))
    strong.legend(fontsize="small")
    results.save_plot(figure, (strong, weak), result["machine"], path)


def main():
    result = results.load(sys.argv[1])
    print(machine.line(result["machine"]))
    print("\n#### The same mesh on more threads\n")
    strong_table(result["strong"])
    print("\n#### A larger mesh for more threads\n")
    weak_table(result["weak"])
    plot(result, sys.argv[2])


if __name__ == "__main__":
    main()
