"""Tests of the Python module: elements whose targets are their shapes in another mesh."""

import unittest

import numpy as np

import planish

from module import box

CORNERS = (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)


def bricks(cells=5):
    """Points and hexahedra of a cube whose rows grow from the wall z = 0."""
    n = cells + 1
    at = np.array([(x, y, z) for x in range(n) for y in range(n) for z in range(n)], dtype=float)
    points = at / cells
    points[:, 2] = (2.0 ** at[:, 2] - 1) / (2.0 ** cells - 1)
    found = [[int(np.ravel_multi_index((x + a, y + b, z + c), (n, n, n))) for a, b, c in CORNERS]
             for x in range(cells) for y in range(cells) for z in range(cells)]
    return points, np.array(found, dtype=np.int32)


def ratios(points, reference, cells):
    """AR of simplices against those of reference."""
    dim = cells.shape[1] - 1

    def edges(at):
        return np.swapaxes(at[cells[:, 1:]] - at[cells[:, :1]], 1, 2)

    t = edges(points[:, :dim]) @ np.linalg.inv(edges(reference[:, :dim]))
    return (t ** 2).sum(axis=(1, 2)) / (dim * np.linalg.det(t) ** (2 / dim))


class Reference(unittest.TestCase):
    def test_a_mesh_that_is_its_target_stays(self):
        for dim in 2, 3:
            points, cells, _ = box(dim)
            start = points.copy()
            result = planish.smooth(points, cells, like=points)
            self.assertAlmostEqual(result.rms, 1, 12)
            np.testing.assert_allclose(points, start, atol=1e-9)

    def test_quality(self):
        for dim in 2, 3:
            points, cells, _ = box(dim, seed=2)
            reference, _, _ = box(dim, seed=3)
            wanted = ratios(points, reference, cells)
            for given, asked in ((reference, {}), (np.asfortranarray(reference), {"per_element": True}),
                                 (np.hstack([reference, np.zeros((len(reference), 3 - dim))]), {})):
                found = planish.quality(points, cells, like=given, **asked)
                self.assertAlmostEqual(found.cells.all.rms_aspect_ratio, np.sqrt((wanted ** 2).mean()), 12)
                self.assertAlmostEqual(found.cells.all.max_aspect_ratio, wanted.max(), 11)
                self.assertAlmostEqual(found.rms_radius_ratio, found.cells.all.rms_aspect_ratio, 12)
            found = planish.quality(points, cells, like=reference, per_element=True)
            np.testing.assert_allclose(found.elements.aspect_ratio, wanted, rtol=1e-11)

    def test_layers_survive(self):
        start, cells = bricks()
        wall = start[:, 2] == 0
        inner = ((start > 0) & (start < 1)).all(axis=1)
        deformed = start.copy()
        deformed[wall, 2] += 0.02 * (np.sin(np.pi * start[:, 0]) * np.sin(np.pi * start[:, 1]))[wall]
        first = (np.arange(len(start)) % 6 == 1) & inner
        heights = {}
        for name, reference in (("like", start), ("regular", None)):
            points = deformed.copy()
            layers = "ignore" if reference is None else None  # those that are targets are not held
            with planish.Plan(points, {"hexahedron": cells}, like=reference, layers=layers) as plan:
                self.assertEqual(plan.free().sum(), inner.sum())
                plan.smooth(points)
            heights[name] = points[first, 2] - points[np.flatnonzero(first) - 1, 2]
        wanted = start[first, 2]
        self.assertLess(abs(heights["like"] / wanted - 1).max(), 0.1)
        self.assertGreater(abs(heights["regular"] / wanted - 1).max(), 0.3)

    def test_layers_keep_their_heights(self):
        start, cells = bricks(8)
        start[:, :2] *= 30
        inner = np.ones(len(start), dtype=bool)
        for d in range(3):
            inner &= (start[:, d] > 0) & (start[:, d] < start[:, d].max())
        pushed = start.copy()
        bends = np.repeat(np.random.default_rng(5).uniform(-0.4, 0.4, (81, 2)), 9, axis=0)  # of each column
        pushed[inner, :2] += (bends * (start[:, 2:] * (1 - start[:, 2:])))[inner]
        points = pushed.copy()
        with planish.Plan(points, {"hexahedron": cells}, layers="keep") as plan:
            before = plan.quality(points).rms_radius_ratio
            self.assertEqual(plan.free().sum(), inner.sum())
            result = plan.smooth(points)
        self.assertLess(result.rms, before)
        self.assertLess(np.square(points - start).sum(), 0.05 * np.square(pushed - start).sum())
        above = np.flatnonzero(inner)
        heights, wanted = (at[above, 2] - at[above - 1, 2] for at in (points, start))
        self.assertLess(abs(heights / wanted - 1).max(), 0.1)
        with self.assertRaisesRegex(ValueError, "like or layers='keep'"):
            planish.smooth(points, {"hexahedron": cells}, layers="keep", like=start)
        with self.assertRaisesRegex(ValueError, "hold, keep, ignore"):
            planish.smooth(points, {"hexahedron": cells}, layers="kept")

    def test_heights_of_layers(self):
        """Heights are those of plain differences, where columns are upright."""
        start, cells = bricks(8)
        start[:, :2] *= 30
        layers = planish.find_layers(start, {"hexahedron": cells})
        self.assertTrue(layers.any())
        rows = int(np.unique(start[cells[layers]][:, :, 2]).size) - 1
        moved = start.copy()
        moved[np.arange(len(start)) % 9 == 1, 2] *= 1.25  # the lowest row is higher, the next one less high
        found = planish.layer_heights(moved, {"hexahedron": cells}, start=start, per_node=True)
        z = start[:9, 2]
        second = (z[2] - 1.25 * z[1]) / (z[2] - z[1])
        self.assertEqual(len(found.by_row), rows)
        self.assertEqual([row.n for row in found.by_row], [81] * rows)
        self.assertEqual((found.all.n, found.n_told, found.reference.min), (81 * rows, 0, 1))
        for row, height in zip(found.by_row, [1.25, second] + [1] * rows):
            for value in row.min, row.median, row.max:
                self.assertAlmostEqual(value, height, 9)
        self.assertAlmostEqual(found.off.max(), 0.25, 9)
        self.assertEqual(found.off.shape, (len(start),))
        self.assertEqual(found.as_dict()["by_row"][0]["n"], 81)
        self.assertRegex(str(found), r"(?m)^edges +\d+$")
        self.assertIsNone(planish.layer_heights(moved, {"hexahedron": cells}, start=start).off)
        with self.assertRaisesRegex(ValueError, "start must have a row"):
            planish.layer_heights(moved, {"hexahedron": cells}, start=start[1:])

    def test_refusals(self):
        points, cells, _ = box(3)
        for wrong in points[1:], 3.0, "text", points.astype(int), points[:, :2]:
            self.assertRaises((TypeError, ValueError), planish.quality, points, cells, like=wrong)
        flat = points * (1, 1, 0)
        with self.assertRaisesRegex(planish.Error, "element 0 is flat in mesh.reference"):
            planish.smooth(points, cells, like=flat)
        with self.assertRaisesRegex(planish.Error, "element 0 is inverted in mesh.reference"):
            planish.quality(points, cells, like=-points)
        for objective in "worst", "edge-ratio":
            with self.assertRaisesRegex((ValueError, planish.Error), "mesh.reference"):
                planish.smooth(points, cells, like=points, objective=objective)
        ball = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, -1]])
        faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
        for call in planish.smooth, planish.quality:
            with self.assertRaisesRegex(ValueError, "like is not for surfaces in space"):
                call(ball, faces, like=ball)


if __name__ == "__main__":
    unittest.main()
