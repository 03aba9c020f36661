"""medit: tetrahedral meshes from Medit (.mesh) and TetGen (.node, .ele) files, and to Medit."""
import numpy as np


def section(words, name, columns):
    """The table of a keyword of a Medit file, or one without rows."""
    if name not in words:
        return np.empty((0, columns))
    at = words.index(name) + 1
    count = int(words[at])
    table = words[at + 1:at + 1 + count * columns]
    return np.array(table, float).reshape(count, columns)


def read(path):
    """points [n][3] and tetrahedra [m][4] (from 0) of an ASCII file."""
    with open(path, encoding="ascii") as file:
        words = " ".join(line.split("#")[0] for line in file).split()
    return (section(words, "Vertices", 4)[:, :3],
            section(words, "Tetrahedra", 5)[:, :4].astype(int) - 1)


def read_tetgen(stem):
    """The same of the two files of TetGen, whose numbers start at 1 as its input's do."""
    points = np.loadtxt(f"{stem}.node", skiprows=1)[:, 1:4]
    return points, np.loadtxt(f"{stem}.ele", skiprows=1, dtype=int)[:, 1:5] - 1


def boundary(tetrahedra):
    """Faces [n][3] that belong to one element."""
    faces = np.concatenate([np.delete(tetrahedra, j, axis=1) for j in range(4)])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True,
                                return_counts=True)
    return faces[first[count == 1]]


def write(path, points, tetrahedra):
    """With the boundary's triangles, by which Gmsh knows which nodes it must not move."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in points.tolist())
        for name, table in ("Triangles", boundary(tetrahedra)), ("Tetrahedra", tetrahedra):
            file.write(f"{name}\n{len(table)}\n")
            file.writelines(" ".join(map(str, row)) + " 1\n" for row in (table + 1).tolist())
        file.write("End\n")
