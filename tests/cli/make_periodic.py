"""make_periodic.py NX NY DIRECTIONS FILE.mesh: a rectangle of 2 NX NY triangles, periodic in x, y or xy, whose
nodes are there once each: the elements of the seam lie across all of it. Prints their numbers."""
import random
import sys

nx, ny, directions, path = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4]
rng = random.Random(1)
columns, rows = nx + ("x" not in directions), ny + ("y" not in directions)
moves = lambda i, n, periodic: rng.uniform(-0.2, 0.2) if periodic or 0 < i < n else 0
points = []
for j in range(rows):
    for i in range(columns):
        dx, dy = moves(i, nx, "x" in directions), moves(j, ny, "y" in directions)
        inside = (rows == ny or 0 < j < ny) and (columns == nx or 0 < i < nx)
        points.append((i + dx * inside, j + dy * inside))
triangles, wrapped = [], []
for j in range(ny):
    for i in range(nx):
        a, b, c, d = (y % rows * columns + x % columns + 1
                      for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        for corners in ((a, b, c), (a, c, d)):
            triangles.append(corners)
            if i + 1 >= columns or j + 1 >= rows:
                wrapped.append(len(triangles))
with open(path, "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices %d\n" % len(points))
    file.writelines("%.17g %.17g 0\n" % point for point in points)
    file.write("Triangles %d\n" % len(triangles))
    file.writelines("%d %d %d 0\n" % corners for corners in triangles)
    file.write("End\n")
print(wrapped)
