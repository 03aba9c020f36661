"""The smallest meshes that have what each format has: two tetrahedra, a triangle, groups, counts.

meshes(): {name of file: bytes}, companions (TetGen's .ele) among them. OFF, STL, OBJ and PLY have two triangles.
folders(): {name of folder: {name of file: bytes}}, of Elmer and OpenFOAM.
"""
import base64
import struct
import zlib

import exodus_mesh

POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
TETRAHEDRA = [(1, 2, 3, 4), (2, 3, 4, 5)]
TRIANGLE = (1, 2, 3)


def lines(rows):
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


def numbered(rows):
    return lines((i + 1, *row) for i, row in enumerate(rows))


def gmsh22():
    return ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 4 \"body\"\n$EndPhysicalNames\n"
            "$Nodes\n5\n" + numbered(POINTS) + "$EndNodes\n$Elements\n3\n1 2 2 7 1 1 2 3\n"
            "2 4 2 4 1 1 2 3 4\n3 4 2 4 1 2 3 4 5\n$EndElements\n"
            "$Periodic\n1\n0 1 2\n1\n1 2\n$EndPeriodic\n").encode()


def gmsh22_binary():
    nodes = b"".join(struct.pack("<i3d", i + 1, *p) for i, p in enumerate(POINTS))
    elements = (struct.pack("<3i", 2, 1, 2) + struct.pack("<6i", 1, 7, 1, *TRIANGLE) +
                struct.pack("<3i", 4, 2, 2) + struct.pack("<7i", 2, 4, 1, *TETRAHEDRA[0]) +
                struct.pack("<7i", 3, 4, 1, *TETRAHEDRA[1]))
    return (b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n5\n" + nodes +
            b"\n$EndNodes\n$Elements\n3\n" + elements + b"\n$EndElements\n")


def gmsh41():
    return ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 4 \"body\"\n$EndPhysicalNames\n"
            "$Entities\n1 0 1 1\n1 0 0 0 0\n1 0 0 0 1 1 1 0 0\n1 0 0 0 1 1 1 1 4 1 1\n$EndEntities\n"
            "$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n" + lines(POINTS) + "$EndNodes\n"
            "$Elements\n2 3 1 3\n2 1 2 1\n1 1 2 3\n3 1 4 2\n2 1 2 3 4\n3 2 3 4 5\n$EndElements\n"
            "$Periodic\n1\n0 1 1\n0\n1\n1 2\n$EndPeriodic\n").encode()


def gmsh41_binary():
    entities = (struct.pack("<4q", 1, 0, 1, 1) + struct.pack("<i3dq", 1, 0, 0, 0, 0) +
                struct.pack("<i6dqq", 1, 0, 0, 0, 1, 1, 1, 0, 0) +
                struct.pack("<i6dqiqi", 1, 0, 0, 0, 1, 1, 1, 1, 4, 1, 1))
    nodes = (struct.pack("<4q", 1, 5, 1, 5) + struct.pack("<3iq", 3, 1, 0, 5) +
             struct.pack("<5q", 1, 2, 3, 4, 5) + b"".join(struct.pack("<3d", *p) for p in POINTS))
    elements = (struct.pack("<4q", 2, 3, 1, 3) + struct.pack("<3iq", 2, 1, 2, 1) +
                struct.pack("<4q", 1, *TRIANGLE) + struct.pack("<3iq", 3, 1, 4, 2) +
                struct.pack("<5q", 2, *TETRAHEDRA[0]) + struct.pack("<5q", 3, *TETRAHEDRA[1]))
    periodic = struct.pack("<q3iqq2q", 1, 0, 1, 1, 0, 1, 1, 2)
    sections = (("Entities", entities), ("Nodes", nodes), ("Elements", elements), ("Periodic", periodic))
    return (b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n" +
            b"".join(b"$%s\n%s\n$End%s\n" % (n.encode(), data, n.encode()) for n, data in sections))


def medit():
    return ("MeshVersionFormatted 2\nDimension 3\nVertices 5\n" + lines((*p, 0) for p in POINTS) +
            "Triangles 1\n1 2 3 7\nTetrahedra 2\n" + lines((*t, 4) for t in TETRAHEDRA) +
            "RequiredVertices 1\n1\nPeriodicVertices 1\n1 2\nEnd\n").encode()


def meshb(version, order):
    """Version 2: positions of 32 bits, version 3: of 64, version 4: counts and numbers, too."""
    position, count = ("i" if version < 3 else "q"), ("i" if version < 4 else "q")
    data = struct.pack(order + "2i", 1, version)
    data += struct.pack(order + "i" + position, 3, len(data) + 4 + struct.calcsize(position) + 4)
    data += struct.pack(order + "i", 3)
    sections = ((4, "3d" + count, [(*p, 0) for p in POINTS]), (6, "4" + count, [(*TRIANGLE, 7)]),
                (8, "5" + count, [(*t, 4) for t in TETRAHEDRA]), (15, count, [(1,)]))
    for keyword, row, rows in sections:
        body = struct.pack(order + count, len(rows))
        body += b"".join(struct.pack(order + row, *values) for values in rows)
        following = len(data) + 4 + struct.calcsize(position) + len(body)
        data += struct.pack(order + "i", keyword) + struct.pack(order + position, following) + body
    return data + struct.pack(order + "i", 54) + struct.pack(order + position, 0)


CELLS = [(3, 0, 1, 2), (4, 0, 1, 2, 3), (4, 1, 2, 3, 4)]


def vtk():
    return ("# vtk DataFile Version 3.0\ntiny\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n" +
            lines(POINTS) + "CELLS 3 14\n" + lines(CELLS) + "CELL_TYPES 3\n5\n10\n10\n"
            "CELL_DATA 3\nSCALARS region int 1\nLOOKUP_TABLE default\n0\n4\n4\n"
            "FIELD FieldData 1\nmore 1 3 int\n1 2 3\nPOINT_DATA 5\nVECTORS v float\n" + "0 0 0\n" * 5).encode()


def vtk_binary():
    cells = [number for cell in CELLS for number in cell]
    return (b"# vtk DataFile Version 3.0\ntiny\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n" +
            b"".join(struct.pack(">3d", *p) for p in POINTS) + b"\nCELLS 3 14\n" +
            struct.pack(">14i", *[3, *cells[1:4], 4, *cells[5:9], 4, *cells[10:]][:14]) +
            b"\nCELL_TYPES 3\n" + struct.pack(">3i", 5, 10, 10) +
            b"\nCELL_DATA 3\nSCALARS region int 1\nLOOKUP_TABLE default\n" + struct.pack(">3i", 0, 4, 4) + b"\n")


def vtk51():
    return (b"# vtk DataFile Version 5.1\ntiny\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n" +
            b"".join(struct.pack(">3d", *p) for p in POINTS) + b"\nMETADATA\nINFORMATION 0\n\nCELLS 4 11\n"
            b"OFFSETS vtktypeint64\n" + struct.pack(">4q", 0, 3, 7, 11) + b"\nCONNECTIVITY vtktypeint64\n" +
            struct.pack(">11q", 0, 1, 2, 0, 1, 2, 3, 1, 2, 3, 4) + b"\nCELL_TYPES 3\n" +
            struct.pack(">3i", 5, 10, 10) + b"\n")


VTU_ARRAYS = [("Float64", "Points", 3, struct.pack("<15d", *[x for p in POINTS for x in p])),
              ("Int64", "connectivity", 1, struct.pack("<11q", 0, 1, 2, 0, 1, 2, 3, 1, 2, 3, 4)),
              ("Int64", "offsets", 1, struct.pack("<3q", 3, 7, 11)),
              ("UInt8", "types", 1, bytes([5, 10, 10])),
              ("Int32", "region", 1, struct.pack("<3i", 0, 4, 4))]


def vtu_file(arrays, attributes, appended=b""):
    points, connectivity, offsets, types, region = arrays
    return (b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
            b'byte_order="LittleEndian"' + attributes + b'>\n<UnstructuredGrid>\n'
            b'<Piece NumberOfPoints="5" NumberOfCells="3">\n<CellData>\n' + region + b'</CellData>\n<Points>\n' +
            points + b'</Points>\n<Cells>\n' + connectivity + offsets + types + b'</Cells>\n</Piece>\n'
            b'</UnstructuredGrid>\n' + appended + b'</VTKFile>\n')


def array(kind, name, components, rest):
    return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '.encode() + rest)


def vtu():
    numbers = {"Float64": "d", "Int64": "q", "UInt8": "B", "Int32": "i"}
    arrays = []
    for kind, name, components, data in VTU_ARRAYS:
        code = numbers[kind]
        values = struct.unpack("<%d%s" % (len(data) // struct.calcsize(code), code), data)
        text = " ".join("%g" % value for value in values)
        arrays.append(array(kind, name, components, f'format="ascii">\n{text}\n</DataArray>\n'.encode()))
    return vtu_file(arrays, b"")


def vtu_appended(pack, attributes):
    """Arrays raw behind the elements; pack gives the bytes of one."""
    arrays, appended = [], b""
    for kind, name, components, data in VTU_ARRAYS:
        offset = b'format="appended" offset="%d"/>\n' % len(appended)
        arrays.append(array(kind, name, components, offset))
        appended += pack(data)
    return vtu_file(arrays, attributes, b'<AppendedData encoding="raw">\n_' + appended + b"\n</AppendedData>\n")


def vtu_raw():
    return vtu_appended(lambda data: struct.pack("<Q", len(data)) + data, b' header_type="UInt64"')


def packed(data):
    """Blocks of 40 bytes: how many, their size, that of the last if it is another, packed sizes."""
    blocks = [zlib.compress(data[i:i + 40]) for i in range(0, len(data), 40)]
    return struct.pack("<%dQ" % (3 + len(blocks)), len(blocks), 40, len(data) % 40,
                       *map(len, blocks)) + b"".join(blocks)


def vtu_zlib():
    return vtu_appended(packed, b' header_type="UInt64" compressor="vtkZLibDataCompressor"')


def vtu_base64():
    arrays = [array(kind, name, components, b'format="binary">\n' +
                    base64.b64encode(struct.pack("<I", len(data)) + data) + b"\n</DataArray>\n")
              for kind, name, components, data in VTU_ARRAYS]
    return vtu_file(arrays, b' header_type="UInt32"')


def netgen():
    return ("mesh3d\ndimension\n3\ngeomtype\n0\nsurfaceelements\n1\n1 1 1 0 3 1 2 3\nvolumeelements\n2\n" +
            lines((1, 4, *t) for t in TETRAHEDRA) + "edgesegmentsgi2\n1\n1 0 1 2 -1 -1 0 0 1 0 1 0\n"
            "points\n5\n" + lines(POINTS) + "identifications\n1\n1 2 1\nidentificationtypes\n1\n2\n"
            "materials\n1\n1 body\nendmesh\n").encode()


def abaqus():
    def rows(values):
        return "".join(", ".join(map(str, row)) + "\n" for row in values)
    return ("*HEADING\ntiny\n*NODE\n" + rows((i + 1, *map(float, p)) for i, p in enumerate(POINTS)) +
            "*ELEMENT, TYPE=C3D4, ELSET=body\n" + rows((i + 1, *t) for i, t in enumerate(TETRAHEDRA)) +
            "*NSET, NSET=some, GENERATE\n1, 5, 2\n*ELSET, ELSET=all, GENERATE\n1, 2, 1\n*NSET, NSET=more\n"
            "some, 4\n*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n").encode()


def nastran():
    return ("BEGIN BULK\n" + "".join("GRID,%d,,%g.,%g.,%g.\n" % (i + 1, *p) for i, p in enumerate(POINTS)) +
            "".join("CTETRA,%d,4,%d,%d,%d,%d\n" % (i + 1, *t) for i, t in enumerate(TETRAHEDRA)) +
            "CTRIA3,3,7,1,2,3\nRBE2,4,1,123,2,THRU,3\nENDDATA\n").encode()


SQUARE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]


def off():
    return ("OFF\n4 2 0\n" + lines(SQUARE) + "3 0 1 2\n3 1 3 2\n").encode()


def off_binary():
    return (b"OFF BINARY\n" + struct.pack(">3i", 4, 2, 0) + b"".join(struct.pack(">3f", *p) for p in SQUARE) +
            struct.pack(">5i", 3, 0, 1, 2, 0) + struct.pack(">5i", 3, 1, 3, 2, 0))


def stl():
    return ("solid a\n" + "".join(
        "facet normal 0 0 1\nouter loop\n" + "".join("vertex %g %g %g\n" % SQUARE[i] for i in t) + "endloop\nendfacet\n"
        for t in ((0, 1, 2), (1, 3, 2))) + "endsolid a\n").encode()


def stl_binary():
    return (b" " * 80 + struct.pack("<I", 2) + b"".join(
        struct.pack("<12fH", 0, 0, 1, *(x for i in t for x in SQUARE[i]), 0) for t in ((0, 1, 2), (1, 3, 2))))


def obj():
    return ("".join("v %g %g %g\n" % p for p in SQUARE) + "g a\nf 1 2/1 3\nf -3 -1 -2//4\nl 1 2\n").encode()


def ply(form, order=""):
    head = ("ply\nformat %s 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 2\nproperty list uchar int vertex_indices\nend_header\n" % form).encode()
    if not order:
        return head + (lines(SQUARE) + "3 0 1 2\n3 1 3 2\n").encode()
    return (head + b"".join(struct.pack(order + "3f", *p) for p in SQUARE) +
            struct.pack(order + "B3iB3i", 3, 0, 1, 2, 3, 1, 3, 2))


def mfem():
    return ("MFEM mesh v1.0\n\ndimension\n3\n\nelements\n2\n" + lines((1, 4, *(i - 1 for i in t)) for t in TETRAHEDRA) +
            "\nboundary\n1\n" + lines([(7, 2, *(i - 1 for i in TRIANGLE))]) + "\nvertices\n5\n3\n" + lines(POINTS)).encode()


def exodus(version):
    file = exodus_mesh.File(POINTS, version)
    file.put_blocks([(4, "body", "TETRA", TETRAHEDRA), (7, "", "SHELL", [TRIANGLE])])
    file.put_sets("ns", [(1, "ends", [1, 5])])
    file.put_sets("ss", [(2, "base", [(1, 4), (2, 2)])])
    return file.classic()


def ucd():
    return ("# tiny\n5 3 1 0 0\n" + numbered(POINTS) + lines((i + 1, 4, "tet", *t) for i, t in enumerate(TETRAHEDRA)) +
            "3 7 tri 1 2 3\n1 1\na, none\n" + numbered([(0,)] * 5)).encode()


def ucd_binary():
    return (b"\7" + struct.pack("<6i", 5, 2, 0, 0, 0, 8) +
            b"".join(struct.pack("<4i", i + 1, 4, 4, 4) for i in range(2)) +
            b"".join(struct.pack("<4i", *t) for t in TETRAHEDRA) +
            b"".join(struct.pack("<5f", *(p[d] for p in POINTS)) for d in range(3)))


def su2():
    return ("% tiny\nNDIME= 3\nNELEM= 2\n" + "".join("10 %d %d %d %d %d\n" % (*(n - 1 for n in t), i)
                                                   for i, t in enumerate(TETRAHEDRA)) +
            "NPOIN= 5\n" + "".join("%g %g %g %d\n" % (*p, i) for i, p in enumerate(POINTS)) +
            "NMARK= 1\nMARKER_TAG= skin\nMARKER_ELEMS= 1\n5 0 1 2\n").encode()


def unv():
    return ("    -1\n  2411\n" + "".join("%10d         1         1        11\n%25.16E%25.16E%25.16E\n" % (i + 1, *p)
                                        for i, p in enumerate(POINTS)) + "    -1\n    -1\n  2412\n" +
            "".join("%10d       111         4         1         7         4\n%10d%10d%10d%10d\n" % (i + 1, *t)
                    for i, t in enumerate(TETRAHEDRA)) +
            "         3        91         1         1         7         3\n         1         2         3\n    -1\n"
            "    -1\n  2467\n         1         0         0         0         0         0         0         2\nsome\n"
            "         8         1         0         0         7         3         0         0\n    -1\n").encode()


def xdmf():
    return ('<?xml version="1.0"?>\n<Xdmf Version="2.0"><Domain><Grid GridType="Uniform">\n'
            '<Topology TopologyType="Mixed" NumberOfElements="3"><DataItem Dimensions="14" NumberType="Int">\n' +
            lines((6, *(i - 1 for i in t)) for t in TETRAHEDRA) + lines([(4, *(i - 1 for i in TRIANGLE))]) +
            '</DataItem></Topology>\n<Geometry><DataItem Dimensions="5 3" Precision="8">\n' + lines(POINTS) +
            '</DataItem></Geometry>\n<Attribute Name="region" Center="Cell"><DataItem Dimensions="3" NumberType="Int">'
            '4 4 7</DataItem></Attribute>\n<Set Name="ends" SetType="Node"><DataItem Dimensions="2" NumberType="Int">'
            '0 4</DataItem></Set>\n</Grid></Domain></Xdmf>\n').encode()


def xdmf_beside():
    """An XDMF file whose numbers stand in a file of bytes beside it."""
    cells = [i - 1 for t in TETRAHEDRA for i in t]
    item = '<DataItem Dimensions="%s" Format="Binary" Endian="Little" NumberType="%s" Precision="%d" Seek="%d">beside.bin</DataItem>'
    return {"beside.xdmf": ('<?xml version="1.0"?>\n<Xdmf Version="3.0"><Domain><Grid GridType="Uniform">\n'
                            '<Topology TopologyType="Tetrahedron" NumberOfElements="2">' + item % ("2 4", "Int", 4, 120) +
                            '</Topology>\n<Geometry>' + item % ("5 3", "Float", 8, 0) +
                            '</Geometry>\n</Grid></Domain></Xdmf>\n').encode(),
            "beside.bin": struct.pack("<15d8i", *[x for p in POINTS for x in p], *cells)}


def meshes():
    return {
        "gmsh22.msh": gmsh22(), "gmsh22_binary.msh": gmsh22_binary(), "gmsh41.msh": gmsh41(),
        "gmsh41_binary.msh": gmsh41_binary(), "medit.mesh": medit(), "version2.meshb": meshb(2, "<"),
        "version3.meshb": meshb(3, ">"), "version4.meshb": meshb(4, "<"), "ascii.vtk": vtk(),
        "binary.vtk": vtk_binary(), "offsets.vtk": vtk51(), "ascii.vtu": vtu(), "raw.vtu": vtu_raw(),
        "zlib.vtu": vtu_zlib(), "base64.vtu": vtu_base64(), "netgen.vol": netgen(), "abaqus.inp": abaqus(),
        "nastran.bdf": nastran(), "plain.mfem": mfem(), "ascii.off": off(), "binary.off": off_binary(),
        "ascii.stl": stl(), "binary.stl": stl_binary(), "plain.obj": obj(), "ascii.ply": ply("ascii"),
        "little.ply": ply("binary_little_endian", "<"), "big.ply": ply("binary_big_endian", ">"),
        "classic.exo": exodus(1), "offsets.exo": exodus(2), "wide.exo": exodus(5),
        "ascii.avs": ucd(), "binary.ucd": ucd_binary(), "tiny.su2": su2(), "tiny.unv": unv(), "tiny.xdmf": xdmf(),
        "tetgen.node": ("5 3 0 1\n" + numbered((*p, 0) for p in POINTS)).encode(),
        "tetgen.ele": ("2 4 1\n" + numbered((*t, 4) for t in TETRAHEDRA)).encode(),
        "tetgen.face": ("1 1\n" + numbered([(*TRIANGLE, 7)])).encode(),
    }


def elmer():
    return {"mesh.header": b"5 2 1\n2\n504 2\n303 1\n",
            "mesh.nodes": lines((i + 1, -1, *map(float, p)) for i, p in enumerate(POINTS)).encode(),
            "mesh.elements": lines((i + 1, 4, 504, *t) for i, t in enumerate(TETRAHEDRA)).encode(),
            "mesh.boundary": lines([(1, 7, 1, 0, 303, *TRIANGLE)]).encode(),
            "mesh.names": b"$ body = 4\n$ skin = 7\n"}


# The face between the two tetrahedra, those of the first, those of the second; from 0.
FOAM_FACES = [(1, 2, 3), (0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]


def openfoam(label):
    """In text (label 0), or in binary by labels of so many bytes."""
    def file(name, kind, text, binary=None):
        form = "binary" if label and binary is not None else "ascii"
        head = ('FoamFile\n{\n version 2.0;\n format %s;\n arch "LSB;label=%d;scalar=64";\n class %s;\n object %s;\n}\n' %
                (form, 8 * (label or 4), kind, name)).encode()
        return head + (text.encode() if form == "ascii" else binary)

    def labels(values):
        return b"%d\n(%s)\n" % (len(values), struct.pack("<%d%s" % (len(values), "iq"[label == 8]), *values))

    def row(values):
        return "%d(%s)\n" % (len(values), " ".join(map(str, values)))
    nodes = [i for face in FOAM_FACES for i in face]
    points = b"5\n(" + struct.pack("<15d", *[x for p in POINTS for x in p]) + b")\n"
    owner = [0, 0, 0, 0, 1, 1, 1]
    return {"points": file("points", "vectorField", "5\n(\n" + "".join("(%g %g %g)\n" % p for p in POINTS) + ")\n", points),
            "faces": file("faces", "faceCompactList" if label else "faceList",
                          "7\n(\n" + "".join(map(row, FOAM_FACES)) + ")\n", labels(range(0, 22, 3)) + labels(nodes)),
            "owner": file("owner", "labelList", row(owner), labels(owner)),
            "neighbour": file("neighbour", "labelList", row([1]), labels([1])),
            "boundary": file("boundary", "polyBoundaryMesh", "1\n(\nskin\n{\n type patch;\n inGroups 1(all);\n"
                             " nFaces 6;\n startFace 1;\n}\n)\n"),
            "cellZones": file("cellZones", "regIOobject", "1\n(\nzone\n{\n type cellZone;\n"
                              " cellLabels List<label> 1(1);\n}\n)\n"),
            "faceZones": file("faceZones", "regIOobject", "1\n(\nbetween\n{\n type faceZone;\n"
                              " faceLabels List<label> 1(0);\n flipMap List<bool> 1(0);\n}\n)\n")}


def folders():
    return {"elmer": elmer(), "openfoam": openfoam(0), "openfoam32": openfoam(4), "openfoam64": openfoam(8)}
