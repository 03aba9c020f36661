"""smoothers: planish and its rivals. Each smooths FOLDER/in.msh, that file of a Mesh, and returns
an Outcome; it raises Failed if that goes wrong."""
import json
import os
import re
import resource
import subprocess
from dataclasses import dataclass

import numpy as np

import meshfile


# All that runs on one thread runs on the same core, whether it binds its thread itself or not; the
# last one, since other programs that bind theirs begin with the first.
ON_ONE_CORE = ["taskset", "--cpu-list", str(max(os.sched_getaffinity(0)))]
TURNED = [0, 1, 3, 2]  # Netgen's tetrahedra are oriented the other way round


class Failed(Exception):
    """A smoother that ended with an error or left no mesh."""


@dataclass
class Outcome:
    """seconds: wall time of the optimisation alone; cpu: CPU time of the same, None on several
    threads; report: planish's."""
    points: np.ndarray
    tetrahedra: np.ndarray
    seconds: float
    cpu: float | None
    report: dict | None = None


def execute(command, folder, accepted=(0,)):
    """Standard output of a program that is run in the folder."""
    done = subprocess.run(command, cwd=folder, text=True, check=False, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)
    if done.returncode not in accepted:
        last = (done.stderr.strip() or done.stdout.strip() or "no output").splitlines()[-1]
        raise Failed(f"it ended with {done.returncode}: {last}")
    return done.stdout


def cpu_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def planish(programs, mesh, folder, threads, *options):
    """Status 1: elements are still inverted, the mesh is written. The CPU time of the smoothing is
    not reported: it is taken to have the share in the wall time that the whole run has."""
    where = ON_ONE_CORE if threads == 1 else []
    command = [*where, f"{programs}/planish", "smooth", "in.msh", "-o", "planish.msh", "-q",
               "-j", str(threads), "--json", "-", *options]
    before = cpu_of_children()
    report = json.loads(execute(command, folder, (0, 1)))
    seconds = report["seconds"]["smooth"]
    share = min((cpu_of_children() - before) / report["seconds"]["total"], 1)
    points, tetrahedra = meshfile.read(f"{folder}/planish.msh", mesh)
    return Outcome(points, tetrahedra, seconds, seconds * share if threads == 1 else None, report)


def netgen(programs, mesh, folder, passes):
    """By netgen.cpp."""
    with open(f"{folder}/netgen.in", "wb") as file:
        counts = len(mesh.points), len(mesh.triangles), len(mesh.tetrahedra)
        np.array(counts, np.int64).tofile(file)
        mesh.points.tofile(file)
        (mesh.triangles + 1).astype(np.int32).tofile(file)
        (mesh.tetrahedra[:, TURNED] + 1).astype(np.int32).tofile(file)
    command = [*ON_ONE_CORE, f"{programs}/netgen", "netgen.in", "netgen.out", str(passes)]
    said = execute(command, folder)
    seconds, cpu = map(float, said.split())
    with open(f"{folder}/netgen.out", "rb") as file:
        points = np.fromfile(file, count=mesh.points.size).reshape(-1, 3)
        tetrahedra = np.fromfile(file, np.int32).reshape(-1, 4) - 1
    return Outcome(points, tetrahedra[:, TURNED], seconds, cpu)


def gmsh(_, mesh, folder, times):
    """The only smoother of Gmsh that takes a mesh which it did not just make. Gmsh numbers the
    nodes anew, those of surfaces first."""
    with open(f"{folder}/step.geo", "w", encoding="ascii") as file:
        file.write('Merge "in.msh";\n' + 'OptimizeMesh "Relocate3D";\n' * times)
    command = [*ON_ONE_CORE, "gmsh", "step.geo", "-v", "5", "-nt", "1", "-save",
               "-format", "msh22", "-bin", "-o", "gmsh.msh"]
    log = execute(command, folder)
    changed = meshfile.read(f"{folder}/gmsh.msh", mesh)
    points, tetrahedra = meshfile.by_old_numbers(mesh, *changed)
    steps = re.findall(r"Done optimizing mesh \(Wall (.*)s, CPU (.*)s\)", log)
    if len(steps) != times:
        raise Failed(f"gmsh logged {len(steps)} steps instead of {times}")
    seconds, cpu = (sum(map(float, column)) for column in zip(*steps))
    return Outcome(points, tetrahedra, seconds, cpu)
