"""salome_smooth: smooth a mesh of Salome's module Mesh with planish, by MED files.

    import sys; sys.path.append(FOLDER)      # of this file; planish must be in PATH
    from salome_smooth import smooth         # in Salome's Python console, or a script: File > Load Script
    better = smooth(mesh, "--slide", "auto") # mesh of smeshBuilder; a new mesh of the study, with the same groups

Not tried in Salome: a test runs this file with stand-ins for Salome's modules.
"""
import os
import subprocess
import tempfile

from salome.smesh import smeshBuilder


def smooth(mesh, *options):
    """Return a smoothed copy of a mesh, without its geometry. options: of planish smooth; RuntimeError if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        before, after = os.path.join(folder, "before.med"), os.path.join(folder, "after.med")
        mesh.ExportMED(before)
        # Salome's libraries, HDF5 among them, are not planish's.
        own = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
        done = subprocess.run(["planish", "smooth", before, "-o", after, *options], env=own)
        if done.returncode not in (0, 1):  # 1: some elements stay inverted
            raise RuntimeError(f"planish ended with {done.returncode}")
        meshes, _ = smeshBuilder.New().CreateMeshesFromMED(after)
    return meshes[0]
