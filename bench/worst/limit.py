"""The limit of the worst tetrahedron of a mesh, by sequential linear programs over all free nodes.

Each program raises the least of the linearised measures of all bad tetrahedra within a trust region, a box around
each node (HiGHS, by SciPy). Boundary nodes, those between regions, and nodes of elements of lower dimension are fixed.
"""
try:
    import meshio
    import numpy as np
    import scipy.optimize
    import scipy.sparse
except ImportError:
    meshio = None

BAND = {"dihedral": 8, "radius-ratio": 0.2}  # measures within it of the least are in a program: degrees, 1 / RR
PROGRAMS = 200
PAIRS = [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)]


def is_possible():
    """Whether the packages are there."""
    return meshio is not None


def dot(a, b):
    return np.einsum("ij,ij->i", a, b)


def angles(x):
    """Return the dihedral angles [n][6] in degrees of tetrahedra x [n][4][3]."""
    found = []
    for a, b, c, d in PAIRS:
        e = x[:, b] - x[:, a]
        n1, n2 = np.cross(e, x[:, c] - x[:, a]), np.cross(e, x[:, d] - x[:, a])
        found.append(np.arctan2(np.linalg.norm(np.cross(n1, n2), axis=1), dot(n1, n2)))
    return np.degrees(np.array(found).T)


def ratios(x):
    """Return 1 / RR [n][1] of tetrahedra x [n][4][3]."""
    a, b, c = (x[:, k] - x[:, 0] for k in (1, 2, 3))
    volume = dot(a, np.cross(b, c))
    faces = sum(np.linalg.norm(np.cross(p, q), axis=1) for p, q in ((a, b), (b, c), (c, a), (b - a, c - a)))
    w = sum(dot(p, p)[:, None] * np.cross(q, r) for p, q, r in ((a, b, c), (b, c, a), (c, a, b)))
    return (6 * volume * np.abs(volume) / (np.linalg.norm(w, axis=1) * faces))[:, None]


def slopes(measure, x, step):
    """Return the derivatives [n][k][4][3] of the measures [n][k], by central differences."""
    found = np.zeros(measure(x).shape + (4, 3))
    for v in range(4):
        for d in range(3):
            up, down = x.copy(), x.copy()
            up[:, v, d] += step
            down[:, v, d] -= step
            found[:, :, v, d] = (measure(up) - measure(down)) / (2 * step)
    return found


def between(mesh, tetrahedra):
    """Return the numbers of the nodes whose tetrahedra have different references, of the first kind there is."""
    for name in ("gmsh:physical", "medit:ref"):
        if name in mesh.cell_data:
            of = np.concatenate([d for c, d in zip(mesh.cells, mesh.cell_data[name]) if c.type == "tetra"])
            least, most = np.full(len(mesh.points), of.max()), np.full(len(mesh.points), of.min())
            for k in range(4):
                np.minimum.at(least, tetrahedra[:, k], of)
                np.maximum.at(most, tetrahedra[:, k], of)
            return np.where(least < most)[0]
    return []


def free_nodes(mesh, tetrahedra):
    """Return the numbers of the nodes that may move."""
    facets = np.sort(np.concatenate([tetrahedra[:, k] for k in ([1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2])]), 1)
    facets, count = np.unique(facets, axis=0, return_counts=True)
    is_free = np.zeros(len(mesh.points), bool)
    is_free[tetrahedra.ravel()] = True
    is_free[facets[count == 1].ravel()] = False
    for cells in mesh.cells:
        if cells.type in ("triangle", "line", "vertex"):
            is_free[cells.data.ravel()] = False
    is_free[between(mesh, tetrahedra)] = False
    return np.where(is_free)[0]


def solve(values, slope, bad, place, tetrahedra, n, radius):
    """Return the step [n][3] of one program, or None."""
    rows, columns, entries = [], [], []
    for r, (t, k) in enumerate(bad):
        for v in range(4):
            i = place[tetrahedra[t, v]]
            if i >= 0:
                rows += [r] * 3
                columns += [3 * i, 3 * i + 1, 3 * i + 2]
                entries += list(-slope[t][k, v])
        rows.append(r)
        columns.append(3 * n)
        entries.append(1.0)
    matrix = scipy.sparse.csr_matrix((entries, (rows, columns)), shape=(len(bad), 3 * n + 1))
    cost = np.zeros(3 * n + 1)
    cost[-1] = -1
    result = scipy.optimize.linprog(cost, A_ub=matrix, b_ub=values[bad[:, 0], bad[:, 1]], method="highs",
                                    bounds=[(-radius, radius)] * (3 * n) + [(None, None)])
    return None if result.status else result.x[:-1].reshape(-1, 3)


def limit_of(path, measure):
    """Return the worst measure that is reached from the mesh at path: degrees, or RR."""
    mesh = meshio.read(path)
    points = mesh.points.astype(float)
    tetrahedra = np.concatenate([c.data for c in mesh.cells if c.type == "tetra"])
    edge = [points[tetrahedra[:, k]] - points[tetrahedra[:, 0]] for k in (1, 2, 3)]
    turned = dot(edge[0], np.cross(edge[1], edge[2])) < 0
    tetrahedra[turned] = tetrahedra[turned][:, [0, 2, 1, 3]]
    free = free_nodes(mesh, tetrahedra)
    place = -np.ones(len(points), int)
    place[free] = np.arange(len(free))
    tetrahedra = tetrahedra[(place[tetrahedra] >= 0).any(1)]
    size = np.linalg.norm(edge[0], axis=1).mean()
    radius, of = 0.1 * size, angles if measure == "dihedral" else ratios
    values = of(points[tetrahedra])
    for _ in range(PROGRAMS):
        least = values.min()
        bad = np.argwhere(values < least + BAND[measure])
        which = np.unique(bad[:, 0])
        slope = dict(zip(which, slopes(of, points[tetrahedra[which]], 1e-6 * size)))
        step = solve(values, slope, bad, place, tetrahedra, len(free), radius)
        if step is None:
            break
        trial = points.copy()
        trial[free] += step
        now, is_valid = of(trial[tetrahedra]), ratios(trial[tetrahedra]).min() > 0
        if is_valid and now.min() > least + 1e-7:
            points, values, radius = trial, now, 1.5 * radius
        else:
            radius *= 0.4
        if radius < 1e-7 * size:
            break
    return values.min() if measure == "dihedral" else 1 / values.min()
