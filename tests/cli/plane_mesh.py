"""Meshes of triangles in any plane of space, in many formats, and a judge of what becomes of them;
it shares no code with planish: signs of triangles are found with fractions.

plane_mesh.py make N PLANE OUT [OFFSET]    a square of N x N squares in halves, inner nodes jittered.
    PLANE: xy, yz, zx (x and y become these); 345 (two rotations by 3-4-5); tilt, steep (others);
    half (halfway between two axes); regular (nothing is jittered); flat, flat345 (some triangles are)
plane_mesh.py count IN                     prints how many triangles are inverted or flat
plane_mesh.py same PLANE XY OUT            OUT in PLANE has the bits of XY, the other column those it had
plane_mesh.py judge IN OUT TOLERANCE       OUT is IN with other places in its plane, none inverted
"""
import base64
import math
import random
import struct
import sys
from fractions import Fraction

AXES = {"xy": (0, 1, 2), "yz": (1, 2, 0), "zx": (2, 0, 1)}


def square(n):
    """Points in the plane, triangles, lines of the boundary."""
    rng = random.Random(n)
    points = []
    for j in range(n + 1):
        for i in range(n + 1):
            inner = 0 < i < n and 0 < j < n
            jitter = [rng.uniform(-0.3, 0.3) if inner else 0 for _ in range(2)]
            points.append((i + jitter[0], j + jitter[1]))
    at = lambda i, j: j * (n + 1) + i
    triangles = []
    for j in range(n):
        for i in range(n):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, b, c), (a, c, d)]
    return points, triangles


def change(points, plane, n):
    if plane == "regular":
        return [(round(x), round(y)) for x, y in points]
    if plane.startswith("flat"):  # inner nodes on the lines of others
        return [(round(x) + (1 if 0 < round(x) < n and round(y) % 3 == 1 else 0), round(y))
                for x, y in points]
    return points


def rotation(plane):
    """The images of the unit vectors."""
    if plane == "half":
        return [(1, 0, 1), (0, math.sqrt(2), 0), (0, 0, 0)]
    if plane in ("345", "flat345"):
        return [(15, 12, 16), (-20, 9, 12), (0, -20, 15)]  # 25 times those of a rotation
    a, b, c = {"tilt": (0.3, 1.1, 0.7), "steep": (2.1, 0.05, -1.3)}.get(plane, (0.3, 0.6, 1.9))
    m = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for angle, p, q in ((a, 0, 1), (b, 1, 2), (c, 0, 2)):
        s, t = math.sin(angle), math.cos(angle)
        m = [[t * v[p] - s * v[q] if d == p else s * v[p] + t * v[q] if d == q else v[d]
              for d in range(3)] for v in m]
    return m


def place(points, plane, offset):
    if plane in AXES:
        p, q, r = AXES[plane]
        placed = []
        for x, y in points:
            row = [0.0] * 3
            row[p], row[q], row[r] = x, y, 0.1 + offset
            placed.append(row)
        return placed
    u, v, _ = rotation(plane)
    # Grid points stay whole numbers in the plane of 3-4-5.
    return [[offset + x * u[d] + y * v[d] for d in range(3)] for x, y in points]


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def short(x, width):
    """x in so many characters."""
    for digits in range(17, 0, -1):
        text = f"{x:.{digits}g}"
        if "." not in text and "e" not in text:
            text += "."
        if len(text) <= width:
            return text
    raise ValueError(x)


# ---- writing ------------------------------------------------------------------------------------


def write_msh(points, triangles, binary=False):
    nodes = "".join(f"{i + 1} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points))
    elements = "".join(f"{i + 1} 2 2 1 1 {a + 1} {b + 1} {c + 1}\n"
                       for i, (a, b, c) in enumerate(triangles))
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n{nodes}$EndNodes\n"
            f"$Elements\n{len(triangles)}\n{elements}$EndElements\n").encode()


def write_mesh(points, triangles, version=2):
    nodes = "".join(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in points)
    elements = "".join(f"{a + 1} {b + 1} {c + 1} 1\n" for a, b, c in triangles)
    return (f"MeshVersionFormatted {version}\nDimension 3\nVertices\n{len(points)}\n{nodes}"
            f"Triangles\n{len(triangles)}\n{elements}End\n").encode()


def write_vtk(points, triangles, kind="double", binary=False):
    n, m = len(points), len(triangles)
    head = (f"# vtk DataFile Version 3.0\nt\n{'BINARY' if binary else 'ASCII'}\n"
            f"DATASET UNSTRUCTURED_GRID\nPOINTS {n} {kind}\n")
    if not binary:
        return (head + "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
                + f"CELLS {m} {4 * m}\n" + "".join("3 %d %d %d\n" % t for t in triangles)
                + f"CELL_TYPES {m}\n" + "5\n" * m).encode()
    code = "f" if kind == "float" else "d"
    return (head.encode() + b"".join(struct.pack(">3" + code, *p) for p in points)
            + f"\nCELLS {m} {4 * m}\n".encode()
            + b"".join(struct.pack(">4i", 3, *t) for t in triangles)
            + f"\nCELL_TYPES {m}\n".encode() + struct.pack(">i", 5) * m + b"\n")


def write_vtu(points, triangles, packed=False):
    n, m = len(points), len(triangles)

    def array(kind, code, values, name, more=""):
        data = struct.pack(f"<{len(values)}{code}", *values)
        text = base64.b64encode(struct.pack("<I", len(data)) + data).decode()
        return f'<DataArray type="{kind}" Name="{name}"{more} format="binary">{text}</DataArray>\n'
    return ('<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">\n'
            f'<UnstructuredGrid>\n<Piece NumberOfPoints="{n}" NumberOfCells="{m}">\n<Points>\n'
            + array("Float64", "d", [x for p in points for x in p], "Points",
                    ' NumberOfComponents="3"')
            + "</Points>\n<Cells>\n"
            + array("Int32", "i", [i for t in triangles for i in t], "connectivity")
            + array("Int32", "i", [3 * (i + 1) for i in range(m)], "offsets")
            + array("UInt8", "B", [5] * m, "types")
            + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n").encode()


def write_off(points, triangles):
    return (f"OFF\n{len(points)} {len(triangles)} 0\n"
            + "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points)
            + "".join("3 %d %d %d\n" % t for t in triangles)).encode()


def write_inp(points, triangles):
    return ("*NODE\n" + "".join(f"{i + 1}, {short(p[0], 20)}, {short(p[1], 20)}, {short(p[2], 20)}\n"
                                for i, p in enumerate(points)) + "*ELEMENT, TYPE=S3\n"
            + "".join(f"{i + 1}, {a + 1}, {b + 1}, {c + 1}\n"
                      for i, (a, b, c) in enumerate(triangles))).encode()


def write_bdf(points, triangles):
    return ("BEGIN BULK\n"
            + "".join(f"GRID    {i + 1:<8d}        " + "".join(f"{short(x, 8):<8s}" for x in p) + "\n"
                      for i, p in enumerate(points))
            + "".join(f"CTRIA3  {i + 1:<8d}{1:<8d}{a + 1:<8d}{b + 1:<8d}{c + 1:<8d}\n"
                      for i, (a, b, c) in enumerate(triangles)) + "ENDDATA\n").encode()


def write_vol(points, triangles):
    return ("mesh3d\ndimension\n3\ngeomtype\n0\nfacedescriptors\n1\n1 1 0 1 1\n\nsurfaceelements\n"
            f"{len(triangles)}\n" + "".join(f"1 1 0 0 3 {a + 1} {b + 1} {c + 1}\n"
                                            for a, b, c in triangles)
            + f"\nvolumeelements\n0\n\nedgesegmentsgi2\n0\n\npoints\n{len(points)}\n"
            + "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points) + "\nendmesh\n").encode()


WRITERS = {"msh": write_msh, "mesh": write_mesh, "1.mesh": lambda p, t: write_mesh(p, t, 1),
           "vtk": write_vtk, "f.vtk": lambda p, t: write_vtk(p, t, "float"),
           "b.vtk": lambda p, t: write_vtk(p, t, binary=True),
           "fb.vtk": lambda p, t: write_vtk(p, t, "float", True), "vtu": write_vtu,
           "off": write_off, "inp": write_inp, "bdf": write_bdf, "vol": write_vol}
FLOATS = ("1.mesh", "f.vtk", "fb.vtk")


def kind_of(path):
    """What follows the first dot."""
    return path.rsplit("/", 1)[-1].split(".", 1)[1]


def write(path, points, triangles):
    if kind_of(path) in FLOATS:
        points = [[single(x) for x in p] for p in points]
    open(path, "wb").write(WRITERS[kind_of(path)](points, triangles))


# ---- reading ------------------------------------------------------------------------------------


def real(text):
    """Nastran's exponents may lack their e."""
    text = text.strip() or "0"
    for i in range(len(text) - 1, 0, -1):
        if text[i] in "+-" and text[i - 1] not in "eE":
            return float(text[:i] + "e" + text[i:])
    return float(text)


def rows(words, at, n, width, skip=0):
    return [words[at + i * width + skip:at + (i + 1) * width] for i in range(n)]


def read(path):
    """Points, and triangles: only of the files that are written here."""
    kind, data = kind_of(path), open(path, "rb").read()
    if kind in ("b.vtk", "fb.vtk"):
        code, size = ("f", 4) if kind == "fb.vtk" else ("d", 8)
        head = data.index(b"POINTS")
        n, at = int(data[head:].split()[1]), data.index(b"\n", head) + 1
        points = [struct.unpack(">3" + code, data[at + 3 * size * i:at + 3 * size * (i + 1)])
                  for i in range(n)]
        head = data.index(b"CELLS", at + 3 * size * n)
        m, at = int(data[head:].split()[1]), data.index(b"\n", head) + 1
        return points, [struct.unpack(">4i", data[at + 16 * i:at + 16 * (i + 1)])[1:]
                        for i in range(m)]
    text = data.decode()
    if kind == "vtu":
        found = [base64.b64decode(part.split(">", 1)[1].split("<", 1)[0])[4:]
                 for part in text.split("<DataArray")[1:3]]
        xyz = struct.unpack(f"<{len(found[0]) // 8}d", found[0])
        ids = struct.unpack(f"<{len(found[1]) // 4}i", found[1])
        return ([xyz[i:i + 3] for i in range(0, len(xyz), 3)],
                [ids[i:i + 3] for i in range(0, len(ids), 3)])
    if kind in ("inp", "bdf"):
        points, triangles = [], []
        for line in text.splitlines():
            if line.startswith("GRID"):
                points.append([real(line[24 + 8 * d:32 + 8 * d]) for d in range(3)])
            elif line.startswith("CTRIA3"):
                triangles.append([int(line[24 + 8 * d:32 + 8 * d]) - 1 for d in range(3)])
            elif line[0].isdigit():
                part = line.split(",")
                if "." in line or "e" in line:
                    points.append([float(x) for x in part[1:]])
                else:
                    triangles.append([int(x) - 1 for x in part[1:]])
        return points, triangles
    words = text.split()
    base = 1
    if kind == "msh":
        at = words.index("$Nodes") + 2
        points = rows(words, at, int(words[at - 1]), 4, 1)
        at = words.index("$Elements") + 2
        triangles = rows(words, at, int(words[at - 1]), 8, 5)
    elif kind in ("mesh", "1.mesh"):
        at = words.index("Vertices") + 2
        points = [row[:3] for row in rows(words, at, int(words[at - 1]), 4)]
        at = words.index("Triangles") + 2
        triangles = [row[:3] for row in rows(words, at, int(words[at - 1]), 4)]
    elif kind == "vol":
        at = words.index("points") + 2
        points = rows(words, at, int(words[at - 1]), 3)
        at = words.index("surfaceelements") + 2
        triangles = rows(words, at, int(words[at - 1]), 8, 5)
    elif kind == "off":
        n, m, base = int(words[1]), int(words[2]), 0
        points, triangles = rows(words, 4, n, 3), rows(words, 4 + 3 * n, m, 4, 1)
    else:
        at, base = words.index("POINTS") + 3, 0
        n = int(words[at - 2])
        points = rows(words, at, n, 3)
        at = words.index("CELLS") + 3
        triangles = rows(words, at, int(words[at - 2]), 4, 1)
    read_real = (lambda x: single(float(x))) if kind in FLOATS else float
    return [[read_real(x) for x in p] for p in points], [[int(i) - base for i in t] for t in triangles]


# ---- judging ------------------------------------------------------------------------------------


def normal_of(points, triangles):
    """The sum of the triangles' normals, of the sign that most have: the mesh may be folded."""
    total = [0.0] * 3
    for a, b, c in triangles:
        e = [points[b][d] - points[a][d] for d in range(3)]
        f = [points[c][d] - points[a][d] for d in range(3)]
        n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
        total = [s + x for s, x in zip(total, n)]
    length = math.sqrt(sum(x * x for x in total))
    return [x / length for x in total]


def sign(points, triangle, p, q):
    """Of the triangle seen along the other axis, exactly."""
    (ax, ay), (bx, by), (cx, cy) = [(Fraction(points[i][p]), Fraction(points[i][q])) for i in triangle]
    det = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return (det > 0) - (det < 0)


def inverted(points, triangles, normal, k):
    p, q = (k + 1) % 3, (k + 2) % 3
    wanted = 1 if normal[k] > 0 else -1
    return sum(sign(points, t, p, q) != wanted for t in triangles)


def rms(points, triangles):
    total = 0
    for t in triangles:
        a, b, c = [math.dist(points[t[i]], points[t[(i + 1) % 3]]) for i in range(3)]
        s = (a + b + c) / 2
        area2 = s * (s - a) * (s - b) * (s - c)
        total += (a * b * c * s / (8 * max(area2, 1e-300))) ** 2
    return math.sqrt(total / len(triangles))


def judge(before, after, tolerance):
    (old, triangles), (new, others) = read(before), read(after)
    assert [list(t) for t in triangles] == [list(t) for t in others], "triangles"
    normal = normal_of(old, triangles)
    axes = [k for k in range(3) if abs(normal[k]) > 0.999999 * max(map(abs, normal))]
    bad_before = [inverted(old, triangles, normal, k) for k in axes]
    bad_after = [inverted(new, triangles, normal, k) for k in axes]
    used = sorted({i for t in triangles for i in t})
    low = [min(old[i][d] for i in used) for d in range(3)]
    high = [max(old[i][d] for i in used) for d in range(3)]
    size = math.dist(low, high)
    base = old[used[0]]
    off = max(abs(sum(n * (x - o) for n, x, o in zip(normal, new[i], base))) for i in used)
    moved = sum(list(p) != list(q) for p, q in zip(old, new))
    print(before, "moved", moved, "inverted", bad_before, bad_after, "off", off / size,
          "RMS", rms(old, triangles), rms(new, triangles))
    assert not any(bad_after), "inverted elements"
    assert off <= tolerance * size, "off the plane"
    assert moved > 0
    if not any(bad_before):
        assert rms(new, triangles) <= rms(old, triangles) * (1 + 1e-9), "RMS"


def same(plane, flat, turned):
    (a, triangles), (b, others) = read(flat), read(turned)
    p, q, _ = AXES[plane]
    assert [list(t) for t in triangles] == [list(t) for t in others]
    assert [[x[0], x[1], x[2]] for x in a] == [[x[p], x[q], x[3 - p - q]] for x in b]


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    if what == "make":
        points, triangles = square(int(rest[0]))
        points = change(points, rest[1], int(rest[0]))
        offset = float(rest[3]) if len(rest) > 3 else 0.0
        write(rest[2], place(points, rest[1], offset), triangles)
    elif what == "count":
        points, triangles = read(rest[0])
        normal = normal_of(points, triangles)
        print(inverted(points, triangles, normal, max(range(3), key=lambda k: abs(normal[k]))))
    elif what == "same":
        same(*rest)
    else:
        judge(rest[0], rest[1], float(rest[2]))
