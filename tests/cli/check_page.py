"""check_page.py PAGE.html RESULT.json [BEFORE AFTER]: a page of a report is well-formed, needs
nothing from elsewhere, says what the result says, and draws the meshes of the files."""
import base64
import collections
import html.parser
import itertools
import json
import math
import struct
import sys

import mesh_file

VOID = {"meta", "input", "br", "link"}
REFERENCES = {"src", "href", "srcset", "action", "poster", "data"}
LARGEST = 3000000  # bytes that a page may have


class Page(html.parser.HTMLParser):
    """The text of a page by the id of its section, and what its tags say."""

    def __init__(self):
        super().__init__()
        self.open, self.scripts, self.attributes, self.words = [], {}, [], []
        self.tags = collections.Counter()
        self.policy = ""

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags[tag] += 1
        self.attributes.append((tag, attributes))
        if attributes.get("http-equiv") == "Content-Security-Policy":
            self.policy = attributes["content"]
        if tag not in VOID and not self.get_starttag_text().endswith("/>"):
            self.open.append((tag, attributes.get("id")))

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1][0] == tag, "</%s> closes %s" % (tag, self.open[-1:])
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1][0] == "script":
            self.scripts[self.open[-1][1]] = data
        elif self.open and self.open[-1][0] != "style":
            self.words.append(data)

    def text(self):
        return " ".join(" ".join(self.words).split())


def check_alone(page):
    """Nothing is loaded, and nothing may be."""
    assert "default-src 'none'" in page.policy, page.policy
    for tag, attributes in page.attributes:
        loaded = REFERENCES & set(attributes)
        assert not loaded, "<%s> loads %s" % (tag, loaded)
        assert not any(name.startswith("on") for name in attributes), attributes
    assert page.tags["h1"] == 1 and page.tags["main"] == 1 and page.tags["title"] >= 1


def check_words(page):
    """Tables have headings, drawings say what they are, controls have labels."""
    for tag, attributes in page.attributes:
        if tag == "th":
            assert attributes.get("scope") in ("col", "row"), attributes
        if tag == "svg":
            assert attributes.get("role") == "img" and attributes.get("aria-label"), attributes


def real(value):
    if value is None:
        return "\u2013"
    if value == 0:
        return "0"
    if 9999.5 <= abs(value) < 1e7:
        return "{:,.0f}".format(value).replace(",", " ")
    return ("%#.4g" % value).rstrip(".")


def is_worse(result):
    """Whether something is worse after than before, of what planish promises."""
    if "after" not in result:
        return False
    before, after = result["before"], result["after"]
    signs = {"inverted": 1, "max_radius_ratio_movable": 1, "min_dihedral_movable_deg": -1,
             "rms_radius_ratio": 1}
    return any(sign * after[key] > sign * before[key] * (1 + sign * 1e-9)
               for key, sign in signs.items() if None not in (before[key], after[key]))


def shown_counts(result, name, counts):
    """Those of a histogram's bins; angles of triangles end at 60 degrees."""
    if name != "angle_histogram" or result["mesh"]["dimension"] == 3:
        return counts
    return counts[:11] + [sum(counts[11:])]


def check_figures(page, result):
    text = page.text()
    states = [result[key] for key in ("before", "after", "quality") if key in result]
    for state in states:
        for key in ("max_radius_ratio", "rms_radius_ratio", "mean_radius_ratio", "min_volume"):
            assert real(state[key]) in text, "%s = %s is not in the page" % (key, real(state[key]))
        assert real(state["min_dihedral_deg"]) + "\u00b0" in text
        for element in state.get("worst_elements", []):
            assert str(element["element"]) in text
    assert result["checksum"] in text
    assert ("does not hold" in text) == is_worse(result)
    for sweep in result.get("sweeps", [])[:1] + result.get("sweeps", [])[-1:]:
        assert "%.8g" % sweep["rms"] in text
    shaded = {tag for tag, a in page.attributes if tag == "rect" and a.get("class") == "phase"}
    phases = {sweep["phase"] for sweep in result.get("sweeps", [])}
    assert bool(shaded) == bool(phases - {"smooth"}), "phases %s, shaded %s" % (phases, shaded)
    rects = [a for tag, a in page.attributes if tag == "rect" and "bar" in a.get("class", "")]
    bars = sum(count > 0 for state in states for name in ("histogram", "angle_histogram")
               for count in shown_counts(result, name, state[name]["counts"]))
    assert len(rects) == bars, "%d bars for %d bins" % (len(rects), bars)


def facets(mesh):
    """Triangles that bound tetrahedra; of triangles all."""
    if mesh.dim == 2:
        return {frozenset(element) for element in mesh.elements}
    seen = collections.Counter(frozenset(element[:i] + element[i + 1:])
                               for element in mesh.elements for i in range(4))
    return {facet for facet, count in seen.items() if count == 1}


def unpack(text, kind):
    data = base64.b64decode(text, validate=True)
    return [value for value, in struct.iter_unpack("<" + kind, data)]


def check_surface(picture, state, mesh):
    """Every triangle drawn is one of the surface, at its place but for the last digit."""
    dim, low, high = mesh.dim, picture["low"], picture["high"]
    numbers = unpack(state.get("points") or picture["states"][0]["points"], "H")
    points = [tuple(numbers[i:i + dim]) for i in range(0, len(numbers), dim)]
    nodes = {}
    for node, xyz in enumerate(mesh.points):
        at = [round((x - a) / (b - a) * 65535) for x, a, b in zip(xyz, low, high)]
        for off in itertools.product((0, -1, 1), repeat=dim):
            nodes.setdefault(tuple(map(sum, zip(at, off))), node)
    corners = unpack(picture["triangles"], "H" if picture["index_bits"] == 16 else "I")
    drawn = collections.Counter(frozenset(nodes[points[i]] for i in corners[j:j + 3])
                                for j in range(0, len(corners), 3))
    assert picture["coarse"] is False
    assert drawn == collections.Counter(facets(mesh)), "the surface is another one"


def check_worst(state, mesh, most):
    """The worst elements are drawn, worst first. Returns how many."""
    ratios = unpack(state["bad_ratios"], "f")
    orientation = math.copysign(1, sum(map(mesh_file.volume, mesh_file.corners(mesh))))
    worst = sorted((-mesh_file.radius_ratio(t) if orientation * mesh_file.volume(t) > 0
                    else -math.inf for t in mesh_file.corners(mesh)))[:most]
    assert len(ratios) == len(worst)
    for drawn, ratio in zip(ratios, worst):
        assert math.isclose(drawn or math.inf, -ratio, rel_tol=1e-4), (drawn, ratio)
    return len(ratios)


def check_bad(picture, state, mesh):
    """The worst elements are drawn where they are."""
    n = check_worst(state, mesh, 4000)
    size = max(b - a for a, b in zip(picture["low"], picture["high"]))
    middle = [(a + b) / 2 for a, b in zip(picture["low"], picture["high"])]
    places = {tuple(round((x - m) / size, 4) for x, m in zip(p, middle)) for p in mesh.points}
    corners = unpack(state["corners"], "f")
    assert len(corners) == n * (mesh.dim + 1) * mesh.dim
    for i in range(0, len(corners), mesh.dim):
        assert tuple(round(x, 4) for x in corners[i:i + mesh.dim]) in places


def code_of(value, edges, codes):
    """The code of a value: its bin, and the place in it."""
    i = max(k for k, edge in enumerate(edges[:-1]) if value >= edge or k == 0)
    place = 1 - edges[i] / value if edges[i + 1] is None else \
        (value - edges[i]) / (edges[i + 1] - edges[i])
    n = codes // (len(edges) - 1)
    return 1 + i * n + min(max(math.floor(place * n), 0), n - 1)


def check_ratios(picture, drawn, mesh):
    """Codes of the radius ratios of all triangles; 0: inverted."""
    measure = picture["measures"][0]
    assert measure["key"] == "histogram"
    assert len(drawn) == len(picture["measures"]) * len(mesh.elements)
    for code, t in zip(drawn, mesh_file.corners(mesh)):
        if mesh_file.volume(t) <= 0:
            assert code == 0, "an inverted triangle is drawn as valid"
        else:
            wanted = code_of(mesh_file.radius_ratio(t), measure["edges"], picture["codes"])
            assert abs(wanted - code) <= 1, (code, wanted)


def check_inside(picture, state, mesh):
    """All elements inside are drawn, with the codes of their radius ratios, or a sample and cubes."""
    measures, codes = picture["measures"], unpack(state["inside_codes"], "B")
    n = -(-len(mesh.elements) // picture["stride"])
    assert len(codes) == len(measures) * n
    corners = unpack(picture["inside_corners"], "H" if picture["inside_bits"] == 16 else "I")
    assert len(corners) == 4 * n
    orientation = math.copysign(1, sum(map(mesh_file.volume, mesh_file.corners(mesh))))
    for code, t in zip(codes, itertools.islice(mesh_file.corners(mesh), 0, None, picture["stride"])):
        wanted = 0 if orientation * mesh_file.volume(t) <= 0 else code_of(
            mesh_file.radius_ratio(t), measures[0]["edges"], picture["codes"])
        assert abs(wanted - code) <= 1, (code, wanted)
    assert ("cubes" in state) == (picture["stride"] > 1)


def check_picture(page, files):
    picture = json.loads(page.scripts["picture-data"])
    assert len(picture["states"]) == len(files)
    for state, path in zip(picture["states"], files):
        mesh = mesh_file.read(path)
        check_surface(picture, state, mesh)
        check_bad(picture, state, mesh)
        if mesh.dim == 2:
            check_ratios(picture, unpack(state["codes"], "B"), mesh)
        else:
            check_inside(picture, state, mesh)
    if not picture.get("flat") and picture["dim"] == 3:
        worst = [unpack(state["bad_ratios"], "f")[0] for state in picture["states"]]
        assert 0 in worst or 1 <= picture["start"] < max(worst), "nothing is seen at first"


def main():
    path, result, files = sys.argv[1], json.load(open(sys.argv[2])), sys.argv[3:]
    text = open(path, encoding="utf-8").read()
    assert len(text.encode()) < LARGEST, "%d bytes" % len(text.encode())
    page = Page()
    page.feed(text)
    page.close()
    assert not page.open, "still open: %s" % page.open
    check_alone(page)
    check_words(page)
    check_figures(page, result)
    if files:
        check_picture(page, files)


if __name__ == "__main__":
    main()
