"""Meshes that are folders, for tests: of Elmer and OpenFOAM.

    folder_meshes.py elmer IN.mesh FOLDER           from the tetrahedra and triangles of a Medit file
    folder_meshes.py foam IN.mesh FOLDER [HOW...]
    folder_meshes.py mixed N FOLDER [HOW...]        N * N * N cubes: hexahedra, wedges, pyramids, tetrahedra
    folder_meshes.py layer N FOLDER [HOW...]        a layer of N * N cubes between empty patches

HOW of OpenFOAM's: binary, label=64, scalar=32, gz.
"""
import gzip
import os
import random
import struct
import sys

# Faces of elements, whose normals leave them, by nodes in VTK's order; by the number of nodes.
FACES = {4: ("021", "013", "123", "203"), 5: ("0321", "014", "124", "234", "304"),
         6: ("021", "345", "0143", "1254", "2035"), 8: ("0321", "4567", "0154", "1265", "2376", "3047")}


def read_medit(path):
    """Return points, [(nodes, reference)] of tetrahedra, and of triangles; nodes from 0."""
    words = iter(open(path).read().split())
    found = {}
    for word in words:
        size = {"Vertices": 4, "Triangles": 4, "Tetrahedra": 5}.get(word)
        if size:
            found[word] = [[next(words) for _ in range(size)] for _ in range(int(next(words)))]
    cells = [[([int(i) - 1 for i in row[:-1]], int(row[-1])) for row in found[name]]
             for name in ("Tetrahedra", "Triangles")]
    return [row[:3] for row in found["Vertices"]], *cells


def write(folder, name, data, packed=False):
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, name + (".gz" if packed else ""))
    with open(path, "wb") as file:
        file.write(gzip.compress(data, 3, mtime=0) if packed else data)


def elmer(folder, points, tetrahedra, triangles):
    write(folder, "mesh.header", b"%d %d %d\n2\n504 %d\n303 %d\n" %
          (len(points), len(tetrahedra), len(triangles), len(tetrahedra), len(triangles)))
    write(folder, "mesh.nodes", "".join(f"{i} -1 {' '.join(p)}\n" for i, p in enumerate(points, 1)).encode())

    def rows(cells, code, between):
        return "".join(f"{i} {r}{between} {code} {' '.join(str(n + 1) for n in nodes)}\n"
                       for i, (nodes, r) in enumerate(cells, 1)).encode()
    write(folder, "mesh.elements", rows(tetrahedra, 504, ""))
    write(folder, "mesh.boundary", rows(triangles, 303, " 0 0"))
    bodies, sides = (sorted({r for _, r in cells}) for cells in (tetrahedra, triangles))
    write(folder, "mesh.names", ("! ----- names for bodies -----\n" + "".join(f"$ body{r} = {r}\n" for r in bodies) +
                                 "! ----- names for boundaries -----\n" +
                                 "".join(f"$ side{r} = {r}\n" for r in sides)).encode())


def foam(folder, points, cells, patch_of, types, zones, how):
    """cells: nodes in VTK's order. patch_of: name of the patch of a face of the boundary, of its nodes. types: of
    patches. zones: {name: cells}."""
    label, scalar = ("q" if "label=64" in how else "i"), ("f" if "scalar=32" in how else "d")
    is_binary, packed = "binary" in how, "gz" in how
    sides = {}
    for i, nodes in enumerate(cells):
        for face in FACES[len(nodes)]:
            face = [nodes[int(k)] for k in face]
            sides.setdefault(frozenset(face), []).append((i, face))
    inner = sorted((s[0][0], s[1][0], s[0][1]) for s in sides.values() if len(s) == 2)
    patches = {}
    for s in sides.values():
        if len(s) == 1:
            patches.setdefault(patch_of(s[0][1]), []).append(s[0])
    outer = [side for name in sorted(patches) for side in patches[name]]
    faces = [face for _, _, face in inner] + [face for _, face in outer]

    def put(name, kind, body):
        arch = "LSB;label=%d;scalar=%d" % (8 * struct.calcsize(label), 8 * struct.calcsize(scalar))
        form = "binary" if is_binary else "ascii"
        head = (f"FoamFile\n{{\n    version     2.0;\n    format      {form};\n    arch        \"{arch}\";\n"
                f"    class       {kind};\n    location    \"constant/polyMesh\";\n    object      {name};\n}}\n"
                "// * * * //\n\n")
        write(folder, name, head.encode() + body + b"\n\n// *** //\n", packed)

    def numbers(values, form=label):
        values = list(values)
        if is_binary:
            return b"%d\n(" % len(values) + struct.pack(f"<{len(values)}{form}", *values) + b")"
        return b"%d\n(\n" % len(values) + "".join(f"{v}\n" for v in values).encode() + b")"
    if is_binary:
        flat = [float(x) for p in points for x in p]
        starts = [0]
        for face in faces:
            starts.append(starts[-1] + len(face))
        put("points", "vectorField", b"%d\n(" % len(points) + struct.pack(f"<{len(flat)}{scalar}", *flat) + b")")
        put("faces", "faceCompactList", numbers(starts) + b"\n" + numbers(n for face in faces for n in face))
    else:
        put("points", "vectorField", b"%d\n(\n" % len(points) +
            "".join(f"({' '.join(map(str, p))})\n" for p in points).encode() + b")")
        put("faces", "faceList", b"%d\n(\n" % len(faces) +
            "".join(f"{len(f)}({' '.join(map(str, f))})\n" for f in faces).encode() + b")")
    put("owner", "labelList", numbers([i for i, _, _ in inner] + [i for i, _ in outer]))
    put("neighbour", "labelList", numbers(i for _, i, _ in inner))
    text, start = "", len(inner)
    for name in sorted(patches):
        n = len(patches[name])
        text += (f"    {name}\n    {{\n        type            {types.get(name, 'patch')};\n"
                 f"        inGroups        1(all);\n        nFaces          {n};\n"
                 f"        startFace       {start};\n    }}\n")
        start += n
    put("boundary", "polyBoundaryMesh", b"%d\n(\n" % len(patches) + text.encode() + b")")
    if zones:
        put("cellZones", "regIOobject", b"%d\n(\n" % len(zones) + b"".join(
            b"%s\n{\n    type cellZone;\n    cellLabels List<label> " % name.encode() + numbers(of) + b";\n}\n"
            for name, of in sorted(zones.items())) + b")")


def grid(nx, ny, nz, noise):
    """Points of cubes, inner ones off their places, and the eight points of each cube."""
    random.seed(1)
    sizes, points, cubes = (nx, ny, nz), [], []
    for k in range(nz + 1):
        for j in range(ny + 1):
            for i in range(nx + 1):
                at = (i, j, k)
                inside = all(0 < a < n for a, n in zip(at, sizes))
                points.append([a + (round(random.uniform(-noise, noise), 6) if inside else 0) for a in at])
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                a, up = (k * (ny + 1) + j) * (nx + 1) + i, (ny + 1) * (nx + 1)
                low = [a, a + 1, a + nx + 2, a + nx + 1]
                cubes.append(low + [n + up for n in low])
    return points, cubes


def mixed(n):
    """Cubes of which columns are wedges, and some are pyramids around a point in their middle."""
    points, cubes = grid(n, n, n, 0.2)
    cells = []
    for i, c in enumerate(cubes):
        x, y, z = i % n, i // n % n, i // (n * n)
        if (x + y) % 3 == 0:
            cells += [[c[0], c[1], c[2], c[4], c[5], c[6]], [c[0], c[2], c[3], c[4], c[6], c[7]]]
        elif (x + y) % 3 == 1 and z % 2:
            middle = len(points)
            points.append([sum(points[k][d] for k in c) / 8 for d in range(3)])
            cells += [[c[int(k)] for k in face[::-1]] + [middle] for face in FACES[8]]
        else:
            cells.append(c)
    return points, cells


def main():
    kind, source, folder, how = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
    if kind == "elmer":
        elmer(folder, *read_medit(source))
    elif kind == "foam":
        points, tetrahedra, triangles = read_medit(source)
        side = {frozenset(nodes): r for nodes, r in triangles}
        zones = {}
        for i, (_, r) in enumerate(tetrahedra):
            zones.setdefault(f"zone{r}", []).append(i)
        foam(folder, points, [nodes for nodes, _ in tetrahedra],
             lambda face: f"side{side.get(frozenset(face), 0)}", {}, zones, how)
    elif kind == "mixed":
        points, cells = mixed(int(source))
        foam(folder, points, cells,
             lambda face: "low" if all(points[i][2] == 0 for i in face) else "rest", {"rest": "wall"}, {}, how)
    else:
        n = int(source)
        points, cubes = grid(n, n, 1, 0)
        for i in range((n + 1) ** 2):
            x, y = points[i][:2]
            if 0 < x < n and 0 < y < n:
                x, y = (round(v + random.uniform(-0.3, 0.3), 6) for v in (x, y))
            for k in (i, i + (n + 1) ** 2):
                points[k][:2] = x, y
        foam(folder, points, cubes,
             lambda face: "frontAndBack" if len({points[i][2] for i in face}) == 1 else "rest",
             {"frontAndBack": "empty"}, {}, how)


if __name__ == "__main__":
    main()
