#!/usr/bin/env python3
"""meshes: the meshes of the gallery that no mesher makes.

   meshes.py mixed OUT.vtk         elements of four types and two materials, its inner nodes moved at random
   meshes.py scan OUT.stl          a smooth closed surface of irregular triangles
   meshes.py turned IN.msh OUT.msh the rotor of rotor.geo turned, while the nodes inside stay behind
   meshes.py sizes IN.msh OUT.msh  with wanted sizes at the nodes, small at a front: the array "size" """
import sys

import numpy as np

import bases
import cells
import layers
import meshfile
import planish

PUSH = 0.42                                # of mixed, in spacings of its grid
TURN = np.radians(15)
FRONT = np.array([8., -4.]), 10.5          # centre and radius of a circle
FINE, SLOPE, COARSE = 0.2, 0.12, 0.7       # sizes at the front, and away from it
SCAN_CUTS, SCAN_PUSH = 3, 0.32             # of a scan's triangles; of its nodes, in edges


def mixed(out):
    base = bases.load("alltypes")
    middle = np.array([base.points[nodes].mean(axis=0)[0] for _, block in base.elements.blocks for nodes in block])
    material = np.where(middle < 7, 1, 2)
    free = ~base.fixed & (np.abs(base.points[:, 0] - 7) > 0.3)
    push = np.random.RandomState(4).uniform(-PUSH, PUSH, base.points.shape)
    meshfile.write_vtk(out, base.points + np.where(free[:, None], push, 0), base.elements)
    with open(out, "ab") as file:
        file.write(f"CELL_DATA {len(material)}\nSCALARS material int 1\nLOOKUP_TABLE default\n".encode("ascii"))
        file.write(material.astype(">i4").tobytes() + b"\n")


def scan(out):
    points, triangles = layers.icosphere(SCAN_CUTS)
    edge = np.linalg.norm(points[triangles[:, 0]] - points[triangles[:, 1]], axis=1).mean()
    points = points + np.random.RandomState(1).uniform(-SCAN_PUSH, SCAN_PUSH, points.shape) * edge
    points /= np.linalg.norm(points, axis=1)[:, None]
    x, y, z = points.T
    points *= (1 + 0.16 * (np.sin(3 * x) + np.sin(3 * y + 1) * np.cos(2 * z)))[:, None]
    with open(out, "w", encoding="ascii") as file:
        file.write("solid scan\n")
        for triangle in points[triangles].tolist():
            vertices = "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle)
            file.write(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        file.write("endsolid scan\n")


def turned(source, out):
    mesh = planish.read(source)
    triangles = mesh.cells["triangle"]
    is_moved = cells.on_boundary(len(mesh.points), cells.Cells(("triangle", triangles)))
    is_moved &= np.linalg.norm(mesh.points, axis=1) < 0.9
    cosine, sine = np.cos(TURN), np.sin(TURN)
    mesh.points[is_moved] = mesh.points[is_moved] @ np.array([[cosine, sine], [-sine, cosine]])
    mesh.write(out)


def sizes(source, out):
    mesh = planish.read(source)
    centre, radius = FRONT
    wanted = np.minimum(COARSE, FINE + SLOPE * abs(np.linalg.norm(mesh.points - centre, axis=1) - radius))
    with open(source, encoding="utf-8") as file:
        text = file.read()
    with open(out, "w", encoding="utf-8") as file:
        file.write(text + f'$NodeData\n1\n"size"\n1\n0\n3\n0\n1\n{len(wanted)}\n')
        file.writelines(f"{mesh.node_number(i)} {size!r}\n" for i, size in enumerate(wanted.tolist()))
        file.write("$EndNodeData\n")


if __name__ == "__main__":
    MAKERS = {maker.__name__: maker for maker in (mixed, scan, turned, sizes)}
    if len(sys.argv) < 3 or sys.argv[1] not in MAKERS:
        sys.exit(__doc__)
    MAKERS[sys.argv[1]](*sys.argv[2:])
