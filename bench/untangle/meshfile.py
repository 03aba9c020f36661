"""meshfile: writes a mesh as binary legacy VTK (fast; planish counts its elements from 0) or, for
eyes, as Medit (.mesh; from 1), and reads VTK files that planish has written."""
import numpy as np

from cells import KINDS, Cells, blocks_of

# By VTK's number of a type; the first two are points and lines.
N_CORNERS = {1: 1, 3: 2, **{kind.vtk: 1 + max(sum(kind.faces, ())) for kind in KINDS.values()}}


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


def read_vtk(path):
    """Points [n][dim], and the elements of the highest dimension, of a file that planish has written."""
    def numbers(keyword, place, kind, each=1):
        """What follows the line of a keyword, whose word at that place counts rows of so many."""
        line = next(line for line in file if line.startswith(keyword))
        return np.fromfile(file, kind, each * int(line.split()[place]))
    with open(path, "rb") as file:
        points = numbers(b"POINTS", 1, ">f8", 3).reshape(-1, 3).astype(float)
        rows = numbers(b"CELLS", 2, ">i4").astype(np.int32)
        types = numbers(b"CELL_TYPES", 1, ">i4").astype(np.int32)
    n_corners = np.zeros(max(*N_CORNERS, types.max()) + 1, int)
    n_corners[list(N_CORNERS)] = list(N_CORNERS.values())
    first = np.cumsum(n_corners[types] + 1) - n_corners[types]
    dim = max(kind.dim for kind in KINDS.values() if kind.vtk in types)
    return points[:, :dim], Cells(*[
        (name, rows[first[types == kind.vtk][:, None] + np.arange(N_CORNERS[kind.vtk])].astype(int))
        for name, kind in KINDS.items() if kind.dim == dim])
