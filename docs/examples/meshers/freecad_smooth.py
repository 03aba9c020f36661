"""freecad_smooth: smooth the FEM meshes of the open document of FreeCAD with planish.

    As a macro: select meshes (none: all of the document), run it.
    freecadcmd PART.FCStd freecad_smooth.py      smooths all meshes and saves PART.FCStd

FreeCAD finds the nodes of loads and constraints by their places on the faces of the part. With --slide auto nodes stay on
these faces. With --slide curved nodes may leave curved faces, within a tolerance, and these faces lose their loads.
"""
import os
import subprocess
import tempfile

import FreeCAD
import Fem

PLANISH, OPTIONS = "planish", ["--slide", "auto", "--objective", "worst"]


def smooth(mesh):
    """Smooth the mesh of an object of the document, by a UNV file, which keeps numbers, groups and all digits."""
    with tempfile.TemporaryDirectory() as folder:
        before, after = os.path.join(folder, "before.unv"), os.path.join(folder, "after.unv")
        mesh.FemMesh.write(before)
        done = subprocess.run([PLANISH, "smooth", before, "-o", after, *OPTIONS], capture_output=True, text=True)
        FreeCAD.Console.PrintMessage(f"{mesh.Label}:\n{done.stdout}{done.stderr}\n")
        if done.returncode not in (0, 1):  # 1: some elements stay inverted
            raise RuntimeError(done.stderr)
        mesh.FemMesh = Fem.read(after)


document = FreeCAD.ActiveDocument
chosen = FreeCAD.Gui.Selection.getSelection() if FreeCAD.GuiUp else []
for mesh in chosen or document.Objects:
    is_result = getattr(getattr(mesh, "Proxy", None), "Type", "") == "Fem::MeshResult"
    if hasattr(mesh, "FemMesh") and not is_result:
        smooth(mesh)
if not FreeCAD.GuiUp:
    document.save()
