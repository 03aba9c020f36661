"""parts: meshes of a part whose boundary is bent, twisted or stretched, smoothed towards the original."""
import numpy as np

import bases
import cells
import deform
import optimum
import ratios

MAPS = "bend", "twist", "stretch"
SHARE = 0.5       # of the largest strength, up to which the image of the whole mesh is valid
MESHES = "bracket", "bracket100k"
ITERATIONS = 3000
MOST_ELEMENTS = 20000  # of a mesh that the optimum is found for


def starts(mesh, image):
    """How inner nodes begin: where the map takes them, or where they were."""
    return {"moved by the map": image, "left behind": np.where(mesh.fixed[:, None], image, mesh.points)}


def global_optimum(mesh, image, smoothed):
    """The least RMS of descents from the map's image and from planish's result."""
    problem = optimum.Problem(image, mesh.points, mesh.elements, ~mesh.fixed)
    rms, iterations = problem.least(image, ITERATIONS)
    nearby, _ = problem.least(smoothed, ITERATIONS)
    return {"optimum_rms": rms, "optimum_iterations": iterations, "optimum_nearby_rms": nearby}


def measure(program):
    rows = []
    for base in MESHES:
        mesh = bases.load(base)
        for name in MAPS:
            image = deform.deformed(mesh, name, SHARE)
            optimal = {}
            for start, points in starts(mesh, image).items():
                smoothed, report = program.smooth(points, mesh.elements, mesh.points, ["-j", "1"])
                row = {"mesh": base, "elements": len(mesh.elements), "map": name, "start": start,
                       "inverted_before": cells.n_inverted(points, mesh.elements),
                       "inverted": cells.n_inverted(smoothed, mesh.elements),
                       "rms_before": ratios.rms(points, mesh.points, mesh.elements),
                       "rms": ratios.rms(smoothed, mesh.points, mesh.elements),
                       "rms_of_report": report["after"]["rms_aspect_ratio"],
                       "sweeps": len(report["sweeps"]), "seconds": report["seconds"]["smooth"]}
                if len(mesh.elements) <= MOST_ELEMENTS:
                    optimal = optimal or global_optimum(mesh, image, smoothed)
                rows.append({**row, **optimal})
                print(rows[-1], flush=True)
    return rows
