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

# From good to bad, told apart by their brightness, too; then those of inverted elements, layers, and the outline.
COLOURS = np.array([[221, 230, 239], [254, 224, 139], [253, 163, 66], [217, 95, 14], [127, 39, 4]])
INVERTED, KEPT, SHELL = np.array([94, 60, 153]), np.array([116, 173, 209]), np.array([240, 243, 246])
PALEST = 0.93  # of shades of the shell

BOLD = ' class="bold"'

# name of a measure; limits between its classes; labels of these, the best first
Scale = namedtuple("Scale", "measure limits labels")
# eye: a view.Camera; is_kept: which elements are drawn, by their centroids [m][3]; bad: draw the elements of this class
# and worse ones alone, in the outline of the mesh; has_layers: wedges have a colour of their own; has_borders: lines are
# drawn between regions
Look = namedtuple("Look", "eye is_kept bad has_layers has_borders", defaults=(view.FLAT, None, 0, False, False))


def radius_ratios(*limits):
    return Scale("radius ratio", limits, rising(limits))


def rising(limits):
    return [f"to {limit:g}" for limit in limits] + [f"> {limits[-1]:g}"]


def falling(name, *limits):
    return Scale(name, limits, [f"> {limit:g}" for limit in limits] + ["less"])


def spread(scale):
    """COLOURS of the classes: the first, and the last ones."""
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


def in_hex(colour):
    return f"#{colour[0]:02x}{colour[1]:02x}{colour[2]:02x}"


def runs(fills, paths):
    """Paths one after the other, those of a colour that follow each other as one."""
    found, last = [], None
    for colour, path in zip(fills.tolist(), paths):
        if colour != last:
            found.append((colour, []))
        found[-1][1].append(path)
        last = colour
    return "\n".join(f'<path fill="{in_hex(colour)}" d="{"".join(same)}"/>' for colour, same in found)


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


class Drawing:
    """A state of a mesh in a frame, as SVG."""

    def __init__(self, mesh, scale, look, frame):
        self.mesh, self.look, self.frame = mesh, look, frame
        self.pixels = frame.pixels(mesh.points)
        self.places = np.round(self.pixels[:, :2] * UNITS).astype(int)
        self.rgb = colours(mesh, scale, look)
        self.is_bad = (classes(mesh, scale) >= look.bad) | mesh.is_inverted

    def content(self, is_kept):
        return self.bad_alone() if self.look.bad else self.kept(is_kept)

    def kept(self, is_kept):
        """The elements of a mask [m]."""
        faces = view.outer_faces(self.mesh, is_kept)
        if self.look.eye is not view.FLAT:
            faces = self.visible(faces)
            lines = view.borders(self.mesh, faces) if self.look.has_borders else []
        else:
            faces = view.chosen(faces, np.lexsort((*self.rgb[faces.elements].T, self.mesh.is_inverted[faces.elements])))
            lines = view.rims(faces)
        return f'<g class="mesh">{self.faces(faces, self.rgb)}</g>\n{self.lines(lines)}'

    def bad_alone(self):
        """The bad elements in the outline of the mesh."""
        shell = view.outer_faces(self.mesh, np.ones(len(self.mesh.types), bool))
        is_back = view.normals(self.mesh, shell) @ self.look.eye.towards < 0
        back = self.visible(view.chosen(shell, is_back))
        bad = self.visible(view.outer_faces(self.mesh, self.is_bad))
        outline = self.lines(view.creases(self.mesh, shell), "line faint")
        pale = np.tile(SHELL, (len(self.mesh.types), 1))
        return (f'<g>{self.faces(back, pale, PALEST)}</g>\n{outline}\n'
                f'<g class="mesh">{self.faces(bad, self.rgb)}</g>\n{outline}')

    def visible(self, faces):
        return view.visible(faces, self.pixels, self.frame.size)

    def faces(self, faces, rgb, darkest=view.DARKEST):
        """Faces in their order, shaded in space."""
        fills = rgb[faces.elements]
        if self.look.eye is not view.FLAT:
            shades = view.shades(self.mesh, faces, self.look.eye, darkest)
            fills = np.round(fills * shades[:, None]).astype(int)
        return runs(fills, [path_of(*face, self.places) for face in zip(faces.corners, faces.mids)])

    def lines(self, edges, kind="line"):
        path = "".join(line_of(*edge, self.places) for edge in edges)
        return f'<path class="{kind}" d="{path}"/>' if path else ""


def legend(scale, look, has_inverted, y):
    """Swatches with their labels, in a line."""
    kinds = list(zip(spread(scale), scale.labels))
    if look.bad:
        kinds = kinds[look.bad:]
    if look.has_layers:
        kinds.append((KEPT, "layers"))
    if has_inverted:
        kinds.append((INVERTED, "inverted"))
    found = [f'<text x="0" y="{y + 14}">{html.escape(scale.measure)}</text>']
    x = 9.2 * len(scale.measure) + 14
    for colour, label in kinds:
        found.append(f'<rect x="{x:.0f}" y="{y}" width="17" height="17" stroke="#888" '
                     f'fill="{in_hex(colour)}"/>'
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
                     f'{Drawing(mesh, scale, look, frame).content(is_kept)}\n</svg>')
    has_inverted = any(mesh.is_inverted.any() for _, mesh in states)
    found.append(legend(scale, look, has_inverted, top + frame.size[1] + 16))
    return document(top + frame.size[1] + FOOT, "\n".join(found))
