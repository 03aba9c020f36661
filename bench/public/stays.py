"""stays: what smoothing must leave as it is: elements, data, bytes, held nodes, planes, surfaces. Each function yields
faults: sentences that begin with a kind of judge.KINDS."""
import re

import numpy as np

import reading
import surface
import topology
from shapes import SHAPES

TOLERANCE = 0.05       # --surface-tolerance, in mean edges
PROOF_OF_CURVED = 2    # tolerances: of facets of second order the distance is proved less sharply
MOST_TURN = 60         # degrees, of facets on curved surfaces
ROOM = 4               # planes of single facets differ from that of all of them
SAMPLE = 1000          # coordinates that tell the digits of a file


def same_mesh(before, after):
    """Faults of connectivity and data."""
    if len(before.points) != len(after.points) or before.points.dtype != after.points.dtype:
        yield f"connectivity: {len(after.points)} nodes instead of {len(before.points)}"
    elif [name for name, _ in before.blocks] != [name for name, _ in after.blocks]:
        yield "connectivity: other types of elements"
    elif not all(np.array_equal(a, b) for (_, a), (_, b) in zip(before.blocks, after.blocks)):
        yield "connectivity: elements have other nodes"
    if before.data.keys() != after.data.keys():
        yield f"data: other arrays: {sorted(before.data.keys() ^ after.data.keys())[:3]}"
    for name in before.data.keys() & after.data.keys():
        a, b = before.data[name], after.data[name]
        if not np.array_equal(a, b, equal_nan=a.dtype.kind == "f" and b.dtype.kind == "f"):
            yield f"data: {name} changed"


def same_bytes(source, target, before, after):
    for old, new in zip(reading.files_of(source), reading.files_of(target)):
        is_points = old.suffix not in (".ele", ".face", ".edge")
        a, b = old.read_bytes(), new.read_bytes()
        if a != b and not is_points:
            yield f"bytes: {new.suffix} changed"
        elif (wrong := reading.changes(old, a, b, before.points, after.points)):
            yield f"bytes: {wrong}"


def _interfaces(meshes):
    """Facets between elements of different regions."""
    names = {*reading.KNOWN_REGIONS, *meshes.report.get("mesh", {}).get("region_arrays", [])}
    found = []
    for name in names & meshes.before.regions.keys():
        values = [np.asarray(meshes.before.regions[name][i]) for i in meshes.numbers]
        if all(v.size == len(v) for v in values):
            values = list(map(np.ravel, values))
            found.append(topology.between(meshes.facets, np.concatenate(values)))
    return np.unique(np.concatenate(found)) if found else np.zeros(0, int)


def held_nodes(meshes):
    """Of a run with the boundary held."""
    for what, facets in (("boundary", topology.boundary(meshes.facets)), ("interface between regions", _interfaces(meshes))):
        if len(facets):
            nodes = topology.nodes_of_facets(meshes.blocks, meshes.facets, facets)
            if (n := int(meshes.moved[nodes].sum())):
                yield f"boundary: {n} nodes of the {what} moved, such as {nodes[meshes.moved[nodes]][0]}"


def _groups_of_facets(meshes, chosen):
    """Boundary facets by base and order: nodes in the order of the surface's shape functions."""
    starts = np.cumsum([0] + [len(cells) for _, cells in meshes.blocks])
    groups = {}
    for number, (name, cells) in enumerate(meshes.blocks):
        shape = SHAPES[name]
        for which, corners in enumerate(shape.facets):
            mine = chosen[(meshes.facets.place[chosen] == (number, which)).all(axis=1)]
            if len(mine):
                nodes = cells[meshes.facets.owner[mine] - starts[number]][:, shape.facet_in_order(corners)]
                groups.setdefault((len(corners), shape.order), []).append(nodes)
    return {key: np.concatenate(value) for key, value in groups.items()}


def slide_tolerance(points):
    """--slide-tolerance as the documents have it: by the precision of the file's numbers."""
    if points.dtype == np.float32:
        return 1e-6
    digits = max(len(re.sub(r"e.*|\D", "", repr(x)).strip("0")) for x in points.ravel()[:SAMPLE].tolist())
    return max(1e-8, min(1e-5, 10.0 ** (1 - digits)))


def in_planes(meshes, has_boundary):
    """Of a run with nodes that slide in planes: moved nodes stay in the planes of all their facets, on the boundary
    (if has_boundary) and between regions."""
    facets = np.concatenate([topology.boundary(meshes.facets)] * has_boundary + [_interfaces(meshes)])
    most = ROOM * slide_tolerance(meshes.before.points) * np.linalg.norm(np.ptp(meshes.x, axis=0))
    for (n_corners, _), nodes in _groups_of_facets(meshes, facets).items():
        x = meshes.x[:, meshes.axes]
        a = x[nodes[:, 0]]
        if n_corners == 2:
            e = x[nodes[:, 1]] - a
            normal = np.stack([-e[:, 1], e[:, 0]], axis=1)
        else:
            normal = np.cross(x[nodes[:, 1]] - a, x[nodes[:, n_corners - 1]] - a)
        length = np.linalg.norm(normal, axis=1)
        normal = normal[length > 0] / length[length > 0, None]
        step = (meshes.y - meshes.x)[:, meshes.axes][nodes[length > 0]]
        off = np.abs((step * normal[:, None]).sum(axis=2))
        if off.size and off.max() > most:
            yield f"plane: a node moved by {off.max():.3g} off the plane of its facet; {most:.3g} is allowed"


def surface_groups(meshes):
    """Facets of the surface for surface.farthest, or None where some have nodes inside."""
    if any(len(shape.facet_nodes(f)) > len(shape.facet_in_order(f)) for shape in map(SHAPES.get, meshes.names)
           for f in (shape.facets if meshes.dim == 3 else [tuple(range(shape.n_corners))])):
        return None
    if meshes.is_in_space:
        return [(SHAPES[name].base, SHAPES[name].order, cells) for name, cells in meshes.blocks]
    found = _groups_of_facets(meshes, topology.boundary(meshes.facets))
    return [("triangle" if n == 3 else "quad", order, nodes) for (n, order), nodes in found.items()]


def on_surface(meshes):
    """Of a run with nodes that slide on curved surfaces: samples are within the distances of the report, and these within
    the tolerance."""
    said, groups = meshes.report.get("surface"), surface_groups(meshes)
    if not said or groups is None:
        return
    in_edges = said["distance_in_edges"]
    most = TOLERANCE * (1 if all(order == 1 for _, order, _ in groups) else PROOF_OF_CURVED)
    if in_edges is not None and in_edges > most * (1 + 1e-9):
        yield f"surface: {in_edges} mean edges off, {most} are allowed"
    for what, new, old in (("distance", meshes.y, meshes.x), ("distance_back", meshes.x, meshes.y)):
        if said[what] is not None:
            far = surface.farthest(new, old, groups, said[what])
            if far > said[what] * (1 + 1e-9) + 1e-12 * np.abs(meshes.x).max():
                yield f"surface: a sample is {far:.6g} off, the report's {what} is {said[what]:.6g}"
    for base, order, nodes in groups:
        if (base, order) == ("triangle", 1) and _most_turn(meshes, nodes) > MOST_TURN + 1e-6:
            yield f"surface: a facet turned by more than {MOST_TURN} degrees"


def _most_turn(meshes, nodes):
    """Largest angle between the normals of a triangle before and after, in degrees."""
    old, new = (np.cross(p[nodes[:, 1]] - p[nodes[:, 0]], p[nodes[:, 2]] - p[nodes[:, 0]]) for p in (meshes.x, meshes.y))
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(old, new), axis=1), (old * new).sum(axis=1))).max()
