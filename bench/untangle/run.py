#!/usr/bin/env python3
"""run: smooth the tangled cases by planish; a line of JSON for each, and the tables.

   run.py PLANISH FOLDER [--quick] [--cells] [--only PATTERN]... [--time-limit S]

FOLDER gets results.jsonl, and NAME.vtk of each case that failed (write_case.py makes the known
solution beside it). Patterns are the shell's, of names or of families."""
import argparse
import fnmatch
import hashlib
import json
import os
import subprocess
import sys

import numpy as np

import bases
import cases
import cells
import meshfile
import table

EVERY = 20     # --quick: one case of so many
THREADS = "2"
GRACE = 30     # seconds over the time limit, until the program is ended from outside
TIMED_OUT = 124  # of timeout(1)


class Bench:
    def __init__(self, planish, folder, seconds):
        self.planish, self.folder, self.seconds = planish, folder, seconds
        with open(planish, "rb") as file:
            program = hashlib.sha256(file.read()).hexdigest()[:16]
        self.references = f"{folder}/references-{program}.json"
        self.known = {}
        if os.path.exists(self.references):
            with open(self.references, encoding="ascii") as file:
                self.known = json.load(file)

    def smooth(self, path, out):
        """Exit status and report; no report where there is none."""
        report = f"{out}.json"
        command = ["timeout", str(self.seconds + GRACE), self.planish, "smooth", path, "-o", out,
                   "-q", "-j", THREADS, "--time-limit", str(self.seconds), "--json", report]
        done = subprocess.run(command, stderr=subprocess.DEVNULL, check=False)
        if not os.path.exists(report):
            return done.returncode, None
        with open(report, encoding="utf-8") as file:
            found = json.load(file)
        os.remove(report)
        return done.returncode, found

    def reference(self, case, path):
        """The RMS over the movable elements that smoothing the known solution comes to; None if
        that fails."""
        key = case.name if case.fixed is not None or case.flaws else case.name.rsplit("_", 1)[0]
        if key not in self.known:
            meshfile.write(path, case.valid, case.elements, case.fixed)
            status, report = self.smooth(path, f"{path}.out.vtk")
            if report is None or status not in (0, 1):
                print(f"{case.name}: status {status} on the known solution", file=sys.stderr)
                return None
            self.known[key] = rms_of(report)
            remove(path, f"{path}.out.vtk")
            with open(self.references, "w", encoding="ascii") as file:
                json.dump(self.known, file, indent=0)
        return self.known[key]

    def run(self, name):
        """The line of results of that case."""
        try:
            case = cases.build(name)
        except cases.NoCase as reason:
            return {"name": name, "family": cases.family_of(name), "no_case": str(reason)}
        stem = f"{self.folder}/{name}"
        tangled, valid, out = f"{stem}.vtk", f"{stem}.valid.vtk", f"{stem}.out.vtk"
        remove(out, f"{out}.json")
        meshfile.write(tangled, case.points, case.elements, case.fixed)
        status, report = self.smooth(tangled, out)
        line = {"name": name, "family": case.family, "elements": len(case.elements),
                "inverted_before": cells.n_inverted(case.points, case.elements),
                "status": status, "timed_out": status == TIMED_OUT}
        if report and status in (0, 1):
            line["timed_out"] = report["stop"] == "time-limit"
            line.update(worth(report), reference_rms=self.reference(case, valid))
            line["reference_failed"] = line["reference_rms"] is None
            points = meshfile.read_vtk_points(out, case.points.shape[1])
            line.update(judgement(case, points, report))
        line["passed"] = passed(case, line)
        remove(out)
        if line["passed"]:
            remove(tangled)
        return line


def remove(*paths):
    for path in paths:
        if os.path.exists(path):
            os.remove(path)


def rms_of(report):
    """Of radius ratios; of aspect ratios where there are other elements than simplices."""
    after = report["after"]
    return after["rms_radius_ratio_movable"] or after["rms_aspect_ratio_movable"]


def worth(report):
    untangle = [sweep for sweep in report["sweeps"] if sweep["phase"] == "untangle"]
    return {"inverted": report["after"]["inverted"], "stop": report["stop"],
            "untangle_sweeps": len(untangle), "sweeps": len(report["sweeps"]),
            "seconds": report["seconds"]["smooth"], "unfixable": report["unfixable"],
            "rms": rms_of(report)}


def judgement(case, points, report):
    """What planish says against what numpy finds, and against what was planted. planish numbers
    the elements of VTK files from 0."""
    bad = set(np.flatnonzero(cells.inverted(points, case.elements)).tolist())
    said, planted = set(report["unfixable"]), set().union(*map(set, case.flaws))
    return {"inverted_by_numpy": len(bad), "inverted_elsewhere": len(bad - planted),
            "held_moved": int((points != case.points)[case.held].any(axis=1).sum()),
            "flaws": len(case.flaws),
            "flaws_found": sum(1 for flaw in case.flaws if said & set(flaw)),
            "false_reports": len(said - planted)}


def passed(case, line):
    """A feasible case: nothing inverted and nothing called unfixable; one with flaws: these found,
    no other, and nothing else inverted."""
    if line["status"] != (1 if case.flaws else 0) or "inverted" not in line:
        return False
    return (not line["reference_failed"] and line["held_moved"] == 0
            and line["inverted_elsewhere"] == 0 and (line["inverted"] == 0 or bool(case.flaws))
            and line["flaws_found"] == line["flaws"] and line["false_reports"] == 0)


def matches(name, patterns):
    called = name, cases.family_of(name)
    return any(fnmatch.fnmatchcase(one, pattern) for one in called for pattern in patterns)


def chosen(arguments):
    names = cases.catalogue()
    if arguments.cells:
        names = [name for name in names if name.split("_")[0] in bases.GRIDS]
    if arguments.only:
        names = [name for name in names if matches(name, arguments.only)]
    return names[::EVERY] if arguments.quick else names


def say(line):
    if "no_case" in line:
        what = f"no case: {line['no_case']}"
    elif line["passed"]:
        what = f"passed, {line['untangle_sweeps']} untangle sweeps, {line['seconds']:.2f} s"
    else:
        what = (f"FAILED, status {line['status']}, inverted {line['inverted_before']} -> "
                f"{line.get('inverted', '?')}, false reports {line.get('false_reports', '?')}, "
                f"flaws {line.get('flaws_found', '?')} of {line.get('flaws', '?')}")
    print(f"{line['name']}: {what}", file=sys.stderr, flush=True)


def main():
    parser = argparse.ArgumentParser(prog="run")
    parser.add_argument("planish")
    parser.add_argument("folder")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--cells", action="store_true")
    parser.add_argument("--only", action="append", metavar="PATTERN")
    parser.add_argument("--time-limit", type=int, default=300, metavar="SECONDS")
    arguments = parser.parse_args()
    bench = Bench(arguments.planish, arguments.folder, arguments.time_limit)
    lines = []
    with open(f"{arguments.folder}/results.jsonl", "w", encoding="ascii") as results:
        for name in chosen(arguments):
            lines.append(bench.run(name))
            say(lines[-1])
            results.write(json.dumps(lines[-1]) + "\n")
            results.flush()
    table.show(lines)
    return 0 if all(line.get("passed", True) for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
