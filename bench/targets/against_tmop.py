"""against_tmop: planish and MFEM's mesh-optimizer on the same meshes towards the same targets.

   against_tmop.py MESH-OPTIMIZER FOLDER    writes FOLDER/tmop.json

Both move the same nodes, on one thread, and run until they stop by themselves. numpy judges both."""
import json
import sys
import tempfile
import time

import numpy as np

import bases
import cells
import deform
import machine
import planish
import ratios
import sizes
import speed
import tmop

REPEATS = 3         # of each; the least seconds count
LONG = 5            # seconds: more is not repeated
ITERATIONS = 100    # of MFEM, at most
SWEEPS = 5000       # of planish, at most
STRICT = 1e-12      # planish's tolerance, where it is to get to MFEM's RMS
DIGITS = 1e-12      # of the domain, in what MFEM writes
NEAR = 1e-5         # so near to it
BENT = 0.5          # of the largest angle, up to which the image of the mesh is valid
PINCHED = 0.5       # the same of a waist

# Two ways to solve of MFEM: it is not to lose time by what nobody needs, or quality by stopping early. The faster one
# counts that comes within WITHIN of the lower energy.
WAYS = {"rough": ("-ls", "3", "-rtol", "1e-4", "-art", "2"), "strict": ("-ls", "3", "-rtol", "1e-7")}
WITHIN = 1e-3

CORNERS = ("-qt", "1", "-qo", "1")  # a point for each corner of quadrilaterals and hexahedra, one for a simplex
SHAPES = {2: ("-tid", "1", "-mid", "50"), 3: ("-tid", "1", "-mid", "304")}
POWERS = {2: 2, 3: 1.5}             # these metrics are the mean of mu to such a power, but for constants
SIZES = {2: ("-mid", "94", "-ir"), 3: ("-mid", "334", "-ir")}
SHARES = {2: 1.5, 3: 1}             # of sizes in these metrics, where shapes have 1
WEIGHTS = {2: 0.75, 3: 2 / 3}       # the same of planish, for small deviations: it has mu^2 where MFEM has mu

NAMES = sizes.NAMES
MESHES = {
    "triangles": lambda: bases.load("plate100k"),
    "quadrilaterals": lambda: base_of_grid("quad", 200, 100),
    "tetrahedra": lambda: bases.load("bracket100k"),
    "hexahedra": lambda: base_of_grid("hex", 40, 20, 20),
}
# Squares and cubes. No simplices: mesh-optimizer takes their area or volume as a determinant, 2 or 6 times as large.
SQUARES = {
    "quadrilaterals": lambda: sizes.grid("quad", 60, 2),
    "hexahedra": lambda: sizes.grid("hex", 14, 3),
}


def base_of(points, elements):
    return bases.Base(points, elements, cells.on_boundary(len(points), elements), cells.edges(elements), None)


def base_of_grid(name, *counts):
    points, nodes = bases.grid(*counts)
    return base_of(points, cells.Cells((name, nodes)))


def pushed(mesh, points):
    """points with inner nodes pushed about, but for those of elements that would be inverted."""
    found = speed.pushed(points, mesh.fixed, mesh.edges)
    (_, nodes), = cells.blocks_of(mesh.elements)
    while (bad := cells.inverted(found, mesh.elements)).any():
        found[nodes[bad]] = points[nodes[bad]]
    return found


def small_at_circle(points):
    """The field of mesh-optimizer's -tid 5, as lengths of edges: a third at a circle or sphere around the middle
    of a side."""
    dim = points.shape[1]
    distance = np.linalg.norm(points - [0, 0.5, 0.5][:dim], axis=1)
    share = (np.tanh(30 * (distance - 0.45)) - np.tanh(30 * (distance - 0.55))) / 2
    small = np.clip(share, 0, 1)
    return (small + (1 - small) * 3 ** dim) ** (1 / dim)


def even(points):
    return np.ones(len(points))


class Case:
    """What is smoothed: points and elements; field: the sizes that are wanted, at points; slides: nodes of the
    boundary do, in planes of axes; options: of mesh-optimizer."""

    def __init__(self, kind, start, points, elements, field=None, slides=False, options=()):
        self.kind, self.start, self.points, self.elements = kind, start, points, elements
        self.field, self.slides, self.dim = field, slides, points.shape[1]
        self.options = (*CORNERS, *options, *(SIZES if field else SHAPES)[self.dim])

    def judged(self, points):
        """Figures of points, by numpy."""
        squares = ratios.squares(points, None, self.elements)
        found = {"rms": float(np.sqrt(squares.mean())), "worst": float(np.sqrt(squares.max())),
                 "inverted": cells.n_inverted(points, self.elements)}
        if self.field:
            return {**found, **self.goals(points), "spread": sizes.spread(points, self.elements, self.field)}
        power = POWERS[self.dim]
        return {**found, "energy": float(ratios.means(points, None, self.elements, power).mean())}

    def goals(self, points):
        """What both programs minimise, with the factor of sizes that fits best: an RMS and a mean."""
        (name, nodes), = cells.blocks_of(self.elements)
        mu, tau = [], []
        for corner in (nodes[:, list(corner)] for corner in ratios.CORNERS[name]):
            mu.append(ratios.mean_ratios(points, np.linalg.inv(ratios.REGULAR[name]), corner))
            measure = np.linalg.det(ratios.matrices(points, corner)) / np.linalg.det(ratios.REGULAR[name])
            tau.append(measure / self.field(points)[corner].mean(axis=1) ** self.dim)
        mu, tau, weight = np.array(mu), np.array(tau), WEIGHTS[self.dim]
        tau = tau / np.sqrt(tau.mean() / (1 / tau).mean())
        size = (tau + 1 / tau) / 2
        return {"planish_goal": float(np.sqrt(((1 - weight) * mu ** 2 + weight * size).mean())),
                "mfem_goal": float((mu + SHARES[self.dim] * size).mean())}

    def check_held(self, points, name):
        """End if the boundary has moved, off its sides where it may slide, by more than MFEM's digits."""
        fixed = cells.on_boundary(len(points), self.elements)
        away = abs(points - self.points)[fixed]
        if self.slides:  # in a square or cube of size 1
            away = away[(self.points[fixed] == 0) | (self.points[fixed] == 1)]
        if away.max() > DIGITS * np.ptp(self.points):
            raise SystemExit(f"against_tmop: {name} has moved the boundary of the {self.kind} by {away.max()}")

    def planned(self, points):
        """planish's plan of points."""
        by_type = {NAMES[name]: nodes for name, nodes in cells.blocks_of(self.elements)}
        wanted = {"sizes": self.field(points), "size_weight": WEIGHTS[self.dim]} if self.field else {}
        return planish.Plan(points, by_type, threads=1, layers="ignore", slide="auto" if self.slides else None,
                            **wanted)

    def by_planish(self):
        points, begin = self.points.copy(), time.process_time()
        with self.planned(points) as plan:
            result = plan.smooth(objective="mean-ratio", max_sweeps=SWEEPS)
        return points, {"seconds": time.process_time() - begin, "iterations": result.sweeps, "stop": result.stop}

    def seconds_to(self, rms):
        """What planish takes until the RMS is as low, by whole sweeps of a run with a strict tolerance; None: never."""
        def is_reached(progress):
            return progress.sweep_done and progress.rms <= rms * (1 + NEAR)

        begin = time.process_time()
        with self.planned(self.points.copy()) as plan:
            result = plan.smooth(objective="mean-ratio", max_sweeps=SWEEPS, tolerance=STRICT, progress=is_reached)
        return time.process_time() - begin if result.stop == "interrupted" else None

    def by_mfem(self, optimizer, way):
        outcome = optimizer.smooth(self.points, self.elements, ITERATIONS, (*self.options, *WAYS[way]), self.slides)
        return outcome.points, {"seconds": outcome.seconds, "iterations": outcome.iterations,
                                "energy_said": outcome.energy,
                                "stop": "converged" if outcome.converged else "not converged", "way": way}


def by_best_way(case, optimizer):
    """MFEM's points and figures by the better way, and the figures by each."""
    runs = {way: case.by_mfem(optimizer, way) for way in WAYS}
    figures = {way: run[1] for way, run in runs.items()}
    lowest = min(found["energy_said"] for found in figures.values())
    good = [way for way, found in figures.items() if found["energy_said"] <= lowest + WITHIN * abs(lowest)]
    way = min(good, key=lambda way: figures[way]["seconds"])
    return repeated(lambda: case.by_mfem(optimizer, way), runs[way]), figures


def repeated(run, first):
    """Points and figures of the run of the least seconds, of which one is made."""
    found = [first]
    while len(found) < REPEATS and first[1]["seconds"] < LONG:
        found.append(run())
    return min(found, key=lambda one: one[1]["seconds"])


def compared(case, optimizer):
    """A row."""
    by_mfem, ways = by_best_way(case, optimizer)
    outcomes = {"mfem": by_mfem, "planish": repeated(case.by_planish, case.by_planish())}
    row = {"kind": case.kind, "start": case.start, "elements": len(case.elements), "before": case.judged(case.points),
           "ways": ways}
    for name, (points, figures) in outcomes.items():
        case.check_held(points, name)
        row[name] = {**figures, **case.judged(points)}
    if not case.field:
        row["planish"]["reached"] = case.seconds_to(row["mfem"]["rms"])
    return row


def shapes():
    """Cases: regular elements alone are wanted."""
    for kind, make in MESHES.items():
        mesh = make()
        bent = deform.deformed(mesh, "bend", BENT)
        yield Case(kind, "bent", bent, mesh.elements)
        yield Case(kind, "bent, pushed", pushed(mesh, bent), mesh.elements)
        yield Case(kind, "pushed", pushed(mesh, mesh.points), mesh.elements)


def sizes_and_shapes():
    """Cases: sizes are wanted, too."""
    for kind, make in SQUARES.items():
        points, elements = make()
        mesh = base_of(points, elements)
        pinched = pushed(mesh, deform.deformed(mesh, "pinch", PINCHED))
        yield Case(kind, "even", pinched, elements, even, False, ("-tid", "2"))
        yield Case(kind, "small at a circle", pushed(mesh, points), elements, small_at_circle, True, ("-tid", "5"))


def main():
    program, folder = sys.argv[1:]
    found = {"machine": machine.description(), "rows": []}
    with tempfile.TemporaryDirectory(dir=folder) as files:
        optimizer = tmop.Optimizer(program, files)
        for case in (*shapes(), *sizes_and_shapes()):
            found["rows"].append(compared(case, optimizer))
            print(found["rows"][-1], flush=True)
    with open(f"{folder}/tmop.json", "w", encoding="ascii") as file:
        json.dump(found, file, indent=1)


if __name__ == "__main__":
    main()
