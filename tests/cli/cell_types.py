"""Write an element of each type of VTK, bent so that a wrong order of its nodes is not valid, by VTK
and by meshio; or compare the cells of pairs of files as VTK reads them.

usage: cell_types.py write DIM; prints the names of files, and how many elements each has
       cell_types.py compare A B ...
       cell_types.py measures COPY REPORT.json; the cell data of a copy for viewing against a report
"""
import json
import math
import sys

import meshio
import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy

TYPES = {
    2: ("Triangle", "Quad", "Pixel", "QuadraticTriangle", "QuadraticQuad", "BiQuadraticQuad"),
    3: ("Tetra", "Hexahedron", "Voxel", "Wedge", "Pyramid", "QuadraticTetra", "QuadraticHexahedron",
        "QuadraticWedge", "QuadraticPyramid", "TriQuadraticHexahedron",
        "BiQuadraticQuadraticWedge"),
}
ROWS = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6]}  # pixels and voxels, by other types' order


def bent(x, dim):
    """The places of nodes, where those of a straight element are at x."""
    out = x + 0.1 * numpy.stack([x[:, 1] ** 2 + x[:, 0] * x[:, 2], x[:, 2] ** 2 + x[:, 0] * x[:, 1],
                                 x[:, 0] ** 2 + x[:, 1] * x[:, 2]], axis=1)
    if dim == 2:
        out[:, 2] = 0
    return out


def elements(dim):
    """VTK's type and the places of the nodes of each element."""
    for number, name in enumerate(TYPES[dim]):
        cell = getattr(vtk, "vtk" + name)()
        n = cell.GetNumberOfPoints()
        x = numpy.array(cell.GetParametricCoords()[:3 * n]).reshape(-1, 3)
        if "Pyramid" in name and n > 5:  # where all parametric mids at the apex are one place
            x[9:] = (x[:4] + x[4]) / 2
        x = bent(x, dim)
        x[:, 0] += 3 * number
        yield cell.GetCellType(), x


def grid_of(dim):
    """All elements as VTK's grid."""
    grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    points.SetDataType(vtk.VTK_DOUBLE)
    for kind, places in elements(dim):
        ids = [points.InsertNextPoint(p) for p in places]
        grid.InsertNextCell(kind, len(ids), ids)
    grid.SetPoints(points)
    return grid


def write(dim):
    """Write files by VTK (old and new legacy versions, XML) and meshio."""
    grid = grid_of(dim)
    for version in (42, 51):
        for binary in (0, 1):
            writer = vtk.vtkUnstructuredGridWriter()
            writer.SetFileVersion(version)
            writer.SetFileType(vtk.VTK_BINARY if binary else vtk.VTK_ASCII)
            name = f"types{dim}_{version}_{binary}.vtk"
            writer.SetFileName(name)
            writer.SetInputData(grid)
            assert writer.Write()
            print(name, grid.GetNumberOfCells())
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(f"types{dim}.vtu")
    writer.SetInputData(grid)
    assert writer.Write()
    print(f"types{dim}.vtu", grid.GetNumberOfCells())
    names = {v: k for k, v in meshio._vtk_common.meshio_to_vtk_type.items()}
    points, cells = [], []
    for kind, places in elements(dim):
        if kind in ROWS or names[kind] not in meshio._mesh.topological_dimension:
            continue
        cells.append((names[kind], [list(range(len(points), len(points) + len(places)))]))
        points += list(places)
    mesh = meshio.Mesh(numpy.array(points), cells)
    for name in (f"meshio{dim}.vtk", f"meshio{dim}.vtu"):
        mesh.write(name)
        print(name, len(cells))
    for block in mesh.cells:  # XDMF's order is VTK's, which meshio keeps to in VTK's own files
        order = meshio._vtk_common.meshio_to_vtk_order(block.type)
        if order is not None:
            block.data = block.data[:, order]
    for form in ("XML", "Binary"):
        name = f"meshio{dim}.{form}.xdmf"
        meshio.write(name, mesh, file_format="xdmf", data_format=form)
        print(name, len(cells))


SMOOTHED = (5, 10, 22, 24)  # triangles and tetrahedra of order 1 and 2


def read_grid(path):
    reader = vtk.vtkXMLUnstructuredGridReader() if path.endswith("u") else \
        vtk.vtkUnstructuredGridReader()
    reader.SetFileName(path)
    if not path.endswith("u"):
        reader.ReadAllFieldsOn()
    reader.Update()
    return reader.GetOutput()


def cells_of(path):
    """Type and points of each cell; pixels and voxels as quadrilaterals and hexahedra."""
    grid = read_grid(path)
    found = []
    for i in range(grid.GetNumberOfCells()):
        kind, ids = grid.GetCellType(i), grid.GetCell(i).GetPointIds()
        ids = [ids.GetId(k) for k in range(ids.GetNumberOfIds())]
        if kind in ROWS:
            kind, ids = kind + 1, [ids[k] for k in ROWS[kind]]
        found.append((kind, [grid.GetPoint(k) for k in ids]))
    return sorted(found, key=lambda cell: cell[0] not in SMOOTHED)


def radius_ratio(cell):
    """That of the corners of a tetrahedron."""
    x = numpy.array([cell.GetPoints().GetPoint(k) for k in range(4)])
    a, b, c = x[1:] - x[0]
    normals = [numpy.cross(b, c), numpy.cross(c, a), numpy.cross(a, b), numpy.cross(b - a, c - a)]
    volume = abs(a @ normals[0]) / 6
    inradius = 6 * volume / sum(numpy.linalg.norm(n) for n in normals)
    spread = sum(v @ v * n for v, n in zip((a, b, c), normals))
    return numpy.linalg.norm(spread) / (12 * volume) / (3 * inradius)


def check_measures(path, report):
    """The values of all elements give the figures of the report; an element that is not valid has a
    radius ratio of 0, but counts in the report by its corners."""
    grid = read_grid(path)
    value = {name: vtk_to_numpy(grid.GetCellData().GetArray(name)) for name in
             ("radius_ratio", "aspect_ratio", "scaled_jacobian", "jacobian_ratio", "edge_ratio", "cell_state",
              "is_curved")}
    with open(report) as text:
        quality = json.load(text)["quality"]
    n = sum(quality["counts"].values())
    assert grid.GetNumberOfCells() == n and all(len(v) == n for v in value.values())
    assert (value["cell_state"] == 2).sum() == quality["inverted"] > 0
    assert (value["cell_state"] == 1).sum() == n - quality["inverted"]
    assert value["is_curved"].sum() == quality["curved"] > 0
    ratios = value["aspect_ratio"][value["aspect_ratio"] > 0]
    assert math.isclose(math.sqrt((ratios ** 2).mean()), quality["rms_aspect_ratio"], rel_tol=1e-12)
    curved = value["jacobian_ratio"][value["is_curved"] == 1]
    assert ratios.max() == quality["max_aspect_ratio"] and curved.min() == quality["min_jacobian_ratio"]
    assert value["scaled_jacobian"].min() == quality["min_scaled_jacobian"]
    assert value["edge_ratio"].max() == quality["max_edge_ratio"]
    simplices = numpy.isfinite(value["radius_ratio"])
    kinds = vtk_to_numpy(grid.GetCellTypesArray())
    expected = numpy.array([radius_ratio(grid.GetCell(int(i))) for i in numpy.flatnonzero(simplices)])
    assert math.isclose(expected.max(), quality["simplices"]["max_radius_ratio"], rel_tol=1e-9)
    expected[value["cell_state"][simplices] == 2] = 0
    assert numpy.allclose(value["radius_ratio"][simplices], expected, rtol=1e-9, atol=0)
    assert set(kinds[simplices]) <= {10, 24} and simplices[kinds == 10].all()


if sys.argv[1] == "measures":
    check_measures(*sys.argv[2:])
elif sys.argv[1] == "write":
    write(int(sys.argv[2]))
else:
    for a, b in zip(sys.argv[2::2], sys.argv[3::2]):
        assert cells_of(a) == cells_of(b), f"{a} and {b} have different cells"
