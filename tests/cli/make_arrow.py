"""make_arrow.py FILE.mesh: four triangles around a free node in the tip of an arrow, whose kernel has
no mean of the corners in it, however weighted."""
import sys

with open(sys.argv[1], "w") as file:
    file.write("MeshVersionFormatted 2\nDimension 2\nVertices\n5\n"
               "3 0 0\n-10 5 0\n0 0 0\n-10 -5 0\n1.5 0 0\n"
               "Triangles\n4\n1 2 5 1\n2 3 5 1\n3 4 5 1\n4 1 5 1\nEnd\n")
