"""Tests of the Python module: meshes of files, which are smoothed and written as the program does."""

import copy
import errno
import gc
import os
import pathlib
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
import types
import unittest
import warnings

import numpy as np

import elements
import planish
from elements import write_vtk
from module import PROGRAM, QUICK, ball, box

DATA = pathlib.Path(os.environ["PLANISH_SOURCE"]) / "tests" / "data"
LOSSLESS = ("abaqus.inp", "ascii.vtk", "ascii.vtu", "ascii22.msh", "base64.vtu", "binary.vtk", "binary41.msh", "cube.avs",
            "cube.cgns", "cube.exo", "cube.h5", "cube.med", "cube.mfem", "cube.su2", "cube.unv", "cube.vtkhdf",
            "medit.mesh", "medit.meshb", "nastran.bdf", "netgen.vol", "elmer", "openfoam")
OPTIONS = (
    (["--slide", "auto"], {"slide": "auto"}),
    (["--slide", "curved", "--surface-tolerance", "0.02h"], {"slide": "curved", "surface_tolerance": "0.02h"}),
    (["--slide", "curved", "--crease-angle", "30", "--slide-interfaces"],
     {"slide": "curved", "crease_angle": 30, "slide_interfaces": True}),
    (["--keep-sizes", "--size-weight", "0.4"], {"keep_sizes": True, "size_weight": 0.4}),
    (["--layers", "keep"], {"layers": "keep"}),
    (["--layers", "hold"], {"layers": "hold"}),
    (["--regions", "none"], {"regions": None}),
    (["--objective", "edge-ratio", "--tolerance", "1e-3", "--no-untangle"],
     {"objective": "edge-ratio", "tolerance": 1e-3, "untangle": False}),
    (["--objective", "worst", "--worst-measure", "radius-ratio", "--worst-rise", "0.1"],
     {"objective": "worst", "worst_measure": "radius-ratio", "worst_rise": 0.1}),
    (["--only-worse-than", "1.5", "--rings", "1"], {"only_worse_than": 1.5, "rings": 1}),
    (["--method", "laplacian"], {"method": "laplacian"}),
    (["--direction", "fletcher-reeves"], {"direction": "fletcher-reeves"}),
    (["--max-displacement", "0.1h", "--max-sweeps", "3"], {"max_displacement": "0.1h", "max_sweeps": 3}),
    (["--min-volume-fraction", "1e-4"], {"min_volume_fraction": 1e-4}),
    (["--fix", "upper part"], {"fix": ["upper part"]}),
    (["--fix", "upper part", "--slide", "auto"], {"fix": "upper part", "slide": "auto"}),
    (["--min-volume", "upper part=1e-4"], {"min_volume": {"upper part": 1e-4}}),
)


def contents(path):
    """Return the bytes of a file, or of all files in a folder."""
    path = pathlib.Path(path)
    if path.is_dir():
        return {str(file.relative_to(path)): file.read_bytes() for file in sorted(path.rglob("*")) if file.is_file()}
    return path.read_bytes()


def read(path, **options):
    """Read a file, or skip the test where the library lacks what the format needs."""
    try:
        return planish.read(path, **options)
    except planish.FileError as error:
        if "built without" in str(error):
            raise unittest.SkipTest(str(error)) from None
        raise


THREADS = """
import os, pathlib, sys
import planish
path, out = map(pathlib.Path, sys.argv[1:])
mesh = planish.read(path, threads=3)
n = len(os.listdir("/proc/self/task"))
planish.smooth(mesh, threads=3, max_sweeps=1)
assert len(os.listdir("/proc/self/task")) == n, "it was read without the threads that smooth it"
if os.fork() == 0:  # one that hangs is ended
    mesh.data("height")
    mesh.write(out)
    mesh.write(out.with_suffix(".msh"))
    assert len(planish.read(out).points) == len(mesh.points)
    os._exit(0)
sys.exit(os.wait()[1] != 0)
"""


class Threads(unittest.TestCase):
    @unittest.skipUnless(os.path.isdir("/proc/self/task"), "nothing says how many threads there are")
    def test_threads_of_files(self):
        """Files are read by several threads, and a child of a fork does not wait for these."""
        n = 300
        points = np.stack(np.meshgrid(range(n), range(n), [0.0]), axis=-1).reshape(-1, 3)
        points[:, 2] = points[:, 0] / 2  # tilted, which takes time
        first = np.arange(n * n).reshape(n, n)[:-1, :-1].reshape(-1, 1)
        cells = np.concatenate([first + [0, 1, n + 1], first + [0, n + 1, n]])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "in.vtk"
            write_vtk(path, points, [("triangle", cells)])
            with open(path, "a", encoding="ascii") as file:
                file.write(f"POINT_DATA {n * n}\nSCALARS height double\nLOOKUP_TABLE default\n" + "7\n" * n * n)
            done = subprocess.run([sys.executable, "-c", THREADS, path, path.with_name("out.vtk")], timeout=120,
                                  check=False, env=dict(os.environ, OMP_NUM_THREADS="3"))
        self.assertEqual(done.returncode, 0)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_null_bytes(self):
        """A path or a name that C would cut is refused, and the file of the first part stays."""
        mesh, victim = read(DATA / "ascii.vtk"), self.folder / "victim.vtk"
        victim.write_text("mine")
        cut = f"{victim}\0other.vtk"
        for call in (lambda: mesh.write(cut), lambda: planish.write(mesh, cut), lambda: read(cut),
                     lambda: read(DATA / "ascii.vtk", format="vtk\0"), lambda: mesh.data("a\0b"),
                     lambda: mesh.held("a\0b"), lambda: planish.smooth(mesh, min_volume={"a\0b": 1e-9})):
            self.assertRaisesRegex(ValueError, "null byte", call)
        self.assertEqual(victim.read_text(), "mine")

    def same_as_the_program(self, path, options=(), may_stay=False, **keywords):
        """Smooth a file by both, and compare what they write."""
        path = pathlib.Path(path)
        ours, theirs = (self.folder / (name + path.suffix) for name in ("ours", "theirs"))
        mesh = read(path)
        start = mesh.points.copy()
        planish.smooth(mesh, **keywords)
        mesh.write(ours)
        done = subprocess.run([PROGRAM, "smooth", path, "-o", theirs, "-q", *options], check=False,
                              stderr=subprocess.PIPE)  # 1: some elements are inverted, or reversed
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertEqual(contents(ours), contents(theirs), (path, options))
        self.assertTrue(may_stay or (mesh.points != start).any(), (path, options))
        for written in ours, theirs:
            shutil.rmtree(written) if written.is_dir() else written.unlink()

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_formats_have_the_programs_bytes(self):
        for i, name in enumerate(LOSSLESS):
            with self.subTest(name):
                self.same_as_the_program(DATA / name)
                if i % 3 == 0 or not QUICK:
                    self.same_as_the_program(DATA / name, ["--slide", "auto"], slide="auto")

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_options_have_the_programs_bytes(self):
        for options, keywords in OPTIONS:
            self.same_as_the_program(DATA / "ascii41.msh", options, **keywords)
        other = self.folder / "other.msh"
        subprocess.run([PROGRAM, "smooth", DATA / "ascii41.msh", "-o", other, "-q", "--slide", "auto"], check=True)
        for given in (other, str(other), read(other)):
            self.same_as_the_program(DATA / "ascii41.msh", ["--like", other], like=given)
            self.same_as_the_program(DATA / "ascii41.msh", ["--slide", "curved", "--surface-of", other],
                                     slide="curved", surface_of=given)

    def write(self, name, points, blocks):
        write_vtk(self.folder / name, np.asarray(points), blocks)
        return self.folder / name

    def write_data(self, path, name, values, of="POINT"):
        """Append an array to a legacy file."""
        rows = "\n".join(" ".join(map(repr, np.ravel(value).tolist())) for value in values)
        kind = "TENSORS" if np.ndim(values) == 3 else "SCALARS"
        table = "LOOKUP_TABLE default\n" if kind == "SCALARS" else ""
        with path.open("a") as file:
            file.write(f"{of}_DATA {len(values)}\n{kind} {name} double\n{table}{rows}\n")

    def check_wrong_metrics(self, points, kinds):
        """The first wrong metric is named; very small ones are right."""
        tiny = 1e-300 * np.tile(np.eye(3), (len(points), 1, 1))
        path = self.write("tiny.vtk", points, kinds)
        self.write_data(path, "m", tiny)
        planish.smooth(planish.read(path), size="m", max_sweeps=1)
        for entries, text in (([[1, 0, 0], [0, 1, 1], [0, 1, 1]], "at node 7 is not positive definite"),
                              ([[1, 2, 0], [2, 1, 0], [0, 0, 1]], "at node 7 is not positive definite"),
                              ([[1, 0, 0], [0.1, 1, 0], [0, 0, 1]], "at node 7 is not symmetric"),
                              ([[1, 0, 0], [0, 1e291, 0], [0, 0, 1]], "at node 7 has an entry that is not a number")):
            wrong = tiny.copy()
            wrong[7] = entries
            path = self.write("wrong.vtk", points, kinds)
            self.write_data(path, "m", wrong)
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(planish.read(path), size="m")

    def check_metrics_in_planes(self):
        """Metrics in space turn with the plane of the mesh."""
        flat, cells, _ = box(2, amount=0.1)
        turn = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
        for frame in np.eye(3)[[0, 2, 1]], np.eye(3)[[2, 0, 1]], turn:
            points = flat @ frame[:2]
            path = self.write("plane.vtk", points, [("triangle", cells)])
            wanted = (1 + flat[:, :1, None]) * np.diag([1, 4, 100.0])
            self.write_data(path, "m", frame.T @ wanted @ frame)
            self.same_as_the_program(path, ["--size", "m", "--size-weight", "0"], size="m", size_weight=0)
            found, same = (planish.quality(*mesh, size=size).cells.all.rms_aspect_ratio
                           for mesh, size in (((planish.read(path),), "m"), ((flat, cells), wanted[:, :2, :2])))
            self.assertAlmostEqual(found, same, 9)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_sizes_of_files(self):
        points, cells, _ = box(3, amount=0.1)
        kinds = [("tetra", cells)]
        path = self.write("nodes.vtk", points, kinds)
        self.write_data(path, "h", 0.5 + points[:, 0])
        self.same_as_the_program(path, ["--size", "h", "--slide", "auto"], size="h", slide="auto")
        path = self.write("cells.vtk", points, kinds)
        self.write_data(path, "h", 0.5 + points[cells].mean(axis=1)[:, 1], "CELL")
        self.same_as_the_program(path, ["--size", "h"], size="h")
        path = self.write("metric.vtk", points, kinds)
        self.write_data(path, "m", np.eye(3) * np.array([1, 1, 4.0]) * (1 + points[:, :1, None]))
        self.same_as_the_program(path, ["--size", "m", "--size-weight", "0"], size="m", size_weight=0)
        self.check_wrong_metrics(points, kinds)
        self.check_metrics_in_planes()
        self.write_sol(self.folder / "h.sol", 1 + points[:, 0])
        self.same_as_the_program(path, ["--size-from", self.folder / "h.sol"], size_from=self.folder / "h.sol")
        with self.assertRaisesRegex(ValueError, "no such array|has no array|there are|'x'"):
            planish.smooth(planish.read(path), size="x")

    def test_regions_of_surfaces_in_space(self):
        """Nodes between regions slide along their curve, from arrays and meshes as from files."""
        flat, cells, inside = box(2, cells=8, amount=0.25)
        points = np.column_stack([flat, 0.03 * flat[:, 0]**2 + 0.02 * flat[:, 1]**2])
        material = np.round(flat[cells]).min(axis=1)[:, 0] // 4
        seam = inside & (np.round(flat[:, 0]) == 4)
        path = self.write("surface.vtk", points, [("triangle", cells)])
        self.write_data(path, "material", material, "CELL")
        of_file, loose = planish.read(path), planish.read(path)
        planish.smooth(of_file)
        planish.smooth(loose, regions=None)
        self.assertGreater(np.abs(loose.points - of_file.points)[seam].max(), 0.1)
        by_name = types.SimpleNamespace(points=points.copy(), cell_data={"material": [material]},
                                        cells=[types.SimpleNamespace(type="triangle", data=cells)])
        planish.smooth(by_name)
        np.testing.assert_array_equal(by_name.points, of_file.points)
        self.assertEqual(planish.Shape(by_name).info.n_edges, planish.Shape(by_name, regions=None).info.n_edges + 8)
        for taken, options in ((cells, {}), ({"triangle": cells}, {}),
                               (cells, {"surface_of": planish.Shape(points, cells, regions=material)})):
            again = points.copy()
            planish.smooth(again, taken, regions=material, **options)
            np.testing.assert_array_equal(again, of_file.points)
        again = points.copy()
        planish.smooth(again, cells, regions=material, surface_of=planish.Shape(points, cells))
        np.testing.assert_array_equal(again[seam], points[seam])
        self.assertTrue((again[inside & ~seam] != points[inside & ~seam]).any())
        with self.assertRaisesRegex(ValueError, "one number for each"):
            planish.smooth(points.copy(), cells, regions=material[:-1])
        with self.assertRaisesRegex(ValueError, "no array of cells 'bent'"):
            planish.smooth(by_name, regions="bent")

    @staticmethod
    def write_sol(path, values):
        rows = "\n".join(map(repr, values.tolist()))
        path.write_text(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(values)}\n1 1\n{rows}\nEnd\n")

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_other_meshes_have_the_programs_bytes(self):
        points, cells, _ = box(2, amount=0.25)
        flat = np.column_stack([points, np.zeros(len(points))])
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        tilted = self.write("tilted.vtk", flat @ turn, [("triangle", cells)])
        self.same_as_the_program(tilted)
        self.same_as_the_program(tilted, ["--slide", "auto", "--objective", "worst"], slide="auto", objective="worst")
        upright = self.write("upright.vtk", flat[:, [2, 1, 0]], [("triangle", cells)])
        self.same_as_the_program(upright, ["--box", "0.5,0.5,5.2,5.4"], box=[0.5, 0.5, 5.2, 5.4])
        self.same_as_the_program(upright, ["--like", self.write("flat.vtk", flat, [("triangle", cells)])],
                                 like=self.folder / "flat.vtk", may_stay=True)
        solid, tets, _ = ball(5)
        self.same_as_the_program(self.write("ball.vtk", solid, [("tetra", tets)]), ["--slide", "curved"], slide="curved")
        faces = np.concatenate([tets[:, list(corners)] for corners in ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))])
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        skin = faces[first[count == 1]]
        used, skin = np.unique(skin, return_inverse=True)
        surface = self.write("skin.vtk", solid[used], [("triangle", skin.reshape(-1, 3))])
        self.assertTrue(read(surface).is_in_space)
        self.assertLess(planish.quality(read(surface)).max_radius_ratio, 10)
        for call in planish.Plan, planish.find_layers:
            with self.assertRaisesRegex(ValueError, "surface in space"):
                call(read(surface))
        self.same_as_the_program(surface)
        self.same_as_the_program(surface, ["--slide", "none", "--max-sweeps", "3"], slide="none", max_sweeps=3)
        small = self.write("small.vtk", 0.97 * solid, [("tetra", tets)])
        self.same_as_the_program(small, ["--onto", surface], onto=surface)
        self.same_as_the_program(small, ["--onto", surface, "--keep-sizes"], onto=surface, keep_sizes=True)
        hexahedra = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
        cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
        self.same_as_the_program(self.write("cube.vtk", cube, [("hexahedron", hexahedra)]), may_stay=True)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_marks_have_the_programs_bytes(self):
        """An array `fixed` that names all of the surface says no more than where that is."""
        points, cells, inside = box(3)
        numbers = np.arange(len(points))
        other = self.write("other.vtk", 1.1 * points - 0.3, [("tetra", cells)])
        for name, marked in (("all", ~inside), ("more", ~inside | (numbers % 50 == 0)), ("half", ~inside & (numbers % 2 > 0))):
            path = self.write(name + ".vtk", points, [("tetra", cells)])
            self.write_data(path, "fixed", marked.astype(float))
            for options, keywords in (([], {}), (["--slide", "auto"], {"slide": "auto"}),
                                      (["--slide", "curved"], {"slide": "curved"}), (["--onto", other], {"onto": other})):
                self.same_as_the_program(path, options, **keywords)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_mixed_meshes_have_the_programs_bytes(self):
        """Elements of any types and orders, some of them inverted."""
        for seed in range(2 if QUICK else 6):
            points, blocks = elements.Elements().filled(seed, is_raised=seed % 2 > 0, dim=2 + (seed % 3 > 0))
            path = self.write("mixed.vtk", points, blocks)
            for options, keywords in (([], {}), (["--slide", "auto"], {"slide": "auto"}),
                                      (["--objective", "worst"], {"objective": "worst"}),
                                      (["--layers", "keep"], {"layers": "keep"}), (["--keep-sizes"], {"keep_sizes": True}),
                                      (["--curve-quality", "0.8"], {"curve_quality": 0.8})):
                self.same_as_the_program(path, options, may_stay=True, **keywords)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_layers_have_the_programs_bytes(self):
        points, cells, inside = elements.Elements().grid("hexahedron", 6, 0)
        points[:, 2] = np.where(points[:, 2] < 0.4, points[:, 2] / 8, points[:, 2])
        points[inside] += 0.002 * np.random.default_rng(2).uniform(-1, 1, (inside.sum(), 3))
        path = self.write("layers.vtk", points, [("hexahedron", cells)])
        for options, keywords in (([], {}), (["--layers", "hold"], {"layers": "hold"}),
                                  (["--layers", "hold", "--slide", "auto"], {"layers": "hold", "slide": "auto"}),
                                  (["--layers", "ignore"], {"layers": "ignore"}),
                                  (["--slide", "auto"], {"slide": "auto"}),
                                  (["--objective", "worst"], {"objective": "worst"}),
                                  (["--objective", "edge-ratio"], {"objective": "edge-ratio"}),
                                  (["--method", "laplacian"], {"method": "laplacian"})):
            self.same_as_the_program(path, options, **keywords)

    @staticmethod
    def rows_of_quads(rows=16, thin=6, push=0.4, seed=1, is_inverted=False):
        """Points and cells of rows over a wall, thin ones and others, with bent columns; two of the others are inverted."""
        n, random = 16, np.random.default_rng(seed)
        heights = 0.004 * (1.3 ** np.arange(thin + 1) - 1) / 0.3
        heights = np.concatenate([heights, heights[-1] + np.arange(1, rows - thin + 1) / n])
        points = np.stack(np.meshgrid(np.arange(n + 1) / n, heights, indexing="ij"), axis=-1)
        points[1:-1, 1:-1, 0] += push / n * random.uniform(-1, 1, (n + 1, rows + 1))[1:-1, 1:-1]
        points[8, 12, 0] += 1.3 / n * is_inverted
        first = np.arange((n + 1) * (rows + 1)).reshape(n + 1, rows + 1)[:-1, :-1].reshape(-1, 1)
        return points.reshape(-1, 2), first + [0, rows + 1, rows + 2, 1]

    def layers_second(self, dim, bump):
        """Write the mesh of layers of second order of a test of the program."""
        path = self.folder / "second.vtk"
        with path.open("w") as file:
            subprocess.run([sys.executable, DATA.parent / "cli" / "layers_second.py", str(dim), str(bump)], stdout=file,
                           check=True)
        return path

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_heights_that_change_by_much_have_the_programs_bytes(self):
        """Nodes of layers are held, also in a mesh that is not valid, but not those that inverted elements need."""
        for dim, bump in ((3, 1.5), (2, 20), (3, 1), (2, 2))[:2 if QUICK else 4]:
            self.same_as_the_program(self.layers_second(dim, bump), ["-j", "1"], threads=1)
        many = {"rows": 32, "thin": 12, "push": 0.3, "seed": 2}  # in the end all nodes of layers are held
        for options in {"is_inverted": False}, {"is_inverted": True}, many:
            points, cells = self.rows_of_quads(**options)
            path = self.write("linear.vtk", np.column_stack([points, np.zeros(len(points))]), [("quad", cells)])
            self.same_as_the_program(path, ["-j", "1"], threads=1)
            self.same_as_the_program(path, ["-j", "1", "--slide", "auto", "--max-sweeps", "5"], threads=1, slide="auto",
                                     max_sweeps=5)
            for kind in np.float64, np.float32:
                start = points.astype(kind)
                moved = start.copy()
                self.assertEqual(planish.smooth(moved, {"quad": cells}, threads=1).n_inverted, 0)
                heights = planish.layer_heights(moved, {"quad": cells}, start=start).all
                self.assertTrue(0.89 < heights.min and heights.max < 1.11, heights)

    def test_a_result_stands_if_later_rounds_are_stopped(self):
        """With nodes held two elements are not repaired, so that the first result comes back."""
        path, times = self.layers_second(2, 20), [0.0]

        def stop_second(step):
            times.append(step.elapsed)
            return times[-1] < times[-2]

        whole, stopped = planish.read(path), planish.read(path)
        result = planish.smooth(whole, threads=1)
        self.assertEqual((result.stop, result.n_inverted), ("converged", 0))
        result = planish.smooth(stopped, threads=1, progress=stop_second)
        self.assertEqual((result.stop, result.n_inverted), ("interrupted", 0))
        np.testing.assert_array_equal(stopped.points, whole.points)

    def smooth_in_rounds(self, stop=(0, 0), wait=0, **keywords):
        """Smooth rows of quadrilaterals, up to a sweep of a round; wait so many seconds in the first sweep.

        Return the points, the result and the number of rounds.
        """
        points, cells = self.rows_of_quads(rows=32, thin=12, push=0.3, seed=2)
        elapsed = [np.inf]

        def progress(step):
            is_first = step.elapsed < elapsed[-1]
            elapsed.append(step.elapsed)
            n_rounds = (np.diff(elapsed) < 0).sum()
            time.sleep(wait if is_first and n_rounds == 1 else 0)
            return n_rounds == stop[0] and step.sweep >= stop[1]

        result = planish.smooth(points, {"quad": cells}, threads=1, max_sweeps=20, tolerance=0, progress=progress, **keywords)
        return points, result, (np.diff(elapsed) < 0).sum()

    def heights_of_rows(self, points):
        """Return the heights of layers of these rows of quadrilaterals."""
        start, cells = self.rows_of_quads(rows=32, thin=12, push=0.3, seed=2)
        return planish.layer_heights(points, {"quad": cells}, start=start).all

    def test_an_unfinished_round_stands_if_it_is_better(self):
        """A round that a signal ends stands if most of it was done, and its heights are better than those before."""
        _, result, last = self.smooth_in_rounds()
        self.assertGreater(last, 3)
        self.assertEqual((result.stop, result.sweeps), ("max-sweeps", 20))
        for stop in (2, 1), (last, 1):
            points, result, n_rounds = self.smooth_in_rounds(stop)
            self.assertEqual((result.stop, result.sweeps, n_rounds), ("interrupted", 20, stop[0]))
            self.assertGreater(self.heights_of_rows(points).max, 1.1)
        points, result, n_rounds = self.smooth_in_rounds((last, 12))
        self.assertEqual((result.stop, result.sweeps, n_rounds), ("interrupted", 12, last))
        heights = self.heights_of_rows(points)
        self.assertTrue(0.9 < heights.min and heights.max < 1.1, heights)

    def test_a_round_without_time_does_not_begin(self):
        first, _, _ = self.smooth_in_rounds((2, 1))
        points, result, n_rounds = self.smooth_in_rounds(wait=2.2, time_limit=3)
        self.assertEqual((result.stop, result.sweeps, n_rounds), ("time-limit", 20, 1))
        np.testing.assert_array_equal(points, first)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_tilted_planes_have_the_programs_bytes(self):
        """Rounding in a tilted plane, of doubles and of floats, breaks no promise."""
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        for kind, amount in (("quad", 0.2), ("quad", 0.7), ("triangle", 0.3), ("triangle", 0.7)):
            flat, cells = (box(2, 8, amount) if kind == "triangle" else elements.Elements().grid(kind, 8, amount))[:2]
            flat = np.column_stack([flat[:, :2], np.zeros(len(flat))])
            path = self.write("tilted.vtk", flat @ turn, [(kind, cells)])
            floats = path.with_name("floats.vtk")
            floats.write_text(path.read_text().replace("double", "float"))
            for file in path, floats:
                for options, keywords in (([], {}), (["--objective", "worst"], {"objective": "worst"}),
                                          (["--keep-sizes"], {"keep_sizes": True})):
                    self.same_as_the_program(file, options, **keywords)

    def planes(self):
        """Yield a name, and rows of three unit vectors, for flat meshes of every plane."""
        yield "x y", np.eye(3)
        yield "z x", np.eye(3)[[2, 0, 1]]
        yield "y z", np.eye(3)[[1, 2, 0]]
        yield "x z", np.eye(3)[[0, 2, 1]]  # seen from behind
        for seed in range(3):
            yield f"tilted {seed}", np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]

    def same_as_the_file(self, path, points, blocks, **options):
        """Smooth the file at path, and arrays of the same points in space."""
        mesh, start = read(path), points.copy()
        self.assertEqual(mesh.dim, 2)
        expected = planish.smooth(mesh, **options)
        result = planish.smooth(points, blocks, **options)
        np.testing.assert_array_equal(points, mesh.space_points().astype(points.dtype), f"{path} {options}")
        self.assertEqual((result.stop, result.sweeps, result.n_moved_nodes),
                         (expected.stop, expected.sweeps, expected.n_moved_nodes))
        self.assertTrue((points != start).any())

    def test_arrays_in_any_plane(self):
        """Flat elements in a plane have the bits that they have in a file, and their boundary stays."""
        for name, axes in self.planes():
            for kind, amount in ("triangle", 0.25), ("quad", 0.4), ("triangle6", 0.1), ("triangle", 0.7):
                flat, cells, inside = box(2, 6, amount)
                if kind == "quad":
                    flat, cells, inside = elements.Elements().grid(kind, 6, amount)
                flat, n = flat[:, :2] * (1, 0.7), len(flat)
                if kind == "triangle6":
                    flat, cells = elements.raised(flat, cells, kind)
                shift = {"x y": 0, "tilted 1": 2000}.get(name, 4)
                points = np.column_stack([flat, np.zeros(len(flat))]) @ axes + shift
                blocks = {kind: cells}
                path = self.write("plane.vtk", points, blocks.items())
                again = points.copy()
                self.same_as_the_file(path, again, blocks)
                self.assertTrue((again == points)[:n][~inside].all(), f"{name} {kind}")
                for options in {"slide": "auto"}, {"objective": "worst", "slide": "auto", "max_sweeps": 5}, {"fix": [7]}:
                    self.same_as_the_file(path, points.copy(), blocks, **options)
                if np.abs(points).max() > 100:  # where floats are off the plane
                    continue
                path.write_text(path.read_text().replace("double", "float"))
                self.same_as_the_file(path, points.astype(np.float32), blocks)
                self.same_as_the_file(path, points.astype(np.float32), blocks, slide="auto")

    def test_options_in_any_plane(self):
        """Other places of the mesh, boxes, measures, progress and errors."""
        flat, cells, inside = box(2, 6, 0.25)
        flat = np.column_stack([flat, np.zeros(len(flat))])
        for name, axes in list(self.planes())[1:]:
            points = flat @ axes
            path, like = (self.write(file, x, [("triangle", cells)]) for file, x in (("plane.vtk", points),
                                                                                   ("like.vtk", 1.1 * flat)))
            first = read(path)
            planish.smooth(first, like=like)
            again = points.copy()
            planish.smooth(again, cells, like=1.1 * flat)
            np.testing.assert_array_equal(again, first.space_points(), name)
            self.same_as_the_file(path, points.copy(), cells, keep_sizes=True)
            with self.assertRaisesRegex(ValueError, "like|compare"):
                planish.smooth(points.copy(), cells, like=flat[:, :2].copy())
            with self.assertRaisesRegex(ValueError, "matrices are for a plane of constant z"):
                planish.smooth(points.copy(), cells, size=np.tile(np.eye(2), (len(points), 1, 1)))
            if name.startswith("tilted"):
                self.assertRaisesRegex(ValueError, "tilted plane", planish.smooth, points, cells, box=[0, 0, 3, 3])
                self.assertRaisesRegex(ValueError, "tilted plane", planish.Plan, points, cells)
            else:
                self.same_as_the_file(path, points.copy(), cells, box=[0, 0, 4, 3.5])
                again = points.copy()
                with planish.Plan(points.copy(), cells) as plan:
                    plan.smooth(again)
                    with self.assertRaisesRegex(ValueError, "columns"):
                        plan.smooth(flat[:, :2].copy())
                    with self.assertRaisesRegex(ValueError, "left the plane"):
                        plan.smooth(points @ np.linalg.qr(np.arange(9).reshape(3, 3) + np.eye(3))[0])
                planish.smooth(points, cells)
                np.testing.assert_array_equal(again, points)
                points = flat @ axes
            seen: list = []

            def progress(step, seen=seen):
                if step.sweep_done:
                    seen.append(step.points())
                    return 1 // (len(seen) < 2) > 1
                return False

            again, start = points.copy(), points.copy()
            self.assertRaises(ZeroDivisionError, planish.smooth, again, cells, progress=progress)
            np.testing.assert_array_equal(again, seen[-1])
            self.assertTrue((again[inside] != start[inside]).any(axis=1).mean() > 0.9)
            again.flags.writeable = False
            self.assertRaisesRegex(ValueError, "read-only", planish.smooth, again, cells)
            self.assertRaises(ValueError, planish.smooth, points, cells, tolerance=2)
            np.testing.assert_array_equal(points, start)
            a, b = planish.quality(points, cells), planish.quality(flat[:, :2].copy(), cells)
            self.assertAlmostEqual(a.rms_radius_ratio, b.rms_radius_ratio, 10)
            self.assertEqual((planish.find_slides(points, cells).constraint == 1).sum(), 4)
        with self.assertRaisesRegex(ValueError, "near one line"):
            planish.smooth(flat * (1, 0, 0) @ axes, cells)
        raised = flat @ axes
        raised[3] += 0.01 * axes[2]
        planish.smooth(raised, cells)
        with self.assertRaisesRegex(ValueError, "must lie in a plane"):
            planish.Plan(raised, cells)

    def test_arrays_of_a_mesh(self):
        mesh = read(DATA / "ascii41.msh")
        self.assertEqual((mesh.format, mesh.dim, mesh.is_in_space, mesh.plane()), ("gmsh", 3, False, None))
        self.assertEqual(sorted(mesh.region_names.values()), ["lower part", "upper part"])
        self.assertEqual(set(mesh.region_names), set(np.unique(mesh.regions).tolist()))
        cells = mesh.cells
        self.assertEqual({name: nodes.shape[1] for name, nodes in cells.items()}, {"tetra": 4})
        self.assertEqual(mesh.groups, [(2, "skin"), (3, "lower part"), (3, "upper part")])
        for _dim, tag in mesh.groups:
            self.assertTrue(mesh.held(fix=tag)["fix"].any(), tag)
        held = mesh.held(fix="upper part")
        self.assertEqual(set(held), {"faces_inside", "interface", "fix"})
        nodes = np.unique(cells["tetra"][mesh.regions == {n: k for k, n in mesh.region_names.items()}["upper part"]])
        np.testing.assert_array_equal(np.flatnonzero(held["fix"]), nodes)
        self.assertEqual(mesh.element_number(0), int(mesh.element_number(1)) - 1)
        with self.assertRaises(IndexError):
            mesh.node_number(len(mesh.points))
        self.assertFalse(mesh.layout().nodes.flags.writeable)
        self.assertEqual(planish.quality(mesh).as_dict(), planish.quality(
            mesh.points, cells, fix=mesh.held()["faces_inside"] | mesh.held()["interface"]).as_dict())
        for way in copy.copy, pickle.dumps:
            self.assertRaises(TypeError, way, mesh)
        self.assertIn("ascii41.msh", repr(mesh))
        self.assertIn("tetra", str(mesh))
        self.assertIn("<table>", mesh._repr_html_())

    def test_arrays_outlive_the_mesh(self):
        points = read(DATA / "ascii41.msh").points
        total = points.sum()
        gc.collect()
        junk = [np.random.default_rng(1).normal(size=len(points) * 3) for _ in range(20)]
        self.assertEqual(points.sum(), total)
        self.assertEqual(len(junk), 20)

    def test_data(self):
        points, cells, _ = box(3)
        path = self.write("data.vtk", points, [("tetra", cells)])
        self.write_data(path, "T", points[:, 0])
        mesh = planish.read(path)
        self.assertEqual(mesh.data_arrays, ["T"])
        values, of_elements = mesh.data("T")
        self.assertFalse(of_elements)
        np.testing.assert_array_equal(values[:, 0], points[:, 0])

    def test_meshio_order_of_wedges(self):
        points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], dtype=float)
        path = self.write("wedge.vtk", points, [("wedge", np.array([[0, 2, 1, 3, 5, 4]]))])
        mesh = planish.read(path)
        np.testing.assert_array_equal(mesh.cells["wedge"], [[0, 2, 1, 3, 5, 4]])
        self.assertEqual(planish.quality(mesh.points, mesh.cells).cells.all.n_inverted, 0)

    def test_unchanged_meshes_keep_their_bytes(self):
        for name in LOSSLESS:
            with self.subTest(name):
                out = (self.folder / name).with_name("out" + pathlib.Path(name).suffix)
                planish.write(read(DATA / name), out)
                self.assertEqual(contents(out), contents(DATA / name))
                subprocess.run(["rm", "-r", out], check=True)

    @unittest.skipIf(not PROGRAM, "without the program")
    def test_conversion_tells_what_is_lost(self):
        mesh = read(DATA / "ascii41.msh")
        for name in ("out.vtu", "out.mesh", "out.stl"):
            with self.assertWarnsRegex(planish.ConversionWarning, name + " lacks .") as caught:
                mesh.write(self.folder / name)
            self.assertEqual(pathlib.Path(caught.filename).name, "files.py")
            with self.assertWarns(planish.ConversionWarning) as caught:
                planish.write(mesh, self.folder / name)
            self.assertEqual(pathlib.Path(caught.filename).name, "files.py")
            subprocess.run([PROGRAM, "convert", DATA / "ascii41.msh", self.folder / ("program" + name), "-q"],
                           check=True)
            self.assertEqual(contents(self.folder / name), contents(self.folder / ("program" + name)))
        self.assertIn("vtu", [format.name for format in planish.formats() if format.is_target])
        known = {extension: format.name for format in planish.formats() for extension in format.extensions}
        self.assertEqual((known[".msh"], known[".vtu"]), ("gmsh", "vtu"))

    def test_one_choice_of_regions(self):
        points, cells, _ = box(3)
        path = self.write("regions.vtk", points, [("tetra", cells)])
        middle = np.round(points[:, 0]) == 3
        self.write_data(path, "zone", np.where(np.round(points[cells]).min(axis=1)[:, 0] >= 3, 1, 0), "CELL")
        mesh = planish.read(path)
        self.assertEqual(mesh.region_arrays, ["zone"])
        for regions in "zone", ["zone"]:
            mesh = planish.read(path)
            with planish.Plan(mesh, regions=regions) as plan:
                self.assertEqual(plan.region_arrays, ["zone"])
                self.assertFalse(plan.free()[middle].any())
            with planish.Plan(mesh, regions=None) as plan:
                self.assertTrue(plan.free()[middle].any())
            with self.assertRaisesRegex(ValueError, "read it again"):
                planish.smooth(mesh, regions=["other"])
        with self.assertRaisesRegex(planish.Error, "zone"):
            planish.smooth(planish.read(path), regions=["other"])

    def test_plans_of_files(self):
        mesh = read(DATA / "ascii41.msh")
        moved = mesh.points.copy()
        with planish.Plan(mesh, fix=[0, 1]) as plan:
            plan.smooth(moved)
            self.assertTrue((moved != mesh.points).any())
            plan.smooth()
            np.testing.assert_array_equal(moved, mesh.points)

    def test_refusals(self):
        missing = self.folder / "missing.msh"
        for error in OSError, ValueError, planish.FileError, FileNotFoundError:
            with self.assertRaisesRegex(error, "^[^\\[]*missing.msh: .*No such file") as raised:
                planish.read(missing)
            self.assertEqual((raised.exception.errno, raised.exception.filename), (errno.ENOENT, str(missing)))
        mesh = read(DATA / "ascii41.msh")
        start = mesh.points.copy()
        with self.assertRaisesRegex(planish.Error, "upper part"):  # it lists those that there are
            planish.smooth(mesh, fix=["wall"])
        for name in "out.xyz", "out":  # extensions of no format, as where such a file is read
            with self.assertRaisesRegex(planish.FileError, "does not have an extension"):
                mesh.write(self.folder / name)
            with self.assertRaisesRegex(OSError, name):
                planish.write(mesh, self.folder / name)
        with self.assertRaisesRegex(planish.FileError, "nowhere"):
            mesh.write("/nowhere/out.msh")
        with self.assertRaisesRegex(planish.Error, "formats|known|unknown"):
            planish.read(DATA / "ascii41.msh", format="nothing")
        with self.assertRaisesRegex(ValueError, "names of arrays"):
            planish.smooth(mesh, regions=np.zeros(3, dtype=int))
        with self.assertRaisesRegex(ValueError, "other nodes or elements"):
            planish.smooth(mesh, like=planish.read(DATA.parents[1] / "docs" / "examples" / "bracket.msh"))
        np.testing.assert_array_equal(mesh.points, start)
        for damaged in DATA.glob("damaged.med" if QUICK else "damaged*.med"):  # one takes seconds: tests/io/test_child.c
            with self.assertRaises(planish.FileError):
                planish.read(damaged)
        copied = pickle.loads(pickle.dumps(planish.FileError("text", -4, 1, 2)))
        self.assertEqual((str(copied), copied.code, copied.element, copied.node), ("text", -4, 1, 2))

    def test_nobody_can_swap_the_points(self):
        mesh = read(DATA / "ascii41.msh")
        with self.assertRaises(AttributeError):
            mesh.points = mesh.points.copy()


if __name__ == "__main__":
    warnings.simplefilter("error", planish.ConversionWarning)
    unittest.main()
