#!/usr/bin/env python3
"""gallery: the pictures of docs/gallery.md, and that document.   gallery.py PLANISH [NAME ...]

With names, these pictures alone."""
import functools
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile

import numpy as np

import histogram
import picture
import planish
import view
from scenes import SCENES

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PICTURES = "docs/pictures"
ANGLES = "angles"
TEMPLATE = """<!-- bench/gallery/run makes this page: change bench/gallery/scenes.py -->
# Gallery

`bench/gallery/run` makes these pictures and measures their figures by the commands shown. Both halves of a picture have
the same view and colours.
"""


class Folder:
    """Where the commands of the gallery run."""

    def __init__(self, path, program):
        self.path, self.program = path, program
        for name in "docs", "bench":
            os.symlink(os.path.join(ROOT, name), os.path.join(path, name))

    def run(self, commands):
        """The JSON of each planish smooth among the commands."""
        reports = []
        environment = {**os.environ, "PATH": os.path.dirname(self.program) + ":" + os.environ["PATH"]}
        for command in commands.split("\n"):
            if command.startswith("planish smooth"):
                command += " -q --json report.json"
            elif command.startswith("gmsh"):
                command += " -v 1 -nt 1"
            print(f"    {command}", flush=True)
            done = subprocess.run(["bash", "-c", command], cwd=self.path, env=environment, check=False)
            if done.returncode != 0:
                sys.exit(f"gallery: exit status {done.returncode}: {command}")
            if command.startswith("planish smooth"):
                with open(os.path.join(self.path, "report.json"), encoding="utf-8") as file:
                    reports.append(json.load(file))
        return reports

    def mesh(self, name, values):
        """A file as planish measures it: values by name, or by a function of the mesh."""
        path, copy = os.path.join(self.path, name), os.path.join(self.path, "view.vtk")
        subprocess.run([self.program, "quality", path, "-q", "-o", copy], check=True)
        mesh = planish.read(copy)
        layout = mesh.layout()
        nodes = np.split(layout.nodes, layout.offsets[1:-1])
        is_inverted = mesh.data("cell_state")[0][:, 0] != 1
        measured = None if callable(values) else mesh.data(values)[0][:, 0]
        found = view.Mesh(mesh.space_points(), layout.types, nodes, measured, is_inverted, planish.read(path).regions)
        return found._replace(values=values(found)) if callable(values) else found


def draw(name, program):
    """Write a picture; returns its section of the document."""
    with tempfile.TemporaryDirectory() as path:
        folder = Folder(path, program)
        return draw_angles(folder) if name == ANGLES else draw_mesh(folder, name)


def draw_mesh(folder, name):
    """The picture of a scene."""
    scene = SCENES[name]
    reports = folder.run(scene.commands)
    texts = scene.titles(reports)
    states = [(text, folder.mesh(file, scene.values)) for text, file in zip(texts, scene.files)]
    write(path_of(name), picture.picture(states, scene.scale, scene.look, scene.box))
    return section(name, scene.heading, texts, scene.caption(reports), scene.commands)


def draw_angles(folder):
    """The picture without a mesh."""
    reports = folder.run(histogram.COMMANDS)
    states = reports[0]["before"], reports[0]["after"], reports[1]["after"]
    texts = [(name, f"smallest angle {state['min_dihedral_deg']:.4g}°")
             for name, state in zip(("as Gmsh leaves it", "planish smooth", "planish smooth --best"), states)]
    panels = [(text, state["angle_histogram"]) for text, state in zip(texts, states)]
    write(path_of("angles"), histogram.picture(panels))
    caption = (f"{reports[0]['mesh']['elements']} triangles are counted by their smallest angles. The default improves "
               "the mean. --best then raises the smallest angle.")
    return section("angles", "The worst element", texts, caption, histogram.COMMANDS)


def path_of(name):
    return f"{PICTURES}/gallery_{name}.svg"


def section(name, heading, texts, caption, commands):
    alternative = "; ".join(f"{text[0]}: {', '.join(text[1:])}" for text in texts)
    lines = "".join(f"    {command}\n" for command in commands.split("\n"))
    return f"\n## {heading}\n\n![{alternative}](pictures/gallery_{name}.svg)\n\n{wrapped(caption)}\n\n{lines}"


def wrapped(text, width=120):
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return "\n".join(lines)


def write(path, text):
    with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
        file.write(text)
    print(f"{path}: {len(text.encode()) // 1000} kB", flush=True)


def main():
    program, *names = sys.argv[1:]
    wanted = names or [*SCENES, ANGLES]
    with multiprocessing.Pool(len(wanted)) as pool:
        sections = pool.map(functools.partial(draw, program=os.path.abspath(program)), wanted, 1)
    if names:
        print("".join(sections))
    else:
        write("docs/gallery.md", TEMPLATE + "".join(sections))


if __name__ == "__main__":
    main()
