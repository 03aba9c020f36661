"""read_vtk.py cgns|hdf A B: both files as VTK reads them have the same cells and data, and other
points."""
import sys

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy


def grid_of(kind, path):
    if kind == "cgns":
        from vtkmodules.vtkIOCGNSReader import vtkCGNSReader
        reader = vtkCGNSReader()
        reader.SetFileName(path)
        reader.UpdateInformation()
        reader.Update()
        data = reader.GetOutput()
        while data.IsA("vtkMultiBlockDataSet"):
            data = data.GetBlock(0)
        return data
    from vtkmodules.vtkIOHDF import vtkHDFReader
    reader = vtkHDFReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


a, b = (grid_of(sys.argv[1], path) for path in sys.argv[2:4])
assert a.GetNumberOfCells() > 0 and a.GetNumberOfCells() == b.GetNumberOfCells()
for part in ("GetConnectivityArray", "GetOffsetsArray"):
    x, y = (vtk_to_numpy(getattr(g.GetCells(), part)()) for g in (a, b))
    assert numpy.array_equal(x, y), part
for which in ("GetPointData", "GetCellData"):
    x, y = getattr(a, which)(), getattr(b, which)()
    assert x.GetNumberOfArrays() == y.GetNumberOfArrays()
    for i in range(x.GetNumberOfArrays()):
        assert numpy.array_equal(vtk_to_numpy(x.GetArray(i)), vtk_to_numpy(y.GetArray(i)))
x, y = (vtk_to_numpy(g.GetPoints().GetData()) for g in (a, b))
assert x.shape == y.shape and not numpy.array_equal(x, y)
