#!/usr/bin/env python3
"""experiments: all runs behind docs/paper.md.

    experiments.py BUILD FOLDER     BUILD: where planish and the benchmarks are built; makes meshes,
                                    reports and FOLDER/results.json, which report.py makes tables of

Needs numpy, scipy and, for the mesh of about 700 free nodes, gmsh. Times are those of the smoothing
alone on one thread, the best of several runs.
"""
import json
import os
import subprocess
import sys

from cube import cube_example
from meshes import CUBE, write_examples
from outside import with_node_outside
from simplices import read_mesh, volumes, write_mesh

FRACTION = 1e-3  # delta in volumes of the domain, as in the paper
REPEATS = 5
BOX_FRACTIONS = (3e-5, 7e-5)  # 3.5e-5 is the least of a fixed element: not all meet the second
MODES = ["--objective radius-ratio", "--objective mean-ratio", "--objective edge-ratio"]
RIVALS = ["laplacian", "area-laplacian", "length-laplacian"]
BOX = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1.15};
MeshSize { PointsOf { Volume{1}; } } = 0.094;
"""


class Bench:
    """Runs programs on meshes of one folder and keeps what they report."""

    def __init__(self, build, folder):
        self.build, self.folder = build, folder

    def mesh(self, name):
        return f"{self.folder}/{name}.msh"

    def call(self, *command, ends=(0, 1)):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in ends:
            raise RuntimeError(f"{' '.join(command)}: {done.stdout}{done.stderr}")
        return done.stdout

    def quality(self, name):
        path = f"{self.folder}/quality.json"
        self.call(f"{self.build}/planish", "quality", self.mesh(name), "-q", "--json", path)
        with open(path, encoding="utf-8") as file:
            return json.load(file)["quality"]

    def planish(self, start, end, options, repeats=REPEATS):
        """Smooth start into end; the report, with the best of the times."""
        path, best = f"{self.folder}/{end}.json", None
        for _ in range(repeats):
            self.call(f"{self.build}/planish", "smooth", self.mesh(start), "-o", self.mesh(end),
                      "-j", "1", "-q", "--json", path, *options.split())
            with open(path, encoding="utf-8") as file:
                report = json.load(file)
            if best is None or report["seconds"]["smooth"] < best["seconds"]["smooth"]:
                best = report
        return self.summary_of_planish(best)

    @staticmethod
    def summary_of_planish(report):
        objective = report["objective"]
        return {"before": measures(report["before"]), "after": measures(report["after"]),
                "objective": objective, "sweeps": len(report["sweeps"]), "stop": report["stop"],
                "evaluations": report["evaluations"], "visits": report["node_visits"],
                "free": report["mesh"]["free_nodes"], "kkt": report["kkt"],
                "seconds": report["seconds"]["smooth"],
                "history": [objective["before"]] + [s["objective"] for s in report["sweeps"]],
                "restoring": sum(s["phase"] == "untangle" for s in report["sweeps"])}

    def global_(self, start, end, options, repeats=REPEATS):
        """The same by IPOPT, in all coordinates at once."""
        best = None
        for _ in range(repeats):
            out = self.call(f"{self.build}/bench/paper_global", self.mesh(start), self.mesh(end),
                            *options.split())
            report = json.loads(out)
            if best is None or report["cpu_seconds"] < best["cpu_seconds"]:
                best = report
        best["after"] = measures(self.quality(end))
        best["seconds"] = best.pop("cpu_seconds")
        with open(f"{self.folder}/{end}.json", "w", encoding="utf-8") as file:
            json.dump(best, file, indent=1)
        return best

    def check_derivatives(self, name, *options):
        """IPOPT's own check against differences; they take long where there are constraints."""
        out = self.call(f"{self.build}/bench/paper_global", self.mesh(name), self.mesh("scratch"),
                        "--derivative-test", "--max-iterations", "0", *options)
        if "No errors detected by derivative checker" not in out:
            raise RuntimeError(f"IPOPT finds the derivatives wrong on {name}:\n{out}")


def measures(quality):
    """What the tables show of a mesh; volumes in units of the domain's."""
    return {"rms": quality["rms_radius_ratio"], "max": quality["max_radius_ratio"],
            "min_volume": quality["min_volume"] / quality["total_volume"],
            "inverted": quality["inverted"], "below": quality["below_min_volume"]}


def with_delta(weight=0.0):
    return f"--min-volume-fraction {FRACTION}" + (f" --area-weight {weight}" if weight else "")


# ---- the experiments -----------------------------------------------------------------------------

def every_method(bench, name):
    """Objectives, directions and rivals on one example from its initial mesh."""
    rows = []
    for mode in MODES:
        for weight in (0, 0.5):
            label = mode.split()[1] + (f", μ₂ = {weight}" if weight else "")
            rows.append((f"planish, {label}",
                         bench.planish(name, f"{name}.{label.split(',')[0]}{weight}",
                                       f"{mode} {with_delta(weight)}")))
    rows.append(("planish, radius-ratio, Fletcher-Reeves",
                 bench.planish(name, f"{name}.fletcher-reeves",
                               f"--direction fletcher-reeves {with_delta()}")))
    for method in RIVALS:
        rows.append((method, bench.planish(name, f"{name}.{method}",
                                           f"--method {method} {with_delta()}")))
    return rows


def starts(bench, name):
    """The example from its initial mesh, from the Laplacian's and with a node outside."""
    points, elements = read_mesh(bench.mesh(f"{name}.laplacian"))
    valid = volumes(points, elements).min() > 0
    if not valid:
        points, elements = read_mesh(bench.mesh(name))
    write_mesh(bench.mesh(f"{name}.outside"), with_node_outside(points, elements), elements)
    rows = []
    for start, label in ((name, "initial mesh"), (f"{name}.laplacian", "Laplacian's result"),
                         (f"{name}.outside", "node outside, " + ("Laplacian's" if valid
                                                                 else "initial") + " mesh")):
        for weight in (0, 0.5):
            rows.append((label, weight,
                         bench.planish(start, f"{start}.start{weight}", with_delta(weight))))
    return rows


def local_and_global(bench, name, fraction, repeats=REPEATS):
    """planish by default and to the last digits, and IPOPT, from the same start; planish once more
    from IPOPT's result."""
    option = f"--min-volume-fraction {fraction}" if fraction else ""
    tight = option + " --tolerance 1e-10 --max-sweeps 5000"
    result = {"name": name, "fraction": fraction,
              "local": bench.planish(name, f"{name}.local", option),
              "tight": bench.planish(name, f"{name}.tight", tight, repeats=1),
              "global": bench.global_(name, f"{name}.global", option, repeats)}
    result["again"] = bench.planish(f"{name}.global", f"{name}.again", tight, repeats=1)
    return result


def weighted(bench, name):
    return {"name": name, "local": bench.planish(name, f"{name}.local", with_delta(0.5)),
            "global": bench.global_(name, f"{name}.global", with_delta(0.5))}


def other_connectivities(bench):
    """The cube in a cube with other random flips: is the example special?"""
    rows = []
    for flips, seed in ((0, 1), (4, 1), (4, 3), (8, 1), (8, 6), (12, 1), (12, 4), (12, 6), (12, 8)):
        name = f"cube_{flips}_{seed}"
        points, elements, _ = cube_example(**{**CUBE, "seed": seed, "flips": flips})
        write_mesh(bench.mesh(name), points, elements)
        rows.append({"flips": flips, "seed": seed,
                     "local": bench.planish(name, f"{name}.local", with_delta(), repeats=1),
                     "global": bench.global_(name, f"{name}.global", with_delta(), repeats=1),
                     "laplacian": bench.planish(name, f"{name}.laplacian",
                                                "--method laplacian", repeats=1)["after"]})
    return rows


def make_box(bench):
    """A box of about 700 free nodes by Gmsh, spoiled."""
    with open(f"{bench.folder}/box.geo", "w", encoding="ascii") as file:
        file.write(BOX)
    bench.call("gmsh", "-3", "-v", "1", f"{bench.folder}/box.geo", "-format", "msh22",
               "-o", bench.mesh("box_good"), ends=(0,))
    bench.call(f"{bench.build}/bench/spoil", bench.mesh("box_good"), bench.mesh("box"), "0.3",
               ends=(0,))


def run(bench):
    write_examples(bench.folder)
    examples = ("square", "holes", "cube")
    bench.check_derivatives("square", *with_delta().split())
    bench.check_derivatives("cube_feasible")
    make_box(bench)
    return {
        "examples": {name: measures(bench.quality(name)) for name in (*examples, "cube_feasible")},
        "methods": {name: every_method(bench, name) for name in examples},
        "starts": {name: starts(bench, name) for name in ("holes", "cube")},
        "references": [local_and_global(bench, name, f) for name in examples for f in (0, FRACTION)]
                      + [local_and_global(bench, "box", f, 1) for f in (0, *BOX_FRACTIONS)],
        "weighted": [weighted(bench, name) for name in examples],
        "connectivities": other_connectivities(bench),
    }


def main():
    build, folder = sys.argv[1:]
    os.makedirs(folder, exist_ok=True)
    results = run(Bench(build, folder))
    with open(f"{folder}/results.json", "w", encoding="utf-8") as file:
        json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
