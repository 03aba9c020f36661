"""uneven_mesh.py: print a Medit mesh of quadrilaterals in layers whose heights change in seven rounds."""
import itertools
import random
import box_file

N, ROWS, GROWTH, FIRST = 60, 26, 1.2, 0.001
random.seed(1)
number, points = {}, []
for at in itertools.product(range(N + 1), range(ROWS + 1)):
    inside = 0 < at[0] < N and 0 < at[1] < ROWS
    number[at] = len(points) + 1
    points.append([(at[0] + inside * random.uniform(-0.2, 0.2)) / N, FIRST * (GROWTH ** at[1] - 1) / (GROWTH - 1)])
print(box_file.medit("quads", points, box_file.elements("quads", [N, ROWS], number)))
