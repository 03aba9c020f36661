"""Tests of the Python module: cells that are to have sizes."""

import unittest

import numpy as np

import planish

SIDE = 20


def squares():
    """Points and quadrilaterals of a square."""
    n = SIDE + 1
    x, y = np.meshgrid(np.arange(n) / SIDE, np.arange(n) / SIDE, indexing="ij")
    i, j = np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij")
    cells = (n * i + j).reshape(-1, 1) + [0, n, n + 1, 1]
    return np.column_stack([x.ravel(), y.ravel()]), {"quad": cells.astype(np.int32)}


def wanted(points):
    """Sizes: small on a circle."""
    return 0.1 + 2 * np.abs(np.hypot(points[:, 0] - 0.5, points[:, 1] - 0.5) - 0.25)


class Sizes(unittest.TestCase):
    def test_sizes_are_met(self):
        points, cells = squares()
        start, sizes = points.copy(), wanted(points)
        before = planish.size_quality(points, cells, size=sizes)
        planish.smooth(points, cells, size=sizes)
        after = planish.size_quality(points, cells, size=sizes, start=start, per_element=True)
        self.assertLess(after.rms_log, 0.6 * before.rms_log)
        self.assertEqual(after.n_elements, SIDE * SIDE)
        self.assertAlmostEqual(np.sqrt((np.log(after.ratio) ** 2).mean()), after.rms_log, 12)
        self.assertAlmostEqual(after.ratio[after.largest], after.max, 15)

    def test_a_weight_is_taken(self):
        points, cells = squares()
        start, sizes = points.copy(), wanted(points)
        planish.smooth(points, cells, size=sizes, size_weight=0.01)
        little = np.abs(points - start).max()
        points[:] = start
        planish.smooth(points, cells, size=sizes)
        self.assertLess(little, 0.5 * np.abs(points - start).max())

    def test_metrics_are_met(self):
        points, cells = squares()
        start, away = points.copy(), points - 0.5
        radius = np.hypot(*away.T) + 1e-3
        thin = 0.2 + 2 * np.abs(radius - 0.25)
        across = away / radius[:, None]
        metrics = np.eye(2) + (1 / np.minimum(1, thin) ** 2 - 1)[:, None, None] * across[:, :, None] * across[:, None, :]
        before = planish.quality(points, cells, size=metrics).cells.all
        planish.smooth(points, cells, size=metrics, size_weight=0.5)
        after = planish.quality(points, cells, size=metrics, start=start).cells.all
        self.assertLess(after.rms_aspect_ratio - 1, 0.6 * (before.rms_aspect_ratio - 1))
        self.assertEqual(after.n_inverted, 0)
        plain = planish.quality(points, cells).cells.all
        self.assertGreater(plain.rms_aspect_ratio, after.rms_aspect_ratio)
        points[:] = start
        planish.smooth(points, cells, size=metrics)
        sizes = planish.size_quality(points, cells, size=metrics, start=start)
        self.assertLess(sizes.rms_log, planish.size_quality(start, cells, size=metrics).rms_log)

    def test_metrics_are_relative(self):
        points, cells = squares()
        metrics = np.tile(np.eye(2), (len(points), 1, 1))
        metrics[:, 1, 1] = 1 + points[:, 0]
        found = [planish.quality(points, cells, size=factor * metrics).cells.all.rms_aspect_ratio
                 for factor in (1, 2.0 ** -996, 2.0 ** 1000)]
        self.assertEqual(found, [found[0]] * 3)

    def test_own_sizes(self):
        points, cells = squares()
        np.testing.assert_allclose(planish.find_sizes(points, cells), 1 / SIDE, rtol=1e-12)
        tri = np.array([[0, 1, 2]], dtype=np.int32)
        found = planish.find_sizes(np.array([[0, 0], [2, 0], [1, np.sqrt(3)]]), tri)
        np.testing.assert_allclose(found, 2, rtol=1e-12)

    def test_what_does_not_fit(self):
        points, cells = squares()
        sizes = wanted(points)
        matrices = np.tile(1e9 * np.eye(2), (len(sizes), 1, 1))
        matrices[3] = [[1, 0.5], [0, 1]]
        for wrong, text in ((sizes[1:], "size must have a number or a 2 x 2 matrix"), (0 * sizes, "has the size 0"),
                            (matrices, "must have symmetric ones; that of node 3 is not"),
                            (0 * matrices, "metric of node 0 is not positive definite; give"),
                            (np.nan * matrices, "metric of node 0 has an entry that is not finite")):
            with self.assertRaisesRegex((ValueError, planish.Error), text):
                planish.smooth(points, cells, size=wrong)
        with self.assertRaisesRegex(ValueError, "like or size, not both"):
            planish.smooth(points, cells, size=sizes, like=points.copy())
        with self.assertRaisesRegex(ValueError, "size or layers=.keep., not both"):
            planish.smooth(points, cells, size=sizes, layers="keep")
        with self.assertRaisesRegex(ValueError, "size_weight is for"):
            planish.smooth(points, cells, size_weight=0.5)


if __name__ == "__main__":
    unittest.main()
