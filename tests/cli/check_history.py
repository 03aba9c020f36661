"""check_history.py PAGE.html RESULT.json K [FOLDER]: the steps of a page that was made with --history K, of
which there are as many as may be, evenly chosen. With FOLDER each is the mesh in FOLDER/SWEEP.mesh, which was
smoothed by so many sweeps alone. Prints the sweeps."""
import itertools
import json
import os
import sys

import check_page
import mesh_file

MOST_BAD = 800  # of a step


def picture_of(path):
    page = check_page.Page()
    text = open(path, encoding="utf-8").read()
    assert len(text.encode()) < check_page.LARGEST, "%d bytes" % len(text.encode())
    page.feed(text)
    ranges = [a for tag, a in page.attributes if tag == "input" and a.get("class") == "step"]
    picture = json.loads(page.scripts["picture-data"])
    assert [int(a["max"]) for a in ranges] == [len(picture["steps"]) + 1], ranges
    return picture


def check_even(sweeps, n):
    """No gap is three times as long as it would be if all were the same."""
    ends = [0] + sweeps + [n]
    gaps = [b - a for a, b in zip(ends, ends[1:])]
    assert all(gap > 0 for gap in gaps), sweeps
    assert max(gaps) <= 3 * max(1, n / (len(sweeps) + 1)), sweeps


def check_inside(picture, step, mesh):
    """The elements inside are where they are, but for the last digit."""
    numbers = check_page.unpack(step["inside"], "H")
    corners = check_page.unpack(picture["inside_corners"], "H" if picture["inside_bits"] == 16 else "I")
    nodes = [node for element in mesh.elements for node in element]
    assert len(nodes) == len(corners)
    for point, node in zip(corners, nodes):
        for d, (low, high) in enumerate(zip(picture["low"], picture["high"])):
            wanted = (mesh.points[node][d] - low) / (high - low) * 65535
            assert abs(numbers[3 * point + d] - wanted) <= 0.51, (numbers[3 * point + d], wanted)
    check_page.check_inside(picture, step, mesh)
    assert "bad_codes" not in step


def check_bad(picture, step, mesh):
    """The worst elements are drawn where they are, but for the last digit."""
    numbers, dim = check_page.unpack(step["places"], "H"), mesh.dim
    nodes = set()
    for xyz in mesh.points:
        at = [round((x - a) / (b - a) * 65535) for x, a, b in zip(xyz, picture["low"], picture["high"])]
        nodes.update(tuple(map(sum, zip(at, off))) for off in itertools.product((0, -1, 1), repeat=dim))
    assert len(numbers) == check_page.check_worst(step, mesh, MOST_BAD) * (dim + 1) * dim
    assert all(tuple(numbers[i:i + dim]) in nodes for i in range(0, len(numbers), dim))


def check_mesh(picture, step, mesh):
    check_page.check_surface(picture, step, mesh)
    if mesh.dim == 2:
        check_page.check_ratios(picture, check_page.unpack(step["codes"], "B"), mesh)
    if mesh.dim == 3 and picture["stride"] == 1:
        check_inside(picture, step, mesh)
    else:
        check_bad(picture, step, mesh)


def main():
    picture, result, most = picture_of(sys.argv[1]), json.load(open(sys.argv[2])), int(sys.argv[3])
    sweeps, n = [step["sweep"] for step in picture["steps"]], len(result["sweeps"])
    assert picture["sweeps"] == n and 0 < len(sweeps) <= min(most - 2, n - 1), sweeps
    for step in picture["steps"]:
        assert step["inverted"] == result["sweeps"][step["sweep"] - 1]["inverted"]
    if all(sweep["phase"] == "smooth" for sweep in result["sweeps"]):
        assert len(sweeps) == min(most - 2, n - 1), sweeps
        check_even(sweeps, n)
    for step in picture["steps"] if len(sys.argv) > 4 else []:
        path = os.path.join(sys.argv[4], "%d.mesh" % step["sweep"])
        check_mesh(picture, step, mesh_file.read(path))
    print(*sweeps)


main()
