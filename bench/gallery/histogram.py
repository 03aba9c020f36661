"""histogram: the smallest angles of triangles before and after, for docs/gallery.md."""
import html
import math

from picture import COLOURS, GAP, KEPT, LINE, WIDTH, document, in_hex, titled

HEAD = 3 * LINE          # pixels: of the titles, and of numbers above bars
HEIGHT, AXIS = 220, 46   # of the bars, and of the axis below
LEAST = 0.5              # elements at the foot of a bar, as the axis is logarithmic
COMMANDS = """gmsh -2 bench/plate.geo -setnumber h 0.3 -string "Mesh.Algorithm=5;Mesh.Smoothing=0;" -format msh41 -o tri.msh
planish smooth tri.msh mean.msh --slide auto
planish smooth tri.msh finest.msh --best"""


def bars(histogram, x, width, most):
    """A bar for each 5 degrees up to 60, and lines at 1, 10, 100 ..."""
    def level(count):
        return HEAD + HEIGHT * (1 - math.log(count / LEAST) / math.log(most / LEAST))
    found, foot = [], HEAD + HEIGHT
    for power in range(int(math.log10(most)) + 1):
        y = level(10 ** power)
        found.append(f'<path d="M{x:.0f} {y:.0f}h{width:.0f}" stroke="#ccc"/>'
                     f'<text x="{x:.0f}" y="{y - 4:.0f}" fill="#666">{10 ** power}</text>')
    shown = [(low, count) for low, count in zip(histogram["edges"], histogram["counts"]) if low < 60]
    step = width / len(shown)
    for k, (low, count) in enumerate(shown):
        if count:
            colour = in_hex(COLOURS[3] if low < 40 else KEPT)
            found.append(f'<rect x="{x + k * step + 1:.1f}" y="{level(count):.1f}" width="{step - 2:.1f}" '
                         f'height="{foot - level(count):.1f}" fill="{colour}"/>')
    found.append(f'<path d="M{x:.0f} {foot}h{width:.0f}" stroke="#222"/>')
    for angle in 0, 20, 40, 60:
        anchor = "start" if angle == 0 else "end" if angle == 60 else "middle"
        found.append(f'<text x="{x + width * angle / 60:.0f}" y="{foot + 20}" text-anchor="{anchor}">{angle}°</text>')
    return "\n".join(found)


def picture(panels):
    """SVG of panels: (texts, histogram) each."""
    width = (WIDTH - GAP * (len(panels) - 1)) / len(panels)
    most = 1.3 * max(max(histogram["counts"]) for _, histogram in panels)
    body = [titled(texts, k * (width + GAP)) + "\n" + bars(histogram, k * (width + GAP), width, most)
            for k, (texts, histogram) in enumerate(panels)]
    note = html.escape("elements by their smallest angle; orange: below 40°")
    body.append(f'<text x="0" y="{HEAD + HEIGHT + AXIS}">{note}</text>')
    return document(HEAD + HEIGHT + AXIS + 12, "\n".join(body))
