#!/usr/bin/env python3
"""converge: smooth meshes, displace what comes out by smooth fields, and smooth again.

   converge.py PROGRAMS OUT.csv MESH.mesh ...     meshes of tetrahedra, as Gmsh writes Medit's format

Write a row for each mesh and error: the number of sweeps, on one thread. All meshes are displaced
before the first one is timed. The errors are 95 % of what keeps the mesh valid:
  warp, twist, stretch    the interior moves by the solution of a graph Laplace equation times a
                          constant, a rotation, a stretching; the boundary stays
  left behind             the boundary is sheared, and the interior stays
"""
import csv
import json
import pathlib
import subprocess
import sys

import numpy
from scipy import sparse
from scipy.sparse import linalg

PART = 0.95  # of the largest amplitude
HALVINGS = 40
REPEATS = 3
START = "as meshed"
KINDS = ("warp", "twist", "stretch", "left behind")


class Mesh:
    """A Medit file: its lines, coordinates, tetrahedra, and which nodes are inside."""

    def __init__(self, path):
        self.lines = path.read_text(encoding="ascii").split("\n")
        heads = [line.strip() for line in self.lines]
        self.first = heads.index("Vertices") + 2
        vertices = self.rows(self.first - 1, 4)
        self.x, self.tags = vertices[:, :3], vertices[:, 3].astype(int)
        self.cells = self.rows(heads.index("Tetrahedra") + 1, 5)[:, :4].astype(int) - 1
        faces = numpy.sort(numpy.concatenate([numpy.delete(self.cells, j, 1) for j in range(4)]))
        unique, times = numpy.unique(faces, axis=0, return_counts=True)
        self.inside = numpy.zeros(len(self.x), bool)
        self.inside[self.cells.ravel()] = True
        self.used = self.inside.copy()
        self.inside[unique[times == 1].ravel()] = False

    def rows(self, count_at, width):
        count = int(self.lines[count_at])
        text = " ".join(self.lines[count_at + 1:count_at + 1 + count])
        return numpy.array(text.split(), float).reshape(count, width)

    def volumes(self, x):
        edges = x[self.cells[:, 1:]] - x[self.cells[:, :1]]
        return numpy.einsum("ij,ij->i", numpy.cross(edges[:, 0], edges[:, 1]), edges[:, 2])

    def write(self, x, path):
        lines = self.lines.copy()
        for k in numpy.flatnonzero((x != self.x).any(1)):
            lines[self.first + k] = "%.17g %.17g %.17g %d" % (*x[k], self.tags[k])
        path.write_text("\n".join(lines), encoding="ascii")


def graph_laplace(mesh):
    """[n] the solution for a load of 1 inside and 0 on the boundary; at most 1."""
    pairs = [mesh.cells[:, [i, j]] for i in range(4) for j in range(4) if i != j]
    pairs = numpy.concatenate(pairs)
    n = len(mesh.x)
    graph = sparse.csr_matrix((numpy.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (n, n))
    graph.data[:] = 1
    matrix = (sparse.diags(numpy.asarray(graph.sum(1)).ravel()) - graph).tocsr()
    matrix = matrix[mesh.inside][:, mesh.inside]
    w = numpy.zeros(n)
    w[mesh.inside] = linalg.cg(matrix, numpy.ones(mesh.inside.sum()), tol=1e-6, maxiter=3000)[0]
    return w / w.max()


def field_of(mesh, kind, w):
    """[n][3] displacement of amplitude 1."""
    away = mesh.x - mesh.x[mesh.used].mean(0)
    if kind == "left behind":
        return numpy.where(mesh.inside[:, None], 0, away[:, [1, 2, 0]])
    if kind == "twist":
        return w[:, None] * numpy.stack([-away[:, 1], away[:, 0], 0 * away[:, 0]], 1)
    if kind == "stretch":
        return w[:, None] * away * [1, -1, 0.5]
    return numpy.broadcast_to(w[:, None] * [1, 0.6, -0.3], away.shape)


def displace(mesh, field):
    """The coordinates after PART of the largest valid displacement."""
    sign = numpy.sign(mesh.volumes(mesh.x))
    low, high = 0.0, numpy.ptp(mesh.x) / abs(field).max()
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        valid = (mesh.volumes(mesh.x + middle * field) * sign > 0).all()
        low, high = (middle, high) if valid else (low, middle)
    return mesh.x + PART * low * field


def run(programs, source, target):
    """The report of one run."""
    done = subprocess.run([f"{programs}/planish", "smooth", source, "-o", target, "-j", "1", "-q",
                           "--json", "-"], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def seconds(report):
    return sum(sweep["seconds"] for sweep in report["sweeps"])


def displaced(source, kind):
    return source.with_suffix(f".{kind.replace(' ', '_')}.mesh")


def prepare(programs, source):
    """Smooth a mesh and write its displaced forms; returns its numbers of elements and free nodes."""
    smoothed = source.with_suffix(".smooth.mesh")
    run(programs, source, smoothed)
    mesh = Mesh(smoothed)
    w = graph_laplace(mesh)
    for kind in KINDS:
        mesh.write(displace(mesh, field_of(mesh, kind, w)), displaced(source, kind))
    return {"elements": len(mesh.cells), "free": int(mesh.inside.sum())}


def row_of(programs, source, error, size):
    """A row: the fastest of several runs."""
    start = source if error == START else displaced(source, error)
    reports = [run(programs, start, source.with_suffix(".out.mesh")) for _ in range(REPEATS)]
    report = min(reports, key=seconds)
    return {"mesh": source.stem, **size, "error": error, "sweeps": len(report["sweeps"]),
            "visits": sum(sweep["visits"] for sweep in report["sweeps"]),
            "seconds": seconds(report), "rms": report["after"]["rms_radius_ratio_movable"]}


def main():
    programs, target, *sources = sys.argv[1:]
    sources = [pathlib.Path(source) for source in sources]
    sizes = [prepare(programs, source) for source in sources]
    rows = [row_of(programs, source, error, size)
            for source, size in zip(sources, sizes) for error in (START, *KINDS)]
    with open(target, "w", encoding="ascii", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
