"""compare.py ALONE TOGETHER N HOW: the report of N processes says what that of one does: numbers of the
same bits, but for means and sums of many numbers, which may be rounded otherwise; unless HOW is alone, what
holds nodes is null; with HOW pieces, what only one who has all of the mesh can say is null, too."""
import json
import re
import sys

OTHER = {"output", "seconds", "threads", "binding", "peak_memory_bytes", "processes"}
UNKNOWN_IN_PARTS = {"held", "mid_side_nodes", "unused_nodes", "doubled_nodes"}
UNKNOWN_IN_PIECES = {"worst_elements", "could_slide", "layer_elements", "free_layer_elements", "held_layer_elements",
                     "kept_layer_elements", "layer_heights"}
SUMS = {"mean", "total_volume", "mean_radius_ratio"}


def unexplained(reason):
    """Without what holds the nodes."""
    return re.sub("(no node is free to move): .*(; the mesh is unchanged)", r"\1\2", reason)


def differences(a, b, path):
    if isinstance(a, dict) and isinstance(b, dict):
        if set(a) - OTHER != set(b) - OTHER:
            yield path, sorted(a), sorted(b)
        for key in (set(a) & set(b)) - OTHER:
            if sys.argv[4] == "pieces" and key in UNKNOWN_IN_PIECES and b[key] is None:
                continue
            if sys.argv[4] != "alone" and key in UNKNOWN_IN_PARTS and b[key] is None:
                continue
            yield from differences(a[key], b[key], path + "/" + key)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for i, (x, y) in enumerate(zip(a, b)):
            yield from differences(x, y, f"{path}[{i}]")
    elif path.rsplit("/", 1)[-1] in SUMS and a is not None and b is not None:
        if abs(a - b) > 1e-12 * abs(a):
            yield path, a, b
    elif path == "/reason" and sys.argv[4] != "alone" and a and b:
        if unexplained(a) != unexplained(b):
            yield path, a, b
    elif a != b:
        yield path, a, b


def main():
    with open(sys.argv[1]) as alone, open(sys.argv[2]) as together:
        a, b = json.load(alone), json.load(together)
    wrong = list(differences(a, b, ""))
    processes = b["processes"]
    if processes["count"] != int(sys.argv[3]) or processes["in_parts"] != (sys.argv[4] != "alone"):
        wrong.append(("processes", processes))
    if processes["in_parts"] and not processes["messages"] > 0:
        wrong.append(("no messages", processes))
    print(*wrong, sep="\n", end="\n" if wrong else "")
    return bool(wrong)


sys.exit(main())
