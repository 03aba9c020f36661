"""methods: the smoothers that are compared; each takes a Medit file and writes one."""
import json
import os
import subprocess

GMSH_TIMES = 5  # relocations in a row: more than enough for Gmsh to arrive


def planish(*options):
    def smooth(build, mesh, out):
        command = [f"{build}/planish", "smooth", mesh, "-o", out, "-j", "1", "-q", *options]
        done = subprocess.run(command, stderr=subprocess.DEVNULL, check=False)
        if done.returncode not in (0, 1):  # 1: elements are inverted, the mesh is written
            raise subprocess.CalledProcessError(done.returncode, done.args)
    return smooth


def relocate(_, mesh, out):
    """The only smoother of Gmsh that takes a mesh which it did not just make."""
    script = f"{out}.geo"
    with open(script, "w", encoding="ascii") as file:
        file.write(f'Merge "{os.path.abspath(mesh)}";\n')
        file.write('OptimizeMesh "Relocate3D";\n' * GMSH_TIMES)
    subprocess.run(["gmsh", script, "-v", "1", "-nt", "1", "-format", "mesh", "-save", "-o", out],
                   check=True)
    os.remove(script)


METHODS = {
    "planish": planish(),
    "planish, mean ratio": planish("--objective", "mean-ratio"),
    "Gmsh Relocate3D": relocate,
    "Laplacian": planish("--method", "laplacian"),
    "volume-weighted Laplacian": planish("--method", "area-laplacian"),
    "length-weighted Laplacian": planish("--method", "length-laplacian"),
}


def quality(build, mesh):
    """What `planish quality` says of it."""
    done = subprocess.run([f"{build}/planish", "quality", mesh, "-q", "--json", "-"],
                          stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)["quality"]
