"""multiplied.py: files here whose parts multiply: few bytes that ask for much, or many things each of which is
looked for among as many others.

A name says what `planish groups` does of it: read_... or refused_...; of convert_... `planish convert` makes
small files. Each has to take time and memory in proportion to its size.
"""
import math
import os
import struct

import exodus_mesh
from tiny_meshes import POINTS, TETRAHEDRA, folders, lines, meshes, numbered


def write(path, *parts):
    with open(path, "wb") as file:
        for part in parts:
            file.write(part if isinstance(part, bytes) else part.encode())


def repeat(n, text):
    """Text n times, with numbers from 1 where it has %d."""
    return "".join([text.replace("%d", str(i + 1)) for i in range(n)])


# ---- bytes that ask for memory --------------------------------------------------------------------


def mfem_with_set(n, n_elements, name):
    """A row of tetrahedra, of attributes 1, 2, ...; a set has 1 .. n."""
    points = [(round(math.cos(i), 3), round(math.sin(i), 3), i / 10) for i in range(n_elements + 3)]
    elements = [(i + 1, 4, i, i + 1, i + 2, i + 3) for i in range(n_elements)]
    return ("MFEM mesh v1.3\n\ndimension\n3\n\nelements\n%d\n%s\nattribute_sets\n1\n%s %d\n%s\n"
            "boundary\n0\n\nbdr_attribute_sets\n0\n\nvertices\n%d\n3\n%s\nmfem_mesh_end\n" %
            (n_elements, lines(elements), name, n, " ".join(map(str, range(1, n + 1))), len(points), lines(points)))


write("refused_names.mfem", mfem_with_set(20000, 1, "n" * 20000))

FIVE = "<Geometry><DataItem Dimensions='5 3' Precision='8'>%s</DataItem></Geometry>" % lines(POINTS)
GRID = "<Grid><Topology Type='Tetrahedron'><DataItem Dimensions='2 4'>0 1 2 3 1 2 3 4</DataItem></Topology>%s</Grid>" % FIVE


def xdmf(name, *parts):
    write(name, "<?xml version='1.0'?>\n<Xdmf><Domain>", *parts, "</Domain></Xdmf>")


N = 100000
xdmf("refused_cells.xdmf", "<Grid><Topology Type='Mixed'><DataItem Dimensions='%d'>6 0 1 2 3 2 %d " % (N + 7, N),
     "0 1 2 3 4 " * (N // 5), "</DataItem></Topology>", FIVE,
     "<Set Name='s' Type='Cell'><DataItem Dimensions='%d'>%s</DataItem></Set></Grid>" % (N, "1 " * N))
xdmf("refused_grids.xdmf", "<Grid Type='Tree'>", "<Grid Reference='/Xdmf/Domain/Grid[2]'/>" * N, "</Grid><Grid Type='Tree'>",
     "<Grid Reference='/Xdmf/Domain/Grid[3]'/>" * N, "</Grid>", GRID)
xdmf("refused_path.xdmf", "<Grid Reference='/Xdmf/Domain/Grid[%d]'/>" % (N + 1) * N,
     "<Grid Reference='XML'>/Xdmf/Domain/", "./" * 500000, "Grid[%d]</Grid>" % (N + 2), GRID)
xdmf("refused_children.xdmf", "<Grid Reference='/Xdmf/Domain/Grid[%d]'/>" % (N + 1) * N,
     GRID.replace("</Grid>", "<a/>" * 500000 + "</Grid>"))
xdmf("refused_attributes.xdmf", GRID.replace("<Grid>", "<Grid %s>" % repeat(1000, " a%d=''")))
xdmf("refused_alike.xdmf", repeat(16384, GRID.replace("'2 4'>0 1 2 3 1 2 3 4", "'2 4' Format='HDF'>a.h5:" + "/a" * 500 + "%d")))
# What a mesh names is copied along with it: no file that programs read by themselves.
os.mkdir(".config")
for name, wanted in (".profile", "refused_hidden"), (".config/x", "refused_folder"), ("plain.bin", "read_plain"):
    write(name, struct.pack("<8i", 0, 1, 2, 3, 1, 2, 3, 4))
    xdmf(wanted + ".xdmf", GRID.replace("0 1 2 3 1 2 3 4", "./" + name).replace(
        "'2 4'", "'2 4' Format='Binary' NumberType='Int' Endian='Little'"))

os.mkdir("refused_faces")
for name, data in {**folders()["openfoam"],
                   "faces": b'FoamFile{format binary;arch "LSB;label=32;scalar=64";class faceList;}\n%d\n(' % N +
                            (b"65536{" + struct.pack("<i", 0) + b"}\n") * N + b")\n"}.items():
    write("refused_faces/" + name, data)

write("refused_points.su2", "NZONE= 100\nNDIME= 3\n", repeat(100, "IZONE= %d\nNPOIN= 1000000\n"), "0 0 0\n" * 700000)
records = exodus_mesh.File(POINTS)
records.dims = {"time_step": 0, "num_nodes": 2000000000}
records.variables = [("coord" + axis, exodus_mesh.DOUBLE, ("time_step", "num_nodes"), [], None) for axis in "xyz"]
write("refused_records.exo", records.classic())

write("refused_force.obj", lines(("v", *p) for p in POINTS), "g", repeat(N, " g%d"), "\n",
      repeat(N // 5, "usemtl m%d\nf 1 2 3\n"))
deck = meshes()["abaqus.inp"].decode()
write("again.inc", "**", b" " * (10 << 20), "\n")
write("refused_again.inp", deck, "*INCLUDE, INPUT=again.inc\n" * 100)

# ---- many things among many others -------------------------------------------------------------------

N = 300000
write("read_zones.su2", "NZONE= %d\n" % N, repeat(N - 1, "IZONE= %d\nNDIME= 3\nNPOIN= 0\nNELEM= 0\n"), "IZONE= %d\n" % N,
      meshes()["tiny.su2"])
blocks = exodus_mesh.File(POINTS)
blocks.put_blocks([(1, "body", "TETRA", TETRAHEDRA)])
blocks.variables[-3] = ("eb_prop1", exodus_mesh.INT, ("n",), list(range(1, N + 1)), None)
blocks.dims.update({"n": N, **{"d%d" % i: 1 for i in range(N)}})
write("read_blocks.exo", blocks.classic())
write("read_types.inp", deck, repeat(N, "*ELEMENT, TYPE=C3D4_%d\n"))
write("read_surfaces.inp", deck.split("*NSET")[0], "*ELEMENT, TYPE=C3D4\n", "7, 1, 2, 3, 4\n" * N,
      repeat(N // 5, "*SURFACE, NAME=s%d\n1, S1\n"))
write("refused_mark.bdf", b"\x89HDF\r\n\x1a\n", "GA\n" * (10 * N))
write("choose_numbers.mfem", mfem_with_set(N, N, "all"))

HEAD = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n"
NODES = "$EndPhysicalNames\n$Nodes\n5\n%s$EndNodes\n$Elements\n%%d\n" % numbered(POINTS)
write("convert_groups.msh", HEAD % N, repeat(N, '3 %d "g%d"\n'), NODES % N, repeat(N, "%d 4 2 %d %d 1 2 3 4\n"), "$EndElements\n")
# Regions that a hash which files can know (FNV-1a of 32 bits) does not tell apart.
N, PRIME = 600000, 0x01000193
SEEDS = [((0x811C9DC5 ^ 3) * PRIME ^ tag) * PRIME & 0x7FFFFFFF for tag in range(1, N + 1)]
write("read_hashes.msh", HEAD % 0, NODES % N, *["%d 4 2 %d %d 1 2 3 4\n" % (i + 1, s or 1, i + 1) for i, s in enumerate(SEEDS)],
      "$EndElements\n")
N = 30000 # names of one number, and the name of many regions
write("convert_names.msh", HEAD % N, '3 1 "%s"\n' % ("n" * 1000000), repeat(N - 1, '3 1 "g%d"\n'), NODES % N,
      repeat(N, "%d 4 2 1 %d 1 2 3 4\n"), "$EndElements\n")
