"""make_mesh.py N AMOUNT FILE.mesh: a cube of N^3 cells of six tetrahedra each, interior nodes pushed
by up to AMOUNT cells (0.2: still valid; 0.9: tangled). The same file every time."""
import sys

n, amount, path = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
state = 12345


def random():
    """Uniform in -1 .. 1, by a linear congruence: the same in every version of Python."""
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 33) / 2**30 - 1


def node(i, j, k):
    return 1 + i + (n + 1) * (j + (n + 1) * k)


corners = [(a, b, c) for c in (0, 1) for b in (0, 1) for a in (0, 1)]
paths = [(1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)]  # around the diagonal from 0 to 7
with open(path, "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n" % (n + 1) ** 3)
    for k in range(n + 1):
        for j in range(n + 1):
            for i in range(n + 1):
                inside = all(0 < c < n for c in (i, j, k))
                xyz = [(c + (amount * random() if inside else 0)) / n for c in (i, j, k)]
                file.write("%r %r %r 0\n" % tuple(xyz))
    file.write("Tetrahedra\n%d\n" % (6 * n**3))
    for k in range(n):
        for j in range(n):
            for i in range(n):
                c = [node(i + a, j + b, k + c) for a, b, c in corners]
                for a, b in paths:
                    file.write("%d %d %d %d 1\n" % (c[0], c[a], c[b], c[7]))
    file.write("End\n")
