"""Tests of the Python module."""

import copy
import ctypes
import itertools
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
from unittest import mock

import numpy as np

import planish
from planish import _library, _run

try:
    import meshio
except ImportError:
    meshio = None

PROGRAM = os.environ.get("PLANISH_PROGRAM")
QUICK = bool(os.environ.get("PLANISH_QUICK"))  # long tests leave the rest to tools/check --full


def box(dim, cells=6, amount=0.14, seed=1):
    """Points and cells of a box of unit cubes (squares) whose inner nodes are off their places."""
    n = cells + 1
    points = np.array(list(itertools.product(range(n), repeat=dim)), dtype=float)
    found = []
    for corner in itertools.product(range(cells), repeat=dim):
        for order in itertools.permutations(range(dim)):
            at = np.array(corner)
            path = [at.copy()]
            for axis in order:
                at[axis] += 1
                path.append(at.copy())
            found.append([int(np.ravel_multi_index(tuple(p), (n,) * dim)) for p in path])
    inside = np.all((points > 0) & (points < cells), axis=1)
    random = np.random.default_rng(seed)
    points[inside] += random.uniform(-amount, amount, (inside.sum(), dim))
    return points, np.array(found, dtype=np.int32), inside


def smooth_box(seed):
    """Of more nodes than one thread is worth."""
    points, cells, _ = box(2, cells=60, amount=0.3, seed=seed)
    before = planish.quality(points, cells).rms_radius_ratio
    return bool(planish.find_layers(points, cells).any()), planish.smooth(points, cells).rms < before


class Processes(unittest.TestCase):
    """Children of a fork, in a process of their own: one that hangs is ended."""

    @unittest.skipUnless(hasattr(os, "fork"), "there is no fork")
    def test_children_of_a_fork(self):
        text = ("import multiprocessing, sys; sys.path.insert(0, %r); import module\n"
                "module.smooth_box(1)\n"
                "with multiprocessing.get_context('fork').Pool(2) as pool:\n"
                "    assert pool.map(module.smooth_box, range(2)) == [(False, True)] * 2\n"
                "points, cells, _ = module.box(2, cells=60)\n"
                "plan = module.planish.Plan(points, cells, threads=2)\n"
                "if module.os.fork() == 0:\n"
                "    try:\n"
                "        plan.smooth()\n"
                "    except RuntimeError:\n"
                "        module.os._exit(0)\n"
                "    module.os._exit(1)\n"
                "sys.exit(module.os.wait()[1] != 0)\n" % str(pathlib.Path(__file__).parent))
        done = subprocess.run([sys.executable, "-c", text], timeout=120, check=False,
                              env=dict(os.environ, OMP_NUM_THREADS="2"))
        self.assertEqual(done.returncode, 0)

    def test_a_wrong_library_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, code in (("other", "int other(void) { return 0; }"),
                               ("later", 'const char *planish_version(void) { return "0.3.0"; }'),
                               ("files", 'const char *planish_io_version(void) { return "0.3.0"; }')):
                source, library = (os.path.join(folder, name + end) for end in (".c", ".so"))
                pathlib.Path(source).write_text(code)
                subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library], check=True)
                done = subprocess.run([sys.executable, "-c", "import planish"], check=False, text=True,
                                      stderr=subprocess.PIPE, env=dict(os.environ, PLANISH_LIBRARY=library))
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("ImportError", done.stderr)
                self.assertRaises(OSError, _library._open, "planish_io", library)


class Smoothing(unittest.TestCase):
    def test_in_place(self):
        for dim, kind in itertools.product((2, 3), (np.int32, np.int64)):
            points, cells, inside = box(dim)
            start, address = points.copy(), points.ctypes.data
            before = planish.quality(points, cells)
            result = planish.smooth(points, cells.astype(kind))
            after = planish.quality(points, cells)
            self.assertEqual(points.ctypes.data, address)
            self.assertEqual(result.stop, "converged")
            self.assertLess(after.rms_radius_ratio, before.rms_radius_ratio)
            self.assertLessEqual(after.max_radius_ratio, before.max_radius_ratio)
            self.assertAlmostEqual(result.rms, after.rms_radius_ratio, 12)
            np.testing.assert_array_equal(points[~inside], start[~inside])
            self.assertEqual(result.n_moved_nodes, (points != start).any(axis=1).sum())

    def test_plans_are_not_copied(self):
        points, cells, _ = box(2)
        with planish.Plan(points, cells) as plan:
            for way in copy.copy, copy.deepcopy, pickle.dumps:
                self.assertRaises(TypeError, way, plan)
            self.assertEqual(plan.smooth().stop, "converged")

    def test_integers_have_a_range(self):
        points, cells, _ = box(2)
        for options in {"threads": 2**32 + 1}, {"rings": 2**32}, {"max_sweeps": 2**32}:
            self.assertRaises(ValueError, planish.smooth, points, cells, **options)
        wide = cells.astype(np.uint64)
        wide[0, 0] = 2**64 - 1
        self.assertRaisesRegex(ValueError, "out of range", planish.smooth, points, wide)

    def test_noise_of_a_plane(self):
        points, cells, _ = box(2)
        points = np.column_stack([points, np.full(len(points), 2.0)])
        points[3, 2] += 1e-9
        self.assertEqual(planish.smooth(points, cells).stop, "converged")
        points[3, 2] += 1e-3
        self.assertRaises(ValueError, planish.Plan, points, cells)
        self.assertEqual(planish.smooth(points, cells, untangle=False).stop, "converged")  # as a surface in space

    def test_layouts_have_the_same_bits(self):
        points, cells, _ = box(3)
        expected = points.copy()
        planish.smooth(expected, cells)
        n = len(points)
        padded = np.full((n, 4), 7.0)
        padded[:, :3] = points
        planish.smooth(padded, cells)
        np.testing.assert_array_equal(padded[:, :3], expected)
        self.assertTrue((padded[:, 3] == 7).all())
        columns = np.asfortranarray(points)
        planish.smooth(columns, cells)
        np.testing.assert_array_equal(columns, expected)
        every_second = np.zeros((2 * n, 3))
        every_second[::2] = points
        planish.smooth(every_second[::2], cells)
        np.testing.assert_array_equal(every_second[::2], expected)
        self.assertTrue((every_second[1::2] == 0).all())
        backward = points[::-1].copy()[::-1]
        planish.smooth(backward, cells)
        np.testing.assert_array_equal(backward, expected)
        self.assertEqual(planish.checksum(padded, cells), planish.checksum(expected, cells))
        self.assertNotEqual(planish.checksum(points, cells), planish.checksum(expected, cells))

    def test_floats_stay_floats(self):
        points, cells, _ = box(3)
        single = points.astype(np.float32)
        before = planish.quality(single, cells)
        planish.smooth(single, cells)
        self.assertEqual(single.dtype, np.float32)
        self.assertLess(planish.quality(single, cells).rms_radius_ratio, before.rms_radius_ratio)
        self.assertEqual(planish.quality(single, cells).n_inverted, 0)

    def test_triangles_in_three_columns(self):
        flat, cells, _ = box(2)
        points = np.column_stack([flat, np.full(len(flat), 5.0)])
        planish.smooth(points, cells)
        planish.smooth(flat, cells)
        np.testing.assert_array_equal(points[:, :2], flat)
        self.assertTrue((points[:, 2] == 5).all())
        points[3, 2] = 6
        with self.assertRaisesRegex(ValueError, "must lie in a plane"):
            planish.Plan(points, cells)

    def test_options(self):
        points, cells, inside = box(3)
        fixed = np.flatnonzero(inside)[::2]
        start = points.copy()
        planish.smooth(points, cells, fix=fixed)
        np.testing.assert_array_equal(points[fixed], start[fixed])
        mask = np.zeros(len(points), dtype=bool)
        mask[fixed] = True
        masked = start.copy()
        planish.smooth(masked, cells, fix=mask)
        np.testing.assert_array_equal(points, masked)
        of_set = start.copy()
        planish.smooth(of_set, cells, fix=set(fixed.tolist()))
        np.testing.assert_array_equal(points, of_set)

        none, all_of_them = start.copy(), start.copy()
        planish.smooth(none, cells, fix=[])
        planish.smooth(all_of_them, cells)
        np.testing.assert_array_equal(none, all_of_them)
        mask[:] = False
        mask[fixed[0]] = True
        some, few = start.copy(), start.copy()
        planish.smooth(some, cells, around=mask)
        planish.smooth(few, cells, around=fixed[:1].astype(np.uint8))
        np.testing.assert_array_equal(some, few)

        worst = start.copy()
        result = planish.smooth(worst, cells, objective="worst", worst_measure="dihedral")
        self.assertGreater(result.worst_sweeps, 0)
        self.assertGreaterEqual(result.worst_after, result.worst_before)

        one = start.copy()
        result = planish.smooth(one, cells, max_sweeps=1)
        self.assertEqual((result.stop, result.sweeps), ("max-sweeps", 1))

        node = int(np.flatnonzero(inside)[5])
        local = start.copy()
        result = planish.smooth(local, cells, around=[node])
        self.assertEqual(np.flatnonzero((local != start).any(axis=1)).tolist(), [node])

        low = start.copy()
        least = np.full(len(cells), 0.1)
        result = planish.smooth(low, cells, min_volume=least)
        self.assertEqual(result.n_below_min_volume, 0)
        with self.assertRaisesRegex(ValueError, "one value for each of"):
            planish.smooth(start.copy(), cells, min_volume=least[1:])

    def test_tangled(self):
        points, cells, inside = box(2, amount=0.8)
        before = planish.quality(points, cells)
        self.assertGreater(before.n_inverted, 0)
        self.assertEqual(planish.smooth(points, cells).n_inverted, 0)

    def test_threads_have_the_same_bits(self):
        points, cells, _ = box(3)
        results = []
        for threads in (1, 2, 3):
            copy = points.copy()
            planish.smooth(copy, cells, threads=threads)
            results.append(copy)
        np.testing.assert_array_equal(results[0], results[1])
        np.testing.assert_array_equal(results[0], results[2])


class Plans(unittest.TestCase):
    def test_many_positions(self):
        points, cells, inside = box(3)
        with planish.Plan(points, cells) as plan:
            np.testing.assert_array_equal(plan.free(), inside)
            for seed in range(3):
                other, _, _ = box(3, seed=seed)
                alone = other.copy()
                before = plan.quality(other).rms_radius_ratio
                plan.smooth(other)
                planish.smooth(alone, cells)
                np.testing.assert_array_equal(other, alone)
                self.assertLess(plan.quality(other).rms_radius_ratio, before)
            columns, padded = np.asfortranarray(points), np.zeros((len(points), 4))
            padded[:, :3] = points
            planish.smooth(points, cells)
            plan.smooth(columns)
            plan.smooth(padded)
            np.testing.assert_array_equal(columns, points)
            np.testing.assert_array_equal(padded[:, :3], points)
            with self.assertRaisesRegex(ValueError, "rows"):
                plan.smooth(points[1:])
            ratios, found = plan.radius_ratios(padded), plan.quality(padded)
            self.assertEqual(ratios.shape, (len(cells),))
            self.assertAlmostEqual(ratios.max(), found.max_radius_ratio)
            self.assertAlmostEqual(np.sqrt((ratios**2).mean()), found.rms_radius_ratio)
            cells[:] = -1  # the plan has its own
            frozen = points.copy()
            frozen.flags.writeable = False
            self.assertEqual(plan.quality(frozen).n_inverted, 0)
            with self.assertRaisesRegex(ValueError, "read-only"):
                plan.smooth(frozen)
            plan.smooth(points)
        for call in (plan.smooth, plan.quality, plan.radius_ratios, plan.free):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()
        plan.close()

    def test_progress(self):
        points, cells, _ = box(3)
        seen = []
        start = points.copy()
        planish.smooth(points, cells, progress=seen.append)
        self.assertGreater(len(seen), 5)
        self.assertLess(seen[-1].rms, seen[0].rms)
        self.assertEqual((seen[0].sweep, seen[0].colour), (1, 1))
        stopped = start.copy()
        result = planish.smooth(stopped, cells, progress=lambda p: p.sweep_done)
        self.assertEqual((result.stop, result.sweeps), ("interrupted", 1))

        with planish.Plan(start.copy(), cells) as plan:
            values = []
            plan.smooth(progress=lambda p: values.append(plan.quality().n_inverted))
            self.assertEqual(set(values), {0})
            for call in (plan.close, plan.smooth):
                with self.assertRaisesRegex(RuntimeError, "at work"):
                    plan.smooth(progress=lambda p: call())

        def fail(progress):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            planish.smooth(start.copy(), cells, progress=fail)

        class Seen(list):  # empty, so not true
            __call__ = list.append

        seen = Seen()
        planish.smooth(start.copy(), cells, progress=seen)
        self.assertGreater(len(seen), 5)

    def test_points_in_progress(self):
        """Positions at the end of each sweep, whatever the array of points is like, are those of the figures."""
        for dim in 2, 3:
            start, cells, _ = box(dim, amount=0.3)
            wide = np.zeros((len(start), dim + 2))
            wide[:, :dim] = start
            for points in (start.copy(), np.asfortranarray(start), start.astype(np.float32), wide[:, :dim]):
                given, sweeps, kept = points.copy(), [], []

                def look(seen):
                    kept.append(seen)
                    if not seen.sweep_done:
                        self.assertRaisesRegex(ValueError, "sweep_done", seen.points)
                        return
                    now = seen.points()
                    self.assertEqual((now.shape, now.dtype), (points.shape, np.float64))
                    self.assertAlmostEqual(planish.quality(now, cells).rms_radius_ratio, seen.rms, 6)
                    np.testing.assert_array_equal(points, given)
                    sweeps.append(now)

                result = planish.smooth(points, cells, progress=look)
                self.assertEqual(len(sweeps), result.sweeps)
                self.assertGreater(len(sweeps), 2)
                self.assertTrue((sweeps[0] != given).any() and (sweeps[0] != sweeps[1]).any())
                np.testing.assert_array_equal(sweeps[-1], points)
                for seen in kept:
                    self.assertRaisesRegex(ValueError, "while progress is called", seen.points)

    def test_points_of_a_surface_in_progress(self):
        i, j = (index.ravel() for index in np.meshgrid(np.arange(24), np.arange(12), indexing="ij"))
        points = np.column_stack([np.cos(np.pi * i / 12), np.sin(np.pi * i / 12), j / 8])  # of a tube
        inner = (j > 0) & (j < 11)
        points[inner, 2] += np.random.default_rng(3).uniform(-0.03, 0.03, inner.sum())
        quads = np.array([[12 * a + b, 12 * ((a + 1) % 24) + b, 12 * ((a + 1) % 24) + b + 1, 12 * a + b + 1]
                          for a in range(24) for b in range(11)])
        start, sweeps = points.copy(), []

        def look(seen):
            if seen.sweep_done:
                sweeps.append(seen.points())

        planish.smooth(points, {"quad": quads}, progress=look)
        self.assertTrue((sweeps[-1] != start).any())
        np.testing.assert_array_equal(sweeps[-1], points)

    @unittest.skipUnless(hasattr(signal, "setitimer"), "there are no timers")
    def test_signals_end_it(self):
        """A handler's exception may come before the first line of what the library calls."""
        class Late(Exception):
            pass

        def handler(_number, _frame):
            raise Late

        points, cells, _ = box(3, cells=14)
        before, hook = signal.signal(signal.SIGALRM, handler), sys.unraisablehook
        try:
            with planish.Plan(points, cells, threads=1) as plan:
                for k in range(12):
                    moved = points.copy()
                    with self.assertRaises(Late):
                        signal.setitimer(signal.ITIMER_REAL, 0.002 + 0.001 * k)
                        plan.smooth(moved, tolerance=0, progress=lambda seen: None)
                        time.sleep(1)  # that was soon done
                    self.assertEqual(plan.quality(moved).n_inverted, 0)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        self.assertIs(sys.unraisablehook, hook)

    def test_exceptions_outside_progress(self):
        """Those of its watch alone are kept, whether Python names the function that raised them or not."""
        class Late:
            """Raises in the first line of a watch, as a signal's handler may."""

            def __bool__(self):
                raise KeyboardInterrupt

        mine, other, passed = _run._Watch(None, None), _run._Watch(None, None), []
        mine.hook = other.hook = passed.append
        mine.raised = Late()
        try:
            mine(None, None)
        except KeyboardInterrupt as exception:
            trace = exception.__traceback__.tb_next  # without this function
            told = types.SimpleNamespace(object=None, exc_value=exception, exc_traceback=trace)
            mine.raised = []
            mine.note(told)
            other.note(told)
        other.note(types.SimpleNamespace(object=None, exc_value=KeyboardInterrupt(), exc_traceback=None))
        self.assertEqual((mine.raised, other.raised, len(passed)), ([told.exc_value], [], 2))
        self.assertIs(passed[0], told)

    def test_every_option_has_its_effect(self):
        points, cells, inside = box(3, amount=0.14)
        plain = points.copy()
        usual = planish.smooth(plain, cells)

        def run(start=points, **options):
            moved = start.copy()
            result = planish.smooth(moved, cells, **options)
            return result, planish.quality(moved, cells), moved

        self.assertEqual(run(time_limit=1e-9)[0].stop, "time-limit")
        self.assertEqual(run(max_sweeps=1)[0].stop, "max-sweeps")
        near = run(max_displacement=0.01)
        self.assertLessEqual(np.linalg.norm(near[2] - points, axis=1).max(), 0.01 * (1 + 1e-12))
        self.assertGreater(usual.max_displacement, 0.02)
        self.assertEqual(run(min_volume=0.1)[0].min_volume, 0.1)
        self.assertGreater(run(min_volume=0.1)[1].min_volume, 0.0996)
        self.assertLess(planish.quality(points, cells).min_volume, 0.0996)
        part = run(min_volume_fraction=1e-4)[0].min_volume
        self.assertAlmostEqual(part, 1e-4 * 6 ** 3, 12)
        even = [run(min_volume=0.1, area_weight=w)[1].rms_radius_ratio for w in (0, 0.9)]
        self.assertGreater(even[1], even[0])  # which is not all that counts then
        tangled = points.copy()
        tangled[np.flatnonzero(inside)[50]] += 1.5
        self.assertGreater(run(tangled, untangle=False)[1].n_inverted, 0)
        self.assertEqual(run(tangled)[1].n_inverted, 0)
        hard = {"objective": "worst", "fix": np.flatnonzero(inside)[::4]}
        worst = [run(worst_rise=rise, **hard)[1] for rise in (1e-5, 0.1)]
        self.assertGreater(worst[1].min_angle_deg, worst[0].min_angle_deg + 1)
        self.assertGreater(worst[1].rms_radius_ratio, worst[0].rms_radius_ratio)
        by_angle, by_ratio = (run(worst_measure=measure, worst_rise=0.1, **hard)[1]
                              for measure in ("dihedral", "radius-ratio"))
        self.assertGreater(by_angle.min_angle_deg, by_ratio.min_angle_deg)
        self.assertLess(by_ratio.max_radius_ratio, by_angle.max_radius_ratio)
        by_mean, by_edge = (run(objective=name)[1] for name in ("mean-ratio", "edge-ratio"))
        self.assertGreater(by_mean.mean_ratio.mean, by_edge.mean_ratio.mean)
        self.assertLess(by_edge.edge_ratio.mean, by_mean.edge_ratio.mean)
        self.assertLess(run(tolerance=0.1)[0].sweeps, run(tolerance=1e-9)[0].sweeps)
        few = [run(only_worse_than=1.9, rings=rings)[0].n_moved_nodes for rings in (0, 1)]
        self.assertTrue(0 < few[0] < few[1] < usual.n_moved_nodes)
        self.assertEqual(planish.quality(points, cells, fix=range(len(points))).n_fixed_elements, len(cells))

    def test_several_threads(self):
        meshes = [box(3, seed=seed) for seed in range(4)]
        copies = [points.copy() for points, _, _ in meshes]
        workers = [
            threading.Thread(target=planish.smooth, args=(copy, mesh[1]))
            for copy, mesh in zip(copies, meshes)
        ]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for copy, (points, cells, _) in zip(copies, meshes):
            planish.smooth(points, cells)
            np.testing.assert_array_equal(copy, points)

    def test_layers_are_found(self):
        points, cells, _ = box(3, amount=0)
        self.assertFalse(planish.find_layers(points, cells).any())
        low = points[cells][:, :, 2].max(axis=1) <= 2
        points[:, 2] *= np.where(points[:, 2] <= 2, 0.1, 1)
        np.testing.assert_array_equal(planish.find_layers(points, cells, threads=2), low)
        self.assertEqual(planish.layer_heights(points, cells).all.min, 1)
        self.assertEqual(planish.layer_heights(*box(3, amount=0)[:2]).all.n, 0)

    def test_values_are_shown(self):
        points, cells, _ = box(2)
        quality = planish.quality(points, cells)
        self.assertIn("rms_radius_ratio=", repr(quality))
        values = quality.as_dict()
        self.assertEqual(values["n_elements"], len(cells))
        self.assertEqual(sum(values["histogram_counts"]), len(cells))
        self.assertEqual(sum(values["angle_counts"]), len(cells))
        self.assertEqual(values["angle_edges_deg"][-1], 75)
        self.assertNotIn("reserved", values)
        self.assertEqual(planish.smooth(points, cells).as_dict()["stop"], "converged")
        self.assertGreater(values["smallest_angle_deg"]["min"], 0)
        self.assertEqual(planish.version(), "0.2.0")
        self.assertEqual(planish.__version__, "0.2.0")


class Refusals(unittest.TestCase):
    def refuse(self, error, text, *arguments, **options):
        with self.assertRaisesRegex(error, text):
            planish.smooth(*arguments, **options)

    def test_wrong_arrays(self):
        points, cells, _ = box(3, 3)
        self.refuse(TypeError, "array of numpy", points.tolist(), cells)
        self.refuse(TypeError, "float64 or float32", points.astype(int), cells)
        self.refuse(ValueError, "columns", points[:, :2].copy(), cells)
        self.refuse(ValueError, r"\[m, 3\]", points, cells[:, :2])
        self.refuse(TypeError, "integers", points, cells.astype(float))
        frozen = points.copy()
        frozen.flags.writeable = False
        self.refuse(ValueError, "read-only", frozen, cells)
        self.refuse(planish.Error, "no elements", points, cells[:0])
        self.refuse(TypeError, "meshio or pyvista", points)
        self.refuse(ValueError, "objective must be", points, cells, objective="best")
        self.refuse(ValueError, "worst_measure must be", points, cells, worst_measure="x")
        self.refuse(TypeError, "unexpected keyword argument .sweeps.", points, cells, sweeps=3)
        self.refuse(planish.Error, "n_around is 0", points, cells, around=[])
        self.refuse(ValueError, "fix has a number", points, cells, fix=[-1])
        self.refuse(ValueError, "around has a number", points, cells, around=[len(points)])
        self.refuse(TypeError, "fix must be numbers", points, cells, fix=[0.5])
        self.refuse(ValueError, "fix is a mask", points, cells, fix=np.ones(3, dtype=bool))
        self.refuse(TypeError, "slide must be auto", points, cells, slide=True)
        self.refuse(ValueError, "objective must be", points, cells, objective="")
        for options in ({"rings": 1}, {"slide_tolerance": 1e-3}, {"worst_measure": "dihedral"}, {"worst_rise": 0.1},
                        {"surface_tolerance": 0.01}, {"surface_tolerance": "0.1h", "slide": "auto"}):
            self.refuse(ValueError, "has no effect without", points, cells, **options)
        self.refuse(ValueError, "regions: array 'regions' has not one", points, cells, regions=False)
        self.refuse(TypeError, "like must be an array", points, cells, like=points.tolist())
        with self.assertRaisesRegex(ValueError, "start is where"):
            planish.quality(points, cells, start=points)
        with self.assertRaisesRegex(TypeError, "meshes of planish.read, not ndarray"):
            planish.write(points, "out.vtk")

    def test_curved_in_a_plane(self):
        """A mesh in a plane has no curved surface: the error says what to give."""
        points, cells, _ = box(2, 3)
        flat, start = np.column_stack([points, np.zeros(len(points))]), points.copy()
        advice = "lies in a plane, which has no curved surface: use slide='auto'"
        for given in points, flat:
            for slide in "curved", ["curved"]:
                self.refuse(ValueError, advice, given, cells, slide=slide)
                self.refuse(ValueError, advice, given, cells, slide=slide, objective="worst", surface_of=given)
            self.assertRaisesRegex(ValueError, advice, planish.Plan, given, cells, slide="curved")
            self.assertRaisesRegex(ValueError, advice, planish.find_slides, given, cells, surface_of=given)
        np.testing.assert_array_equal(points, start)
        self.assertEqual(planish.smooth(points, cells, slide="auto", objective="worst").n_inverted, 0)

    def test_masked_values_are_refused(self):
        """The library would take the numbers behind the mask."""
        points, cells, _ = box(3, 3)
        start = points.copy()

        def masked(values):
            return np.ma.masked_array(values, np.arange(np.size(values)).reshape(np.shape(values)) == 40)

        for given in (masked(points), cells), (masked(points.astype(np.float32)), cells):
            self.refuse(ValueError, "points has masked values", *given)
            self.assertTrue(given[0].mask.any())
        self.refuse(ValueError, "cells has masked values", points, masked(cells))
        self.refuse(ValueError, "type tetra has masked values", points, {"tetra": masked(cells)})
        for name, values in (("fix", np.arange(50)), ("around", np.arange(50)), ("size", np.ones(len(points))),
                             ("min_volume", np.ones(len(cells))), ("regions", np.ones(len(cells))), ("like", points)):
            self.refuse(ValueError, f"{name} has masked values", points, cells, **{name: masked(values)})
        np.testing.assert_array_equal(points, start)
        whole = np.ma.masked_array(points.copy())
        planish.smooth(whole, cells)
        planish.smooth(points, cells)
        np.testing.assert_array_equal(whole.data, points)

    def test_errors_say_where(self):
        points, cells, _ = box(2, cells=3)
        cells[5, 1] = cells[5, 0]
        with self.assertRaises(planish.Error) as caught:
            planish.smooth(points, cells)
        error = caught.exception
        self.assertEqual((error.code, error.element), (-2, 5))
        for other in (copy.copy(error), pickle.loads(pickle.dumps(error))):  # as from another process
            self.assertEqual((str(other), other.code, other.element, other.node),
                             (str(error), error.code, error.element, error.node))
        self.assertIn("5", str(error))

    def test_wrong_meshes(self):
        points, cells, _ = box(3, 3)
        start = points.copy()
        for kind, value in ((np.int32, -1), (np.int64, 1 << 40), (np.int32, len(points))):
            wrong = cells.astype(kind)
            wrong[5, 2] = value
            with self.assertRaisesRegex(planish.Error, "element 5") as caught:
                planish.smooth(points, wrong)
            self.assertEqual((caught.exception.code, caught.exception.element), (-2, 5))
        points[7, 1] = np.nan
        with self.assertRaisesRegex(planish.Error, "node 7") as caught:
            planish.smooth(points, cells)
        self.assertEqual(caught.exception.node, 7)
        points[7, 1] = start[7, 1]
        np.testing.assert_array_equal(points, start)
        self.refuse(planish.Error, "rings", points, cells, rings=-1)
        self.refuse(planish.Error, "tolerance", points, cells, tolerance=-1.0)

    def test_library_is_missing(self):
        environment = dict(os.environ, PLANISH_LIBRARY="/nowhere/libplanish.so")
        run = subprocess.run([sys.executable, "-c", "import planish"], env=environment,
                             stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertIn("PLANISH_LIBRARY", run.stderr)


class Block:
    """What the module asks of meshio's cell blocks."""

    def __init__(self, kind, data):
        self.type, self.data = kind, data


def lists_of(cells):
    """VTK's lists: a count, so many nodes, a count, ..."""
    return np.concatenate([[len(nodes), *nodes] for nodes in cells]).astype(np.int64)


class Mesh:
    """Stands in for meshes of other packages, which name the same things: meshio's cells are a list
    of blocks; an UnstructuredGrid of pyvista has cells and celltypes, a PolyData faces, lines and verts."""

    def __init__(self, points, **more):
        self.points = points
        self.__dict__.update(more)


class Meshes(unittest.TestCase):
    def setUp(self):
        self.points, self.cells, inside = box(3)
        self.expected = self.points.copy()
        held = np.flatnonzero(inside)[:3].reshape(1, 3)
        self.held = held.astype(np.int64)
        planish.smooth(self.expected, self.cells, fix=held.ravel())

    def check(self, mesh):
        points = mesh.points
        planish.smooth(mesh)
        self.assertIs(mesh.points, points)
        np.testing.assert_array_equal(mesh.points, self.expected)
        self.assertEqual(planish.quality(mesh).n_elements, len(self.cells))

    def test_blocks(self):
        half = len(self.cells) // 2
        self.check(Mesh(self.points, cells=[Block("tetra", self.cells[:half]),
                                            Block("triangle", self.held),
                                            Block("tetra", self.cells[half:])]))

    def test_kinds_of_vtk(self):
        kinds = np.full(len(self.cells) + 1, 10, dtype=np.uint8)
        kinds[7] = 5
        self.check(Mesh(self.points, celltypes=kinds,
                        cells=lists_of([*self.cells[:7], self.held[0], *self.cells[7:]])))

    def test_faces(self):
        points, cells, _ = box(2)
        flat = np.column_stack([points, np.zeros(len(points))])
        planish.smooth(points, cells)
        mesh = Mesh(flat, faces=lists_of(cells))
        planish.smooth(mesh)
        np.testing.assert_array_equal(mesh.points[:, :2], points)

    def test_polyhedra_and_lines(self):
        nodes = self.held.ravel().tolist()
        uneven = [[nodes, nodes[:2]], [nodes[:1], nodes[1:]]]
        self.check(Mesh(self.points, cells=[Block("tetra", self.cells), Block("polyhedron6", uneven),
                                            Block("polygon", []), Block("line", np.zeros((0, 2)))]))

    def test_faces_of_others(self):
        points, cells, inside = box(2)
        stay = np.flatnonzero(inside)[:3]
        flat = np.column_stack([points, np.zeros(len(points))])
        planish.smooth(points, cells, fix=stay)
        planish.smooth(Mesh(flat, faces=lists_of(cells), lines=np.array([2, stay[0], stay[1]]),
                            verts=np.array([1, stay[2], 1, stay[0]])))
        np.testing.assert_array_equal(flat[:, :2], points)
        before = flat.copy()  # a quadrilateral by itself has no node that moves
        self.assertEqual(planish.smooth(Mesh(flat, faces=np.array([4, 0, 7, 8, 1]))).n_moved_nodes, 0)
        np.testing.assert_array_equal(flat, before)

    def test_noise_in_z_of_floats(self):
        points, cells, _ = box(2)
        flat = np.column_stack([points, np.full(len(points), 5)]).astype(np.float32)
        flat[0, 2] = np.nextafter(np.float32(5), np.float32(6))
        self.assertEqual(planish.quality(flat, cells).n_inverted, 0)
        flat[0, 2] = 5.1
        for array in (flat, np.column_stack([flat, flat[:, :1]])):
            with self.assertRaisesRegex(ValueError, "plane"):
                planish.Plan(array, cells)
            self.assertEqual(planish.quality(array, cells).n_inverted, 0)  # as a surface in space

    def test_neither(self):
        for blocks, text in (([Block("hexahedron", self.cells[:, :1])], r"hexahedron must be \[m, 8\]"),
                             ([Block("pyramid13", np.arange(13).reshape(1, 13))], "no tetrahedron"),
                             ([Block("line", self.cells[:, :2]), Block("polygon", self.cells)], "no elements"),
                             ([], "no elements")):
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(Mesh(self.points, cells=blocks))

    @unittest.skipIf(meshio is None, "without meshio")
    def test_meshio(self):
        self.check(meshio.Mesh(self.points, [("tetra", self.cells), ("triangle", self.held)]))

    @unittest.skipIf(meshio is None or not PROGRAM, "without meshio, or the program")
    def test_same_bits_as_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            mesh = meshio.Mesh(self.points, [("tetra", self.cells)])
            mesh.write(path / "in.vtk", file_format="vtk42", binary=True)
            subprocess.run([PROGRAM, "smooth", path / "in.vtk", "-o", path / "out.vtk", "-q"],
                           check=True)
            other = meshio.read(path / "in.vtk")
            if not other.points.dtype.isnative:
                other.points = other.points.astype(other.points.dtype.newbyteorder("="))
            planish.smooth(other)
            np.testing.assert_array_equal(other.points, meshio.read(path / "out.vtk").points)


def ball(cells=6, amount=0.1):
    """Points and cells of a ball: a box whose sides were bent, and whether points are inside."""
    points, tets, inside = box(3, cells, amount)
    points -= cells / 2
    largest = np.abs(points).max(axis=1, keepdims=True)
    bent = np.tan(np.pi / 4 * points / np.maximum(largest, 1e-9))
    bent *= largest / np.maximum(np.linalg.norm(bent, axis=1, keepdims=True), 1e-9)
    return bent, tets, inside


class Surfaces(unittest.TestCase):
    def test_shapes_have_classes(self):
        points, cells, inside = ball()
        with planish.Shape(points, cells) as shape:
            self.assertEqual(shape.info.n_nodes, (~inside).sum())
            self.assertEqual(shape.info.n_facets, 2 * shape.info.n_nodes - 4)
            classes = shape.classes()
            np.testing.assert_array_equal(classes == 0, inside)
            counts = np.bincount(classes, minlength=4)
            self.assertEqual(list(counts[1:]), [shape.info.n_on_patch, shape.info.n_on_curve, shape.info.n_corners])
            self.assertGreater(counts[1], 0.9 * counts[1:].sum())
            self.assertIn("n_patches=", repr(shape.info))
            self.assertRaises(TypeError, copy.copy, shape)
        self.assertRaises(ValueError, shape.classes)

    def test_crease_angles_and_tags_make_edges(self):
        points, cells, _ = box(3)
        self.assertEqual(planish.Shape(points, cells).info.n_creases, 12 * 6)
        self.assertEqual(planish.Shape(points, cells, crease_angle=91).info.n_edges, 0)
        cap = [[7 * a + b, 7 * (a + 1) + b, 7 * a + b + 1, 7 * (a + 1) + b + 1] for a in range(2) for b in range(2)]
        facets = np.array([f for q in cap for f in (q[:3], q[1:])]) * 7  # on the side of z = 0
        listed = {(frozenset(f)) for c in cells.tolist() for f in itertools.combinations(c, 3)}
        facets = np.array([f for f in itertools.combinations(sorted(set(facets.ravel().tolist())), 3)
                           if frozenset(f) in listed])
        tagged = planish.Shape(points, {"tetra": cells, "triangle": facets}, crease_angle=91)
        self.assertEqual(tagged.info.n_edges, 8)
        lines = np.array([[0, 1], [1, 2]])
        self.assertEqual(planish.Shape(points, {"tetra": cells, "line": lines}, crease_angle=91).info.n_edges, 2)
        region = (points[cells].mean(axis=1)[:, 0] > 3).astype(int)
        self.assertEqual(planish.Shape(points, cells, regions=region, crease_angle=91).info.n_edges, 4 * 6)

    def test_slides_are_found(self):
        points, cells, inside = box(3)
        found = planish.find_slides(points, cells)
        self.assertEqual(found.info.n_on_plane, 6 * 25)
        self.assertEqual(found.info.n_on_line, 12 * 5)
        self.assertEqual(list(np.bincount(found.constraint)), [inside.sum(), 8, 150, 60])
        listed = planish.find_slides(points, {"tetra": cells, "line": np.array([[0, 1]]), "vertex": np.array([[3]])})
        self.assertEqual(listed.info.n_on_line, 58)  # the vertex and the end of the tag stay
        points = box(3, amount=0)[0]
        region = (points[cells].mean(axis=1)[:, 0] > 3).astype(int)
        self.assertEqual(planish.find_slides(points, cells, regions=region).info.n_on_plane, 7 * 25 - 4 * 5)
        points, cells, _ = ball()
        self.assertEqual(planish.find_slides(points, cells).info.n_on_plane, 0)
        shape = planish.Shape(points, cells)
        curved = planish.find_slides(points, cells, surface_of=shape, fix=[0])
        self.assertGreaterEqual(curved.info.n_on_patch, shape.info.n_on_patch - 1)
        self.assertEqual(curved.constraint[0], 1)
        again = planish.find_slides(points, cells, surface_of=points.copy(), fix=[0])
        np.testing.assert_array_equal(again.constraint, curved.constraint)

    def test_curved_boundaries_are_smoothed(self):
        first, cells, inside = ball()
        points, flat = first.copy(), first.copy()
        planish.smooth(flat, cells, slide="auto")
        np.testing.assert_array_equal(flat[~inside], first[~inside])
        with planish.Plan(points, cells, slide="curved") as plan:
            self.assertEqual(plan.slides.n_on_patch, plan.shape.info.n_on_patch)
            result = plan.smooth(surface_tolerance="0.04h")
            moved = plan.shape.distance(points)
            self.assertEqual(plan.shape.distance(first).distance, 0)
        self.assertLess(result.rms, planish.quality(flat, cells).rms_radius_ratio)
        self.assertGreater(np.any(points != first, axis=1)[~inside].sum(), 100)
        self.assertTrue(0 < moved.in_edges <= 0.0401 and moved.n_unproved == 0)
        self.assertTrue(0 < moved.back_in_edges < 0.08)
        again = points.copy()  # a second run on the same shape does not add up
        shape = planish.Shape(first, cells)
        planish.smooth(again, cells, slide="curved", surface_of=shape, surface_tolerance=0.04)
        self.assertLess(shape.distance(again).distance, 0.0401)

    def test_surfaces_in_space(self):
        """Triangles and quadrilaterals of a torus in space move on it, from arrays and from meshes."""
        n, m = 36, 18
        random = np.random.default_rng(5)
        i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
        u, v = (2 * np.pi * (k + random.uniform(-0.2, 0.2, n * m)) / c for k, c in ((i, n), (j, m)))
        start = np.column_stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)])
        quads = np.column_stack([i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m])
        triangles = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        before = planish.quality(start, triangles)
        points = start.copy()
        result = planish.smooth(points, triangles)
        after = planish.quality(points, triangles)
        self.assertEqual(result.stop, "converged")
        self.assertLess(after.max_radius_ratio, 0.7 * before.max_radius_ratio)
        self.assertGreater(after.min_angle_deg, before.min_angle_deg + 5)
        self.assertAlmostEqual(result.rms, after.rms_radius_ratio, 9)
        with planish.Shape(start, triangles) as shape:
            self.assertEqual((shape.info.n_open_edges, shape.info.n_turned, shape.info.n_corners), (0, 0, 0))
            self.assertLessEqual(shape.distance(points).in_edges, 0.0525)
            planish.smooth(points, triangles, surface_of=shape, objective="worst", surface_tolerance="0.05h")
            self.assertLessEqual(shape.distance(points).in_edges, 0.0525)
        of_mesh = Mesh(start.copy(), cells=[Block("triangle", triangles)])
        again = start.copy()
        planish.smooth(of_mesh)
        planish.smooth(again, triangles)
        np.testing.assert_array_equal(of_mesh.points, again)
        of_mesh = Mesh(start.copy(), faces=lists_of(list(triangles)), verts=None, lines=None)
        planish.smooth(of_mesh)
        np.testing.assert_array_equal(of_mesh.points, again)
        again = start.copy()
        planish.smooth(again, triangles, fix=np.arange(100), max_sweeps=1)
        np.testing.assert_array_equal(again[:100], start[:100])
        self.assertGreater((again[100:] != start[100:]).any(axis=1).mean(), 0.9)
        self.assertEqual(planish.smooth(start.copy(), triangles, progress=lambda step: True).stop, "interrupted")
        again = start.copy()
        planish.smooth(again, {"quad": quads})
        a, b = (planish.quality(x, {"quad": quads}, per_element=True) for x in (start, again))
        self.assertLess(b.cells.all.max_aspect_ratio, a.cells.all.max_aspect_ratio)
        self.assertAlmostEqual(b.elements.aspect_ratio.max(), b.cells.all.max_aspect_ratio, 12)
        for options in {"min_volume": 1}, {"slide": "auto"}, {"objective": "edge-ratio"}, {"around": [1]}:
            self.assertRaises(ValueError, planish.smooth, start.copy(), triangles, **options)

    def test_surfaces_are_fitted_to_others(self):
        fine, solids, _ = ball(8)
        fine /= 2
        facets, counts = np.unique(np.sort(solids[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3)),
                                   axis=0, return_counts=True)
        faces = facets[counts == 1]
        other = planish.Shape(fine, faces)
        self.assertEqual(other.info.n_facets, len(faces))
        first, cells, inside = ball(4)
        first *= 0.95
        points = first.copy()
        result = planish.smooth(points, cells, onto=other)
        self.assertEqual((result.fit.n_off, result.fit.n_out_of_reach, result.fit.n_held), (0, 0, 0))
        self.assertEqual(result.fit.n_on_patch + result.fit.n_on_curve + result.fit.n_on_corner, (~inside).sum())
        radius = np.linalg.norm(fine, axis=1).max()
        self.assertLess(np.abs(np.linalg.norm(points[~inside], axis=1) - radius).max(), 0.02 * radius)
        self.assertTrue(0 < result.fit_distance.in_edges < 0.3 and result.fit_distance.n_unproved == 0)
        self.assertEqual(result.n_inverted, 0)
        with planish.Plan(first.copy(), cells, onto=other, fix=~inside) as plan:
            self.assertEqual(plan.fit.n_held, (~inside).sum())
        floats = first.astype(np.float32)
        planish.smooth(floats, cells, onto=other)
        self.assertLess(np.abs(np.linalg.norm(floats[~inside], axis=1) - radius).max(), 0.02 * radius)
        with self.assertRaisesRegex(ValueError, "same unit"):
            planish.smooth(first.copy(), cells, onto=planish.Shape(100 * fine, faces))
        with planish.Plan(first.copy(), cells) as plan, self.assertRaisesRegex(ValueError, "without onto"):
            plan.fit_distance()
        with planish.Shape(fine, faces) as closed:
            again = first.copy()
            plan = planish.Plan(again, cells, onto=closed)
        with plan:  # a plan keeps what it needs
            plan.smooth(again)
            self.assertLess(np.abs(np.linalg.norm(again[~inside], axis=1) - radius).max(), 0.02 * radius)
            self.assertLess(plan.fit_distance(again).in_edges, 0.3)
        self.assertRaisesRegex(ValueError, "the shape is closed", closed.classes)

    def fitted_ball(self):
        """Points and cells of a ball, and the shape of a finer one around it."""
        fine, solids, _ = ball(4)
        points, cells, _ = ball(3)
        return 0.6 * points, cells, planish.Shape(fine * (3 / 4) * 0.65, solids)

    def test_errors_beside_onto_move_nothing(self):
        """Options of a run are wrong, the library refuses them, or memory ends: points are where they were."""
        first, cells, other = self.fitted_ball()
        points = first.copy()
        planish.smooth(points, cells, onto=other)
        self.assertGreater((points != first).any(axis=1).sum(), 50)
        for wrong in ({"max_sweeps": 2.5}, {"tolerance": 2}, {"objective": "foo"}, {"min_volume": -1}, {"area_weight": 0.5},
                      {"time_limit": -1}, {"worst_measure": "dihedral"}, {"progress": 5}, {"rounding": -1}):
            points = first.copy()
            self.assertRaises((ValueError, TypeError), planish.smooth, points, cells, onto=other, **wrong)
            np.testing.assert_array_equal(points, first, str(wrong))
        for where in ("planish._plan.call", "planish._smooth.run_with_layers", "planish.Plan.fit_distance",
                      "planish._fit.Fit.let_slide"):
            for points in first.copy(), first[:, ::-1].astype(np.float32)[:, ::-1]:
                before = points.copy()
                with mock.patch(where, side_effect=MemoryError), self.assertRaises(MemoryError):
                    planish.smooth(points, cells, onto=other)
                np.testing.assert_array_equal(points, before, where)
        points = first.copy()
        with mock.patch("planish._plan.call", side_effect=MemoryError), self.assertRaises(MemoryError):
            planish.Plan(points, cells, onto=other)
        np.testing.assert_array_equal(points, first)

    def test_options_without_a_place_beside_onto(self):
        """Options that the program refuses beside --onto are refused, in a run of a plan, too, and nothing moves."""
        first, cells, other = self.fitted_ball()
        points = first.copy()
        of_plan = ({"slide": "auto"}, {"slide": ["wall"]}, {"only_worse_than": 2}, {"around": [1]}, {"surface_of": first})
        of_run = ({"box": [-1, -1, -1, 1, 1, 1]}, {"max_displacement": 0.01}, {"max_displacement": "0.1h"})
        for wrong in of_plan + of_run:
            with self.assertRaisesRegex(ValueError, f"give onto or {list(wrong)[0]}, not both"):
                planish.smooth(points, cells, onto=other, **wrong)
        others = ({"method": "laplacian"}, "onto has no effect with method='laplacian'"), (
            {"surface_tolerance": "0.1h"}, "surface_tolerance has no effect without slide='curved'")
        for wrong, text in others:
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(points, cells, onto=other, **wrong)
        np.testing.assert_array_equal(points, first)
        with planish.Plan(points, cells, onto=other) as plan:
            for wrong in (*of_run, *(wrong for wrong, _ in others)):
                self.assertRaises(ValueError, plan.smooth, **wrong)

    def test_progress_beside_onto_may_raise(self):
        """What progress raises is no error: points stay as good as they have become."""
        first, cells, other = self.fitted_ball()
        points = first.copy()
        with self.assertRaises(ZeroDivisionError):
            planish.smooth(points, cells, onto=other, progress=lambda _: 1 / 0)
        with planish.Plan(first.copy(), cells, onto=other) as plan:
            self.assertEqual((plan.fit.n_off, plan.fit_distance(points).n_unproved), (0, 0))
            self.assertLess(plan.fit_distance(points).in_edges, 0.3)

    def test_errors_after_a_round_move_nothing(self):
        """An error in a later step of smooth takes back the steps before."""
        first, cells, _ = box(3)
        for where in "planish._smooth.promises_for", "planish._smooth.run_with_layers":
            points = first.copy()

            def smooth_and_fail(plan, *run):
                plan.run(None, run[-1])
                raise MemoryError

            with mock.patch(where, side_effect=smooth_and_fail), self.assertRaises(MemoryError):
                planish.smooth(points, cells)
            np.testing.assert_array_equal(points, first)

    def test_shapes_are_closed_at_any_time(self):
        """Who closes a shape while nodes slide on it changes nothing."""
        points, cells, _ = ball(4)
        for closes in (False, True):
            shape, again = planish.Shape(points, cells), points.copy()

            def progress(_step):
                if closes:
                    shape.close()

            with planish.Plan(again, cells, slide="curved", surface_of=shape) as plan:
                plan.smooth(again, progress=progress)
            if closes:
                np.testing.assert_array_equal(again, expected)
                self.assertRaisesRegex(ValueError, "the shape is closed", shape.classes)
            expected = again

    def test_refusals(self):
        points, cells, _ = ball(3)
        shape = planish.Shape(points, cells)
        for wrong, text in (({"slide": "round"}, "auto, curved, none"), ({"surface_of": shape}, "slide='curved'"),
                            ({"slide": "curved", "crease_angle": -1}, "crease_angle"),
                            ({"slide": "curved", "surface_tolerance": "h"}, "0.05h"),
                            ({"slide": "curved", "surface_tolerance": -1}, "surface_tolerance")):
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(points.copy(), cells, **wrong)
        with self.assertRaisesRegex(planish.Error, "nodes"):
            shape.distance(points[:-1])
        with self.assertRaisesRegex(planish.Error, "dim is 2"):
            planish.Shape(*box(2)[:2])
        shape.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            planish.smooth(points, cells, slide="curved", surface_of=shape)


class Regions(unittest.TestCase):
    """Nodes between regions stay, by the rule or as asked for."""

    def setUp(self):
        self.points, self.cells, self.inside = box(3)
        self.halves = np.where(np.round(self.points[self.cells]).min(axis=1)[:, 0] >= 3, 5, -2)
        self.quarters = np.where(np.round(self.points[self.cells]).min(axis=1)[:, 1] >= 3, 1.0, 0.0)
        self.middle = np.round(self.points[:, 0]) == 3

    def mesh(self, **arrays):
        return Mesh(self.points.copy(), cells=[Block("tetra", self.cells)],
                    cell_data={name: [values] for name, values in arrays.items()})

    def moved(self, mesh, **options):
        """Which nodes move."""
        planish.smooth(mesh, **options)
        return (mesh.points != self.points).any(axis=1)

    def check(self, mesh, expected, **options):
        with planish.Plan(mesh, **options) as plan:
            self.assertEqual(plan.region_arrays, expected)
            free = plan.free()
        moved = self.moved(mesh, **options)
        np.testing.assert_array_equal(moved, free)
        return moved

    def test_any_name_and_type(self):
        for dtype in "i1 i2 i4 i8 f4 f8 >i4 >f8 f2".split():
            moved = self.check(self.mesh(mat_id=self.halves.astype(dtype)), ["mat_id"])
            np.testing.assert_array_equal(moved, self.inside & ~self.middle)
        for values in (self.halves > 0, (self.halves > 0).astype("u8"), self.halves.reshape(-1, 1)):
            np.testing.assert_array_equal(self.check(self.mesh(zone=values), ["zone"]),
                                          self.inside & ~self.middle)

    def test_what_is_no_region(self):
        n = len(self.cells)
        odd = self.halves.astype(float)
        odd[5] = np.nan
        for values in (np.arange(n), np.arange(n) % 2, np.ones(n), self.halves + 0.5, odd,
                       np.column_stack([self.halves] * 2), np.array(["a"] * n)):
            np.testing.assert_array_equal(self.check(self.mesh(x=values), []), self.inside)
        for name in ("partition", "vtkGhostType", "Rank"):
            np.testing.assert_array_equal(self.check(self.mesh(**{name: self.halves}), []), self.inside)

    def test_several(self):
        mesh = self.mesh(a=self.halves, number=np.arange(len(self.cells)), b=self.quarters)
        moved = self.check(mesh, ["a", "b"])
        self.assertTrue(moved.any())
        self.assertFalse((moved & (self.middle | (np.round(self.points[:, 1]) == 3))).any())

    def test_asked_for(self):
        def mesh():
            return self.mesh(a=self.halves, rank=self.quarters)
        half = self.inside & ~self.middle
        quarter = self.inside & (np.round(self.points[:, 1]) != 3)
        np.testing.assert_array_equal(self.check(mesh(), [], regions=None), self.inside)
        np.testing.assert_array_equal(self.check(mesh(), ["rank"], regions="rank"), quarter)
        np.testing.assert_array_equal(self.check(mesh(), ["a", "rank"], regions=["a", "rank"]), half & quarter)
        for values in (self.halves, self.halves.tolist()):
            np.testing.assert_array_equal(self.moved(mesh(), regions=values), half)
        points = self.points.copy()
        planish.smooth(points, self.cells, regions=self.halves)
        np.testing.assert_array_equal((points != self.points).any(axis=1), half)
        for bad, text in (("x", "no array of cells 'x'; it has: a, rank"), (["a", "y"], "'y'"),
                          (self.halves[:-1], "one number"), (self.halves + 0.5, "whole number")):
            with self.assertRaisesRegex(ValueError, text):
                planish.smooth(mesh(), regions=bad)
        self.assertLess(planish.quality(mesh(), regions=None).n_fixed_elements, planish.quality(mesh()).n_fixed_elements)

    def test_blocks_of_several_kinds(self):
        half = len(self.cells) // 2
        line = np.array([[0, 1]])
        mesh = Mesh(self.points.copy(), cells=[Block("tetra", self.cells[:half]), Block("line", line),
                                               Block("tetra", self.cells[half:])],
                    cell_data={"m": [self.halves[:half], np.array([77]), self.halves[half:]]})
        np.testing.assert_array_equal(self.check(mesh, ["m"]), self.inside & ~self.middle)

    def test_grid_of_pyvista(self):
        kinds = np.array([10, 5] * 2 + [10] * (len(self.cells) - 2), dtype=np.uint8)
        values = np.zeros(len(kinds))
        values[kinds == 10] = self.halves
        values[kinds == 5] = np.nan
        rows = [self.cells[0], [0, 1, 8], self.cells[1], [1, 8, 2], *self.cells[2:]]
        mesh = Mesh(self.points.copy(), cells=lists_of(rows), celltypes=kinds, cell_data={"m": values})
        np.testing.assert_array_equal(self.check(mesh, ["m"]), self.inside & ~self.middle)

    def test_surface_of_pyvista(self):
        points, cells, inside = box(2)
        flat = np.column_stack([points, np.zeros(len(points))])
        middle = np.round(points[:, 0]) == 3
        values = np.where(np.round(points[cells]).min(axis=1)[:, 0] >= 3, 2, 1)
        mesh = Mesh(flat.copy(), faces=lists_of(cells), verts=np.array([1, 0, 1, 1]), lines=np.array([3, 0, 1, 2]),
                    cell_data={"m": np.concatenate([[9, 8, 7], values])})
        planish.smooth(mesh)
        np.testing.assert_array_equal((mesh.points != flat).any(axis=1), inside & ~middle)

    def test_points_that_are_all_nodes_hold_none(self):
        vertices = np.arange(len(self.points)).reshape(-1, 1)
        mesh = Mesh(self.points.copy(), cells=[Block("vertex", vertices), Block("tetra", self.cells)])
        np.testing.assert_array_equal(self.moved(mesh), self.inside)
        mesh = Mesh(self.points.copy(), cells=[Block("vertex", vertices[:-1]), Block("tetra", self.cells)])
        self.assertFalse(self.moved(mesh).any())
        for nodes, expected in ((vertices.ravel(), self.inside), (vertices.ravel()[:-1], self.inside & False)):
            mesh = Mesh(self.points.copy(), cells=lists_of([nodes, *self.cells]),
                        celltypes=np.append(2, np.full(len(self.cells), 10)))
            np.testing.assert_array_equal(self.moved(mesh), expected)

    def test_all_edges_or_facets_hold_none(self):
        """Lists of all of them say nothing; those with a tag of their own do."""
        for corners, kind in ((2, "line"), (3, "triangle")):
            sets = list(itertools.combinations(range(4), corners))
            all_of = np.unique(np.sort(self.cells[:, sets].reshape(-1, corners), axis=1), axis=0)[:, ::-1]

            def mesh(listed, tags=None, kind=kind):
                return Mesh(self.points.copy(), cells=[Block(kind, listed), Block("tetra", self.cells)],
                            cell_data={} if tags is None else {"tag": [tags, np.zeros(len(self.cells), dtype=int)]})
            half = len(all_of) // 2
            np.testing.assert_array_equal(self.moved(mesh(all_of)), self.inside)
            two = mesh(all_of[:half])
            two.cells.append(Block(kind, all_of[half:]))
            np.testing.assert_array_equal(self.moved(two), self.inside)
            self.assertFalse(self.moved(mesh(all_of[1:])).any())
            at_middle = self.middle[all_of].all(axis=1)
            np.testing.assert_array_equal(self.moved(mesh(all_of, at_middle * 3)), self.inside & ~self.middle)
            grid = Mesh(self.points.copy(), cells=lists_of([*self.cells, *all_of]),
                        celltypes=np.repeat([10, 3 if corners == 2 else 5], (len(self.cells), len(all_of))))
            np.testing.assert_array_equal(self.moved(grid), self.inside)

    def test_all_edges_of_triangles_hold_none(self):
        points, cells, inside = box(2)
        flat = np.column_stack([points, np.zeros(len(points))])
        edges = np.unique(np.sort(cells[:, [(0, 1), (0, 2), (1, 2)]].reshape(-1, 2), axis=1), axis=0)
        for listed, expected in ((edges, inside), (edges[:-1], inside & False)):
            lines = np.column_stack([np.full(len(listed), 2), listed]).ravel()
            mesh = Mesh(flat.copy(), faces=lists_of(cells), lines=lines, cell_data={})
            planish.smooth(mesh)
            np.testing.assert_array_equal((mesh.points != flat).any(axis=1), expected)

    def test_negative_counts(self):
        points, cells, _ = box(2)
        flat = np.column_stack([points, np.zeros(len(points))])
        for bad in ([-1], [2, 0, 1, -3, 1], [2, 0, 1, -1], [9, 1], [2, 0]):
            for name in ("lines", "verts"):
                with self.assertRaisesRegex(ValueError, f"{name} of the mesh has the count"):
                    planish.smooth(Mesh(flat, faces=lists_of(cells), **{name: np.array(bad)}))

    @unittest.skipIf(meshio is None or not PROGRAM, "without meshio, or the program")
    def test_the_program_moves_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            lower = np.array([[0, 1, 8], [1, 8, 2]])
            mesh = meshio.Mesh(self.points, [("tetra", self.cells), ("triangle", lower)],
                               cell_data={"mat_id": [self.halves, [3, 4]], "T": [self.halves / 3, [1.0, 2.0]],
                                          "zone": [self.quarters, [5.0, 5.0]]})
            mesh.write(path / "in.vtk", file_format="vtk42", binary=True)
            for options, kept in (([], {}), (["--regions", "zone"], {"regions": "zone"}),
                                  (["--regions", "none"], {"regions": None})):
                subprocess.run([PROGRAM, "smooth", path / "in.vtk", "-o", path / "out.vtk", "-q", *options],
                               check=True)
                other = meshio.read(path / "in.vtk")
                other.points = other.points.astype(other.points.dtype.newbyteorder("="))
                planish.smooth(other, **kept)
                np.testing.assert_array_equal(other.points, meshio.read(path / "out.vtk").points)

    @unittest.skipIf(meshio is None or not PROGRAM, "without meshio, or the program")
    def test_the_program_takes_lists_of_all_edges_alike(self):
        sets = list(itertools.combinations(range(4), 2))
        edges = np.unique(np.sort(self.cells[:, sets].reshape(-1, 2), axis=1), axis=0)
        tags = self.middle[edges].all(axis=1) * 2 + 1
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            mesh = meshio.Mesh(self.points, [("tetra", self.cells), ("line", edges)],
                               cell_data={"mat": [self.halves, tags]})
            mesh.write(path / "in.vtk", file_format="vtk42", binary=True)
            subprocess.run([PROGRAM, "smooth", path / "in.vtk", "-o", path / "out.vtk", "-q"], check=True)
            other = meshio.read(path / "in.vtk")
            other.points = other.points.astype(other.points.dtype.newbyteorder("="))
            planish.smooth(other)
            np.testing.assert_array_equal(other.points, meshio.read(path / "out.vtk").points)


class Locks(unittest.TestCase):
    def test_closing_while_others_use_it(self):
        """Closed from another thread, a plan ends with an error, and never in freed memory."""
        points, cells, _ = box(3, cells=8)
        for _ in range(20):
            plan = planish.Plan(points, cells, threads=1)
            ends = []

            def use(plan=plan, ends=ends):
                try:
                    while True:
                        plan.radius_ratios()
                        plan.quality()
                        plan.free()
                except ValueError as error:
                    ends.append(str(error))

            threads = [threading.Thread(target=use) for _ in range(3)]
            for thread in threads:
                thread.start()
            time.sleep(0.01)
            plan.close()
            for thread in threads:
                thread.join(60)
            self.assertEqual(ends, ["the plan is closed"] * 3)
            plan.close()

    def test_smoothing_refuses_others(self):
        points, cells, _ = box(3)
        with planish.Plan(points, cells, threads=1) as plan:
            refused = []

            def intrude():
                for call in (plan.close, plan.smooth, plan.quality, plan.free, plan.radius_ratios):
                    try:
                        call()
                    except RuntimeError:
                        refused.append(call)

            def progress(_):
                thread = threading.Thread(target=intrude)
                thread.start()
                thread.join(60)
                return True

            plan.smooth(progress=progress)
            self.assertGreaterEqual(len(refused), 5)
            self.assertEqual(plan.quality().n_inverted, 0)

    def test_refused_calls_leave_the_options(self):
        """Options of a call that is refused are not those of the run that goes on."""
        points, cells, _ = box(3)
        usual = planish.smooth(points.copy(), cells, threads=1)
        refused = []
        with planish.Plan(points, cells, threads=1) as plan:

            def intrude():
                try:
                    plan.smooth(max_sweeps=1)
                except RuntimeError as error:
                    refused.append(error)

            def progress(_):
                thread = threading.Thread(target=intrude)
                thread.start()
                thread.join(60)
                intrude()

            result = plan.smooth(progress=progress)
        self.assertGreater(len(refused), 2)
        self.assertGreater(usual.sweeps, 1)
        self.assertEqual((result.stop, result.sweeps), (usual.stop, usual.sweeps))

    def test_others_wait(self):
        points, cells, _ = box(3, cells=8)
        with planish.Plan(points, cells, threads=1) as plan:
            expected, found = plan.radius_ratios(), []
            threads = [threading.Thread(target=lambda: found.append(plan.radius_ratios())) for _ in range(8)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join(60)
            self.assertEqual(len(found), 8)
            for ratios in found:
                np.testing.assert_array_equal(ratios, expected)


if __name__ == "__main__":
    unittest.main()
