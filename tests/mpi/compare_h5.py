"""compare_h5.py ALONE.json TOGETHER.json ALONE.mesh TOGETHER.h5: the report and the coordinates of a mesh in
PETSc's file are those of the same mesh in a file of Medit's, bit for bit."""
import json
import sys

import h5py
import numpy


def coordinates_of_medit(path):
    with open(path) as file:
        words = file.read().split()
    n = int(words[words.index("Vertices") + 1])
    first = words.index("Vertices") + 2
    return numpy.array(words[first : first + 4 * n], dtype=float).reshape(n, 4)[:, :3]


def main():
    with open(sys.argv[1]) as alone, open(sys.argv[2]) as together:
        a, b = json.load(alone), json.load(together)
    for key in ("objective", "moved_nodes", "node_visits", "max_displacement", "stop"):
        assert a[key] == b[key], key
    for x, y in zip(a["sweeps"], b["sweeps"], strict=True):
        assert (x["rms"], x["visits"]) == (y["rms"], y["visits"])
    assert a["mesh"]["nodes"] == b["mesh"]["nodes"] and a["mesh"]["elements"] == b["mesh"]["elements"]
    x = coordinates_of_medit(sys.argv[3])
    with h5py.File(sys.argv[4]) as file:
        y = file["geometry/vertices"][:]
    assert x.shape == y.shape and (x == y).all(), "coordinates"


main()
