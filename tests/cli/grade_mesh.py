"""grade_mesh.py IN.mesh OUT.mesh: the nodes of a unit square or cube drawn to its lower corner, where
elements become small."""
import sys

source, path = sys.argv[1:]
lines = open(source).read().split("\n")
dim = int(lines[1].split()[1])
begin = lines.index("Vertices") + 2
for i in range(begin, begin + int(lines[begin - 1])):
    words = lines[i].split()
    graded = ["%r" % (x * (0.5 + 0.5 * x)) for x in map(float, words[:dim])]
    lines[i] = " ".join(graded + words[dim:])
open(path, "w").write("\n".join(lines))
