"""Tests of the Python module: its keywords, its tables, threads, sets of meshio, the accessor of PyVista."""

import importlib
import inspect
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import types
import unittest

import numpy as np

import planish
from elements import vtk
from module import QUICK, Block, Mesh, ball, box, lists_of

try:
    import pyvista
except ImportError:
    pyvista = None

PACKAGE = pathlib.Path(planish.__file__).parent


def keywords(function):
    """Return keywords and their defaults."""
    return {name: value.default for name, value in inspect.signature(function).parameters.items()
            if value.kind is inspect.Parameter.KEYWORD_ONLY}


class Keywords(unittest.TestCase):
    def test_all_have_the_same_keywords(self):
        of_smooth, of_plan, of_run = map(keywords, (planish.smooth, planish.Plan, planish.Plan.smooth))
        joined = {**of_plan, **of_run}
        self.assertEqual(of_smooth, joined)
        self.assertEqual(keywords(planish.accessor.Accessor.smooth), of_smooth)
        self.assertEqual(keywords(planish.accessor.Accessor.quality), keywords(planish.quality))
        for callable_ in planish.smooth, planish.Plan, planish.quality, planish.read:
            self.assertNotIn("**", str(inspect.signature(callable_)))

    def test_keywords_are_documented(self):
        for function in (planish.smooth, planish.Plan.__init__, planish.Plan.smooth, planish.quality, planish.read,
                         planish.Shape.__init__, planish.find_slides, planish.size_quality, planish.layer_heights):
            for name in keywords(function):
                self.assertRegex(inspect.getdoc(function), rf"(?m)^ +{name}: ", (function, name))

    def test_words_are_the_programs(self):
        """Each keyword is an option of the program, but for those of arrays."""
        text = (PACKAGE.parents[1] / "options" / "options.c").read_text()
        options = {name.replace("-", "_") for name in re.findall(r'\{(?:[A-Z_]+, )?(?:0|\'.\'), "([a-z-]+)"', text)}
        own = {"around", "rounding", "untangle", "progress", "bind"}
        self.assertEqual(set(keywords(planish.smooth)) - options, own - {"bind"})

    def test_numbers_of_words(self):
        points, cells, _ = box(2)
        for options in ({"method": "none"}, {"direction": "up"}, {"objective": "x"}, {"layers": "x"}, {"slide": "x"},
                        {"max_displacement": "far"}, {"box": [1, 2, 3]}):
            name = next(iter(options))
            with self.assertRaisesRegex(ValueError, name):
                planish.smooth(points, cells, **options)

    def test_box_and_displacement(self):
        points, cells, inside = box(2, amount=0.3)
        moved, start = points.copy(), points.copy()
        planish.smooth(moved, cells, box=[[0, 0], [6, 3.2]])
        self.assertLessEqual(moved[inside & (start[:, 1] <= 3.2), 1].max(), 3.2)
        planish.smooth(points, cells, max_displacement="0.05h")
        self.assertTrue(0 < np.linalg.norm(points - start, axis=1).max() < 0.1)
        for method in "laplacian", "area-laplacian", "length-laplacian":
            other = start.copy()
            planish.smooth(other, cells, method=method)
            self.assertTrue((other != start).any())
            self.refuse_optimising(start.copy(), cells, method)

    def refuse_optimising(self, points, cells, method):
        """Options without effect are refused, as in the program, and nothing moves."""
        before = points.copy()
        of_plan = [{"slide": "auto"}, {"only_worse_than": 2}, {"layers": "keep"}, {"like": before}, {"keep_sizes": True},
                   {"size": np.ones(len(points))}]
        of_run = [{"objective": "mean-ratio"}, {"direction": "fletcher-reeves"}, {"untangle": False}, {"curve_quality": 0}]
        for wrong in of_plan + of_run:
            name = next(iter(wrong))
            with self.assertRaisesRegex(ValueError, f"{name} has no effect with method='{method}'"):
                planish.smooth(points, cells, method=method, **wrong)
        with planish.Plan(points, cells, slide="auto") as plan, self.assertRaisesRegex(ValueError, "slide has no effect"):
            plan.smooth(method=method)
        np.testing.assert_array_equal(points, before)
        planish.smooth(points, cells, method=method, slide="none", layers="ignore", fix=[0])
        self.assertTrue((points != before).any())

    def test_no_circles(self):
        """Modules of the package import one another in one direction."""
        imports = {}
        for path in PACKAGE.rglob("*.py"):
            text = path.read_text()
            found = set(re.findall(r"^from \.(\w+) import", text, re.M))
            for line in re.findall(r"^from \. import (.+)$", text, re.M):
                found |= set(re.findall(r"\w+", line.split("#")[0]))
            imports[path.stem] = found
        order = []
        while imports:
            free = [name for name, needs in imports.items() if not needs & set(imports)]
            self.assertTrue(free, f"a circle among {sorted(imports)}")
            order += free
            for name in free:
                del imports[name]
        self.assertGreater(len(order), 20)


class Shown(unittest.TestCase):
    def test_tables(self):
        points, cells, _ = box(2)
        found, result = planish.quality(points, cells), planish.smooth(points, cells)
        self.assertRegex(str(found), r"(?m)^elements +72$")
        self.assertRegex(str(found), r"angle, smallest +\d")
        self.assertRegex(str(result), r"(?m)^ended +converged$")
        for shown in found, result:
            self.assertEqual(len(str(shown).splitlines()), shown._repr_html_().count("<tr>"))
            self.assertEqual(len({len(line) for line in str(shown).splitlines()}), 1)
        quads = planish.quality(np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), {"quad": [[0, 1, 2, 3]]})
        self.assertRegex(str(quads), r"(?m)^quad +1$")
        self.assertIn("aspect ratio, RMS", str(quads))
        self.assertNotIn("angle", str(quads))
        self.assertIn("n_elements=", repr(found))


class Threads(unittest.TestCase):
    def test_several_meshes_at_once(self):
        """Threads smooth different meshes, of arrays and on curved surfaces, with progress and without."""
        meshes = [ball(5, amount=0.02 * k) for k in range(4)] + [box(3, seed=k) for k in range(4)]
        expected, found = [m[0].copy() for m in meshes], [m[0].copy() for m in meshes]
        options = [{"slide": "curved"}] * 4 + [{"progress": lambda seen: None}] * 4
        for points, (_, cells, _), more in zip(expected, meshes, options):
            planish.smooth(points, cells, threads=1, **more)
        failures = []

        def work(points, cells, more):
            try:
                planish.smooth(points, cells, threads=1, **more)
            except BaseException as error:
                failures.append(error)

        workers = [threading.Thread(target=work, args=(points, m[1], more))
                   for points, m, more in zip(found, meshes, options)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(failures, [])
        for ours, theirs in zip(found, expected):
            np.testing.assert_array_equal(ours, theirs)

    def test_others_run_meanwhile(self):
        """The library works without Python's lock."""
        points, cells, _ = box(3, cells=12)
        worker = threading.Thread(target=planish.smooth, args=(points, cells), kwargs={"tolerance": 0, "threads": 1})
        worker.start()
        turns = 0
        while worker.is_alive():
            turns += 1
        self.assertGreater(turns, 1000)


class Sets(unittest.TestCase):
    def test_names_of_meshio_sets(self):
        points, cells, inside = box(3)
        stay = np.flatnonzero(inside)[:5]
        expected = points.copy()
        planish.smooth(expected, cells, fix=stay)
        some = cells[:7]
        by_cells = points.copy()
        planish.smooth(by_cells, cells, fix=np.unique(some))
        for name, wanted in (("wall", expected), (["wall"], expected), ("part", by_cells)):
            mesh = Mesh(points.copy(), cells=[Block("tetra", cells)], cell_data={}, point_sets={"wall": stay},
                        cell_sets={"part": [np.arange(7)]})
            planish.smooth(mesh, fix=name)
            np.testing.assert_array_equal(mesh.points, wanted)
        mesh = Mesh(points.copy(), cells=[Block("tetra", cells)], cell_data={},
                    point_sets={"wall": np.isin(np.arange(len(points)), stay), "far": [len(points)]},
                    cell_sets={"part": [np.arange(len(cells)) < 7], "none": [[-1]], "gmsh:bounding_entities": [[1]]})
        for name, wanted in (("wall", expected), ("part", by_cells)):  # masks
            mesh.points = points.copy()
            planish.smooth(mesh, fix=name)
            np.testing.assert_array_equal(mesh.points, wanted)
        for name, text in (("far", "set of points 'far' has a number"), ("none", "set of cells 'none' has a number"),
                           ("gmsh:bounding_entities", "no set 'gmsh:bounding_entities'; it has: wall, far, part, none")):
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(mesh, fix=name)
        mesh = Mesh(points.copy(), cells=[Block("tetra", cells)], cell_data={}, point_sets={"wall": stay},
                    cell_sets={"part": [np.arange(7)]})
        with self.assertRaisesRegex(ValueError, "no set 'roof'; it has: wall, part"):
            planish.smooth(mesh, fix="roof")
        with self.assertRaisesRegex(ValueError, "it has: none"):
            planish.smooth(points, cells, fix="roof")

    def test_size_by_name(self):
        points, cells, _ = box(2)
        size = 1 + points[:, 0]
        expected = points.copy()
        planish.smooth(expected, cells, size=size)
        mesh = Mesh(points.copy(), cells=[Block("triangle", cells)], cell_data={}, point_data={"h": size})
        planish.smooth(mesh, size="h")
        np.testing.assert_array_equal(mesh.points, expected)
        with self.assertRaisesRegex(ValueError, "no array of points 'x'; it has: h"):
            planish.smooth(mesh, size="x")


class StandIn(types.ModuleType):
    """What the accessor asks of PyVista 0.48."""

    def __init__(self):
        super().__init__("pyvista")
        self.entries = []

        class UnstructuredGrid(Mesh):
            pass

        class PolyData(Mesh):
            pass

        self.UnstructuredGrid, self.PolyData = UnstructuredGrid, PolyData

    def register_dataset_accessor(self, name, target):
        def decorate(accessor):
            setattr(target, name, property(accessor))
            self.entries.append(types.SimpleNamespace(name=name, target=target, accessor=accessor))
            return accessor
        return decorate

    def registered_accessors(self):
        raise AssertionError("PyVista imports all other packages that have accessors")


LAZY = """
import importlib
pending = {"planish": "%s"}  # entry points, whose modules are imported when an attribute is missed


class DataObject:
    def __getattr__(self, name):
        if name not in pending:
            raise AttributeError(name)
        importlib.import_module(pending.pop(name))
        return getattr(self, name)


class UnstructuredGrid(DataObject):
    pass


class PolyData(DataObject):
    pass


def register_dataset_accessor(name, target):
    def decorate(accessor):
        assert name not in vars(target), "PyVista 0.48 warns"
        setattr(target, name, property(accessor))
        return accessor
    return decorate
"""


class PyVista(unittest.TestCase):
    def test_accessor_of_a_stand_in(self):
        stand_in = StandIn()
        for _ in range(2):  # the second time it is there
            self.assertTrue(planish.accessor.register(stand_in))
        self.assertEqual(len(stand_in.entries), 2)
        points, cells, inside = box(3)
        mesh = stand_in.UnstructuredGrid(points.copy(), cells=lists_of(cells), celltypes=np.full(len(cells), 10))
        before = mesh.planish.quality()
        result = mesh.planish.smooth(fix=np.flatnonzero(inside)[:2], max_sweeps=5)
        self.assertEqual(result.sweeps, 5)
        self.assertLess(mesh.planish.quality(threads=1).rms_radius_ratio, before.rms_radius_ratio)
        self.assertFalse(mesh.planish.find_layers().any())
        self.assertFalse(planish.accessor.register(types.ModuleType("pyvista")))  # an older one

    def test_pyvista_finds_it(self):
        """The module of the entry point registers it when PyVista first misses it, whatever was imported before."""
        text = (PACKAGE.parents[2] / "pyproject.toml").read_text()
        (module,) = re.findall(r'"pyvista\.accessors"\]\nplanish = "(.+)"', text)
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "pyvista.py").write_text(LAZY % module)
            path = os.pathsep.join([folder, str(PACKAGE.parent), os.environ.get("PYTHONPATH", "")])
            for imports in "import pyvista", "import planish, pyvista", "import pyvista, planish":
                for kind in ("UnstructuredGrid", "PolyData")[:1 if QUICK else 2]:
                    done = subprocess.run(
                        [sys.executable, "-c", f"{imports}\nassert pyvista.{kind}().planish.quality, 'none'"],
                        env=dict(os.environ, PYTHONPATH=path), check=False, stderr=subprocess.PIPE, text=True)
                    self.assertEqual(done.stderr, "", imports)

    def test_other_data_sets_of_pyvista(self):
        class StructuredGrid(Mesh):
            def cast_to_unstructured_grid(self):
                raise AssertionError("the caller's points would stay")

        with self.assertRaisesRegex(TypeError, "not StructuredGrid; give its cast_to_unstructured_grid"):
            planish.smooth(StructuredGrid(box(3)[0]))

    def test_registers_itself(self):
        before, sys.modules["pyvista"] = sys.modules.get("pyvista"), StandIn()
        try:
            module = importlib.reload(planish.accessor)
            self.assertTrue(hasattr(sys.modules["pyvista"].PolyData, module.NAME))
        finally:
            del sys.modules["pyvista"]
            if before is not None:
                sys.modules["pyvista"] = before
            importlib.reload(planish.accessor)

    def test_views_of_vtk_are_taken_without_lists(self):
        points, cells, _ = box(3)
        expected = points.copy()
        planish.smooth(expected, cells)

        class Grid(Mesh):
            @property
            def cells(self):
                raise AssertionError("a copy is made")

        mesh = Grid(points.copy(), cell_connectivity=cells.ravel().astype(np.int64),
                    offset=np.arange(0, cells.size + 1, 4), celltypes=np.full(len(cells), 10, np.uint8), cell_data={})
        planish.smooth(mesh)
        np.testing.assert_array_equal(mesh.points, expected)

    @unittest.skipIf(vtk is None, "without VTK")
    def test_vtk_is_told(self):
        points, cells, _ = box(2)
        of_vtk = vtk.vtkPoints()

        class Grid(Mesh):
            def GetPoints(self):
                return of_vtk

        before = of_vtk.GetMTime()
        planish.smooth(Grid(points, cells=[Block("triangle", cells)], cell_data={}))
        self.assertGreater(of_vtk.GetMTime(), before)

    @unittest.skipIf(pyvista is None, "without PyVista")
    def test_pyvista(self):
        points, cells, _ = box(3)
        expected = points.copy()
        planish.smooth(expected, cells)
        mesh = pyvista.UnstructuredGrid({10: cells}, points)
        if planish.accessor.register(pyvista):
            mesh.planish.smooth()
        else:
            planish.smooth(mesh)
        np.testing.assert_array_equal(mesh.points, expected)


if __name__ == "__main__":
    unittest.main()
