"""meshfile: writes a mesh as binary legacy VTK (fast; planish counts its elements from 0) or, for
eyes, as Medit (.mesh; from 1), and reads the points of a VTK file that planish has written back."""
import numpy as np

from cells import KINDS, blocks_of


def in_space(points):
    """With z = 0 in 2-D."""
    flat = np.zeros((len(points), 3))
    flat[:, :points.shape[1]] = points
    return flat


def write_vtk(path, points, elements, fixed=None):
    blocks = blocks_of(elements)
    rows = [np.insert(nodes, 0, nodes.shape[1], axis=1).ravel() for _, nodes in blocks]
    types = [np.full(len(nodes), KINDS[name].vtk) for name, nodes in blocks]
    with open(path, "wb") as file:
        def line(text):
            file.write(text.encode("ascii") + b"\n")
        line("# vtk DataFile Version 3.0\na tangled mesh\nBINARY\nDATASET UNSTRUCTURED_GRID")
        line(f"POINTS {len(points)} double")
        file.write(in_space(points).astype(">f8").tobytes())
        line(f"\nCELLS {len(elements)} {sum(map(len, rows))}")
        file.write(np.concatenate(rows).astype(">i4").tobytes())
        line(f"\nCELL_TYPES {len(elements)}")
        file.write(np.concatenate(types).astype(">i4").tobytes())
        if fixed is not None:
            line(f"\nPOINT_DATA {len(points)}\nSCALARS fixed int 1\nLOOKUP_TABLE default")
            file.write(fixed.astype(">i4").tobytes())
        line("")


def write_medit(path, points, elements, fixed=None):
    dim = points.shape[1]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension {dim}\nVertices\n{len(points)}\n")
        file.writelines(" ".join(map(repr, row)) + " 0\n" for row in points.tolist())
        if fixed is not None:
            file.write(f"RequiredVertices\n{int(fixed.sum())}\n")
            file.writelines(f"{node + 1}\n" for node in np.flatnonzero(fixed))
        for name, nodes in blocks_of(elements):
            file.write(f"{KINDS[name].medit}\n{len(nodes)}\n")
            file.writelines(" ".join(map(str, row)) + " 1\n" for row in (nodes + 1).tolist())
        file.write("End\n")


def write(path, points, elements, fixed=None):
    writer = write_medit if path.endswith(".mesh") else write_vtk
    writer(path, points, elements, fixed)


def read_vtk_points(path, dim):
    """Of a file that write_vtk has written and planish has written back."""
    with open(path, "rb") as file:
        for line in file:
            if line.startswith(b"POINTS"):
                break
        n_points = int(line.split()[1])
        values = np.frombuffer(file.read(24 * n_points), ">f8")
    return values.reshape(n_points, 3)[:, :dim].astype(float)
