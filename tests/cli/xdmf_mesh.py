"""XDMF files by meshio and h5py, and comparisons.

    xdmf_mesh.py forms MESH             write MESH with its numbers in the XML, in HDF5 and as bytes; print the names
    xdmf_mesh.py dolfinx MESH OUT       write the tetrahedra of MESH as DOLFINx does, with tags and a series in time
    xdmf_mesh.py same IN OUT ...        check pairs: nothing but places of points differs
"""
import os
import sys

import numpy as np
import meshio


def forms(mesh):
    for form in "XML", "HDF", "Binary":
        name = form.lower() + ".xdmf"
        meshio.write(name, meshio.read(mesh), file_format="xdmf", data_format=form)
        print(name)


def dolfinx(mesh, out):
    import h5py
    read = meshio.read(mesh)
    cells = np.concatenate([block.data for block in read.cells if block.type == "tetra"])
    tags = np.where(read.points[cells].mean(axis=1)[:, 2] < .5, 3, 8)
    order = np.random.default_rng(1).permutation(len(cells))
    facets = np.concatenate([block.data for block in read.cells if block.type == "triangle"])
    stem = os.path.splitext(os.path.basename(out))[0]
    with h5py.File(os.path.splitext(out)[0] + ".h5", "w") as file:
        file["Mesh/mesh/geometry"], file["Mesh/mesh/topology"] = read.points, cells.astype("i8")
        file["MeshTags/cells/topology"] = cells[order][:, ::-1].astype("i8")
        file["MeshTags/cells/Values"] = tags[order].astype("i4")
        file["MeshTags/facets/topology"], file["MeshTags/facets/Values"] = facets, np.full(len(facets), 5, "i4")
        file["Function/f/0"] = read.points[:, :1]
        file["Function/f/1"] = read.points[:, :1]

    def item(name, kind="Int"):
        shape = {"Mesh/mesh/geometry": read.points, "Mesh/mesh/topology": cells, "MeshTags/cells/topology": cells,
                 "MeshTags/facets/topology": facets, "Function/f/0": read.points[:, :1],
                 "Function/f/1": read.points[:, :1], "MeshTags/cells/Values": tags,
                 "MeshTags/facets/Values": facets[:, 0]}[name].shape
        return '<DataItem Dimensions="%s" NumberType="%s" Format="HDF">%s.h5:/%s</DataItem>' % (
            " ".join(map(str, shape)), kind, stem, name)

    def grid_of_tags(name, kind, n):
        return ('<Grid Name="%s" GridType="Uniform"><xi:include xpointer="xpointer(/Xdmf/Domain/Grid/Geometry)"/>'
                '<Topology TopologyType="%s" NumberOfElements="%d">%s</Topology>'
                '<Attribute Name="%s" AttributeType="Scalar" Center="Cell">%s</Attribute></Grid>\n' % (
                    name, kind, n, item("MeshTags/%s/topology" % name), name, item("MeshTags/%s/Values" % name)))
    include = ("<xi:include xpointer=\"xpointer(/Xdmf/Domain/Grid[@GridType='Uniform'][1]/*[self::Topology or "
               "self::Geometry])\"/>")
    steps = "".join('<Grid Name="f" GridType="Uniform">%s<Time Value="%d"/><Attribute Name="f" Center="Node">%s'
                    '</Attribute></Grid>\n' % (include, k, item("Function/f/%d" % k, "Float")) for k in range(2))
    with open(out, "w") as file:
        file.write('<?xml version="1.0"?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="3.0" '
                   'xmlns:xi="https://www.w3.org/2001/XInclude">\n<Domain>\n<Grid Name="mesh" GridType="Uniform">'
                   '<Topology TopologyType="Tetrahedron" NumberOfElements="%d" NodesPerElement="4">%s</Topology>'
                   '<Geometry GeometryType="XYZ">%s</Geometry></Grid>\n' % (
                       len(cells), item("Mesh/mesh/topology"), item("Mesh/mesh/geometry", "Float")))
        file.write(grid_of_tags("cells", "Tetrahedron", len(cells)))
        file.write(grid_of_tags("facets", "Triangle", len(facets)))
        file.write('<Grid Name="f" GridType="Collection" CollectionType="Temporal">\n%s</Grid>\n</Domain>\n</Xdmf>\n' % steps)


def read(path):
    """meshio looks for files of bytes in the current folder."""
    here = os.getcwd()
    os.chdir(os.path.dirname(path) or ".")
    mesh = meshio.read(os.path.basename(path))
    os.chdir(here)
    return mesh


def elements(mesh):
    return sorted((block.type, tuple(nodes)) for block in mesh.cells for nodes in block.data.tolist())


def same(names):
    for a, b in zip(names[::2], names[1::2]):
        x, y = read(a), read(b)
        assert elements(x) == elements(y), a
        moved = (x.points != y.points).any(axis=1).sum()
        assert 0 < moved < len(x.points), (a, moved)
        assert x.cell_data.keys() == y.cell_data.keys()
        for name, blocks in x.cell_data.items():
            assert all(np.array_equal(p, q) for p, q in zip(blocks, y.cell_data[name])), (a, name)


if __name__ == "__main__":
    what, arguments = sys.argv[1], sys.argv[2:]
    {"forms": lambda: forms(*arguments), "dolfinx": lambda: dolfinx(*arguments), "same": lambda: same(arguments)}[what]()
