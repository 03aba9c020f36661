"""Test of the plugin in ParaView: pvpython in_paraview.py [FOLDER OF A PICTURE]."""

import inspect
import pathlib
import sys
import unittest

if not hasattr(inspect, "getargspec"):  # ParaView 5.11 needs it, and Python 3.11 has it no more
    inspect.getargspec = inspect.getfullargspec

from paraview import simple  # noqa: E402  # pylint: disable=wrong-import-position

PLUGIN = pathlib.Path(__file__).resolve().parents[2] / "tools/python/planish/paraview_plugin.py"
PICTURE = sys.argv.pop() if len(sys.argv) > 1 else ""
simple.LoadPlugin(str(PLUGIN), ns=globals())


def tetrahedra():
    return simple.Tetrahedralize(Input=simple.Wavelet(WholeExtent=[0, 8, 0, 8, 0, 8]))


def n_fixed(made):
    """Number of points that stay."""
    made.UpdatePipeline()
    fixed = simple.servermanager.Fetch(made).GetPointData().GetArray("fixed")
    return sum(fixed.GetValue(i) for i in range(fixed.GetNumberOfTuples()))


class InParaView(unittest.TestCase):
    """The plugin."""

    def test_grid(self):
        made = PlanishSmooth(Input=tetrahedra())  # noqa: F821
        made.UpdatePipeline()
        self.assertEqual(set(made.PointData.keys()), {"RTData", "displacement", "fixed"})
        self.assertEqual(set(made.CellData.keys()), {"aspect_ratio", "scaled_jacobian", "cell_state"})
        on_boundary = n_fixed(made)
        made.Slide = "auto"
        self.assertEqual((on_boundary, n_fixed(made)), (9**3 - 7**3, 8))

    def test_surface(self):
        made = PlanishSmooth(Input=simple.Sphere(ThetaResolution=24, PhiResolution=24))  # noqa: F821
        made.UpdatePipeline()
        self.assertEqual(made.CellData["cell_state"].GetRange(), (1, 1))
        self.assertGreater(made.PointData["displacement"].GetRange(-1)[1], 1e-3)

    def test_regions(self):
        kinds = simple.PythonCalculator(Input=tetrahedra(), ArrayAssociation="Cell Data", ArrayName="kind",
                                        Expression="numpy.arange(inputs[0].GetNumberOfCells()) // 1280")
        free = PlanishSmooth(Input=kinds, HoldRegions=0)  # noqa: F821
        held = PlanishSmooth(Input=kinds, RegionArray="kind")  # noqa: F821
        self.assertLess(n_fixed(free), n_fixed(held))

    def test_blocks(self):
        alone, together = PlanishSmooth(Input=tetrahedra()), PlanishSmooth(  # noqa: F821
            Input=simple.GroupDatasets(Input=[tetrahedra(), tetrahedra()]))
        for made in (alone, together):
            made.UpdatePipeline()
        self.assertEqual(together.GetDataInformation().GetNumberOfCells(),
                         2 * alone.GetDataInformation().GetNumberOfCells())
        self.assertIn("aspect_ratio", together.CellData.keys())

    @unittest.skipIf(not PICTURE, "no folder for a picture is given")
    def test_picture(self):
        made = PlanishSmooth(Input=tetrahedra(), Slide="auto")  # noqa: F821
        view = simple.CreateView("RenderView")
        shown = simple.Show(made, view)
        shown.Representation = "Surface With Edges"
        simple.ColorBy(shown, ("CELLS", "aspect_ratio"))
        shown.SetScalarBarVisibility(view, True)
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [-14, -18, 22], [4, 4, 4], [0, 0, 1]
        simple.ResetCamera(view)
        simple.SaveScreenshot(f"{PICTURE}/planish_in_paraview.png", view, ImageResolution=[800, 500])
        simple.Delete(view)


if __name__ == "__main__":
    unittest.main()
