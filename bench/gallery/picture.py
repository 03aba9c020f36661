"""picture: states of a mesh side by side, with a title each and a legend, as SVG."""
import html
from collections import namedtuple

import numpy as np

import view

WIDTH, GAP, LINE, FOOT = 800, 20, 22, 40  # pixels
MARGIN = 8
UNITS = 10                                # of a coordinate in the file, per pixel
STYLE = """text { font: 17px sans-serif; fill: #222 } .bold { font-weight: bold }
.mesh { stroke: #26323d; stroke-width: 5; stroke-linejoin: round }
.line { fill: none; stroke: #111; stroke-width: 16; stroke-linejoin: round } .faint { opacity: 0.3 }"""

# From good to bad, told apart by their brightness too; then inverted elements, and those that are told apart as kept.
COLOURS = np.array([[221, 230, 239], [254, 224, 139], [253, 163, 66], [217, 95, 14], [127, 39, 4]])
INVERTED, KEPT, SHELL = np.array([94, 60, 153]), np.array([116, 173, 209]), np.array([240, 243, 246])
PALEST = 0.93  # of shades of the shell

BOLD = ' class="bold"'

# name of a measure; limits between its classes; labels of these, the best first
Scale = namedtuple("Scale", "measure limits labels")
# eye: a view.Camera; is_kept: which elements are drawn, by their centroids [m][3]; bad: draw the elements of this class and
# worse ones alone, in the outline of the mesh; has_layers: of wedges, which have a colour of their own; has_borders: draw
# lines between regions
Look = namedtuple("Look", "eye is_kept bad has_layers has_borders", defaults=(view.FLAT, None, 0, False, False))


def radius_ratios(*limits):
    return Scale("radius ratio", limits, rising(limits))


def rising(limits):
    return [f"to {limit:g}" for limit in limits] + [f"> {limits[-1]:g}"]


def falling(name, *limits):
    return Scale(name, limits, [f"> {limit:g}" for limit in limits] + ["less"])


def spread(scale):
    """Which COLOURS the classes have: the first, and the last ones."""
    n = len(scale.limits) + 1
    return COLOURS[[0, *range(len(COLOURS) - n + 1, len(COLOURS))]]


def classes(mesh, scale):
    """Class [m] of elements: 0 good."""
    return np.digitize(mesh.values, scale.limits)


def colours(mesh, scale, look):
    """RGB [m][3] of elements."""
    found = spread(scale)[classes(mesh, scale)]
    if look.has_layers:
        found[mesh.types == 13] = KEPT
    found[mesh.is_inverted] = INVERTED
    return found


# ---- paths ---------------------------------------------------------------------------------------

def steps(points):
    """The path through points in whole units: the first one, then steps."""
    moves = np.diff(points, axis=0)
    return f"M{points[0][0]} {points[0][1]}l" + " ".join(f"{x} {y}" for x, y in moves)


def curves(corners, mids):
    """A closed path of quadratic curves through corners and mids."""
    ends = np.roll(corners, -1, axis=0)
    controls = np.round(2 * mids - (corners + ends) / 2).astype(int)
    pieces = [f"q{c[0] - a[0]} {c[1] - a[1]} {b[0] - a[0]} {b[1] - a[1]}" for a, b, c in zip(corners, ends, controls)]
    return f"M{corners[0][0]} {corners[0][1]}" + "".join(pieces) + "z"


def line_of(first, last, mid, places):
    a, b = places[first], places[last]
    if mid < 0:
        return steps([a, b])
    c = np.round(2 * places[mid] - (a + b) / 2).astype(int) - a
    return f"M{a[0]} {a[1]}q{c[0]} {c[1]} {b[0] - a[0]} {b[1] - a[1]}"


def path_of(corners, mids, places):
    at = places[corners[corners >= 0]]
    return curves(at, places[mids[mids >= 0]]) if (mids >= 0).any() else steps(at) + "z"


def filled(colour, path):
    return f'<path fill="#{colour[0]:02x}{colour[1]:02x}{colour[2]:02x}" d="{path}"/>'


def runs(fills, paths):
    """Paths one after the other, those of a colour that follow each other as one."""
    found, last = [], None
    for colour, path in zip(fills.tolist(), paths):
        if colour == last:
            found[-1][1].append(path)
        else:
            found.append((colour, [path]))
        last = colour
    return "\n".join(filled(colour, "".join(same)) for colour, same in found)


def drawn_faces(mesh, faces, rgb, places, look, darkest=view.DARKEST):
    """Faces in their order, or, in the plane, by colour with inverted ones on top."""
    fills = rgb[faces.elements]
    if look.eye is view.FLAT:
        order = np.lexsort((*fills.T, mesh.is_inverted[faces.elements]))
        faces = view.chosen(faces, order)
        fills = fills[order]
    else:
        fills = np.round(fills * view.shades(mesh, faces, look.eye, darkest)[:, None]).astype(int)
    return runs(fills, [path_of(*face, places) for face in zip(faces.corners, faces.mids)])


def drawn_lines(edges, places, kind="line"):
    path = "".join(line_of(*edge, places) for edge in edges)
    return f'<path class="{kind}" d="{path}"/>' if path else ""


# ---- panels --------------------------------------------------------------------------------------

def corners_of(box):
    """Eight points of a box, given by two corners."""
    return np.stack(np.meshgrid(*np.transpose(box)), axis=-1).reshape(-1, 3)


class Frame:
    """Where the points of meshes are in a panel: one scale for all states of a mesh."""

    def __init__(self, points, eye, width):
        """points [n][3]: those to be seen."""
        self.eye = eye
        points = view.in_picture(eye, points)
        self.low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.01 * (high[0] - self.low[0])
        self.low, high = self.low - margin, high + margin
        self.scale = width / (high[0] - self.low[0])
        self.size = width, round((high[1] - self.low[1]) * self.scale)

    def pixels(self, points):
        """Places [n][3] in pixels, y downwards, and depths."""
        found = (view.in_picture(self.eye, points) - self.low) * self.scale
        found[:, 1] = self.size[1] - found[:, 1]
        return found


def content(mesh, scale, look, frame, is_kept):
    """The mesh as SVG."""
    pixels = frame.pixels(mesh.points)
    places = np.round(pixels[:, :2] * UNITS).astype(int)
    rgb = colours(mesh, scale, look)
    if look.bad:
        return within_outline(mesh, scale, look, frame, pixels, places, rgb)
    faces = view.outer_faces(mesh, is_kept)
    if look.eye is not view.FLAT:
        faces = view.visible(mesh, faces, look.eye, pixels, frame.size)
    body = drawn_faces(mesh, faces, rgb, places, look)
    lines = view.borders(mesh, faces) if look.has_borders else view.rims(faces) if look.eye is view.FLAT else []
    return f'<g class="mesh">{body}</g>\n' + drawn_lines(lines, places)


def within_outline(mesh, scale, look, frame, pixels, places, rgb):
    """The bad elements alone, in the shell of the mesh."""
    shell = view.outer_faces(mesh, np.ones(len(mesh.types), bool))
    edge = view.creases(mesh, shell)
    towards = view.normals(mesh, shell) @ look.eye.towards
    back = view.visible(mesh, view.chosen(shell, towards < 0), look.eye, pixels, frame.size)
    grey = np.tile(SHELL, (len(mesh.types), 1))
    bad = view.outer_faces(mesh, (classes(mesh, scale) >= look.bad) | mesh.is_inverted)
    bad = view.visible(mesh, bad, look.eye, pixels, frame.size)
    return "\n".join([f'<g>{drawn_faces(mesh, back, grey, places, look, PALEST)}</g>', drawn_lines(edge, places, "line faint"),
                      f'<g class="mesh">{drawn_faces(mesh, bad, rgb, places, look)}</g>',
                      drawn_lines(edge, places, "line faint")])


def legend(scale, look, has_inverted, y):
    """Swatches with their labels, in a line."""
    kinds = list(zip(spread(scale), scale.labels))
    if look.bad:
        kinds = kinds[look.bad:]
    if look.has_layers:
        kinds.append((KEPT, "layers"))
    if has_inverted:
        kinds.append((INVERTED, "inverted"))
    x, found = 0, [f'<text x="0" y="{y + 14}">{html.escape(scale.measure)}</text>']
    x = 9.2 * len(scale.measure) + 14
    for colour, label in kinds:
        found.append(f'<rect x="{x:.0f}" y="{y}" width="17" height="17" stroke="#888" '
                     f'fill="#{colour[0]:02x}{colour[1]:02x}{colour[2]:02x}"/>'
                     f'<text x="{x + 23:.0f}" y="{y + 14}">{html.escape(label)}</text>')
        x += 23 + 9 * len(label) + 16
    return "\n".join(found)


def titled(texts, x):
    """A bold line, and the lines under it."""
    return "\n".join(f'<text x="{x:.0f}" y="{18 + LINE * k}"{"" if k else BOLD}>{html.escape(text)}</text>'
                     for k, text in enumerate(texts))


def head(states):
    """Height of the titles."""
    return 10 + LINE * max(len(texts) for texts, _ in states)


def document(height, body):
    width, height = WIDTH + 2 * MARGIN, height + MARGIN
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height:.0f}" '
            f'viewBox="{-MARGIN} 0 {width} {height:.0f}">\n<style>{STYLE}</style>\n'
            f'<rect x="{-MARGIN}" width="100%" height="100%" fill="#fff"/>\n{body}\n</svg>\n')


def picture(states, scale, look, box=None):
    """SVG of states: (texts, mesh) each. The last one decides what is kept in all, and where it is."""
    width = (WIDTH - GAP * (len(states) - 1)) // len(states)
    last = states[-1][1]
    centroids = np.array([last.points[nodes].mean(axis=0) for nodes in last.nodes])
    is_kept = np.ones(len(centroids), bool) if look.is_kept is None else look.is_kept(centroids)
    kept = np.concatenate([last.nodes[element] for element in np.flatnonzero(is_kept)])
    frame = Frame(last.points[kept] if box is None else corners_of(box), look.eye, width)
    found, top = [], head(states)
    for k, (texts, mesh) in enumerate(states):
        x = k * (width + GAP)
        found.append(titled(texts, x))
        found.append(f'<svg x="{x:.0f}" y="{top}" width="{width:.0f}" height="{frame.size[1]}" '
                     f'viewBox="0 0 {width * UNITS:.0f} {frame.size[1] * UNITS}">\n'
                     f'{content(mesh, scale, look, frame, is_kept)}\n</svg>')
    has_inverted = any(mesh.is_inverted.any() for _, mesh in states)
    found.append(legend(scale, look, has_inverted, top + frame.size[1] + 16))
    return document(top + frame.size[1] + FOOT, "\n".join(found))
