"""program: planish smooth on points and elements in memory."""
import json
import os
import subprocess

import meshfile


class Program:
    """The program, and a folder for its files."""

    def __init__(self, planish, folder):
        self.planish, self.folder = planish, folder

    def smooth(self, points, elements, like=None, options=()):
        """The points that planish makes of points, and its JSON. like: the points of --like."""
        source, target, out, report = (f"{self.folder}/{name}" for name in
                                       ("in.vtk", "like.vtk", "out.vtk", "out.json"))
        meshfile.write_vtk(source, points, elements)
        command = [self.planish, "smooth", source, "-o", out, "-q", "--json", report, *options]
        if like is not None:
            meshfile.write_vtk(target, like, elements)
            command += ["--like", target]
        done = subprocess.run(command, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(f"targets: {' '.join(command)} ended with {done.returncode}")
        with open(report, encoding="utf-8") as file:
            found = json.load(file)
        smoothed = meshfile.read_vtk_points(out, points.shape[1])
        for path in (source, out, report):
            os.remove(path)
        return smoothed, found
