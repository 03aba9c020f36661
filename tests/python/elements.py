"""Tests of the Python module with cells of any type."""

import itertools
import json
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np

import planish
from planish._cell_types import KNOWN
from module import PROGRAM, Block, Mesh, box, lists_of, meshio

try:
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
except ImportError:
    vtk = None

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
    rows = [[KNOWN[kind].number, len(row), *(row[MIRRORED_WEDGE] if kind == "wedge" else row)]
            for kind, cells in blocks for row in cells]
    lines = ["# vtk DataFile Version 3.0", "mixed", "ASCII", "DATASET UNSTRUCTURED_GRID",
             f"POINTS {len(points)} double", *(" ".join(map(repr, point)) for point in points.tolist()),
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
                [(kind, cells.tolist()) for kind, cells in blocks],
                [(kind, cells.astype("u8")) for kind, cells in blocks],
                (lists, types), (lists.astype("i4"), types.astype("u1")), (flat, offsets, types),
                tuple(array.astype("u8") for array in (flat, offsets, types)), [*blocks, ("wedge15", [])]]
        meshes = [Mesh(points, cells=[Block(*pair) for pair in blocks]), Mesh(points, cells=lists, celltypes=types)]
        expected = planish.quality(points, dict(blocks), per_element=True)
        self.assertEqual(sum(expected.cells.counts.values()), len(rows) - 2)
        self.assertEqual(expected.n_elements, len(rows) - 2)
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
        self.assertEqual([(one.state == state).sum() for state in (2, 3)], [all_of.n_inverted, all_of.n_uncertified])
        self.assertGreater(all_of.n_inverted, 0)
        self.assertEqual(one.is_curved.dtype, bool)
        self.assertEqual(one.is_curved.sum(), all_of.n_curved)
        self.assertEqual(one.aspect_ratio.max(), all_of.max_aspect_ratio)
        self.assertEqual(np.argmax(one.aspect_ratio), all_of.worst_element)
        self.assertEqual(one.scaled_jacobian.min(), all_of.min_scaled_jacobian)
        self.assertEqual(one.edge_ratio.max(), all_of.max_edge_ratio)
        numbers = np.arange(len(one.number))
        np.testing.assert_array_equal(one.number, numbers + 3 * (numbers >= len(blocks[0][1])))
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
        """A pyramid of second order beside tetrahedra holds its nodes, and arrays of elements have entries of
        its."""
        points, cells, inside = box(3)
        n, m = len(points), len(cells)
        corners, pyramid = self.unit("pyramid13")
        pyramid = pyramid + n
        pyramid[0, :2] = np.flatnonzero(inside)[:2]
        more = np.concatenate([points, corners + 20.0])
        expected = more.copy()
        planish.smooth(expected, cells, fix=pyramid[0, :2])
        halves = np.where(np.round(points[cells]).min(axis=1)[:, 0] >= 3, 5, -2)
        least = np.full(m, 0.1)
        for blocks, joined in (([("tetra", cells), ("pyramid13", pyramid)], lambda a, b: np.append(a, b)),
                               ([("pyramid13", pyramid), ("tetra", cells)], lambda a, b: np.append(b, a))):
            moved = more.copy()
            planish.smooth(moved, blocks)
            np.testing.assert_array_equal(moved, expected)
            by_regions, alone = more.copy(), more.copy()
            planish.smooth(by_regions, blocks, regions=joined(halves, 7))
            planish.smooth(alone, cells, regions=halves, fix=pyramid[0, :2])
            np.testing.assert_array_equal(by_regions, alone)
            rows = [row for _, nodes in blocks for row in nodes]
            grid = Mesh(more.copy(), cells=lists_of(rows), celltypes=joined(np.full(m, 10), 27),
                        cell_data={"m": joined(halves, 7)})
            planish.smooth(grid)
            np.testing.assert_array_equal(grid.points, by_regions)
            with self.assertRaisesRegex(ValueError, f"each of {m + 1} elements"):
                planish.smooth(more.copy(), blocks, regions=halves)
            low, alone = more.copy(), more.copy()
            planish.smooth(low, blocks, min_volume=joined(least, 9))
            planish.smooth(alone, cells, min_volume=least, fix=pyramid[0, :2])
            np.testing.assert_array_equal(low, alone)
            with planish.Plan(more.copy(), blocks) as plan:
                ratios, found = plan.radius_ratios(), plan.quality()
            with planish.Plan(more.copy(), cells) as plan:
                np.testing.assert_array_equal(ratios, joined(plan.radius_ratios(), 0))
            self.assertEqual((found.n_elements, found.worst_element), (m, np.argmax(ratios)))
            self.assertEqual(planish.quality(more, blocks).worst_element, np.argmax(ratios))
            self.assertEqual(planish.find_layers(more, blocks).shape, (m + 1,))

    def grid(self, kind, n, amount, seed=1):
        """The unit cube or square of n^dim cells, nodes inside off their places by up to amount of a cell:
        points, cells, mask of the nodes inside."""
        dim = 2 if kind in ("quad", "triangle") else 3
        points = np.array(list(itertools.product(range(n + 1), repeat=dim)), dtype=float)
        at = np.array([[np.ravel_multi_index(tuple(np.array(corner) + unit[:dim]), (n + 1,) * dim)
                        for unit in np.array(UNITS["hexahedron" if dim == 3 else "quad"])]
                       for corner in itertools.product(range(n), repeat=dim)])
        cells = at
        if kind == "wedge":
            cells = np.concatenate([at[:, [0, 1, 2, 4, 5, 6]], at[:, [0, 2, 3, 4, 6, 7]]])[:, MIRRORED_WEDGE]
        if kind == "pyramid":
            middle = np.arange(len(points), len(points) + len(at))
            points = np.concatenate([points, points[at].mean(axis=1)])
            cells = np.concatenate([np.column_stack([at[:, face], middle]) for face in FACES[:6]])
        inside = ((points > 0) & (points < n)).all(axis=1)
        points[inside] += np.random.default_rng(seed).uniform(-amount, amount, points[inside].shape)
        return (np.column_stack([points, np.zeros(len(points))]) if dim == 2 else points) / n, cells, inside

    def test_all_types_are_smoothed(self):
        for kind in ("quad", "hexahedron", "wedge", "pyramid"):
            for amount in (0.2, 0.7):  # valid; tangled
                points, cells, inside = self.grid(kind, 8 if kind == "quad" else 5, amount)
                start, blocks = points.copy(), {kind: cells}
                before = planish.quality(start, blocks).cells.all
                result = planish.smooth(points, blocks)
                after = planish.quality(points, blocks).cells.all
                self.assertEqual((after.n_inverted, result.n_inverted), (0, 0), kind)
                np.testing.assert_array_equal(points[~inside], start[~inside])
                self.assertTrue((points[inside] != start[inside]).any(axis=1).all(), kind)
                self.assertEqual(before.n_inverted > 0, amount > 0.5, kind)
                if before.n_inverted == 0:
                    self.assertLess(after.rms_aspect_ratio, before.rms_aspect_ratio)
                    self.assertLessEqual(after.max_aspect_ratio, before.max_aspect_ratio)
                    self.assertGreaterEqual(after.min_scaled_jacobian, before.min_scaled_jacobian)
                self.assertAlmostEqual(after.rms_aspect_ratio, planish.quality(points, blocks).rms_radius_ratio, 12)
                for threads in (1, 3):
                    again = start.copy()
                    planish.smooth(again, blocks, threads=threads)
                    np.testing.assert_array_equal(again, points)
                higher = [name for name, (low, _) in MIDS.items() if low == kind and kind != "pyramid"]
                for name in higher:  # corners move as they do by themselves, others follow
                    more, quadratic = raised(start.copy(), cells, name) if kind != "wedge" else raised(
                        start.copy(), cells[:, MIRRORED_WEDGE], name)
                    planish.smooth(more, {name: quadratic})
                    np.testing.assert_array_equal(more[:len(points)], points, name)
                    ends = quadratic[:, :len(UNITS[kind])]
                    for i, corners in enumerate(MIDS[name][1], len(UNITS[kind])):
                        np.testing.assert_allclose(more[quadratic[:, i]], more[ends[:, corners]].mean(axis=1), rtol=0,
                                                   atol=1e-14)

    def test_mixed_meshes_are_smoothed(self):
        for seed in range(4):
            points, blocks = self.filled(seed, dim=2 + seed % 2)
            before, start = planish.quality(points, blocks).cells.all, points.copy()
            planish.smooth(points, blocks)
            after = planish.quality(points, blocks).cells.all
            self.assertLessEqual(after.n_inverted, before.n_inverted)
            self.assertFalse(np.array_equal(points, start))
            worst = start.copy()
            result = planish.smooth(worst, blocks, objective="worst", worst_rise=0.05)
            self.assertGreaterEqual(result.worst_after, result.worst_before)
            self.assertGreater(result.worst_sweeps, 0)
            few = start.copy()
            planish.smooth(few, blocks, only_worse_than=1.2)
            self.assertFalse(np.array_equal(few, start))

    def test_options_of_types(self):
        points, cells, inside = self.grid("hexahedron", 4, 0.2)
        flat, triangles, _ = box(2)
        for options in ({"objective": "radius-ratio"}, {"objective": "worst", "worst_measure": "dihedral"},
                        {"worst_measure": "radius-ratio"}, {"layers": "some"}):
            with self.assertRaises(ValueError):
                planish.smooth(points.copy(), {"hexahedron": cells}, **options)
        with self.assertRaisesRegex(ValueError, "other elements"):
            planish.smooth(flat, triangles, objective="worst", worst_measure="scaled-jacobian")
        for options in ({"objective": "mean-ratio"}, {"objective": "edge-ratio"},
                        {"objective": "worst", "worst_measure": "aspect-ratio"}, {"curve_quality": 0}):
            moved = points.copy()
            self.assertEqual(planish.smooth(moved, {"hexahedron": cells}, **options).n_inverted, 0)
            self.assertTrue((moved != points).any(axis=1)[inside].all())

    def test_layers_are_kept_or_held(self):
        points, cells, inside = self.grid("hexahedron", 6, 0)
        points[:, 2] = np.where(points[:, 2] < 0.4, points[:, 2] / 8, points[:, 2])  # two rows, and a higher one
        low = points[:, 2] < 0.05
        random = np.random.default_rng(2)  # boxes alone have the best scaled Jacobian, and stay
        points[inside] += np.where(low[inside], 0.002, 0.02)[:, None] * random.uniform(-1, 1, (inside.sum(), 3))
        low = np.round(points[:, 2] * 48) < 3
        results = {}
        for layers, is_held in ((None, False), ("keep", False), ("hold", True), ("ignore", False)):
            moved = points.copy()
            planish.smooth(moved, {"hexahedron": cells}, layers=layers)
            self.assertEqual(np.array_equal(moved[low], points[low]), is_held, layers)
            self.assertFalse(np.array_equal(moved, points))
            results[layers] = moved
        np.testing.assert_array_equal(results[None], results["keep"])  # the default of smooth
        for options in {"objective": "worst"}, {"objective": "edge-ratio"}, {"size": planish.find_sizes(points, {"hexahedron": cells})}:
            moved = points.copy()
            planish.smooth(moved, {"hexahedron": cells}, **options)
            np.testing.assert_array_equal(moved[low], points[low])  # which cannot keep heights with these
        moved = points.copy()
        with planish.Plan(moved, {"hexahedron": cells}) as plan:  # it does not know what is to be smoothed for
            plan.smooth(moved)
        np.testing.assert_array_equal(moved, results["hold"])

    def test_progress_stops_types(self):
        points, cells, _ = self.grid("hexahedron", 6, 0.7)
        moved = points.copy()
        result = planish.smooth(moved, {"hexahedron": cells}, progress=lambda seen: seen.sweep >= 1)
        self.assertEqual(result.stop, "interrupted")
        self.assertLessEqual(planish.quality(moved, {"hexahedron": cells}).cells.all.n_inverted,
                             planish.quality(points, {"hexahedron": cells}).cells.all.n_inverted)
        result = planish.smooth(points.copy(), {"hexahedron": cells}, time_limit=1e-9)
        self.assertEqual(result.stop, "time-limit")

    def test_layers_of_hexahedra_and_wedges(self):
        points = np.array(list(itertools.product(range(7), repeat=3)), dtype=float)
        cells = np.array([[np.ravel_multi_index(tuple(np.array(corner) + unit), (7,) * 3)
                           for unit in np.array(UNITS["hexahedron"])]
                          for corner in itertools.product(range(6), repeat=3)])
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
        planish.smooth(expected, cells, fix=stay)
        for kind, nodes in (("line3", stay), ("triangle", stay), ("vertex", stay), ("line", stay[[0, 1, 1, 2]])):
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
        grid = vtk.vtkUnstructuredGrid()
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
        planish.smooth(expected, cells, fix=stay)
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
        refuse("offsets of", (np.arange(12), np.array([0, 8, 4, 12], dtype="u4"), np.full(3, 42)))
        refuse("columns", good, at=points[:, :2].copy())
        corners, pyramid = self.unit("pyramid13")
        self.assertEqual(planish.quality(corners, {"pyramid13": pyramid}).n_elements, 0)
        with self.assertRaisesRegex(planish.Error, "no tetrahedron"):
            planish.smooth(corners, {"pyramid13": pyramid})

    def test_random_damage(self):
        """Damaged cells give an error or a result, and an error leaves the points alone."""
        refused = 0
        for seed in range(150):
            random = np.random.default_rng(seed)
            points, blocks = self.filled(seed, is_raised=seed % 2 > 0, dim=2 + seed % 3 % 2)
            rows = [row.astype(np.int64) for _, cells in blocks for row in cells]
            types = np.concatenate([np.full(len(cells), KNOWN[kind].number) for kind, cells in blocks])
            arrays = [np.concatenate(rows), np.append(0, np.cumsum([len(row) for row in rows])), types]
            if seed % 3 > 0:
                arrays = [lists_of(rows), types]
            for _ in range(random.integers(1, 4)):
                array = arrays[random.integers(len(arrays))]
                wrong = [-2, -1, 0, 1, 4, 8, 10, 12, len(points), 1 << 31, 1 << 62]
                array[random.integers(len(array))] = random.choice(wrong)
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


if __name__ == "__main__":
    unittest.main()
