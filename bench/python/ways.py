"""ways: seconds of the processor that smoothing one mesh takes, called as C calls it, and through the Python module.

The call of C is planish_plan_create, planish_smooth and planish_plan_destroy on arrays of 32 bits, by ctypes. All
ways take turns, on one thread, and the least time of each counts.
"""

import sys
import time
import types
from ctypes import byref, c_void_p

import numpy as np

import machine
import planish
from planish._arrays import address, pointer
from planish._library import call, library, new_options
from planish._structures import MeshView

TURNS, SWEEPS = 3, 200


def by_c(points, cells):
    """Smooth as a caller in C does, without layers, regions and other things that the module looks for."""
    mesh = MeshView(dim=3, n_nodes=len(points), n_elements=len(cells), coordinates=address(points),
                    elements=address(cells))
    options, plan, result = new_options(), c_void_p(), planish.Result()
    options.threads, options.max_sweeps = 1, SWEEPS
    call(library.planish_plan_create, byref(mesh), byref(options), byref(plan))
    call(library.planish_smooth, plan, pointer(points), byref(options), byref(result))
    library.planish_plan_destroy(plan)
    return result


def by_module(*mesh):
    """Smooth by the module."""
    return planish.smooth(*mesh, threads=1, max_sweeps=SWEEPS)


def of_meshio(points, cells):
    """Return a mesh of meshio, None: it is not there."""
    try:
        import meshio
    except ImportError:
        return None
    return meshio.Mesh(points, [("tetra", cells.astype(np.int64))])


def of_vtk(points, cells):
    """Return VTK's arrays of a grid as PyVista shows them, None: VTK is not there."""
    try:
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    except ImportError:
        return None
    grid, places, lists = vtk.vtkUnstructuredGrid(), vtk.vtkPoints(), vtk.vtkCellArray()
    places.SetData(numpy_to_vtk(points, deep=True))
    offsets = np.arange(0, cells.size + 1, 4)
    lists.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True),
                  numpy_to_vtkIdTypeArray(cells.astype(np.int64).ravel(), deep=True))
    grid.SetPoints(places)
    grid.SetCells(10, lists)
    return types.SimpleNamespace(
        grid=grid, points=vtk_to_numpy(places.GetData()), celltypes=vtk_to_numpy(grid.GetCellTypesArray()),
        cell_connectivity=vtk_to_numpy(lists.GetConnectivityArray()), offset=vtk_to_numpy(lists.GetOffsetsArray()),
        cell_data={})


def ways(mesh):
    """Return the ways to smooth the mesh: names, functions, what they take from new points."""
    points, cells = mesh.points, mesh.cells["tetra"]
    found = [("C: plan and smooth", by_c, lambda x: (x, cells)),
             ("arrays, int32", by_module, lambda x: (x, cells)),
             ("arrays, int64", by_module, lambda x: (x, cells.astype(np.int64))),
             ('{"tetra": cells}', by_module, lambda x: (x, {"tetra": cells}))]
    found += [(name, by_module, lambda x, make=make: (make(x, cells),))
              for name, make in (("meshio", of_meshio), ("VTK's arrays, as PyVista's", of_vtk))
              if make(points, cells) is not None]
    return found


def least(name, work, take, start):
    """Return the seconds of one turn, and the points after it."""
    given = take(start.copy())
    begin = time.process_time()
    result = work(*given)
    seconds = time.process_time() - begin
    return seconds, result.sweeps, getattr(given[0], "points", given[0]).copy()


def main(path):
    """Print the table of the mesh at path."""
    mesh = planish.read(path)
    start, rows, expected = mesh.points.copy(), {}, None
    all_ways = ways(mesh)
    for _ in range(TURNS):
        for name, work, take in all_ways:
            seconds, sweeps, after = least(name, work, take, start)
            expected = after if expected is None else expected
            assert np.array_equal(after, expected), name
            rows[name] = min(seconds, rows.get(name, seconds))
    least_c = rows[all_ways[0][0]]
    print(f"{machine.line(machine.description())}, one thread, {len(mesh.cells['tetra'])} tetrahedra, {sweeps} sweeps\n")
    print("| called by | s of the processor | above C |\n| --- | --: | --: |")
    for name, seconds in rows.items():
        print(f"| {name} | {seconds:.2f} | {100 * (seconds / least_c - 1):.1f} % |")


main(sys.argv[1])
