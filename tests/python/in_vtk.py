"""Tests of the filter for VTK and ParaView. They need VTK alone, and run in pvpython, too."""

import pathlib
import unittest

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import planish
from planish.paraview import Smooth

SIDE = 7


def box(kind="tetra", is_float=True, noise=0.3):
    """A box with points inside that are off their places, and with two regions."""
    image = vtk.vtkImageData()
    image.SetDimensions(SIDE, SIDE, SIDE)
    split = vtk.vtkDataSetTriangleFilter() if kind == "tetra" else vtk.vtkAppendFilter()
    split.SetInputData(image)
    split.Update()
    grid = vtk.vtkUnstructuredGrid()
    grid.DeepCopy(split.GetOutput())
    points = vtk.vtkPoints()
    points.SetDataType(vtk.VTK_FLOAT if is_float else vtk.VTK_DOUBLE)
    points.DeepCopy(grid.GetPoints())
    places = vtk_to_numpy(points.GetData())
    inside = ((places > 0) & (places < SIDE - 1)).all(axis=1)
    places[inside] += np.random.default_rng(1).uniform(-noise, noise, (inside.sum(), 3))
    grid.SetPoints(points)
    regions = np.array([int(grid.GetCell(i).GetBounds()[1] <= 3.31) for i in range(grid.GetNumberOfCells())])
    add(grid.GetCellData(), "kind", regions)
    return grid


def add(data, name, values):
    array = numpy_to_vtk(np.asarray(values), deep=True)
    array.SetName(name)
    data.AddArray(array)


def sphere():
    source = vtk.vtkSphereSource()
    source.SetThetaResolution(24)
    source.SetPhiResolution(24)
    source.Update()
    return source.GetOutput()


def places(data_set):
    return vtk_to_numpy(data_set.GetPoints().GetData())


def array(data, name):
    return vtk_to_numpy(data.GetArray(name))


def cells_of(grid):
    """Cells as planish takes them from pyvista."""
    cells = grid.GetCells()
    return (vtk_to_numpy(cells.GetConnectivityArray()), vtk_to_numpy(cells.GetOffsetsArray()),
            vtk_to_numpy(grid.GetCellTypesArray()))


class Observer:
    """Observer of VTK's that keeps the texts of events."""

    CallDataType = "string0"

    def __init__(self, texts):
        self.texts = texts

    def __call__(self, _caller, _event, text):
        self.texts.append(text)


class Filter(unittest.TestCase):
    """The filter."""

    def smoothed(self, data_set, **options):
        """Output and filter; options by the names of properties."""
        smooth = Smooth()
        smooth.SetInputDataObject(data_set)
        for name, value in options.items():
            getattr(smooth, "Set" + name)(value)
        smooth.Update()
        return smooth.GetOutputDataObject(0), smooth

    def test_bits_of_planish(self):
        for kind in ("tetra", "voxel"):
            for is_float in (True, False):
                grid = box(kind, is_float)
                expected = places(grid).copy()
                planish.smooth(expected, cells_of(grid), regions=None)
                made, smooth = self.smoothed(grid, HoldRegions=0)
                np.testing.assert_array_equal(places(made), expected)
                self.assertEqual(places(made).dtype, np.float32 if is_float else np.float64)
                self.assertGreater(smooth.result.n_moved_nodes, 0)

    def test_input_stays(self):
        for data_set in (box(), sphere()):
            before, points = places(data_set).copy(), data_set.GetPoints()
            n_arrays = data_set.GetPointData().GetNumberOfArrays(), data_set.GetCellData().GetNumberOfArrays()
            made, _ = self.smoothed(data_set)
            self.assertGreater(np.abs(places(made) - before).max(), 1e-3)
            np.testing.assert_array_equal(places(data_set), before)
            self.assertIs(data_set.GetPoints(), points)
            self.assertEqual((data_set.GetPointData().GetNumberOfArrays(), data_set.GetCellData().GetNumberOfArrays()),
                             n_arrays)
            self.assertEqual(made.GetClassName(), data_set.GetClassName())
            self.assertEqual(made.GetNumberOfCells(), data_set.GetNumberOfCells())

    def test_arrays(self):
        grid = box()
        made, _ = self.smoothed(grid)
        moved = places(made) - places(grid)
        np.testing.assert_array_equal(array(made.GetPointData(), "displacement"), moved)
        fixed = array(made.GetPointData(), "fixed")
        self.assertEqual(set(fixed.tolist()), {0, 1})
        self.assertFalse(moved[fixed == 1].any())
        self.assertGreater((moved[fixed == 0] != 0).any(axis=1).mean(), 0.9)
        found = planish.quality(places(made), cells_of(made), per_element=True).elements
        for name, values in (("aspect_ratio", found.aspect_ratio), ("scaled_jacobian", found.scaled_jacobian),
                             ("cell_state", found.state)):
            np.testing.assert_array_equal(array(made.GetCellData(), name), values)
        self.assertEqual(set(found.state.tolist()), {1})
        self.assertIsNotNone(made.GetCellData().GetArray("kind"))

    def test_cells_without_measures(self):
        grid = box()
        grid.InsertNextCell(vtk.VTK_VERTEX, 1, [0])
        grid.GetCellData().Initialize()
        made, _ = self.smoothed(grid)
        last = grid.GetNumberOfCells() - 1
        self.assertTrue(np.isnan(array(made.GetCellData(), "aspect_ratio")[last]))
        self.assertEqual(array(made.GetCellData(), "cell_state")[last], 0)
        self.assertFalse(np.isnan(array(made.GetCellData(), "aspect_ratio")[:last]).any())

    def test_regions(self):
        grid = box()
        nodes, offsets, _ = cells_of(grid)
        region = np.repeat(array(grid.GetCellData(), "kind"), np.diff(offsets))
        between = np.intersect1d(nodes[region == 0], nodes[region == 1])
        free, _ = self.smoothed(grid, HoldRegions=0)
        held, _ = self.smoothed(grid, RegionArray="kind")
        self.assertTrue((places(free) != places(grid))[between].any())
        self.assertFalse((places(held) != places(grid))[between].any())
        self.assertTrue(array(held.GetPointData(), "fixed")[between].all())

    def test_fixed_array(self):
        grid = box()
        marks = np.arange(grid.GetNumberOfPoints()) % 2
        add(grid.GetPointData(), "marks", marks)
        made, _ = self.smoothed(grid, FixedArray="marks")
        moved = (places(made) != places(grid)).any(axis=1)
        self.assertFalse(moved[marks == 1].any())
        self.assertTrue(moved[marks == 0].any())
        self.assertTrue(array(made.GetPointData(), "fixed")[marks == 1].all())

    def test_slides(self):
        grid = box()
        on_face = (places(grid)[:, 2] == 0) & (places(grid)[:, :2] > 0).all(axis=1) & (
            places(grid)[:, :2] < SIDE - 1).all(axis=1)
        places(grid)[on_face, 0] += 0.2
        for slide in (Smooth.NO_SLIDE, Smooth.AUTO, Smooth.CURVED):
            made, _ = self.smoothed(grid, Slide=slide)
            moved = (places(made) != places(grid))[on_face].any()
            self.assertEqual(moved, slide != Smooth.NO_SLIDE)
            self.assertEqual(bool(array(made.GetPointData(), "fixed")[on_face].all()), slide == Smooth.NO_SLIDE)
            self.assertFalse((places(made)[on_face, 2] != 0).any())

    def test_surface(self):
        made, smooth = self.smoothed(sphere(), SurfaceTolerance=0.02)
        self.assertGreater(smooth.result.n_moved_nodes, 0)
        np.testing.assert_allclose(np.linalg.norm(places(made), axis=1), 0.5, atol=0.01)
        self.assertEqual(set(array(made.GetCellData(), "cell_state").tolist()), {1})

    def test_surface_with_points_and_lines(self):
        surface = vtk.vtkGeometryFilter()
        surface.SetInputData(box())
        surface.Update()
        given = vtk.vtkPolyData()
        given.DeepCopy(surface.GetOutput())
        given.GetCellData().Initialize()
        for set_cells, cell in ((given.SetVerts, [3]), (given.SetLines, [0, 1, 2])):
            cells = vtk.vtkCellArray()
            cells.InsertNextCell(len(cell), cell)
            set_cells(cells)
        places(given)[30:, :] += np.random.default_rng(2).uniform(-0.01, 0.01, (given.GetNumberOfPoints() - 30, 3))
        free, _ = self.smoothed(given)
        held = np.flatnonzero((places(free) != places(given)).any(axis=1))[::2]
        marks = np.zeros(given.GetNumberOfPoints())
        marks[held] = 1
        add(given.GetPointData(), "marks", marks)
        made, _ = self.smoothed(given, FixedArray="marks")
        self.assertGreater(len(held), 10)
        self.assertFalse((places(made) != places(given))[[0, 1, 2, 3, *held]].any())
        self.assertTrue(array(made.GetPointData(), "fixed")[held].all())
        self.assertEqual(np.flatnonzero(np.isnan(array(made.GetCellData(), "aspect_ratio"))).tolist(), [0, 1])
        self.assertEqual(np.flatnonzero(array(made.GetCellData(), "cell_state") == 0).tolist(), [0, 1])

    def test_polygons_that_are_elements(self):
        points = vtk.vtkPoints()
        for i in range(25):
            points.InsertNextPoint(i % 5 + (0.3 if i == 12 else 0), i // 5, 0)
        places_of = {}
        for kinds in ((vtk.VTK_TRIANGLE, vtk.VTK_QUAD), (vtk.VTK_POLYGON, vtk.VTK_POLYGON),
                      (vtk.VTK_TRIANGLE_STRIP, vtk.VTK_QUAD)):
            grid = vtk.vtkUnstructuredGrid()
            grid.SetPoints(points)
            for i in range(16):
                at = i // 4 * 5 + i % 4
                if i % 3:
                    grid.InsertNextCell(kinds[1], 4, [at, at + 1, at + 6, at + 5])
                else:
                    grid.InsertNextCell(kinds[0], 3, [at, at + 1, at + 5])
                    grid.InsertNextCell(kinds[0], 3, [at + 1, at + 6, at + 5])
            made, _ = self.smoothed(grid)
            places_of[kinds] = places(made)
            self.assertGreater(np.abs(places(made) - places(grid)).max(), 0.1)
        first, *others = places_of.values()
        for other in others:
            np.testing.assert_array_equal(other, first)

    def test_progress_and_abort(self):
        seen = []
        smooth = Smooth()
        smooth.SetInputDataObject(box())
        smooth.AddObserver("ProgressEvent", lambda *_: seen.append(smooth.GetProgress()))
        smooth.Update()
        self.assertEqual(seen, sorted(seen))
        self.assertGreater(len(seen), 10)
        self.assertTrue(0 <= seen[0] and seen[-1] <= 1)
        self.assertEqual(smooth.result.stop, "converged")
        smooth.AddObserver("ProgressEvent", lambda *_: smooth.SetAbortExecute(int(smooth.GetProgress() > 0.5)))
        smooth.Modified()
        smooth.Update()
        self.assertEqual(smooth.result.stop, "interrupted")
        state = array(smooth.GetOutputDataObject(0).GetCellData(), "cell_state")
        self.assertEqual(set(state.tolist()), {1})

    def test_errors(self):
        texts = []

        class Window(vtk.vtkOutputWindow):
            """VTK's window of messages: none is wanted here."""

        vtk.vtkOutputWindow.SetInstance(Window())
        vtk.vtkOutputWindow.GetInstance().AddObserver("ErrorEvent", lambda *_: texts.append("error"))
        vtk.vtkObject.GlobalWarningDisplayOff()
        try:
            for options in ({"RegionArray": "nothing"}, {"FixedArray": "nothing"}, {"CreaseAngle": 30.0}):
                made, _ = self.smoothed(box(), **options)
                self.assertEqual(made.GetNumberOfCells(), 0, options)
        finally:
            vtk.vtkObject.GlobalWarningDisplayOn()
        self.assertGreaterEqual(len(texts), 3)

    def test_planes(self):
        """The boundary of flat cells stays, in any plane, of floats, too, and with AUTO it slides along its edges."""
        n, tilt = 9, np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
        flat = np.stack(np.meshgrid(range(n), range(n), [0.0]), axis=-1).reshape(-1, 3)
        inside = ((flat[:, :2] > 0) & (flat[:, :2] < n - 1)).all(axis=1)
        flat[inside, :2] += np.random.default_rng(1).uniform(-0.3, 0.3, (inside.sum(), 2))
        flat[3, 0] += 0.3
        for axes in (np.eye(3), np.eye(3)[[2, 0, 1]], np.eye(3)[[1, 2, 0]], tilt):
            for is_float in (True, False):
                grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
                points.SetDataType(vtk.VTK_FLOAT if is_float else vtk.VTK_DOUBLE)
                points.SetNumberOfPoints(len(flat))
                grid.SetPoints(points)
                places(grid)[...] = flat @ axes
                for i in range(n * n - n):
                    if i % n < n - 1:
                        grid.InsertNextCell(vtk.VTK_QUAD, 4, [i, i + 1, i + n + 1, i + n])
                made, _ = self.smoothed(grid)
                moved = (places(made) != places(grid)).any(axis=1)
                np.testing.assert_array_equal(array(made.GetPointData(), "fixed") == 1, ~inside)
                self.assertFalse(moved[~inside].any())
                self.assertGreater(moved[inside].mean(), 0.9)
                self.assertLess(np.abs(places(made) @ axes[2]).max(), 1e-6)
                made, _ = self.smoothed(grid, Slide=Smooth.AUTO)
                self.assertEqual(np.flatnonzero(array(made.GetPointData(), "fixed")).tolist(), [0, n - 1, n * n - n, n * n - 1])
                self.assertGreater(np.abs(places(made) - places(grid))[3].max(), 0.05)
                self.assertLess(np.abs((places(made) @ axes.T)[:n, 1]).max(), 1e-5)

    def test_curved_in_a_plane(self):
        """As by the program: an error that says what to choose, and nothing of planish's C structures."""
        source, texts = vtk.vtkPlaneSource(), []
        source.SetResolution(4, 4)
        source.Update()

        class Window(vtk.vtkOutputWindow):
            """VTK's window of messages."""

        vtk.vtkOutputWindow.SetInstance(Window())
        vtk.vtkOutputWindow.GetInstance().AddObserver("ErrorEvent", Observer(texts))
        vtk.vtkObject.GlobalWarningDisplayOff()
        self.addCleanup(vtk.vtkObject.GlobalWarningDisplayOn)
        made, _ = self.smoothed(source.GetOutput(), Slide=Smooth.CURVED)
        self.assertEqual(made.GetNumberOfCells(), 0)
        self.assertIn("no curved surface: use slide='auto'", "".join(texts))

    def test_empty(self):
        points_alone = vtk.vtkUnstructuredGrid()
        points_alone.SetPoints(box().GetPoints())
        for given in (vtk.vtkUnstructuredGrid(), points_alone):
            made, smooth = self.smoothed(given)
            self.assertEqual((made.GetNumberOfCells(), made.GetNumberOfPoints()), (0, given.GetNumberOfPoints()))
            self.assertIsNone(smooth.result)

    def test_document(self):
        """The code in docs/where-meshes-are-made.md."""
        document = pathlib.Path(__file__).resolve().parents[2] / "docs/where-meshes-are-made.md"
        (code,) = [piece for piece in document.read_text().split("```") if piece.startswith("python\nfrom planish.par")]
        names = {"grid": box()}
        exec(code.removeprefix("python"), names)  # pylint: disable=exec-used
        self.assertGreater(np.abs(places(names["better"]) - places(names["grid"])).max(), 0.01)

    def test_options(self):
        made, smooth = self.smoothed(box(noise=0.5), Untangle=0, MaxSweeps=1, TimeLimit=10.0, Objective=2)
        self.assertLessEqual(smooth.result.sweeps, 1)
        is_inverted = array(made.GetCellData(), "cell_state") == 2
        n_inverted = is_inverted.sum()
        np.testing.assert_array_equal(np.isnan(array(made.GetCellData(), "aspect_ratio")), is_inverted)
        made, _ = self.smoothed(box(noise=0.5))
        self.assertLess((array(made.GetCellData(), "cell_state") == 2).sum(), n_inverted)


if __name__ == "__main__":
    unittest.main()
