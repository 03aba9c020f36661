"""recipes: parametric models in Gmsh's OpenCASCADE kernel, and how each is meshed."""
import math
from dataclasses import dataclass

import gmsh

occ = gmsh.model.occ
ELEMENTS = (200, 900)  # so many in a mesh, roughly
RECIPES, SOLIDS = {}, []


@dataclass(frozen=True)
class Recipe:
    build: object          # function of the random numbers; returns dimension and tags of the entities to mesh
    mesh: object           # function of the random numbers and the entities: what to set before meshing
    dim: int
    is_surface: bool = False
    only_triangles: bool = True


def recipe(dim=3, mesh=None, **more):
    """Register a function as a recipe under its name."""
    def add(build):
        RECIPES[build.__name__] = Recipe(build, mesh or free_simplices, dim, **more)
        if dim == 3 and mesh is None:
            SOLIDS.append(build.__name__)
        return build
    return add


def has_mesh():
    return any(len(tags) for tags in gmsh.model.mesh.getElements()[1])


def make(one, rng, order, dim=None):
    """Build and mesh a recipe; dim: only up to this dimension."""
    gmsh.model.add("model")
    for name, value in (("Mesh.RecombineAll", 0), ("Mesh.SubdivisionAlgorithm", 0), ("Mesh.ElementOrder", order),
                        ("Mesh.Optimize", rng.randrange(2)), ("Mesh.Algorithm", rng.choice((5, 6))),
                        ("Mesh.Algorithm3D", rng.choice((1, 1, 10))), ("Mesh.RecombinationAlgorithm", 1),
                        ("Mesh.SecondOrderIncomplete", rng.randrange(2)), ("Mesh.HighOrderOptimize", 0)):
        gmsh.option.setNumber(name, value)
    entities = one.build(rng)
    occ.synchronize()
    size = _size(entities, rng)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size * rng.uniform(0.3, 1))
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", rng.choice((0, 0, 8)))
    if rng.random() < 0.5:
        for tag in sorted({tag for _, tag in entities}):
            gmsh.model.addPhysicalGroup(entities[0][0], [tag])
    one.mesh(rng, entities)
    gmsh.model.mesh.generate(dim or one.dim)


def _size(entities, rng):
    """The edge length that gives the number of elements."""
    n = rng.uniform(*ELEMENTS)
    mass = sum(occ.getMass(*entity) for entity in entities)
    return (mass / (0.118 * n)) ** (1 / 3) if entities[0][0] == 3 else math.sqrt(mass / (0.433 * n))


# ---- how ---------------------------------------------------------------------------------------------


def free_simplices(_rng, _entities):
    """Triangles or tetrahedra."""


def recombined(rng, _entities):
    """Quadrilaterals."""
    gmsh.option.setNumber("Mesh.RecombineAll", 1)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", rng.choice((0, 1, 3)))
    gmsh.option.setNumber("Mesh.Algorithm", rng.choice((6, 8)))


def subdivided(_rng, entities):
    """Quadrilaterals or hexahedra from each simplex."""
    gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 2 if entities[0][0] == 3 else 1)
    for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
        gmsh.option.setNumber(name, gmsh.option.getNumber(name) * (1.7 if entities[0][0] == 3 else 1.5))


def transfinite(rng, entities):
    """A block of hexahedra, finer to one side."""
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, 7, "Progression", rng.choice((1, 1, 1.3)))
    for _, face in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(face)
        gmsh.model.mesh.setRecombine(2, face)
    for _, solid in entities:
        gmsh.model.mesh.setTransfiniteVolume(solid)


def first_recombined(_rng, _entities):
    """Quadrilaterals in the first face, and what is extruded from them; triangles in the others."""
    gmsh.model.mesh.setRecombine(2, min(tag for _, tag in gmsh.model.getEntities(2)))


# ---- solids --------------------------------------------------------------------------------------------


def _box(rng, at=(0, 0, 0)):
    return occ.addBox(*at, *(rng.uniform(0.6, 2) for _ in range(3)))


def _edges(solid):
    occ.synchronize()
    faces = gmsh.model.getBoundary([(3, solid)], oriented=False)
    return sorted({tag for _, tag in gmsh.model.getBoundary(faces, combined=False, oriented=False)})


@recipe()
def box_with_fillets(rng):
    box = _box(rng)
    edges = _edges(box)
    return occ.fillet([box], rng.sample(edges, rng.randint(1, 4)), [rng.uniform(0.05, 0.2)])


@recipe()
def box_with_chamfer(rng):
    box = _box(rng)
    faces = gmsh.model.getBoundary([(3, box)], oriented=False) if _edges(box) else []
    face = rng.choice(faces)[1]
    edge = rng.choice(gmsh.model.getBoundary([(2, face)], oriented=False))[1]
    return occ.chamfer([box], [edge], [face], [rng.uniform(0.05, 0.25)])


@recipe()
def box_with_bores(rng):
    box = occ.addBox(0, 0, 0, 2, 1.5, rng.uniform(0.3, 1))
    bores = [(3, occ.addCylinder(0.5 + i, rng.uniform(0.4, 1), -1, 0, 0, 4, rng.uniform(0.1, 0.3))) for i in range(2)]
    return occ.cut([(3, box)], bores)[0]


@recipe()
def cut_sphere(rng):
    sphere = occ.addSphere(0, 0, 0, 1)
    return occ.cut([(3, sphere)], [(3, _box(rng, [rng.uniform(-0.5, 0.3) for _ in range(3)]))])[0]


@recipe()
def tee(rng):
    r = rng.uniform(0.3, 0.5)
    tubes = [(3, occ.addCylinder(-1, 0, 0, 2, 0, 0, r)),
             (3, occ.addCylinder(rng.uniform(-0.3, 0.3), 0, 0, 0, 0, 1.2, r * rng.uniform(0.5, 0.95)))]
    return occ.fuse(tubes[:1], tubes[1:])[0]


@recipe()
def torus(rng):
    return [(3, occ.addTorus(0, 0, 0, 1, rng.uniform(0.2, 0.45), angle=rng.choice((2 * math.pi, 4, 2))))]


@recipe()
def cone(rng):
    return [(3, occ.addCone(0, 0, 0, 0, 0, rng.uniform(0.8, 2), rng.uniform(0.5, 1), rng.uniform(0, 0.4)))]


@recipe()
def hollow_sphere(rng):
    inner = occ.addSphere(rng.uniform(0, 0.3), 0, 0, rng.uniform(0.2, 0.6))
    return occ.cut([(3, occ.addSphere(0, 0, 0, 1))], [(3, inner)])[0]


@recipe()
def two_materials(rng):
    inner = occ.addSphere(rng.uniform(0.2, 0.8), 0.5, 0.5, rng.uniform(0.2, 0.45))
    return occ.fragment([(3, occ.addBox(0, 0, 0, 1, 1, 1))], [(3, inner)])[0]


def _profile(rng, radius=1.0, at=(0.0, 0.0)):
    """A polygon around a point, as a wire."""
    n = rng.randint(4, 7)
    points = [occ.addPoint(at[0] + radius * rng.uniform(0.6, 1.2) * math.cos(2 * math.pi * i / n),
                           at[1] + radius * rng.uniform(0.6, 1.2) * math.sin(2 * math.pi * i / n), 0) for i in range(n)]
    return occ.addCurveLoop([occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])])


def _plate(rng):
    """A polygon with a round hole."""
    hole = occ.addCurveLoop([occ.addCircle(rng.uniform(-0.1, 0.1), 0, 0, rng.uniform(0.15, 0.35))])
    return occ.addPlaneSurface([_profile(rng), hole])


@recipe()
def extruded_plate(rng):
    return [e for e in occ.extrude([(2, _plate(rng))], 0, 0, rng.uniform(0.2, 0.8)) if e[0] == 3]


@recipe()
def turned_profile(rng):
    face = occ.addPlaneSurface([_profile(rng, 0.4, (1.2, 0))])
    return [e for e in occ.revolve([(2, face)], 0, 0, 0, 0, 1, 0, rng.uniform(0.8, 4)) if e[0] == 3]


@recipe()
def bent_pipe(rng):
    path = occ.addWire([occ.addCircle(0, 0, 0, 1.5, angle1=0, angle2=rng.uniform(0.7, 2))])
    section = occ.addDisk(1.5, 0, 0, 0.4, rng.uniform(0.25, 0.4))
    occ.rotate([(2, section)], 1.5, 0, 0, 1, 0, 0, math.pi / 2)
    return [e for e in occ.addPipe([(2, section)], path) if e[0] == 3]


# ---- hexahedra, wedges --------------------------------------------------------------------------------


@recipe(mesh=transfinite)
def hexahedra_block(rng):
    box = _box(rng)
    if rng.random() < 0.5:
        occ.rotate([(3, box)], 0, 0, 0, 1, 2, 3, rng.uniform(0, 1))
    return [(3, box)]


@recipe(mesh=subdivided)
def hexahedra_subdivided(rng):
    return box_with_bores(rng)


def _layers(rng, recombine):
    heights = rng.choice(([1], [0.1, 0.3, 1]))
    return [e for e in occ.extrude([(2, _plate(rng))], 0, 0, rng.uniform(0.3, 1), [3] if len(heights) == 1 else [1, 1, 2],
                                   heights, recombine) if e[0] == 3]


@recipe(mesh=recombined)
def hexahedra_extruded(rng):
    return _layers(rng, True)


@recipe()
def wedges_extruded(rng):
    return _layers(rng, True)


@recipe()
def wedges_turned(rng):
    face = occ.addPlaneSurface([_profile(rng, 0.4, (1.2, 0))])
    return [e for e in occ.revolve([(2, face)], 0, 0, 0, 0, 1, 0, rng.uniform(0.8, 3), [rng.randint(4, 9)], [1], True)
            if e[0] == 3]


def _two_faces(rng):
    disk = occ.addDisk(rng.uniform(-0.2, 0.2), 0, 0, 0.4, rng.uniform(0.2, 0.4))
    return occ.fragment([(2, occ.addRectangle(-1, -1, 0, 2, 2))], [(2, disk)])[0]


@recipe(mesh=first_recombined)
def mixed_extruded(rng):
    return [e for e in occ.extrude(_two_faces(rng), 0, 0, rng.uniform(0.4, 1), [4], [1], True) if e[0] == 3]


# ---- in the plane ----------------------------------------------------------------------------------------


@recipe(dim=2)
def triangles_plate(rng):
    return [(2, _plate(rng))]


@recipe(dim=2)
def triangles_tilted(rng):
    plate = _plate(rng)
    occ.rotate([(2, plate)], 0, 0, 0, *rng.choice(((1, 0, 0), (0, 1, 0), (1, 2, 3))), rng.choice((math.pi / 2, 0.7)))
    return [(2, plate)]


@recipe(dim=2, mesh=recombined)
def quadrilaterals_plate(rng):
    return [(2, _plate(rng))]


@recipe(dim=2, mesh=subdivided)
def quadrilaterals_subdivided(rng):
    return [(2, _plate(rng))]


@recipe(dim=2)
def triangles_two_regions(rng):
    return _two_faces(rng)


@recipe(dim=2, mesh=first_recombined)
def mixed_plate(rng):
    return _two_faces(rng)


# ---- surfaces in space -----------------------------------------------------------------------------------


def _skin(solids):
    """The faces of solids, which are forgotten."""
    occ.synchronize()
    faces = [(2, abs(tag)) for _, tag in gmsh.model.getBoundary(solids, oriented=False)]
    occ.remove(solids)
    return faces


@recipe(dim=2, is_surface=True)
def surface_of_fillets(rng):
    return _skin(box_with_fillets(rng))


@recipe(dim=2, is_surface=True)
def surface_of_tee(rng):
    return _skin(tee(rng))


@recipe(dim=2, is_surface=True)
def surface_of_torus(rng):
    return _skin(torus(rng))


@recipe(dim=2, mesh=recombined, is_surface=True, only_triangles=False)
def surface_of_quadrilaterals(rng):
    return _skin(cut_sphere(rng))
