"""Whether pairs of .vtu files, read by VTK, differ in the points alone, of which MOVED did.

usage: same_vtu.py <LIST: lines of BEFORE AFTER MOVED
"""
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def arrays(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    found = {"points": grid.GetPoints().GetData(), "types": grid.GetCellTypesArray(),
             "nodes": grid.GetCells().GetConnectivityArray(),
             "offsets": grid.GetCells().GetOffsetsArray()}
    for kind, data in ("point ", grid.GetPointData()), ("cell ", grid.GetCellData()):
        for i in range(data.GetNumberOfArrays()):
            found[kind + data.GetArrayName(i)] = data.GetArray(i)
    return {name: vtk_to_numpy(array) for name, array in found.items()}


def compare(before, after, moved):
    assert before.keys() == after.keys() and len(before) >= 5, (before.keys(), after.keys())
    for name in before:
        assert before[name].dtype == after[name].dtype, name
        assert before[name].shape == after[name].shape, name
        assert name == "points" or (before[name] == after[name]).all(), name
    found = (before["points"] != after["points"]).any(axis=1).sum()
    assert found == moved > 0, (found, moved)


failures = 0
for line in sys.stdin:
    first, second, number = line.split()
    try:
        compare(arrays(first), arrays(second), int(number))
    except AssertionError as error:
        print(f"{first}: {error}")
        failures += 1
sys.exit(failures > 0)
