"""svg: meshes of quadrilaterals as pictures of a few dozen kB."""
import html

import numpy as np

UNITS = 20     # of a coordinate in the file, per pixel
GAP, HEAD = 16, 22
STYLE = """text { font: 13px sans-serif; fill: #222 } .mesh { fill: none; stroke: #456; stroke-width: 10 }
.inverted { fill: #e99; stroke: none } .body { fill: #ddd; stroke: #222; stroke-width: 16 }"""


class Panel:
    """A title, points [n][2] and quadrilaterals; inverted [m] of bool; body: nodes around it."""

    def __init__(self, title, points, quads, inverted, body=()):
        self.title, self.points, self.quads, self.inverted, self.body = title, points, quads, inverted, body


def lines_of(quads):
    """Nodes of lines that have each edge of the quadrilaterals once, followed as far as they lead."""
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    left = {}
    for i, j in np.unique(ends, axis=0).tolist():
        left.setdefault(i, set()).add(j)
        left.setdefault(j, set()).add(i)
    opposite = opposites(quads)
    for start in sorted(left):
        while left[start]:
            line = [start, min(left[start])]
            remove(left, *line)
            while (ahead := opposite.get((line[-2], line[-1]))) in left[line[-1]]:
                remove(left, line[-1], ahead)
                line.append(ahead)
            yield line


def opposites(quads):
    """Of an edge (i, j) the node straight on beyond j: neither end shares an element with both."""
    beside = {}
    for nodes in quads.tolist():
        for k, node in enumerate(nodes):
            beside.setdefault(node, []).append({nodes[k - 1], nodes[(k + 1) % 4]})
    found = {}
    for j, pairs in beside.items():
        around = set().union(*pairs)
        for i in around:
            across = around - {i} - set().union(*[pair for pair in pairs if i in pair])
            if len(pairs) == 4 and len(across) == 1:
                found[i, j] = across.pop()
    return found


def remove(left, i, j):
    left[i].discard(j)
    left[j].discard(i)


def steps(points):
    """The path through points, in whole units: the first one, then steps."""
    moves = np.diff(points, axis=0)
    return f"M{points[0][0]} {points[0][1]}l" + " ".join(f"{x} {y}" for x, y in moves)


def content(panel, low, high, scale):
    places = np.round((panel.points - low) * scale * UNITS).astype(int)
    places[:, 1] = round((high[1] - low[1]) * scale * UNITS) - places[:, 1]
    is_seen = ((panel.points >= low) & (panel.points <= high)).all(axis=1)
    lines = [part for line in lines_of(panel.quads) for part in seen_parts(line, is_seen)]
    body = steps(places[list(panel.body)]) + "z" if len(panel.body) else ""
    bad = "".join(steps(places[nodes]) + "z" for nodes in panel.quads[panel.inverted])
    mesh = "".join(steps(places[line]) for line in lines)
    paths = ("body", body), ("inverted", bad), ("mesh", mesh)
    return "\n".join(f'<path class="{name}" d="{path}"/>' for name, path in paths if path)


def seen_parts(line, is_seen):
    """The pieces of a line between nodes of which one at least is seen."""
    part = line[:1]
    for i, j in zip(line, line[1:]):
        if is_seen[i] or is_seen[j]:
            part = part or [i]
            part.append(j)
        else:
            if len(part) > 1:
                yield part
            part = []
    if len(part) > 1:
        yield part


def write(path, panels, low, high, width, columns=2):
    """A picture of panels that show from low to high, each so many pixels wide."""
    low, high = np.array(low), np.array(high)
    scale = width / (high[0] - low[0])
    height = scale * (high[1] - low[1])
    rows = -(-len(panels) // columns)
    size = columns * (width + GAP) + GAP, rows * (height + HEAD + GAP) + GAP
    with open(path, "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]:.0f}" height="{size[1]:.0f}">\n'
                   f'<style>{STYLE}</style>\n<rect width="100%" height="100%" fill="#fff"/>\n')
        for k, panel in enumerate(panels):
            x = GAP + k % columns * (width + GAP)
            y = GAP + k // columns * (height + HEAD + GAP)
            file.write(f'<text x="{x}" y="{y + 12:.0f}">{html.escape(panel.title)}</text>\n'
                       f'<svg x="{x}" y="{y + HEAD:.0f}" width="{width}" height="{height:.0f}" '
                       f'viewBox="0 0 {width * UNITS} {height * UNITS:.0f}">\n'
                       f'{content(panel, low, high, scale)}\n</svg>\n')
        file.write("</svg>\n")
