#!/usr/bin/env python3
"""table: the results of bench/run as Markdown.   table.py RESULTS-FOLDER"""
import glob
import os
import sys

import machine
from results import load

# Operations on packs of four doubles in a visit of a star of 27 tetrahedra that has kept its Hessian,
# counted from the formulas (docs/performance.md, "What a visit is made of").
ARITHMETIC, DIVISIONS, ROOTS = 1800, 31, 27


def sweeps(folder, names):
    print("| mesh | tetrahedra | threads | set-up ms | in early sweeps | in sweeps | sweeps to 0.4 % | ms | "
          "all sweeps | ms | visits/s | RMS | library B per tetrahedron |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |")
    for name in names:
        report = load(f"{folder}/{name}.smooth.json")
        for run in report["runs"]:
            print(f"| {name} | {report['elements']} | {run['threads']} | {run['setup_s'] * 1e3:.1f} "
                  f"| {run['setup_in_early_sweeps']:.1f} | {run['setup_in_sweeps']:.1f} | {run['sweeps_to_target']} "
                  f"| {run['to_target_s'] * 1e3:.1f} | {run['sweeps']} | {run['sweeps_s'] * 1e3:.0f} "
                  f"| {run['visits_per_s'] / 1e6:.2f} M | {run['rms']:.4f} "
                  f"| {run['bytes_per_element']:.0f} |")


def kernels(folder, name):
    print("| problem | kernel | value ns | derivatives ns | first visit ns | sixth visit ns |")
    print("| --- | --- | --: | --: | --: | --: |")
    for run in load(f"{folder}/{name}.kernel.json")["ns_per_star"]:
        print(f"| {run['problem']} | {run['isa']} | {run['value']:.0f} | {run['derivatives']:.0f} "
              f"| {run['visit']:.0f} | {run['later']:.0f} |")


def peak(folder, name):
    found = load(f"{folder}/machine.json")
    rate, clock = found["packs_per_cycle"], found["ghz"]
    print("| packs of four doubles per cycle | additions | multiplications | both in turn | divisions "
          "| square roots | GHz | memory GB/s, 1 to all threads |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: |")
    print("| one core | " + " | ".join(f"{rate[key]:.2f}" for key in
                                        ("addition", "multiplication", "both", "division", "root"))
          + f" | {clock:.2f} | {', '.join(f'{one:.0f}' for one in found['memory_gb_per_s'])} |")
    arithmetic = ARITHMETIC / rate["both"] / clock
    divider = (DIVISIONS / rate["division"] + ROOTS / rate["root"]) / clock
    visit = min(run["later"] for run in load(f"{folder}/{name}.kernel.json")["ns_per_star"]
                if run["problem"] == "plain")
    print(f"\nA visit by a Hessian that was kept needs {arithmetic:.0f} ns for its additions and "
          f"multiplications at that rate, and {divider:.0f} ns of the divider at the same time; it takes {visit:.0f} ns: "
          f"{arithmetic / visit:.0%} of the peak.")
    if "line_round_trip_ns" in found:
        print(f"\nA line of the cache takes {found['line_round_trip_ns']} ns from one core to the other and back.")


def main():
    folder = sys.argv[1]
    names = sorted(os.path.basename(path)[:-len(".smooth.json")]
                   for path in glob.glob(f"{folder}/*.smooth.json"))
    print(machine.line(machine.description()))
    print("\n#### Set-up and sweeps\n")
    sweeps(folder, names)
    print(f"\n#### Kernels: nanoseconds per star of {names[0]}, one thread\n")
    kernels(folder, names[0])
    print("\n#### What the machine could do\n")
    peak(folder, names[0])


if __name__ == "__main__":
    main()
