#!/usr/bin/env python3
"""table: the results of bench/run as Markdown.   table.py RESULTS-FOLDER"""
import glob
import json
import os
import platform
import sys


def load(path):
    with open(path) as file:
        return json.load(file)


def cpu():
    try:
        with open("/proc/cpuinfo") as info:
            return next(line.split(":", 1)[1].strip() for line in info if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def sweeps(folder, names):
    print("| mesh | tetrahedra | threads | set-up ms | in sweeps | sweeps to 0.4 % | ms | "
          "all sweeps | ms | visits/s | RMS |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |")
    for name in names:
        report = load(f"{folder}/{name}.smooth.json")
        for run in report["runs"]:
            print(f"| {name} | {report['elements']} | {run['threads']} | {run['setup_s'] * 1e3:.1f} "
                  f"| {run['setup_in_sweeps']:.1f} | {run['sweeps_to_target']} "
                  f"| {run['to_target_s'] * 1e3:.1f} | {run['sweeps']} | {run['sweeps_s'] * 1e3:.0f} "
                  f"| {run['visits_per_s'] / 1e6:.2f} M | {run['rms']:.4f} |")


def kernels(folder, names):
    print("| mesh | problem | kernel | value ns | derivatives ns | visit ns |")
    print("| --- | --- | --- | --: | --: | --: |")
    for name in names:
        for run in load(f"{folder}/{name}.kernel.json")["ns_per_star"]:
            print(f"| {name} | {run['problem']} | {run['isa']} | {run['value']:.0f} | {run['derivatives']:.0f} "
                  f"| {run['visit']:.0f} |")


def whole(folder, names):
    print("| mesh | threads | worst RR | smallest angle | RMS | read s | set-up s | smooth s "
          "| write s | total s | peak MB | B per tet |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |")
    for name in names:
        for path in sorted(glob.glob(f"{folder}/{glob.escape(name)}.whole-*.json")):
            report = load(path)
            before, after, time = report["before"], report["after"], report["seconds"]
            change = " | ".join(f"{before[key]:.4g} → {after[key]:.4g}" for key in
                                ("max_radius_ratio", "min_dihedral_deg", "rms_radius_ratio"))
            phases = " | ".join(f"{time[key]:.3f}" for key in
                                ("read", "setup", "smooth", "write", "total"))
            peak = report["peak_memory_bytes"]
            print(f"| {name} | {report['threads']} | {change} | {phases} | {peak / 1e6:.0f} "
                  f"| {peak / report['mesh']['elements']:.0f} |")


def main():
    folder = sys.argv[1]
    names = sorted(os.path.basename(path)[:-len(".smooth.json")]
                   for path in glob.glob(f"{folder}/*.smooth.json"))
    print(f"Machine: {cpu()}, {os.cpu_count()} CPUs\n")
    print("Set-up and sweeps\n")
    sweeps(folder, names)
    print("\nKernels, one thread, nanoseconds per star\n")
    kernels(folder, names)
    print("\nFrom file to file\n")
    whole(folder, names)


if __name__ == "__main__":
    main()
