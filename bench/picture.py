#!/usr/bin/env python3
"""picture: triangle meshes side by side as SVG, coloured by their radius ratio.

   picture.py OUT.svg TITLE MESH.msh [TITLE MESH.msh ...]        (MSH 4.1 ASCII)"""
import sys

COLUMN, GAP, TOP = 560, 40, 34
# Radius ratio up to which each colour is used: from good to bad.
COLOURS = [(1.1, "#f3f7fb"), (1.25, "#cfe1f2"), (1.5, "#9dc7e4"), (2, "#fde6a9"), (4, "#f9a65a"),
           (float("inf"), "#d7301f")]


def read(path):
    """Nodes by tag and triangles as triples of tags."""
    lines = open(path, encoding="utf-8").read().split("\n")
    at = lines.index("$Nodes") + 1
    nodes, triangles = {}, []
    blocks, at = int(lines[at].split()[0]), at + 1
    for _ in range(blocks):
        count = int(lines[at].split()[3])
        for i in range(count):
            nodes[int(lines[at + 1 + i])] = tuple(map(float, lines[at + 1 + count + i].split()[:2]))
        at += 1 + 2 * count
    at = lines.index("$Elements") + 1
    blocks, at = int(lines[at].split()[0]), at + 1
    for _ in range(blocks):
        kind, count = map(int, lines[at].split()[2:4])
        if kind == 2:
            triangles += [tuple(map(int, line.split()[1:4])) for line in lines[at + 1:at + 1 + count]]
        at += 1 + count
    return nodes, triangles


def ratio(p, q, r):
    """R / (2 r) of a triangle, infinite if it is flat or inverted."""
    a, b, c = (((u[0] - v[0]) ** 2 + (u[1] - v[1]) ** 2) ** 0.5 for u, v in ((p, q), (q, r), (r, p)))
    area = ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) / 2
    return a * b * c * (a + b + c) / (16 * area * area) if area else float("inf")


def panel(title, path, left):
    nodes, triangles = read(path)
    xs, ys = zip(*(nodes[tag] for triangle in triangles for tag in triangle))
    scale = COLUMN / (max(xs) - min(xs))
    height = scale * (max(ys) - min(ys))
    place = {tag: (left + scale * (x - min(xs)), TOP + height - scale * (y - min(ys)))
             for tag, (x, y) in nodes.items()}
    ratios = [ratio(*(nodes[tag] for tag in triangle)) for triangle in triangles]
    rms = (sum(value * value for value in ratios) / len(ratios)) ** 0.5
    out = [f'<text x="{left}" y="20">{title}: worst radius ratio {max(ratios):.3g}, '
           f'RMS {rms:.3g}</text>']
    for triangle, value in zip(triangles, ratios):
        colour = next(colour for limit, colour in COLOURS if value <= limit)
        points = " ".join(f"{place[tag][0]:.1f},{place[tag][1]:.1f}" for tag in triangle)
        out.append(f'<polygon points="{points}" fill="{colour}"/>')
    return out, height


def main():
    panels = list(zip(sys.argv[2::2], sys.argv[3::2]))
    body, height = [], 0
    for i, (title, path) in enumerate(panels):
        lines, tall = panel(title, path, GAP / 2 + i * (COLUMN + GAP))
        body += lines
        height = max(height, tall)
    width = len(panels) * (COLUMN + GAP)
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" '
                   f'height="{height + TOP + 20:.0f}" viewBox="0 0 {width} {height + TOP + 20:.0f}" '
                   'font-family="sans-serif" font-size="15">\n'
                   '<rect width="100%" height="100%" fill="white"/>\n'
                   '<g stroke="#33475b" stroke-width="0.7" stroke-linejoin="round">\n')
        file.write("\n".join(line for line in body if line.startswith("<polygon")) + "\n</g>\n")
        file.write("\n".join(line for line in body if line.startswith("<text")) + "\n</svg>\n")


if __name__ == "__main__":
    main()
