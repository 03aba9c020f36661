"""Write the mesh of a legacy VTK file as .vtu in every way that VTK has, and as meshio writes it.

usage: vtk_variants.py IN.vtk; prints the names.
"""
import itertools
import sys

import meshio
import vtk

reader = vtk.vtkUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.ReadAllScalarsOn()
reader.Update()


def grid(single):
    """The grid with points of one precision, and data behind them that must stay."""
    result = vtk.vtkUnstructuredGrid()
    result.DeepCopy(reader.GetOutput())
    points = vtk.vtkPoints()
    points.SetDataType(vtk.VTK_FLOAT if single else vtk.VTK_DOUBLE)
    points.SetNumberOfPoints(result.GetNumberOfPoints())
    ids = vtk.vtkLongLongArray()
    ids.SetName("ids")
    for i in range(result.GetNumberOfPoints()):
        points.SetPoint(i, result.GetPoint(i))
        ids.InsertNextValue(7 * i)
    result.SetPoints(points)
    result.GetPointData().AddArray(ids)
    return result


grids = [grid(0), grid(1)]
for mode, packer, text, wide, big, single in itertools.product(
        ("Ascii", "Binary", "Appended"), ("None", "ZLib", "LZ4", "LZMA"), *[(0, 1)] * 4):
    if mode == "Ascii" and (packer != "None" or text or wide or big) or mode == "Binary" and text:
        continue
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grids[single])
    getattr(writer, "SetDataModeTo" + mode)()
    getattr(writer, "SetCompressorTypeTo" + packer)()
    writer.SetEncodeAppendedData(text)
    writer.SetBlockSize(4096)
    writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
    writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
    name = f"{mode}-{packer}-{text}{wide}{big}{single}.vtu"
    writer.SetFileName(name)
    writer.Write()
    print(name)
mesh = meshio.read(sys.argv[1])
for packer in ("zlib", "lzma", None):
    name = f"meshio-{packer}.vtu"
    meshio.vtu.write(name, mesh, compression=packer)
    print(name)
