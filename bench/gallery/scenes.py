"""scenes: the pictures of the gallery. Commands are run by bash in one folder, where docs and bench are the project's;
figures are of the JSON of each planish smooth, in their order."""
from collections import namedtuple

import numpy as np

import view
from picture import Look, falling, radius_ratios

# heading; commands, one a line; files: of the states; titles: of the reports, lines above each state; caption: of the
# reports; scale; look; values: name of the measure, or a function of a view.Mesh; box: two corners of what is seen, or
# None: all of it
Scene = namedtuple("Scene", "heading commands files titles caption scale look values box", defaults=(None,))


def n(value, digits=3):
    """A number as people write it."""
    return f"{value:.{digits}g}"


def ratio(state):
    return state["max_radius_ratio"] or state["max_aspect_ratio"]


def inverted(state):
    return f"{state['inverted']} inverted elements" if state["inverted"] else "no inverted element"


def halves(report, lines, before="before", after="after planish"):
    """Titles of both states: a name, and lines of each."""
    return (before, *lines(report["before"])), (after, *lines(report["after"]))


def tetrahedra(state):
    return f"worst radius ratio {n(ratio(state))}", f"smallest angle {n(state['min_dihedral_deg'])}°"


def jacobians(state):
    return inverted(state), f"least scaled Jacobian {n(state['min_scaled_jacobian'], 2)}"


def curved(state):
    return inverted(state), f"least Jacobian / mean {n(state['min_jacobian_ratio'], 2)}"


def sizes(state):
    return (f"sizes are off by a factor of {n(np.exp(state['sizes']['rms_log']))} (RMS)",)


def distance(report):
    return n(report["surface"]["distance_in_edges"], 2)


def scanned(state):
    return f"worst radius ratio {n(ratio(state))}", f"RMS {state['rms_radius_ratio']:.2f}"


def edge_lengths(mesh):
    """Those of the equilateral triangles of the same areas."""
    x = np.stack([mesh.points[nodes] for nodes in mesh.nodes])
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2
    return np.sqrt(area * 4 / 3 ** 0.5)


SCENES = {
    "bracket": Scene(
        "After a mesher's own optimisation",
        """gmsh -3 docs/examples/bracket.geo -setnumber optimise 1 -format msh41 -o bracket.msh
planish smooth bracket.msh best.msh --best""",
        ("bracket.msh", "best.msh"), lambda r: halves(r[0], tetrahedra, "as Gmsh's optimiser leaves it"),
        lambda r: f"Gmsh has optimised these {r[0]['mesh']['elements']} tetrahedra. Those with a radius ratio "
                  f"above 2 are drawn. planish proves that the surface has moved by at most {distance(r[0])} edge lengths.",
        radius_ratios(1.5, 2, 2.5, 3), Look(view.camera(-60, 25), bad=2), "radius_ratio"),
    "hexahedra": Scene(
        "Tangled hexahedra",
        """bench/untangle/case hexes_bend-50_left tangled.vtk
planish smooth tangled.vtk untangled.vtk""",
        ("tangled.vtk", "untangled.vtk"), lambda r: halves(r[0], jacobians),
        lambda r: f"A bar of {r[0]['mesh']['elements']} hexahedra was bent, and the nodes inside stayed behind. The upper "
                  f"half is cut off. planish repairs all {r[0]['before']['inverted']} inverted elements.",
        falling("scaled Jacobian", 0.8, 0.6, 0.4, 0.2), Look(view.camera(-60, 35), lambda x: x[:, 2] < 5),
        "scaled_jacobian"),
    "quadratic": Scene(
        "Curved elements",
        """gmsh -3 docs/examples/bracket.geo -setnumber h 8 -setnumber optimise 1 -order 2 -format msh41 -o order2.msh
planish smooth order2.msh valid.msh""",
        ("order2.msh", "valid.msh"),
        lambda r: halves(r[0], curved, "as Gmsh raises the order"),
        lambda r: f"Gmsh has curved tetrahedra at coarse holes; {r[0]['before']['inverted']} are inverted between "
                  "positive corners. planish moves mid-side nodes and corners inside. The boundary stays.",
        falling("least Jacobian / mean", 0.6, 0.4, 0.2, 0.1), Look(view.camera(-60, 25), bad=3), "jacobian_ratio",
        ((6, -1, 0), (40, 41, 14))),
    "layers": Scene(
        "A boundary layer",
        """gmsh -3 bench/gallery/layers.geo -format msh41 -o layers.msh
planish smooth layers.msh kept.msh --layers keep""",
        ("layers.msh", "kept.msh"), lambda r: halves(r[0], jacobians),
        lambda r: f"{r[0]['mesh']['kept_layer_elements']} prisms in five layers keep their heights. The tetrahedra around "
                  "them get better.",
        falling("scaled Jacobian", 0.5, 0.3, 0.2, 0.1),
        Look(view.camera(-60, 20), lambda x: x[:, 1] > 0, has_layers=True),
        "scaled_jacobian", ((-1.6, 0, -1.45), (1.6, 0, 1.45))),
    "rotor": Scene(
        "A moving mesh",
        """gmsh -2 bench/gallery/rotor.geo -format msh41 -o rotor.msh
bench/gallery/mesh turned rotor.msh turned.msh
planish smooth turned.msh followed.msh --like rotor.msh""",
        ("turned.msh", "followed.msh"),
        lambda r: halves(r[0], lambda state: (inverted(state),), "the rotor has turned by 15°"),
        lambda r: "The rotor has turned, and the nodes inside have stayed behind. With --like each triangle gets its "
                  "earlier shape back.",
        radius_ratios(1.5, 2, 3, 5), Look(), "radius_ratio"),
    "sizes": Scene(
        "Sizes",
        """gmsh -2 bench/plate.geo -setnumber h 0.5 -format msh41 -o plate.msh
bench/gallery/mesh sizes plate.msh wanted.msh
planish smooth wanted.msh sized.msh --size size --slide auto""",
        ("wanted.msh", "sized.msh"),
        lambda r: halves(r[0], sizes),
        lambda r: "Small elements are wanted at an arc. The same triangles move there.",
        falling("edge length", 0.5, 0.4, 0.3, 0.2), Look(),
        edge_lengths),
    "scan": Scene(
        "A scan",
        """bench/gallery/mesh scan scan.stl
planish smooth scan.stl better.stl""",
        ("scan.stl", "better.stl"),
        lambda r: halves(r[0], scanned),
        lambda r: f"{r[0]['mesh']['elements']} irregular triangles slide along their surface. planish proves "
                  f"that no point leaves the scan by more than {distance(r[0])} edge lengths.",
        radius_ratios(1.2, 1.5, 2, 3), Look(view.camera(-60, 25)), "radius_ratio"),
    "quadrilaterals": Scene(
        "Quadrilaterals",
        """gmsh -2 bench/plate.geo -string "Mesh.RecombineAll=1;Mesh.Smoothing=0;" -format msh41 -o quads.msh
planish smooth quads.msh smooth.msh --slide auto""",
        ("quads.msh", "smooth.msh"), lambda r: halves(r[0], jacobians),
        lambda r: f"Gmsh has joined triangles to these {r[0]['mesh']['elements']} elements. Nodes inside move, and those of "
                  "straight sides slide.",
        falling("scaled Jacobian", 0.9, 0.8, 0.6, 0.4), Look(), "scaled_jacobian"),
    "mixed": Scene(
        "All types, two materials",
        """bench/gallery/mesh mixed mixed.vtk
planish smooth mixed.vtk smoothed.vtk""",
        ("mixed.vtk", "smoothed.vtk"), lambda r: halves(r[0], jacobians),
        lambda r: "Hexahedra, wedges, pyramids and tetrahedra are tangled. planish holds the nodes between two materials "
                  "(black line).",
        falling("scaled Jacobian", 0.8, 0.6, 0.4, 0.2),
        Look(view.camera(-60, 30), lambda x: x[:, 2] < 4, has_borders=True),
        "scaled_jacobian"),
}
