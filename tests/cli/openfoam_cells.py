"""Compare VTK's own reader with copies for viewing.

    openfoam_cells.py CASE...         the cells of CASE.vtu are the same, each with its faces in the same sense
    openfoam_cells.py --layer CASE    the mesh is a layer, whose points stand one above the other
"""
import os
import sys

import vtk
from vtk.util.numpy_support import vtk_to_numpy

HEXAHEDRON, WEDGE, PYRAMID = 12, 13, 14
# Whose normals leave the cell. VTK's reader has wedges of the other sense.
FACES = {HEXAHEDRON: ("0321", "4567", "0154", "1265", "2376", "3047"),
         WEDGE: ("021", "345", "0143", "1254", "2035"), PYRAMID: ("0321", "014", "124", "234", "304")}


def turned(face):
    first = face.index(min(face))
    return tuple(face[first:] + face[:first])


def cells(grid, is_reader):
    found = {}
    number = grid.GetCellData().GetArray("number")
    ids = vtk.vtkIdList()
    for i in range(grid.GetNumberOfCells()):
        kind = grid.GetCellType(i)
        if kind not in FACES:
            assert not is_reader, kind
            continue
        grid.GetCellPoints(i, ids)
        points = [ids.GetId(k) for k in range(ids.GetNumberOfIds())]
        step = -1 if kind == WEDGE and is_reader else 1
        faces = frozenset(turned([points[int(k)] for k in face][::step]) for face in FACES[kind])
        found[i if is_reader else int(number.GetTuple1(i))] = (kind, faces)
    return found


def read_case(case):
    os.makedirs(case + "/system", exist_ok=True)
    with open(case + "/system/controlDict", "w") as file:
        file.write("FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }\n"
                   "startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
                   "writeControl timeStep; writeInterval 1;\n")
    open(case + "/case.foam", "w").close()
    reader = vtk.vtkOpenFOAMReader()
    reader.SetFileName(case + "/case.foam")
    reader.DecomposePolyhedraOff()
    reader.Update()
    blocks = reader.GetOutput()
    return next(b for b in map(blocks.GetBlock, range(blocks.GetNumberOfBlocks()))
                if b and b.IsA("vtkUnstructuredGrid"))


def check_layer(case):
    points = vtk_to_numpy(read_case(case).GetPoints().GetData())
    half = len(points) // 2
    assert (points[:half, :2] == points[half:, :2]).all()
    assert (points[:half, 2] == 0).all() and (points[half:, 2] == 1).all()


def check_case(case):
    grid = read_case(case)
    mine = cells(grid, True)
    kinds = [kind for kind, _ in mine.values()]
    assert all(kinds.count(kind) > 5 for kind in FACES), kinds
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(case + ".vtu")
    reader.Update()
    assert cells(reader.GetOutput(), False) == mine, case
    points, there = (vtk_to_numpy(g.GetPoints().GetData()) for g in (grid, reader.GetOutput()))
    assert len(points) == len(there) and abs(points - there).max() < 1e-6  # VTK's reader has floats


if sys.argv[1] == "--layer":
    check_layer(sys.argv[2])
else:
    for name in sys.argv[1:]:
        check_case(name)
