"""make_slow_mesh.py N FILE.mesh: a square of N^2 cells of two triangles each, pulled to one side as a
whole. Sweeps take such mesh-wide error away slowly: smoothing it lasts long enough to be stopped."""
import math
import sys

n, path = int(sys.argv[1]), sys.argv[2]
with open(path, "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices\n%d\n" % (n + 1) ** 2)
    for j in range(n + 1):
        for i in range(n + 1):
            x, y = i / n, j / n
            pull = 0.25 * math.sin(math.pi * x) * math.sin(math.pi * y)
            inside = 0 < i < n and 0 < j < n
            file.write("%r %r 0\n" % (x - pull if inside else x, y))
    file.write("Triangles\n%d\n" % (2 * n**2))
    for j in range(n):
        for i in range(n):
            a = 1 + i + (n + 1) * j
            b, c, d = a + 1, a + n + 1, a + n + 2
            file.write("%d %d %d 1\n%d %d %d 1\n" % (a, b, d, a, d, c))
    file.write("End\n")
