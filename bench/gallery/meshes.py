#!/usr/bin/env python3
"""meshes: the meshes of the gallery that no mesher makes.

   meshes.py mixed OUT.vtk         elements of four types and two materials, its inner nodes moved at random
   meshes.py scan OUT.stl          a smooth surface, cut out of a grid as scanners do
   meshes.py turned IN.msh OUT.msh the rotor of rotor.geo turned, while the nodes inside stay behind
   meshes.py sizes IN.msh OUT.msh  with wanted sizes at the nodes, small at a front: the array "size" """
import sys

import numpy as np

import bases
import cells
import meshfile
import planish

PUSH = 0.42                                # of mixed, in spacings of its grid
TURN = np.radians(15)
FRONT = np.array([8., -4.]), 10.5          # centre and radius of a circle
FINE, SLOPE, COARSE = 0.2, 0.12, 0.7       # sizes at the front, and away from it
SCAN_SIDE = 22                             # bricks of the grid, along each side of a cube from -1 to 1
NEAREST = 0.05                             # part of an edge of the grid that is left between the surface and a node
BALLS = np.array([(-0.4, -0.15, -0.3, 0.42), (0.3, -0.25, -0.2, 0.4), (0.1, 0.35, -0.25, 0.4), (0, 0, 0.35, 0.38)])


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


def level(points):
    """Positive inside of balls that run into one another."""
    distance = np.linalg.norm(points[:, None] - BALLS[:, :3], axis=2) / BALLS[:, 3]
    return np.exp(-1.5 * (distance ** 2 - 1)).sum(axis=1) - 1


def crossing(points, values, i, j):
    """Where the level is 0 between nodes i and j, the same bits for j and i."""
    i, j = np.minimum(i, j), np.maximum(i, j)
    part = np.clip(values[i] / (values[i] - values[j]), NEAREST, 1 - NEAREST)[:, None]
    return points[i] + part * (points[j] - points[i])


def cut(points, values, tetrahedra):
    """Triangles [k][3][3] of the surface of level 0, oriented outwards."""
    is_out = values[tetrahedra] <= 0
    nodes = np.take_along_axis(tetrahedra, np.argsort(is_out, axis=1, kind="stable"), axis=1)  # those inside first
    corners = {1: [((0, 1), (0, 2), (0, 3))], 3: [((0, 3), (1, 3), (2, 3))],
               2: [((0, 2), (0, 3), (1, 3)), ((0, 2), (1, 3), (1, 2))]}
    found = []
    for n_inside, triangles in corners.items():
        some = nodes[(~is_out).sum(axis=1) == n_inside]
        outwards = points[some[:, 3]] - points[some[:, 0]]
        for triangle in triangles:
            x = np.stack([crossing(points, values, some[:, i], some[:, j]) for i, j in triangle], axis=1)
            is_turned = (np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) * outwards).sum(axis=1) < 0
            x[is_turned] = x[is_turned, ::-1]
            found.append(x)
    return np.concatenate(found)


def scan(out):
    points, bricks = bases.grid(*[SCAN_SIDE] * 3)
    points = 2 * points / SCAN_SIDE - 1
    triangles = cut(points, level(points), bricks[:, bases.KUHN].reshape(-1, 4))
    with open(out, "w", encoding="ascii") as file:
        file.write("solid scan\n")
        for triangle in triangles.tolist():
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
