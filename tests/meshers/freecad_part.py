"""Make part.FCStd in FreeCAD: a block with a hole, a mesh of quadratic tetrahedra, a group of faces."""

import FreeCAD
import ObjectsFem
from femmesh.gmshtools import GmshTools

document = FreeCAD.newDocument("part")
block = document.addObject("Part::Box", "Block")
block.Length = block.Width = block.Height = 20
hole = document.addObject("Part::Cylinder", "Hole")
hole.Radius, hole.Height, hole.Placement.Base = 4, 20, FreeCAD.Vector(10, 10, 0)
part = document.addObject("Part::Cut", "Part")
part.Base, part.Tool = block, hole
analysis = ObjectsFem.makeAnalysis(document, "Analysis")
mesh = ObjectsFem.makeMeshGmsh(document, "Mesh")
mesh.Part, mesh.CharacteristicLengthMax, mesh.ElementOrder = part, 3.0, "2nd"
analysis.addObject(mesh)
document.recompute()
group = ObjectsFem.makeMeshGroup(document, mesh, True, "hole")
group.References = [(part, "Face7")]
document.recompute()
GmshTools(mesh, analysis).create_mesh()
document.saveAs("part.FCStd")
