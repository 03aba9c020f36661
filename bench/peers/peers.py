#!/usr/bin/env python3
"""peers: planish beside its rivals, mesh by mesh, as Markdown on standard output.

   peers.py PROGRAMS RESULTS.json VERSION-OF-NETGEN [--quick] MESH...

PROGRAMS: the folder of planish and of netgen, the program of netgen.cpp."""
import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import meshfile
import show
import smoothers
from machine import cpu

REPEATS = 5         # of planish
RIVAL_REPEATS = 3   # of rivals
LONG = 10           # seconds: what takes more is not repeated
BUSY = 1.1          # wall time by CPU time: with more, something else was running,
BRIEF = 0.01        # unless it is less than these seconds
MEASURES = ("rms_radius_ratio", "max_radius_ratio", "min_dihedral_deg", "inverted")
RIVALS = (          # name, smoother, how often; --quick: those that are run once
    ("Netgen ImproveMesh, 1 pass", smoothers.netgen, 1),
    ("Netgen ImproveMesh, 3 passes", smoothers.netgen, 3),
    ("Gmsh Relocate3D, once", smoothers.gmsh, 1),
    ("Gmsh Relocate3D, 5 times", smoothers.gmsh, 5),
)


def repeat(times, run):
    """Outcomes of several runs, of one if that is long."""
    outcomes = [run()]
    while outcomes[0].seconds <= LONG and len(outcomes) < times:
        outcomes.append(run())
    return outcomes


def median(outcomes):
    """The one whose seconds are the median."""
    return sorted(outcomes, key=lambda outcome: outcome.seconds)[len(outcomes) // 2]


class Comparison:
    """Of one mesh, in a folder of its own."""

    def __init__(self, programs, mesh, folder):
        self.programs, self.mesh, self.folder = programs, mesh, folder
        meshfile.write(f"{folder}/in.msh", mesh, mesh.points)
        self.rows = [{"method": "the mesh as it is", **self.quality(mesh.points)}]
        self.reports = []  # of planish until it converges, on one thread

    def quality(self, points):
        """What planish says of the mesh with these points."""
        meshfile.write(f"{self.folder}/judged.msh", self.mesh, points)
        said = smoothers.execute([f"{self.programs}/planish", "quality", "judged.msh", "-q",
                                  "--json", "-"], self.folder, (0, 1))
        quality = json.loads(said)["quality"]
        return {key: quality[key] for key in MEASURES}

    def check_kept(self, outcome):
        """Failed if it changed more than the places of free nodes."""
        if not np.array_equal(outcome.tetrahedra, self.mesh.tetrahedra):
            raise smoothers.Failed("the connectivity is not the same")
        moved = (outcome.points != self.mesh.points).any(axis=1)
        n_moved = (moved & self.mesh.is_fixed).sum()
        if n_moved > 0:
            raise smoothers.Failed(f"{n_moved} nodes of the boundary moved")

    def add(self, method, outcomes):
        outcome = median(outcomes)
        self.check_kept(outcome)
        if outcome.cpu and outcome.seconds > BUSY * outcome.cpu + BRIEF:
            print(f"{method}: {outcome.seconds:.3f} s for {outcome.cpu:.3f} s of CPU time: "
                  "is the machine busy?", file=sys.stderr)
        row = {"method": method, "seconds": outcome.seconds, "cpu_seconds": outcome.cpu,
               "repeats": [one.seconds for one in outcomes], **self.quality(outcome.points)}
        self.rows.append(row)
        return row

    def run_planish(self, name, threads, *options):
        outcomes = repeat(REPEATS, lambda: smoothers.planish(
            self.programs, self.mesh, self.folder, threads, *options))
        self.add(f"planish, {name}", outcomes)
        return [outcome.report for outcome in outcomes]

    def run_all_of_planish(self):
        for sweeps in 1, 3, 5:
            name = f"{sweeps} sweep" + "s" * (sweeps > 1)
            self.run_planish(name, 1, "--max-sweeps", str(sweeps))
        self.reports = self.run_planish("converged", 1)
        threads = len(os.sched_getaffinity(0))
        if threads > 1:
            self.run_planish(f"converged, {threads} threads", threads)

    def run_rival(self, name, smoother, times):
        try:
            row = self.add(name, repeat(RIVAL_REPEATS, lambda: smoother(
                self.programs, self.mesh, self.folder, times)))
            row["planish"] = self.overtake(row)
        except smoothers.Failed as reason:
            self.rows.append({"method": name, "failed": str(reason)})

    def overtake(self, row):
        """How long planish takes to be as good as that row; None if it never is."""
        sweeps = sweeps_to(self.reports[0], row)
        if sweeps is None:
            return None
        seconds = statistics.median(seconds_of(report, sweeps) for report in self.reports)
        return {"sweeps": sweeps, "seconds": seconds, "times_faster": row["seconds"] / seconds,
                "times_faster_with_setup": row["seconds"] / (seconds + self.setup_seconds())}

    def setup_seconds(self):
        return statistics.median(report["seconds"]["setup"] for report in self.reports)


def sweeps_to(report, row):
    """After how many sweeps the RMS is that of the row or less, with no more inverted elements."""
    states = [{"rms": report["before"]["rms_radius_ratio"],
               "inverted": report["before"]["inverted"]}, *report["sweeps"]]
    for count, state in enumerate(states):
        if state["rms"] <= row["rms_radius_ratio"] and state["inverted"] <= row["inverted"]:
            return count
    return None


def seconds_of(report, sweeps):
    """Of the first sweeps, and of what the smoothing does before and after them."""
    later = sum(sweep["seconds"] for sweep in report["sweeps"][sweeps:])
    return report["seconds"]["smooth"] - later


def compare(programs, path, quick):
    """The results of a mesh, which it prints."""
    mesh = meshfile.load(path)
    with tempfile.TemporaryDirectory() as folder:
        comparison = Comparison(programs, mesh, folder)
        comparison.run_all_of_planish()
        for name, smoother, times in RIVALS:
            if times == 1 or not quick:
                comparison.run_rival(name, smoother, times)
    counts = comparison.reports[0]["mesh"]
    found = {"mesh": os.path.basename(path),
             **{key: counts[key] for key in ("elements", "nodes", "free_nodes")},
             "setup_seconds": comparison.setup_seconds(), "rows": comparison.rows}
    show.table(found)
    return found


def versions(programs, netgen):
    def said(*command):
        return subprocess.run(command, text=True, check=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT).stdout.strip()
    planish = said(f"{programs}/planish", "--version").split()[1]
    return {"planish": planish, "Netgen": netgen, "Gmsh": said("gmsh", "--version")}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs")
    parser.add_argument("results")
    parser.add_argument("netgen")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("mesh", nargs="+")
    arguments = parser.parse_args()
    programs = os.path.abspath(arguments.programs)
    results = {"date": datetime.date.today().isoformat(), "cpu": cpu(),
               "cores": os.cpu_count(), "versions": versions(programs, arguments.netgen),
               "meshes": []}
    show.machine(results)
    for path in arguments.mesh:
        try:
            results["meshes"].append(compare(programs, path, arguments.quick))
        except (ValueError, OSError, smoothers.Failed) as reason:
            parser.exit(2, f"bench/peers/run: {path}: {reason}\n")
        with open(arguments.results, "w", encoding="ascii") as file:
            json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
