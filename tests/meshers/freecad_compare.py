"""Compare the meshes of start.FCStd and part.FCStd in FreeCAD; print same if all is but places of nodes."""

import FreeCAD


def content(name):
    """The mesh of a document, and what it has but for places."""
    document = FreeCAD.openDocument(name)
    mesh, shape = document.getObject("Mesh").FemMesh, document.getObject("Part").Shape
    elements = {kind: {i: mesh.getElementNodes(i) for i in getattr(mesh, kind)}
                for kind in ("Edges", "Faces", "Volumes")}
    groups = {mesh.getGroupName(i): mesh.getGroupElements(i) for i in mesh.Groups}
    on_faces = [sorted(mesh.getNodesByFace(face)) for face in shape.Faces]
    on_edges = [sorted(mesh.getNodesByEdge(edge)) for edge in shape.Edges]
    return mesh, (elements, groups, on_faces, on_edges)


before, kept = content("start.FCStd")
after, found = content("part.FCStd")
moved = max((before.Nodes[i] - after.Nodes[i]).Length for i in before.Nodes)
print("moved by", moved, "groups", list(kept[1]), "nodes on faces", [len(nodes) for nodes in kept[2]])
if set(before.Nodes) == set(after.Nodes) and kept == found and kept[1] and moved > 0.1:
    print("same")
