"""Tests of planish.gmsh: meshes in Gmsh's memory."""

import contextlib
import io
import os
import pathlib
import subprocess
import tempfile
import unittest

import gmsh
import numpy as np

import planish
import planish.gmsh

PROGRAM = os.environ["PLANISH_PROGRAM"]
DOCUMENT = pathlib.Path(__file__).resolve().parents[2] / "docs/where-meshes-are-made.md"
MESH, OCC, GEO = gmsh.model.mesh, gmsh.model.occ, gmsh.model.geo


# ---- models -----------------------------------------------------------------------------------------


def generate(size, dim=3):
    """Mesh what OpenCASCADE has, with elements of a size."""
    OCC.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    MESH.generate(dim)


def block_with_ball(size=0.2):
    """Two regions, a curved interface between them."""
    block, ball = OCC.addBox(0, 0, 0, 1, 1, 1), OCC.addSphere(0.5, 0.5, 0.5, 0.3)
    OCC.fragment([(3, block)], [(3, ball)])
    generate(size)


def cylinder(dim=3):
    """A cylinder; of dimension 2 its surface."""
    OCC.addCylinder(0, 0, 0, 0, 0, 1, 0.4)
    generate(0.2, dim)


def prisms():
    disk = OCC.addDisk(0, 0, 0, 1, 1)
    OCC.extrude([(2, disk)], 0, 0, 0.5, [3], recombine=True)
    generate(0.25)


def hexahedra():
    corners = [GEO.addPoint(*place, 0.2) for place in ((0, 0, 0), (1, 0, 0), (1.3, 1, 0), (0, 1.2, 0))]
    lines = [GEO.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    surface = GEO.addPlaneSurface([GEO.addCurveLoop(lines)])
    GEO.mesh.setRecombine(2, surface)
    GEO.extrude([(2, surface)], 0.2, 0, 0.7, [4], recombine=True)
    GEO.synchronize()
    MESH.generate(3)


def pyramids():
    OCC.addBox(0, 0, 0, 1, 1, 1)
    OCC.synchronize()
    MESH.setTransfiniteSurface(1)
    for _, curve in gmsh.model.getBoundary([(2, 1)], oriented=False):
        MESH.setTransfiniteCurve(curve, 6)
    MESH.setRecombine(2, 1)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
    MESH.generate(3)


def disk(axis=(0, 1, 0), angle=0):
    """Two regions of triangles in a plane, turned about an axis."""
    OCC.fragment([(2, OCC.addDisk(0, 0, 0, 1, 1))], [(2, OCC.addRectangle(-0.3, -0.3, 0, 0.5, 0.4))])
    if angle:
        OCC.rotate(OCC.getEntities(2), 0, 0, 0, *axis, angle)
    generate(0.15, 2)


def disk_across_x():
    disk((0, 1, 0), np.pi / 2)


def disk_across_y():
    disk((1, 0, 0), np.pi / 2)


def disk_tilted():
    disk((1, 0.3, 0.2), 0.7)


def embedded():
    """A point and a line inside."""
    block = OCC.addBox(0, 0, 0, 1, 1, 1)
    point, ends = OCC.addPoint(0.5, 0.5, 0.3), [OCC.addPoint(0.3, 0.3, 0.7), OCC.addPoint(0.7, 0.7, 0.75)]
    line = OCC.addLine(*ends)
    OCC.synchronize()
    MESH.embed(0, [point], 3, block)
    MESH.embed(1, [line], 3, block)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
    MESH.generate(3)


def partitioned():
    block_with_ball()
    MESH.partition(3)


def periodic():
    OCC.addBox(0, 0, 0, 1, 1, 1)
    OCC.synchronize()
    MESH.setPeriodic(2, [2], [1], [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
    MESH.generate(3)


# ---- what Gmsh has -----------------------------------------------------------------------------------


def nodes(dim=-1, tag=-1, boundary=False):
    """Numbers and coordinates [n, 3] of nodes."""
    tags, xyz, _ = MESH.getNodes(dim, tag, boundary, False)
    return tags.copy(), xyz.reshape(-1, 3).copy()


def off_parameters():
    """How far nodes of curves and surfaces are off the place that their parameters have."""
    farthest = 0
    for dim, tag in gmsh.model.getEntities():
        _, xyz, parameters = MESH.getNodes(dim, tag)
        if dim in (1, 2) and len(parameters):
            farthest = max(farthest, np.abs(gmsh.model.getValue(dim, tag, parameters) - xyz).max())
    return farthest


def copied():
    """Entities, their nodes and elements."""
    return [(entity, *(values.copy() for values in MESH.getNodes(*entity, False, False)[:2]),
             MESH.getElements(*entity)) for entity in gmsh.model.getEntities()]


def put(kept, number, dims=range(4)):
    """Make discrete entities with nodes, of other numbers, and the elements of some dimensions."""
    for (dim, tag), tags, xyz, _ in kept:
        gmsh.model.addDiscreteEntity(dim, tag)
        MESH.addNodes(dim, tag, number(tags), xyz)
    for (dim, tag), _, _, (kinds, numbers, corners) in kept:
        if len(kinds) and dim in dims:
            MESH.addElements(dim, tag, kinds, numbers, [number(row) for row in corners])


class InGmsh(unittest.TestCase):
    """Meshes in Gmsh's memory."""

    def setUp(self):
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("model")

    def tearDown(self):
        gmsh.finalize()

    def by_program(self, words):
        """Coordinates that the program makes of the mesh in a file."""
        with tempfile.TemporaryDirectory() as folder:
            before, after = pathlib.Path(folder) / "before.msh", pathlib.Path(folder) / "after.msh"
            gmsh.option.setNumber("Mesh.Binary", 1)
            gmsh.option.setNumber("Mesh.SaveAll", 1)
            gmsh.write(str(before))
            done = subprocess.run([PROGRAM, "smooth", before, "-o", after, *words], check=False, capture_output=True)
            self.assertIn(done.returncode, (0, 1), done.stderr)  # 1: some elements stay inverted
            name = gmsh.model.getCurrent()
            gmsh.open(str(after))
            found = nodes()
            gmsh.model.remove()
            gmsh.model.setCurrent(name)
        return found

    def expect_program(self, slides=(None, "auto", "curved")):
        """Expect the bits of the program, whatever slides; the mesh is put back between."""
        start = nodes()
        for slide in slides:
            tags, xyz = self.by_program([] if slide is None else ["--slide", slide])
            result = planish.gmsh.smooth(**({} if slide is None else {"slide": slide}))
            self.assertGreater(result.n_moved_nodes, 0)
            now = nodes()
            np.testing.assert_array_equal(now[0], tags)
            np.testing.assert_array_equal(now[1], xyz, err_msg=f"slide {slide}")
            self.assertGreater(np.abs(now[1] - start[1]).max(), 1e-4)
            for tag, place in zip(*start):
                MESH.setNode(tag, place, [])

    def test_bits_of_the_program(self):
        for make, orders in ((block_with_ball, (1, 2)), (cylinder, (1,)), (prisms, (1, 2)), (hexahedra, (1, 2)),
                             (pyramids, (1,)), (embedded, (1,)), (partitioned, (1,))):
            for order in orders:
                with self.subTest(make=make.__name__, order=order):
                    gmsh.model.add(make.__name__)
                    make()
                    if order == 2:
                        MESH.setOrder(2)
                    self.expect_program()
        for make in (disk, disk_across_x, disk_across_y, disk_tilted):
            with self.subTest(make=make.__name__):
                gmsh.model.add(make.__name__)
                make()
                self.expect_program((None, "auto"))

    def test_serendipity(self):
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        for make in (prisms, hexahedra):
            gmsh.model.add(make.__name__)
            make()
            MESH.setOrder(2)
            self.expect_program((None,))

    def test_periodic_nodes_stay(self):
        periodic()
        self.expect_program((None,))
        sides = [nodes(2, side, True)[1] for side in (1, 2)]
        planish.gmsh.smooth(slide="auto")
        for side, before in zip((1, 2), sides):
            np.testing.assert_array_equal(nodes(2, side, True)[1], before)
        self.assertEqual(planish.gmsh.quality().n_inverted, 0)

    def test_embedded_nodes_stay(self):
        embedded()
        inside = [entity for entity in gmsh.model.getEntities()
                  if entity[0] < 2 and not gmsh.model.getAdjacencies(*entity)[0].size or entity == (1, 13)]
        before = {entity: nodes(*entity, True)[1] for entity in inside}
        self.assertTrue(any(len(places) > 2 for places in before.values()))
        planish.gmsh.smooth(slide="curved")
        for entity, places in before.items():
            np.testing.assert_array_equal(nodes(*entity, True)[1], places)

    def test_parameters(self):
        for make, slide in ((cylinder, "curved"), (disk, "auto"), (hexahedra, "auto")):
            with self.subTest(make=make.__name__):
                gmsh.model.add(make.__name__)
                make()
                planish.gmsh.smooth(slide=slide)
                self.assertLess(off_parameters(), 0.05 * 0.2 if slide == "curved" else 1e-12)
                MESH.setOrder(2)
                self.assertEqual(planish.gmsh.quality().cells.all.n_inverted, 0)

    def test_surfaces(self):
        cylinder(2)
        before, start = planish.gmsh.quality(), nodes()[1]
        result = planish.gmsh.smooth()
        after = planish.gmsh.quality()
        self.assertGreater(result.n_moved_nodes, 0)
        self.assertLess(after.rms_radius_ratio, before.rms_radius_ratio)
        self.assertLess(off_parameters(), 0.05 * 0.2)
        self.assertGreater(np.abs(nodes()[1] - start).max(), 1e-4)
        MESH.generate(3)
        self.assertEqual(planish.gmsh.quality().n_inverted, 0)

    def test_fix(self):
        block_with_ball()
        (_, volume), = [entity for entity in gmsh.model.getEntities(3) if nodes(*entity)[0].size < 30]
        group = gmsh.model.addPhysicalGroup(3, [volume])
        gmsh.model.setPhysicalName(3, group, "ball")
        tags, held = nodes(3, volume, True)
        start = nodes()
        for fix in ("ball", ["ball"], ("ball", "3:1"), str(group), f"3:{group}", (3, volume), [(3, volume)], tags,
                    tags.tolist(), tuple(tags.tolist()), np.isin(start[0], tags)):
            planish.gmsh.smooth(fix=fix)
            np.testing.assert_array_equal(nodes(3, volume, True)[1], held)
            self.assertGreater(np.abs(nodes()[1] - start[1]).max(), 1e-4)
            for tag, place in zip(*start):
                MESH.setNode(tag, place, [])
        planish.gmsh.smooth()
        self.assertGreater(np.abs(nodes(3, volume, True)[1] - held).max(), 1e-4)
        for fix in ("bal", "2:99", (3, 99), [10**9]):
            with self.assertRaisesRegex(ValueError, "has no"):
                planish.gmsh.smooth(fix=fix)

    def test_fix_of_a_side_that_slides(self):
        hexahedra()
        side = gmsh.model.getEntities(2)[0]
        held, start = nodes(*side, True), nodes()[1]
        planish.gmsh.smooth(slide="auto", fix=side)
        np.testing.assert_array_equal(nodes(*side, True)[1], held[1])
        self.assertGreater(np.abs(nodes()[1] - start).max(), 1e-4)
        planish.gmsh.smooth(slide="auto")
        moved = (nodes(*side, True)[1] != held[1]).any(axis=1)
        self.assertTrue(moved[np.isin(held[0], nodes(*side)[0], invert=True)].any())  # on its curves, too

    def test_regions_without_surfaces(self):
        block_with_ball()
        kept = copied()
        gmsh.model.add("discrete")
        put(kept, lambda tags: tags, [3])
        self.expect_program((None, "auto"))

    def test_around(self):
        cylinder()
        chosen = nodes(3)[0][::3]
        start = nodes()[1]
        planish.gmsh.smooth(around=chosen)
        moved = nodes()[0][(nodes()[1] != start).any(axis=1)]
        self.assertGreater(len(moved), len(chosen) // 2)
        self.assertTrue(np.isin(moved, chosen).all())
        expected = nodes()[1]
        for tag, place in zip(nodes()[0], start):
            MESH.setNode(tag, place, [])
        planish.gmsh.smooth(around=np.isin(nodes()[0], chosen))
        np.testing.assert_array_equal(nodes()[1], expected)

    def test_nodes_are_numbers(self):
        cylinder()
        start = nodes()[1]
        for name in "fix", "around":
            with self.assertRaisesRegex(TypeError, f"{name} must be Gmsh's numbers"):
                planish.gmsh.smooth(**{name: [5.5]})
            with self.assertRaisesRegex(ValueError, f"{name} is a mask of shape"):
                planish.gmsh.smooth(**{name: [True, True]})
        np.testing.assert_array_equal(nodes()[1], start)

    def test_like_in_planes(self):
        """Coordinates in space are those of the plane that the mesh lies in."""
        places = {}
        for make in disk, disk_across_x, disk_across_y, disk_tilted:
            gmsh.model.add(make.__name__)
            make()
            like = nodes()[1]
            planish.gmsh.smooth()
            self.assertGreater(np.abs(nodes()[1] - like).max(), 1e-4)
            planish.gmsh.smooth(like=like)
            places[make.__name__] = np.abs(nodes()[1] - like).max()
        self.assertLess(max(places.values()), 1e-3)

    def test_quality(self):
        block_with_ball()
        plain = planish.gmsh.quality(per_element=True)
        worst = plain.elements.number[np.argmax(plain.elements.aspect_ratio)]
        gamma = {}
        for kind, tags, corners in zip(*MESH.getElements(3)):
            self.assertEqual(kind, 4)
            gamma.update(zip(tags.tolist(), corners.reshape(-1, 4)))
        self.assertEqual(set(plain.elements.number.tolist()), set(gamma))
        place = dict(zip(*nodes()))
        points = np.array([place[tag] for tag in gamma[worst]])
        alone = planish.quality(points, np.array([[0, 1, 2, 3]]), per_element=True)
        self.assertAlmostEqual(alone.elements.aspect_ratio[0], plain.elements.aspect_ratio.max(), 12)

    def test_models_by_name(self):
        cylinder()
        start = nodes()[1]
        gmsh.model.add("other")
        result = planish.gmsh.smooth("model")
        self.assertGreater(result.n_moved_nodes, 0)
        self.assertEqual(gmsh.model.getCurrent(), "other")
        gmsh.model.setCurrent("model")
        self.assertGreater(np.abs(nodes()[1] - start).max(), 1e-4)

    def test_numbers_far_apart(self):
        """Numbers of nodes are any; the bits are those of consecutive ones."""
        cylinder()
        kept = copied()
        planish.gmsh.smooth()
        expected = nodes()[1]
        gmsh.model.add("far")
        put(kept, lambda tags: 10**6 + 1000 * tags.astype(int))
        planish.gmsh.smooth()
        np.testing.assert_array_equal(nodes()[1], expected)

    def test_document(self):
        """The code in docs/where-meshes-are-made.md."""
        (code,) = [piece for piece in DOCUMENT.read_text().split("```") if piece.startswith("python\nimport gmsh")]
        self.addCleanup(os.chdir, os.getcwd())
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            pathlib.Path("part.geo").write_text(
                'SetFactory("OpenCASCADE"); Cylinder(1) = {0, 0, 0, 0, 0, 1, 0.4}; Mesh.MeshSizeMax = 0.2;'
                'Physical Surface("inlet") = {2}; Physical Volume("inside") = {1};\n')
            gmsh.finalize()
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(code.removeprefix("python"), {})  # pylint: disable=exec-used
            self.assertGreater(float(printed.getvalue().splitlines()[-1]), 5)
            self.assertGreater(pathlib.Path("part.msh").stat().st_size, 1000)

    def test_refusals(self):
        with self.assertRaisesRegex(ValueError, "has no mesh"):
            planish.gmsh.smooth()
        block_with_ball()
        start = nodes()[1]
        for dim, text in ((2, "elements of dimension 3"), (4, "dim must be 2, 3 or None")):
            with self.assertRaisesRegex(ValueError, text):
                planish.gmsh.smooth(dim=dim)
        with self.assertRaises(ValueError):
            planish.gmsh.smooth(objective="none")
        with self.assertRaises(TypeError):
            planish.gmsh.smooth(nothing=1)
        np.testing.assert_array_equal(nodes()[1], start)
        planish.gmsh.smooth(dim=3)
        MESH.setOrder(3)
        start = nodes()[1]
        for call in (planish.gmsh.smooth, planish.gmsh.quality):
            with self.assertRaisesRegex(ValueError, "order 3"):
                call()
        np.testing.assert_array_equal(nodes()[1], start)


if __name__ == "__main__":
    unittest.main()
