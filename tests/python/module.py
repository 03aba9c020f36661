"""Tests of the Python module."""

import copy
import ctypes
import itertools
import json
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import planish

try:
    import meshio
except ImportError:
    meshio = None
try:
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
except ImportError:
    vtk = None

PROGRAM = os.environ.get("PLANISH_PROGRAM")


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
                               ("later", 'const char *planish_version(void) { return "0.3.0"; }')):
                source, library = (os.path.join(folder, name + end) for end in (".c", ".so"))
                pathlib.Path(source).write_text(code)
                subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library], check=True)
                done = subprocess.run([sys.executable, "-c", "import planish"], check=False, text=True,
                                      stderr=subprocess.PIPE, env=dict(os.environ, PLANISH_LIBRARY=library))
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("ImportError", done.stderr)


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
        self.assertRaises(ValueError, planish.smooth, points, cells)

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
        with self.assertRaisesRegex(ValueError, "constant z"):
            planish.smooth(points, cells)

    def test_options(self):
        points, cells, inside = box(3)
        fixed = np.flatnonzero(inside)[::2]
        start = points.copy()
        planish.smooth(points, cells, fixed=fixed)
        np.testing.assert_array_equal(points[fixed], start[fixed])
        mask = np.zeros(len(points), dtype=bool)
        mask[fixed] = True
        masked = start.copy()
        planish.smooth(masked, cells, fixed=mask)
        np.testing.assert_array_equal(points, masked)

        none, all_of_them = start.copy(), start.copy()
        planish.smooth(none, cells, fixed=[])
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
        result = planish.smooth(low, cells, min_volumes=least)
        self.assertEqual(result.n_below_min_volume, 0)
        with self.assertRaisesRegex(ValueError, "one value for each of"):
            planish.smooth(start.copy(), cells, min_volumes=least[1:])

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
        hard = {"objective": "worst", "fixed": np.flatnonzero(inside)[::4]}
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
        self.assertEqual(planish.quality(points, cells, fixed=range(len(points))).n_fixed_elements, len(cells))

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
        self.refuse(TypeError, "sweeps is no option", points, cells, sweeps=3)
        self.refuse(planish.Error, "n_around is 0", points, cells, around=[])
        self.refuse(ValueError, "fixed has a number", points, cells, fixed=[-1])
        self.refuse(ValueError, "around has a number", points, cells, around=[len(points)])
        self.refuse(TypeError, "fixed must be numbers", points, cells, fixed=[0.5])
        self.refuse(ValueError, "fixed is a mask", points, cells, fixed=np.ones(3, dtype=bool))

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
        planish.smooth(self.expected, self.cells, fixed=held.ravel())

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
        self.check(Mesh(self.points, cells=[Block("tetra", self.cells), Block("polyhedron6", uneven)]))

    def test_faces_of_others(self):
        points, cells, inside = box(2)
        stay = np.flatnonzero(inside)[:3]
        flat = np.column_stack([points, np.zeros(len(points))])
        planish.smooth(points, cells, fixed=stay)
        planish.smooth(Mesh(flat, faces=lists_of(cells), lines=np.array([2, stay[0], stay[1]]),
                            verts=np.array([1, stay[2], 1, stay[0]])))
        np.testing.assert_array_equal(flat[:, :2], points)
        with self.assertRaisesRegex(planish.Error, "no triangle"):
            planish.smooth(Mesh(flat, faces=np.array([4, 0, 7, 8, 1])))

    def test_noise_in_z_of_floats(self):
        points, cells, _ = box(2)
        flat = np.column_stack([points, np.full(len(points), 5)]).astype(np.float32)
        flat[0, 2] = np.nextafter(np.float32(5), np.float32(6))
        self.assertEqual(planish.quality(flat, cells).n_inverted, 0)
        flat[0, 2] = 5.1
        for array in (flat, np.column_stack([flat, flat[:, :1]])):
            with self.assertRaisesRegex(ValueError, "plane"):
                planish.quality(array, cells)

    def test_neither(self):
        for blocks, text in (([Block("hexahedron", self.cells[:, :1])], r"hexahedron must be \[m, 8\]"),
                             ([Block("hexahedron", np.arange(8).reshape(1, 8))], "no tetrahedron"),
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


# Corners of unit elements by meshio's names of their types, and the corners that each further node of
# a type is in the middle of, in VTK's order.
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
UNITS = {"triangle": [(0, 0, 0), (1, 0, 0), (0, 1, 0)], "quad": SQUARE,
         "tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
         "hexahedron": SQUARE + [(x, y, 1) for x, y, _ in SQUARE],
         "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
         "pyramid": SQUARE + [(0.5, 0.5, 0.7)]}
FACES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 1, 2, 3), (4, 5, 6, 7), tuple(range(8))]
ROUND = [(0, 1), (1, 2), (2, 3), (3, 0)]
MIDS = {
    "triangle6": ("triangle", [(0, 1), (1, 2), (2, 0)]),
    "quad8": ("quad", ROUND), "quad9": ("quad", ROUND + [(0, 1, 2, 3)]),
    "tetra10": ("tetra", [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
    "hexahedron20": ("hexahedron", ROUND + [(a + 4, b + 4) for a, b in ROUND] + [(a, a + 4) for a in range(4)]),
    "wedge15": ("wedge", [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]),
    "pyramid13": ("pyramid", ROUND + [(a, 4) for a in range(4)])}
MIDS["hexahedron27"] = ("hexahedron", MIDS["hexahedron20"][1] + FACES)
MIDS["wedge18"] = ("wedge", MIDS["wedge15"][1] + [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)])
MIDS["pyramid14"] = ("pyramid", MIDS["pyramid13"][1] + [(0, 1, 2, 3)])
MIRRORED_WEDGE = [0, 2, 1, 3, 5, 4]  # meshio's order of "wedge"


def write_vtk(path, points, blocks):
    """Write a legacy file: meshio has no wedge15 and pyramid13."""
    rows = [[planish._KNOWN[kind].number, len(row), *(row[MIRRORED_WEDGE] if kind == "wedge" else row)]
            for kind, cells in blocks for row in cells]
    lines = ["# vtk DataFile Version 3.0", "mixed", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double",
             *(" ".join(map(repr, point)) for point in points.tolist()),
             f"CELLS {len(rows)} {sum(map(len, rows)) - len(rows)}", *(" ".join(map(str, row[1:])) for row in rows),
             f"CELL_TYPES {len(rows)}", *(str(row[0]) for row in rows)]
    path.write_text("\n".join(lines) + "\n")


def raised(points, cells, kind):
    """Points and cells of a higher order: with nodes in the middle of corners, each there once."""
    sets, columns = MIDS[kind][1], [cells]
    for size in sorted({len(corners) for corners in sets}):
        wanted = cells[:, [corners for corners in sets if len(corners) == size]]
        rows, back = np.unique(np.sort(wanted.reshape(-1, size), axis=1), axis=0, return_inverse=True)
        columns.append(back.reshape(len(cells), -1) + len(points))
        points = np.concatenate([points, points[rows].mean(axis=1)])
    return points, np.concatenate(columns, axis=1)


class Elements(unittest.TestCase):
    """Cells of any type."""

    def unit(self, kind):
        points = np.array(UNITS[MIDS.get(kind, (kind,))[0]], dtype=float)
        cells = np.arange(len(points)).reshape(1, -1)
        points, cells = raised(points, cells, kind) if kind in MIDS else (points, cells)
        return points, cells[:, MIRRORED_WEDGE] if kind == "wedge" else cells

    def filled(self, seed, is_raised=False, dim=3):
        """Cubes (squares) that are filled with elements of random types, off their places; blocks of cells."""
        random = np.random.default_rng(seed)
        n = 4
        points = np.array(list(itertools.product(range(n), repeat=dim)), dtype=float)
        by_type = {}
        for corner in itertools.product(range(n - 1), repeat=dim):
            at = [np.ravel_multi_index(tuple(np.array(corner) + unit[:dim]), (n,) * dim)
                  for unit in np.array(UNITS["hexahedron" if dim == 3 else "quad"])]
            if dim == 2:
                ways = {"quad": [at], "triangle": [[at[0], at[1], at[2]], [at[0], at[2], at[3]]]}
            else:
                middle = len(points)
                ways = {"hexahedron": [at], "pyramid": [[*(at[i] for i in face), middle] for face in FACES[:6]],
                        "wedge": [[at[i] for i in (0, 1, 2, 4, 5, 6)], [at[i] for i in (0, 2, 3, 4, 6, 7)]],
                        "tetra": [[at[0], at[i], at[j], at[6]] for i, j in
                                  ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))]}
            way = "tetra" if max(corner) < 2 and dim == 3 else random.choice(sorted(ways))  # a node there is free
            if way == "pyramid":
                points = np.concatenate([points, [np.array(corner) + 0.5]])
            by_type.setdefault(str(way), []).extend(ways[way])
        blocks = []
        for kind, cells in by_type.items():
            cells = np.array(cells)
            higher = sorted(name for name, (low, _) in MIDS.items() if low == kind and name != "pyramid14")
            if is_raised and random.random() < 0.7:
                kind = str(random.choice(higher))
                points, cells = raised(points, cells, kind)
            blocks.append((kind, cells[:, MIRRORED_WEDGE] if kind == "wedge" else cells))
        points = points + random.uniform(-0.2, 0.2, points.shape)
        return np.column_stack([points, np.zeros(len(points))]) if dim == 2 else points, blocks

    def test_orders_of_nodes(self):
        for kind in [*UNITS, *MIDS]:
            points, cells = self.unit(kind)
            found = planish.quality(points, {kind: cells}, per_element=True).cells
            self.assertEqual((found.counts, found.all.n_inverted, found.all.n_curved, found.all.n_uncertified),
                             ({kind: 1}, 0, 0, 0), kind)
            low = planish.quality(points, {MIDS.get(kind, (kind,))[0]: self.unit(MIDS.get(kind, (kind,))[0])[1]},
                                  per_element=True).cells
            self.assertEqual(found.all.max_aspect_ratio, low.all.max_aspect_ratio)
            if kind in MIDS:  # a wrong order bends edges
                for a, b in itertools.combinations(range(len(UNITS[MIDS[kind][0]]), cells.shape[1]), 2):
                    wrong = cells.copy()
                    wrong[0, [a, b]] = wrong[0, [b, a]]
                    self.assertEqual(planish.quality(points, {kind: wrong}).cells.all.n_curved,
                                     0 if kind in ("pyramid13", "pyramid14") else 1)

    @unittest.skipIf(vtk is None, "without VTK")
    def test_orders_of_nodes_are_those_of_vtk(self):
        for name in ("QuadraticTriangle", "QuadraticQuad", "BiQuadraticQuad", "QuadraticTetra", "QuadraticHexahedron",
                     "TriQuadraticHexahedron", "QuadraticWedge", "BiQuadraticQuadraticWedge", "QuadraticPyramid"):
            cell = getattr(vtk, "vtk" + name)()
            n = cell.GetNumberOfPoints()
            points = np.array([cell.GetParametricCoords()[i] for i in range(3 * n)]).reshape(n, 3)
            found = planish.quality(points, [(cell.GetCellType(), np.arange(n).reshape(1, n))]).cells
            self.assertEqual((found.all.n_elements, found.all.n_inverted, found.all.n_curved), (1, 0, 0), name)

    def test_ways_to_give_cells(self):
        """All ways give the same bits, and elements in the order given."""
        points, blocks = self.filled(1)
        blocks.insert(1, ("line", np.array([[0, 1], [1, 2]])))
        numbers = {"tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14, "line": 3}
        numbered = [(numbers[kind], cells[:, MIRRORED_WEDGE] if kind == "wedge" else cells) for kind, cells in blocks]
        rows = [row for _, cells in numbered for row in cells]
        types = np.concatenate([np.full(len(cells), number) for number, cells in numbered])
        flat, lists = np.concatenate(rows), lists_of(rows)
        offsets = np.append(0, np.cumsum([len(row) for row in rows]))
        ways = [dict(blocks), blocks, dict(numbered), numbered, [Block(*pair) for pair in blocks],
                [(kind, cells.tolist()) for kind, cells in blocks], [(kind, cells.astype("u8")) for kind, cells in blocks],
                (lists, types), (lists.astype("i4"), types.astype("u1")), (flat, offsets, types)]
        meshes = [Mesh(points, cells=[Block(*pair) for pair in blocks]), Mesh(points, cells=lists, celltypes=types)]
        expected = planish.quality(points, dict(blocks), per_element=True)
        self.assertEqual(sum(expected.cells.counts.values()), len(rows) - 2)
        self.assertEqual(expected.n_elements, expected.cells.counts["tetra"])
        after = points.copy()
        result = planish.smooth(after, dict(blocks))
        self.assertGreater(result.n_moved_nodes, 0)
        for given in [(points, cells) for cells in ways] + [(mesh,) for mesh in meshes]:
            found = planish.quality(*given, per_element=True)
            self.assertEqual(found.as_dict(), expected.as_dict())
            for ours, theirs in zip(found.elements, expected.elements):
                np.testing.assert_array_equal(ours, theirs)
            moved = points.copy()
            if len(given) == 1:
                given[0].points = moved
                planish.smooth(given[0])
            else:
                planish.smooth(moved, given[1])
            np.testing.assert_array_equal(moved, after)

    def test_order_of_types_that_alternate(self):
        points, blocks = self.filled(2)
        rows = [(kind, row) for kind, cells in blocks for row in cells]
        order = np.random.default_rng(3).permutation(len(rows))
        numbers = {"tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}
        mixed = [rows[i] for i in order]
        types = np.array([numbers[kind] for kind, _ in mixed])
        nodes = [row[MIRRORED_WEDGE] if kind == "wedge" else row for kind, row in mixed]
        expected = planish.quality(points, blocks, per_element=True)
        found = planish.quality(points, (lists_of(nodes), types), per_element=True)
        self.assertEqual(found.cells.counts, expected.cells.counts)
        for ours, theirs in zip(found.elements[1:], expected.elements[1:]):
            np.testing.assert_array_equal(ours, theirs[order])

    def test_measures_of_elements(self):
        points, blocks = self.filled(4, is_raised=True)
        blocks.insert(1, ("vertex", np.arange(3).reshape(3, 1)))
        found = planish.quality(points, blocks, per_element=True)
        of, one, all_of = found.cells, found.elements, found.cells.all
        self.assertEqual(len(one.state), all_of.n_elements)
        self.assertEqual((one.state == 2).sum() + (one.state == 3).sum(), all_of.n_inverted + all_of.n_uncertified * 0)
        self.assertEqual(one.is_curved.dtype, bool)
        self.assertEqual(one.is_curved.sum(), all_of.n_curved)
        self.assertEqual(one.aspect_ratio.max(), all_of.max_aspect_ratio)
        self.assertEqual(np.argmax(one.aspect_ratio), all_of.worst_element)
        self.assertEqual(one.scaled_jacobian.min(), all_of.min_scaled_jacobian)
        self.assertEqual(one.edge_ratio.max(), all_of.max_edge_ratio)
        first = len(blocks[0][1])
        np.testing.assert_array_equal(one.number, np.arange(len(one.number)) + 3 * (np.arange(len(one.number)) >= first))
        self.assertEqual(sum(measures.n_curved for measures in of.by_type.values()), all_of.n_curved)
        self.assertEqual(set(of.as_dict()["by_type"]), {kind for kind, _ in blocks} - {"vertex"})
        self.assertIn("max_aspect_ratio=", repr(of.all))
        self.assertIn("by_type", found.as_dict()["cells"])

    def test_simplices_alone(self):
        """Elements by type give the bits that their array gives, and measures only if asked for."""
        for dim, kind in ((2, "triangle"), (3, "tetra")):
            points, cells, _ = box(dim)
            plain, by_type = points.copy(), points.copy()
            planish.smooth(plain, cells)
            planish.smooth(by_type, {kind: cells})
            np.testing.assert_array_equal(by_type, plain)
            found, same = planish.quality(points, cells), planish.quality(points, {kind: cells})
            self.assertEqual(found.as_dict(), same.as_dict())
            self.assertIsNone(found.cells)
            asked = planish.quality(points, cells, per_element=True)
            self.assertEqual(asked.cells.counts, {kind: len(cells)})
            self.assertEqual(asked.elements.state.tolist(), [1] * len(cells))
            self.assertAlmostEqual(asked.cells.all.min_scaled_jacobian, asked.scaled_jacobian.min, 12)

    def test_mids_follow(self):
        for dim, kind in ((2, "triangle6"), (3, "tetra10")):
            corners, cells, inside = box(dim)
            points, quadratic = raised(corners, cells, kind)
            n, start = len(corners), points.copy()
            result = planish.smooth(points, {kind: quadratic})
            planish.smooth(corners, cells)
            np.testing.assert_array_equal(points[:n], corners)
            mids = quadratic[:, dim + 1:]
            ends = cells[:, MIDS[kind][1]]
            np.testing.assert_allclose(points[mids], points[ends].mean(axis=2), rtol=0, atol=1e-14)
            self.assertEqual((result.n_curved, result.n_inverted, result.n_refused), (0, 0, 0))
            np.testing.assert_array_equal(points[:n][~inside], start[:n][~inside])
            bent = start.copy()
            at = np.flatnonzero(inside[ends].all(axis=2).ravel())[0]
            bent[mids.ravel()[at], 0] += 0.02
            result = planish.smooth(bent, {kind: quadratic})
            off = bent[mids] - bent[ends].mean(axis=2)
            self.assertAlmostEqual(off[..., 0].max(), 0.02, 12)
            self.assertEqual(result.n_curved, (mids == mids.ravel()[at]).any(axis=1).sum())
            loose = start.copy()
            loose[mids.ravel()[at], 0] += 0.02
            self.assertEqual(planish.smooth(loose, {kind: quadratic}, rounding=0.03).n_curved, 0)
            self.assertEqual(planish.quality(loose, {kind: quadratic}, rounding=0.03).cells.all.n_curved, 0)
            self.assertGreater(planish.quality(loose, {kind: quadratic}).cells.all.n_curved, 0)
            single = (start * 0.001 + 1).astype(np.float32)
            self.assertEqual(planish.smooth(single, {kind: quadratic}).n_curved, 0)
            self.assertEqual(planish.quality(single, {kind: quadratic}).cells.all.n_curved, 0)
            self.assertGreater(planish.quality(single, {kind: quadratic}, rounding=0).cells.all.n_curved, 0)
            few = start.copy()
            missing = np.where(quadratic == mids.ravel()[at], -1, quadratic)
            planish.smooth(few, {kind: missing})
            np.testing.assert_array_equal(few[:n], corners)
            with planish.Plan(start.copy(), {kind: quadratic}) as plan:
                quadratic[:] = 0  # the plan has its own
                again = start.copy()
                plan.smooth(again)
                np.testing.assert_array_equal(again, points)

    def test_elements_that_hold(self):
        """A hexahedron beside tetrahedra holds its nodes, and arrays of elements have entries of its."""
        points, cells, inside = box(3)
        n, m = len(points), len(cells)
        hexahedron = np.arange(n, n + 8).reshape(1, 8)
        hexahedron[0, :2] = np.flatnonzero(inside)[:2]
        more = np.concatenate([points, np.array(UNITS["hexahedron"]) + 20.0])
        expected = more.copy()
        planish.smooth(expected, cells, fixed=hexahedron[0, :2])
        halves = np.where(np.round(points[cells]).min(axis=1)[:, 0] >= 3, 5, -2)
        least = np.full(m, 0.1)
        for blocks, joined in (([("tetra", cells), ("hexahedron", hexahedron)], lambda a, b: np.append(a, b)),
                               ([("hexahedron", hexahedron), ("tetra", cells)], lambda a, b: np.append(b, a))):
            moved = more.copy()
            planish.smooth(moved, blocks)
            np.testing.assert_array_equal(moved, expected)
            by_regions, alone = more.copy(), more.copy()
            planish.smooth(by_regions, blocks, regions=joined(halves, 7))
            planish.smooth(alone, cells, regions=halves, fixed=hexahedron[0, :2])
            np.testing.assert_array_equal(by_regions, alone)
            with self.assertRaisesRegex(ValueError, f"each of {m + 1} elements"):
                planish.smooth(more.copy(), blocks, regions=halves)
            low, alone = more.copy(), more.copy()
            planish.smooth(low, blocks, min_volumes=joined(least, 9))
            planish.smooth(alone, cells, min_volumes=least, fixed=hexahedron[0, :2])
            np.testing.assert_array_equal(low, alone)
            with planish.Plan(more.copy(), blocks) as plan:
                ratios, found = plan.radius_ratios(), plan.quality()
            with planish.Plan(more.copy(), cells) as plan:
                np.testing.assert_array_equal(ratios, joined(plan.radius_ratios(), 0))
            self.assertEqual((found.n_elements, found.worst_element), (m, np.argmax(ratios)))
            self.assertEqual(planish.quality(more, blocks).worst_element, np.argmax(ratios))
            self.assertEqual(planish.find_layers(more, blocks).shape, (m + 1,))

    def test_layers_of_hexahedra_and_wedges(self):
        points = np.array(list(itertools.product(range(7), repeat=3)), dtype=float)
        cells = np.array([[np.ravel_multi_index(tuple(np.array(corner) + unit), (7,) * 3)
                           for unit in np.array(UNITS["hexahedron"])] for corner in itertools.product(range(6), repeat=3)])
        low = points[cells][:, :, 2].max(axis=1) <= 2
        wedges = np.concatenate([cells[~low][:, [0, 1, 2, 4, 5, 6]], cells[low][:, [0, 2, 3, 4, 6, 7]]])
        self.assertFalse(planish.find_layers(points, {"hexahedron": cells}).any())
        points[:, 2] *= np.where(points[:, 2] <= 2, 0.1, 1)
        np.testing.assert_array_equal(planish.find_layers(points, {"hexahedron": cells}), low)
        np.testing.assert_array_equal(planish.find_layers(points, {"wedge": wedges}), np.sort(low))

    def test_cells_of_lower_dimension_hold(self):
        """Lines and triangles hold their nodes, mids too."""
        points, cells, inside = box(3)
        stay = np.flatnonzero(inside)[:3]
        expected = points.copy()
        planish.smooth(expected, cells, fixed=stay)
        for kind, nodes in (("line3", stay), ("triangle", stay), ("vertex", stay[:, None]), ("line", stay[[0, 1, 1, 2]])):
            moved = points.copy()
            planish.smooth(moved, {"tetra": cells, kind: nodes.reshape(-1, {"line": 2, "vertex": 1}.get(kind, 3))})
            np.testing.assert_array_equal(moved, expected)
        missing = points.copy()
        planish.smooth(missing, {"tetra": cells, "line3": [[*stay[:2], -1], [*stay[1:], -1]]})
        np.testing.assert_array_equal(missing, expected)

    @unittest.skipIf(vtk is None, "without VTK")
    def test_grid_of_vtk(self):
        """What an UnstructuredGrid of pyvista has: views of VTK's own arrays."""
        points, blocks = self.filled(5)
        numbers = {"tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}
        grid, numbered = vtk.vtkUnstructuredGrid(), []
        coordinates = vtk.vtkPoints()
        coordinates.SetData(numpy_to_vtk(points, deep=True))
        grid.SetPoints(coordinates)
        for kind, cells in blocks:
            for row in cells[:, MIRRORED_WEDGE] if kind == "wedge" else cells:
                grid.InsertNextCell(numbers[kind], len(row), row.tolist())
        mesh = Mesh(vtk_to_numpy(grid.GetPoints().GetData()), cells=vtk_to_numpy(grid.GetCells().GetData()),
                    celltypes=vtk_to_numpy(grid.GetCellTypesArray()))
        self.assertEqual(planish.quality(mesh).as_dict(), planish.quality(points, blocks).as_dict())
        planish.smooth(mesh)
        planish.smooth(points, blocks)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points)

    def test_cells_that_are_not_known_hold(self):
        points, cells, inside = box(3)
        stay = np.flatnonzero(inside)[:3]
        expected = points.copy()
        planish.smooth(expected, cells, fixed=stay)
        mesh = Mesh(points.copy(), cells=lists_of([stay, *cells, stay[:2]]),
                    celltypes=np.array([7] + [10] * len(cells) + [4], dtype=np.uint8))
        planish.smooth(mesh)
        np.testing.assert_array_equal(mesh.points, expected)
        voxel = planish.quality(np.array(list(itertools.product(range(2), repeat=3)))[:, ::-1] * 1.0,
                                {"voxel": np.arange(8).reshape(1, 8)}).cells
        self.assertEqual((voxel.counts, voxel.all.max_aspect_ratio), ({"hexahedron": 1}, 1))

    def test_refusals(self):
        points, blocks = self.filled(6)
        good = dict(blocks)
        tetra = good["tetra"]

        def refuse(text, cells, error=ValueError, at=points):
            for call in planish.quality, planish.smooth:
                start = at.copy()
                with self.assertRaisesRegex(error, text):
                    call(at, cells)
                np.testing.assert_array_equal(at, start)

        def changed(kind, value, column=0, row=0):
            cells = good[kind].astype(np.int64)
            cells[row, column] = value
            return {**good, kind: cells}

        refuse("does not know cells of type 'tetra20'", {"tetra20": np.zeros((1, 20), dtype=int)})
        refuse("does not know cells of type 71", {71: tetra})
        refuse("does not know cells of type 'tet'; .* tetra10", {"tet": tetra})
        refuse(r"cells of type tetra10 must be \[m, 10\]", {"tetra10": tetra})
        refuse(r"cells of type 12 must be \[m, 8\], not \(32,\)", {12: np.arange(32)})
        refuse(r"cells of type tetra must be \[m, 4\]", {"tetra": [[0, 1, 2, 3], [4, 5]]})
        refuse("cells is empty", {})
        for bad in ({None: tetra}, {2.5: tetra}, {"tetra": None}, {"tetra": 3}):
            refuse("names or VTK's numbers and arrays, not", bad, TypeError)
        refuse("no elements", {"line": [[0, 1]]})
        refuse("no elements", {"tetra": np.zeros((0, 4), dtype=int)})
        refuse("type tetra must be integers", {"tetra": tetra.astype(float)}, TypeError)
        for wrong in (len(points), -1, -2):
            refuse(f"element {len(blocks[0][1]) if blocks[0][0] != 'tetra' else 0}.* has node {wrong}",
                   {blocks[0][0]: good[blocks[0][0]], **changed("tetra", wrong)}, planish.Error)
            refuse(f"line have node {wrong}", {**good, "line": [[0, wrong]]})
        refuse("node 1099511627776, which is out of range", changed("tetra", 1 << 40))
        refuse("line have node 1099511627776", {**good, "line": [[0, 1 << 40]]})
        refuse("twice", changed("tetra", tetra[0, 1]), planish.Error)
        bad = points.copy()
        bad[tetra[0, 0], 1] = np.nan
        with self.assertRaisesRegex(planish.Error, f"node {tetra[0, 0]}"):
            planish.quality(bad, good)
        lists = np.append(lists_of(tetra), lists_of(tetra[:1]))
        types = np.full(len(tetra) + 1, 10)
        self.assertEqual(planish.quality(points, (lists, types)).n_elements, len(types))
        refuse("has the count", (lists[:-1], types))
        refuse(f"has {len(types)} cells, but there are {len(types) - 1} types", (lists, types[1:]))
        refuse("cell 0 of type 12 has 4 nodes, not 8", (lists, np.full(len(types), 12)))
        refuse("0 .. 255", (lists, np.full(len(types), 300)))
        refuse("0 .. 255", (lists, np.full(len(types), -1)))
        refuse("integers", (lists, types.astype(float)), TypeError)
        refuse("offsets of", (tetra.ravel(), np.array([0, 8, 4]), np.array([10, 10])))
        refuse("offsets of", (tetra.ravel(), np.array([0, 4]), np.array([10])))
        refuse("columns", good, at=points[:, :2].copy())
        hexahedra = {"hexahedron": good["hexahedron"]}
        self.assertEqual(planish.quality(points, hexahedra).n_elements, 0)
        with self.assertRaisesRegex(planish.Error, "no tetrahedron"):
            planish.smooth(points, hexahedra)

    def test_random_damage(self):
        """Damaged cells give an error or a result, and an error leaves the points alone."""
        refused = 0
        for seed in range(150):
            random = np.random.default_rng(seed)
            points, blocks = self.filled(seed, is_raised=seed % 2 > 0, dim=2 + seed % 3 % 2)
            rows = [row.astype(np.int64) for _, cells in blocks for row in cells]
            types = np.concatenate([np.full(len(cells), planish._KNOWN[kind].number) for kind, cells in blocks])
            arrays = [np.concatenate(rows), np.append(0, np.cumsum([len(row) for row in rows])), types]
            if seed % 3 > 0:
                arrays = [lists_of(rows), types]
            for _ in range(random.integers(1, 4)):
                array = arrays[random.integers(len(arrays))]
                array[random.integers(len(array))] = random.choice([-2, -1, 0, 1, 4, 8, 10, 12, len(points), 1 << 31, 1 << 62])
            given, start = tuple(arrays), points.copy()
            for call in planish.quality, planish.find_layers, planish.smooth:
                try:
                    call(points, given)
                except ValueError as error:
                    self.assertIn(" ", str(error))
                    np.testing.assert_array_equal(points, start)
                    refused += 1
        self.assertGreater(refused, 200)

    @unittest.skipIf(meshio is None or not PROGRAM, "without meshio, or the program")
    def test_the_program_smooths_the_same(self):
        """Second order with bent edges, regions and lines; hexahedra beside tetrahedra."""
        straight, cells, inside = box(3, amount=0.2)
        points, quadratic = raised(straight, cells, "tetra10")
        mids = np.unique(quadratic[:, 4:])
        points[mids[::7]] += np.random.default_rng(3).uniform(-0.05, 0.05, (len(mids[::7]), 3))
        halves = np.where(np.round(straight[cells]).min(axis=1)[:, 0] >= 3, 5, -2)
        stay = np.flatnonzero(inside)[:2].reshape(1, 2)
        meshes = [(points, [("tetra10", quadratic)], {}),
                  (points, [("line", stay), ("tetra10", quadratic)], {"m": [[1], halves]})]
        mixed, blocks = self.filled(1)
        meshes.append((mixed, blocks, {"m": [np.arange(len(cells)) % 2 for _, cells in blocks]}))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            for points, blocks, data in meshes:
                meshio.Mesh(points, blocks, cell_data=data).write(path / "in.vtu")
                subprocess.run([PROGRAM, "smooth", path / "in.vtu", "-o", path / "out.vtu", "-q"], check=True)
                other = meshio.read(path / "in.vtu")
                result = planish.smooth(other)
                self.assertGreater(result.n_moved_nodes, 0)
                np.testing.assert_array_equal(other.points, meshio.read(path / "out.vtu").points)

    @unittest.skipIf(meshio is None or not PROGRAM, "without meshio, or the program")
    def test_the_program_measures_the_same(self):
        """Meshes of random elements, written by meshio."""
        names = {"tetra": "tetrahedron", "quad": "quadrilateral"}
        seen = {}
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(24):
                points, blocks = self.filled(seed, is_raised=True, dim=2 + (seed % 3 > 0))
                ours = planish.quality(points, blocks)
                path = pathlib.Path(folder, "in.vtu")
                if {"wedge15", "pyramid13"}.intersection(kind for kind, _ in blocks):
                    path = path.with_suffix(".vtk")
                    write_vtk(path, points, blocks)
                else:
                    meshio.Mesh(points, blocks).write(path)
                    self.assertEqual(planish.quality(meshio.read(path)).as_dict(), ours.as_dict())
                if ours.cells is None:
                    continue
                report = json.loads(subprocess.run([PROGRAM, "quality", path, "-q", "--json", "-"], check=True,
                                                   stdout=subprocess.PIPE).stdout)["quality"]
                for theirs, of in [(report, ours.cells.all)] + [
                        (theirs, ours.cells.by_type[next(kind for kind in ours.cells.counts if re.sub(
                            "^(tetra|quad)(?=[0-9]*$)", lambda found: names[found.group(1)], kind) == name)])
                        for name, theirs in report["by_type"].items()]:
                    for key, value in (("inverted", of.n_inverted), ("corner_inverted", of.n_inverted_corners),
                                       ("uncertified", of.n_uncertified), ("curved", of.n_curved),
                                       ("rms_aspect_ratio", of.rms_aspect_ratio or None),
                                       ("mean_aspect_ratio", of.mean_aspect_ratio or None),
                                       ("max_aspect_ratio", of.max_aspect_ratio or None),
                                       ("min_scaled_jacobian", of.min_scaled_jacobian)):
                        self.assertEqual(theirs[key], value, (seed, key))
                for kind, of in ours.cells.by_type.items():
                    seen[kind] = seen.get(kind, 0) + of.n_elements
        self.assertEqual(set(seen) | {"pyramid14"}, {*UNITS, *MIDS})


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
