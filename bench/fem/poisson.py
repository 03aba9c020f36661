"""poisson: linear elements for -div grad u = f on tetrahedra, and what they say about a mesh.

The domain is scaled to a largest extent of 1. The exact solution is u(s) = exp(a.s) sin(k.s), its
values are given on the boundary. Formulas: docs/fem.md. An inverted element enters with its signed
volume, as in a code that does not look at it.
"""
import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from scipy.special import roots_jacobi

from medit import boundary

GROWTH, WAVE = np.array([1, -0.5, 0.25]), np.array([4.0, 5.0, 6.0])  # a and k
QUADRATURE_POINTS = 4     # per direction: exact to degree 7
CG_TOLERANCE = 1e-10      # residual, relative to the right-hand side
CG_LIMIT = 20000          # iterations
EIGENVALUE_TOLERANCE = 1e-7


def exact(s):
    return np.exp(s @ GROWTH) * np.sin(s @ WAVE)


def exact_gradient(s):
    size, phase = np.exp(s @ GROWTH)[..., None], (s @ WAVE)[..., None]
    return size * (GROWTH * np.sin(phase) + WAVE * np.cos(phase))


def source(s):
    """-div grad of exact."""
    a2, k2, ak = GROWTH @ GROWTH, WAVE @ WAVE, GROWTH @ WAVE
    return np.exp(s @ GROWTH) * ((k2 - a2) * np.sin(s @ WAVE) - 2 * ak * np.cos(s @ WAVE))


def quadrature():
    """Barycentric coordinates [q][4] and weights [q] (sum 1): Gauss-Jacobi rules of a cube that is
    collapsed to the tetrahedron (Stroud's conical product)."""
    rules = []
    for power in (2, 1, 0):
        t, w = roots_jacobi(QUADRATURE_POINTS, power, 0)
        rules.append(((1 + t) / 2, w / w.sum()))
    (x, u), (y, v), (z, w) = rules
    x, y, z = (c.ravel() for c in np.meshgrid(x, y, z, indexing="ij"))
    first, second, third = x, (1 - x) * y, (1 - x) * (1 - y) * z
    points = np.stack([1 - first - second - third, first, second, third], axis=1)
    return points, np.einsum("i,j,k->ijk", u, v, w).ravel()


class Problem:
    """The linear system of a mesh, and the figures that it gives."""

    def __init__(self, points, tetrahedra):
        extent = np.ptp(points, axis=0).max()
        self.points = (points - points.min(axis=0)) / extent
        used = np.unique(tetrahedra)
        self.points = self.points[used]
        self.elements = np.searchsorted(used, tetrahedra)
        self.measure_elements()
        self.inner = np.setdiff1d(np.arange(len(self.points)), boundary(self.elements))
        self.stiffness = self.assemble_stiffness()
        self.mass = self.lump_mass()
        self.inner_stiffness = self.stiffness[self.inner][:, self.inner].tocsc()
        self.factors = splu(self.inner_stiffness, permc_spec="MMD_AT_PLUS_A",
                            options={"SymmetricMode": True})

    def measure_elements(self):
        """Signed volumes [m], positive for most; gradients [m][4][3] of the shape functions."""
        corner = self.points[self.elements]
        edges = corner[:, 1:] - corner[:, :1]
        self.volumes = np.linalg.det(edges) / 6
        if self.volumes.sum() < 0:
            self.volumes *= -1
        rest = np.linalg.inv(edges).transpose(0, 2, 1)
        self.gradients = np.concatenate([-rest.sum(axis=1, keepdims=True), rest], axis=1)

    def assemble_stiffness(self):
        blocks = np.einsum("k,kid,kjd->kij", self.volumes, self.gradients, self.gradients)
        rows = np.repeat(self.elements, 4, axis=1).ravel()
        columns = np.tile(self.elements, (1, 4)).ravel()
        size = len(self.points)
        return coo_matrix((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsr()

    def lump_mass(self):
        mass = np.zeros(len(self.points))
        np.add.at(mass, self.elements, self.volumes[:, None] / 4)
        return mass

    def load(self, of):
        rule, weights = quadrature()
        load = np.zeros(len(self.points))
        for at, weight in zip(rule, weights):
            here = np.einsum("i,kid->kd", at, self.points[self.elements])
            np.add.at(load, self.elements, (weight * self.volumes * of(here))[:, None] * at)
        return load

    def right_hand_side(self, solution, of):
        """Of the inner nodes, with the solution's values on the boundary."""
        given = solution(self.points)
        given[self.inner] = 0
        return (self.load(of) - self.stiffness @ given)[self.inner]

    def solve(self, solution=exact, of=source):
        """Values [n] at the nodes, by a direct solver."""
        values = solution(self.points)
        values[self.inner] = self.factors.solve(self.right_hand_side(solution, of))
        return values

    def errors(self, values):
        """L2 norm and H1 seminorm of the error, each relative to that of the solution."""
        rule, weights = quadrature()
        slope = np.einsum("ki,kid->kd", values[self.elements], self.gradients)
        error, norm = np.zeros(2), np.zeros(2)
        for at, weight in zip(rule, weights):
            here = np.einsum("i,kid->kd", at, self.points[self.elements])
            share = weight * np.abs(self.volumes)
            u, gradient = exact(here), exact_gradient(here)
            error += (share @ (values[self.elements] @ at - u) ** 2,
                      share @ ((slope - gradient) ** 2).sum(axis=1))
            norm += share @ u ** 2, share @ (gradient ** 2).sum(axis=1)
        return np.sqrt(error / norm)

    def conjugate_gradients(self):
        """Iterations with the diagonal as preconditioner; None if the matrix shows that it is not
        positive definite, or at the limit."""
        matrix, b = self.inner_stiffness, self.right_hand_side(exact, source)
        diagonal = matrix.diagonal()
        x, r, p, old = np.zeros_like(b), b.copy(), np.zeros_like(b), 1.0
        for iteration in range(CG_LIMIT):
            if np.linalg.norm(r) <= CG_TOLERANCE * np.linalg.norm(b):
                return iteration
            z = r / diagonal
            new = r @ z
            p = z + new / old * p
            product = matrix @ p
            curvature = p @ product
            if not (new > 0 and curvature > 0):
                return None
            x += new / curvature * p
            r -= new / curvature * product
            old = new
        return None

    def smallest_eigenvalue(self):
        """Of the stiffness matrix of the inner nodes; the negative one, if there is one."""
        size = len(self.inner)
        if (self.volumes <= 0).any():
            lowest = extreme(self.inner_stiffness, "SA")
            if lowest < 0:
                return lowest
        inverse = LinearOperator((size, size), matvec=self.factors.solve, dtype=float)
        return 1 / extreme(inverse, "LA")


def extreme(matrix, which):
    """The algebraically largest (LA) or smallest (SA) eigenvalue, by Lanczos from a fixed start."""
    start = np.random.default_rng(1).standard_normal(matrix.shape[0])
    return eigsh(matrix, k=1, which=which, v0=start, tol=EIGENVALUE_TOLERANCE, ncv=40,
                 maxiter=5000, return_eigenvectors=False)[0]


def by_mass(matrix, mass):
    """M^-1/2 K M^-1/2, which has the eigenvalues of M^-1 K."""
    root = diags(1 / np.sqrt(mass))
    return root @ matrix @ root


def largest_by_mass(matrix, mass):
    """Largest eigenvalue of M^-1 K, or None where a mass is not positive."""
    return extreme(by_mass(matrix, mass), "LA") if mass.min() > 0 else None


def linear_error(problem):
    """Largest error at the nodes where the solution is linear, so 0 but for rounding: a check."""
    def linear(s):
        return 1 + s @ WAVE
    return np.abs(problem.solve(linear, lambda s: 0 * s[:, 0]) - linear(problem.points)).max()


def figures(points, tetrahedra):
    """All figures of a mesh, as a dictionary."""
    problem = Problem(points, tetrahedra)
    l2, h1 = problem.errors(problem.solve())
    smallest = problem.smallest_eigenvalue()
    inner = largest_by_mass(problem.inner_stiffness, problem.mass[problem.inner])
    natural = largest_by_mass(problem.stiffness, problem.mass)
    return {"nodes": len(problem.points), "inner": len(problem.inner),
            "elements": len(tetrahedra), "linear_error": linear_error(problem), "l2": l2, "h1": h1,
            "largest": extreme(problem.inner_stiffness, "LA"), "smallest": smallest,
            "iterations": problem.conjugate_gradients(),
            "largest_by_mass": inner, "largest_by_mass_natural": natural,
            "definite": bool(smallest > 0)}
