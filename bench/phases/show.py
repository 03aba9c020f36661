#!/usr/bin/env python3
"""show: the results of phases.py as Markdown, and as a plot.   show.py RESULT.json PLOT.svg"""
import sys

import matplotlib
matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

import machine  # noqa: E402
import results  # noqa: E402

PHASES = ("read", "setup", "shape", "smooth", "write")


def growth_table(rows):
    print("| tetrahedra | threads | read s | set-up s | shape s | smooth s | write s | total s | share % "
          "| sweeps | us per visit | total in sweeps' time | us per tetrahedron | us per free node "
          "| peak B per tetrahedron |")
    print("| --: | --: | --: | --: | --: | --: | --: | --: | --- | --: | --: | --: | --: | --: | --: |")
    for row in rows:
        time = row["seconds"]
        shares = ", ".join(f"{time[phase] / time['total'] * 100:.0f}" for phase in PHASES)
        print(f"| {row['elements']} | {row['threads']} | "
              + " | ".join(f"{time[phase]:.3f}" for phase in (*PHASES, "total"))
              + f" | {shares} | {row['sweeps']} "
              f"| {row['sweeps_s'] / row['visits'] * 1e6:.2f} | {time['total'] / row['sweeps_s']:.2f} "
              f"| {time['total'] / row['elements'] * 1e6:.2f} "
              f"| {time['total'] / row['free_nodes'] * 1e6:.2f} | {row['peak_bytes'] / row['elements']:.0f} |")


def range_of(seconds):
    """From .. to, of a few times."""
    return f"{min(seconds):.1f} to {max(seconds):.1f} s"


def memory_and_disk(touched, copied):
    """What fresh memory costs here, and the largest file, in two sentences."""
    slowest = max(touched, key=lambda each: each["seconds"])
    print(f"\nTouching {slowest['bytes'] / 1e9:.1f} GB of memory, before a run, took up to "
          f"{slowest['seconds']:.1f} s.", end=" ")
    largest = max(each["bytes"] for each in copied)
    times = [each["seconds"] for each in copied if each["bytes"] == largest]
    print(f"A plain copy of the largest file, after a run, took {range_of(times)}.")


def count_of(threads):
    return f"{threads} thread" + "s" * (threads > 1)


def plot(result, path):
    """Time and memory per tetrahedron against size. Sweeps differ in number: time is that of ten."""
    figure, (time, memory) = pyplot.subplots(1, 2, figsize=(9, 3.6))
    for threads, style in zip(sorted({row["threads"] for row in result["growth"]}), ("o-", "o--")):
        rows = [row for row in result["growth"] if row["threads"] == threads]
        sizes = [row["elements"] for row in rows]
        time.set_prop_cycle(None)  # the same colours again
        for name, seconds in (
                ("ten sweeps", lambda row: row["sweeps_s"] / row["sweeps"] * 10),
                ("set-up", lambda row: row["seconds"]["setup"]),
                ("read and write", lambda row: row["seconds"]["read"] + row["seconds"]["write"])):
            time.plot(sizes, [seconds(row) / row["elements"] * 1e6 for row in rows], style,
                      label=f"{name}, {count_of(threads)}")
        memory.plot(sizes, [row["peak_bytes"] / row["elements"] for row in rows], style,
                    label=count_of(threads))
    time.set(title="time", ylabel="us per tetrahedron")
    memory.set(title="peak memory of the program", ylabel="bytes per tetrahedron")
    for axes in (time, memory):
        axes.set(xlabel="tetrahedra", xscale="log", ylim=(0, 1.4 * axes.get_ylim()[1]))
        axes.legend(fontsize="x-small", ncol=2, loc="upper center")
    results.save_plot(figure, (time, memory), result["machine"], path)


def main():
    result = results.load(sys.argv[1])
    print(machine.line(result["machine"]))
    print("\n#### Sizes: binary MSH 4.1, until converged\n")
    growth_table(result["growth"])
    memory_and_disk(result["touched"], result["copied"])
    plot(result, sys.argv[2])


if __name__ == "__main__":
    main()
