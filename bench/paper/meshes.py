#!/usr/bin/env python3
"""meshes: the three examples of the paper, re-made with its counts and as bad as its were.

    meshes.py FOLDER      writes FOLDER/{square,holes,cube}.msh (Gmsh 2.2 ASCII)

Good meshes are made first (plane.py, cube.py), and then their free nodes are pushed about at random
as far as gives the largest radius ratio that the paper states (spoil.py). Seeds are fixed: the same
files each time. cube_feasible.msh is the good mesh in space before: it shows that all minimum volumes
can be met. Needs numpy and scipy.
"""
import sys

from cube import cube_example
from plane import HOLES, plane_example
from simplices import free_nodes, write_mesh

# The paper gives no radius ratio for its first example: 12 is ours.
SQUARE = {"n_free": 49, "n_triangles": 124, "per_side": 7, "holes": [], "worst": 12.0}
WITH_HOLES = {"n_free": 45, "n_triangles": 160, "per_side": 8, "holes": HOLES, "worst": 22.489}
CUBE = {"seed": 3, "flips": 12, "count": 580, "worst": 18.22, "least": 3e-6}


def check(elements, n_free, count):
    if len(elements) != count or len(free_nodes(elements)) != n_free:
        raise RuntimeError("the mesh does not have the paper's counts")


def write_examples(folder):
    for name, example in (("square", SQUARE), ("holes", WITH_HOLES)):
        points, triangles = plane_example(**example)
        check(triangles, example["n_free"], example["n_triangles"])
        write_mesh(f"{folder}/{name}.msh", points, triangles)
    points, tetrahedra, feasible = cube_example(**CUBE)
    check(tetrahedra, 38, CUBE["count"])
    write_mesh(f"{folder}/cube.msh", points, tetrahedra)
    write_mesh(f"{folder}/cube_feasible.msh", feasible, tetrahedra)


def main():
    write_examples(sys.argv[1])


if __name__ == "__main__":
    main()
