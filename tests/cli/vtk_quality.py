"""vtk_quality.py MESH QUALITY.json: the spreads that planish reports against VTK's mesh quality of
the same cells. MESH: Medit, or VTK's own format. Ends with 1 if they differ."""
import json
import math
import sys

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy


def read_medit(path):
    """Coordinates (flat meshes: with a third one of 0) and elements of the highest dimension."""
    words = open(path).read().split()
    dim = int(words[words.index("Dimension") + 1])

    def section(name, columns, kind):
        at = words.index(name) + 2
        end = at + int(words[at - 1]) * columns
        return numpy.array(words[at:end], dtype=kind).reshape(-1, columns)[:, :-1]
    points = section("Vertices", dim + 1, float)
    name, columns = ("Tetrahedra", 5) if dim == 3 else ("Triangles", 4)
    elements = section(name, columns, numpy.int64) - 1
    return numpy.pad(points, ((0, 0), (0, 3 - dim))), elements


def read_vtk(path):
    reader = vtk.vtkUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    kinds = vtk_to_numpy(grid.GetCellTypesArray())
    kind, corners = (vtk.VTK_TETRA, 4) if vtk.VTK_TETRA in kinds else (vtk.VTK_TRIANGLE, 3)
    starts = vtk_to_numpy(grid.GetCells().GetOffsetsArray())[:-1][kinds == kind]
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    return points, nodes[starts[:, None] + numpy.arange(corners)]


def positive(points, elements):
    """Elements with the orientation that most of the mesh has made the positive one."""
    edges = points[elements[:, 1:]] - points[elements[:, :1]]
    if elements.shape[1] == 4:
        measure = numpy.linalg.det(edges)
    else:
        measure = numpy.cross(edges[:, 0], edges[:, 1])[:, 2]
    if measure.sum() < 0:
        elements = elements[:, [1, 0, *range(2, elements.shape[1])]]
    return elements, abs(measure).min()


def grid_of(points, elements):
    corners = elements.shape[1]
    cells = vtk.vtkCellArray()
    cells.SetData(numpy_to_vtk(numpy.arange(0, elements.size + 1, corners), deep=True,
                               array_type=vtk.VTK_ID_TYPE),
                  numpy_to_vtk(numpy.ascontiguousarray(elements.ravel()), deep=True,
                               array_type=vtk.VTK_ID_TYPE))
    coordinates = vtk.vtkPoints()
    coordinates.SetDataTypeToDouble()
    coordinates.SetData(numpy_to_vtk(numpy.ascontiguousarray(points, dtype=float), deep=True))
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(coordinates)
    grid.SetCells(vtk.VTK_TETRA if corners == 4 else vtk.VTK_TRIANGLE, cells)
    return grid


def measured(grid, name):
    """VTK's measure of that name, of each cell."""
    quality = vtk.vtkMeshQuality()
    quality.SetInputData(grid)
    getattr(quality, "SetTetQualityMeasureTo" + name if grid.GetCellType(0) == vtk.VTK_TETRA
            else "SetTriangleQualityMeasureTo" + name)()
    quality.Update()
    return vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality")).copy()


def dihedral_angles(points, elements):
    """In degrees, [edge][element], from the normals of the faces at each edge. VTK has no largest
    one, and its smallest one (9.1) takes 180 degrees less the angle at the edges 02 and 13."""
    angles = []
    for i, j, k, l in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2),
                       (2, 3, 0, 1)):
        edge, to_k, to_l = (points[elements[:, m]] - points[elements[:, i]] for m in (j, k, l))
        a, b = numpy.cross(edge, to_k), numpy.cross(edge, to_l)
        sine = numpy.linalg.norm(numpy.cross(a, b), axis=1)
        angles.append(numpy.degrees(numpy.arctan2(sine, (a * b).sum(axis=1))))
    return numpy.array(angles)


def expected(points, elements):
    """By planish's key. The factors are in docs/measures.md; what VTK lacks is put together."""
    grid = grid_of(points, elements)
    ratio, aspect = measured(grid, "RadiusRatio"), measured(grid, "AspectRatio")
    values = {
        "radius_ratio": ratio,
        "edge_to_inradius": aspect,
        "circumradius_to_edge": ratio / aspect,  # both normalised to the regular element
        "edge_ratio": measured(grid, "EdgeRatio"),
        "mean_ratio": 1 / measured(grid, "AspectFrobenius"),
        "scaled_jacobian": measured(grid, "ScaledJacobian"),
    }
    if elements.shape[1] == 4:
        angles = dihedral_angles(points, elements)
        values["smallest_angle_deg"] = angles.min(axis=0)
        values["largest_angle_deg"] = angles.max(axis=0)
    else:
        values["smallest_angle_deg"] = measured(grid, "MinAngle")
        values["largest_angle_deg"] = measured(grid, "MaxAngle")
    shape = measured(grid, "Shape")
    assert numpy.allclose(shape, values["mean_ratio"], rtol=1e-6), "two of VTK's names differ"
    return values


path, report = sys.argv[1], json.load(open(sys.argv[2]))
points, elements = read_medit(path) if path.endswith(".mesh") else read_vtk(path)
elements, smallest = positive(points, elements)
quality = report["quality"]
assert len(elements) == report["mesh"]["elements"] and quality["inverted"] == 0 and smallest > 0
wrong = 0
for key, values in expected(points, elements).items():
    # Slivers magnify rounding, and an angle near 0 is that of a cosine near 1.
    tolerance = 1e-12 * quality["max_radius_ratio"]
    for name, value in (("min", values.min()), ("mean", math.fsum(values) / len(values)),
                        ("max", values.max())):
        if not math.isclose(quality[key][name], value, rel_tol=tolerance):
            print("%s %s: planish says %r, it is %r" % (key, name, quality[key][name], value))
            wrong += 1
print("%s: %d elements, %d figures differ" % (path, len(elements), wrong))
sys.exit(wrong > 0)
