"""optimum: the least RMS of aspect ratios of simplices against targets, over all inner nodes at once, by
scipy's L-BFGS-B. It has its own formulas and derivatives, and knows nothing of planish."""
import numpy as np
from scipy.optimize import minimize

import ratios

ROUNDS = 40        # of L-BFGS, each from where the one before ended
ENOUGH = 1e-8      # relative decrease of a round that is the last


class Problem:
    """F = sum of mu^2 over the elements, as a function of the places of free nodes."""

    def __init__(self, points, targets, elements, free):
        self.points, self.elements, self.free = points.copy(), elements, np.flatnonzero(free)
        self.dim = points.shape[1]
        self.inverse = np.linalg.inv(ratios.matrices(targets, elements))
        self.invalid = np.inf  # the value where an element is inverted: line searches get on with a finite one

    def value_and_slope(self, x):
        dim, points = self.dim, self.points
        points[self.free] = x.reshape(-1, dim)
        t = ratios.matrices(points, self.elements) @ self.inverse
        determinant = np.linalg.det(t)
        if determinant.min() <= 0:
            return self.invalid, np.zeros_like(x)
        square = (t * t).sum(axis=(1, 2))
        mu = square / (dim * determinant ** (2 / dim))
        # d mu / dT = mu (2 T / |T|^2 - 2 / dim T^-T), and T = A W^-1
        by_t = t / square[:, None, None] - np.linalg.inv(t).transpose(0, 2, 1) / dim
        by_edges = (4 * mu * mu)[:, None, None] * by_t @ self.inverse.transpose(0, 2, 1)
        by_node = np.concatenate([-by_edges.sum(axis=2)[:, :, None], by_edges], axis=2)
        ends = self.elements.ravel()
        slope = np.stack([np.bincount(ends, by_node[:, d].ravel(), len(points)) for d in range(dim)], axis=1)
        return (mu * mu).mean(), slope[self.free].ravel() / len(mu)

    def least(self, start, iterations):
        """RMS, and the number of iterations, of a descent from valid points."""
        x, done = start[self.free].ravel(), 0
        value, _ = self.value_and_slope(x)
        for _ in range(ROUNDS):
            self.invalid = 2 * value
            result = minimize(self.value_and_slope, x, jac=True, method="L-BFGS-B",
                              options={"maxiter": iterations - done, "maxfun": 4 * iterations, "maxcor": 30,
                                       "ftol": 1e-14, "gtol": 1e-12})
            x, before, value, done = result.x, value, result.fun, done + result.nit
            if value > (1 - ENOUGH) * before or done >= iterations:
                break
        return float(np.sqrt(value)), done
