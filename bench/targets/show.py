"""show: a part of the results as a table for docs/targets.md.   show.py TARGETS.json PART"""
import sys

import machine
import results

WAYS = "plain", "targets"


def table(heads, rows):
    print("| " + " | ".join(head for head, _ in heads) + " |")
    print("| " + " | ".join(mark for _, mark in heads) + " |")
    for row in rows:
        print("| " + " | ".join(row) + " |")


def columns(texts, numbers):
    return [(head, "---") for head in texts] + [(head, "--:") for head in numbers]


def seconds(value):
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"


def ratio(value):
    """Not that of a mesh with inverted elements."""
    return "" if value == float("inf") else f"{value:.5f}"


def percent(value):
    return f"{100 * value:.2g} %" if value < 1 else f"{100 * value:.0f} %"


def above_optimum(row):
    """How far the result is above the least RMS that a descent has found."""
    least = min(row["optimum_rms"], row["optimum_nearby_rms"])
    return [ratio(least), f"{100 * (row['rms'] / least - 1):.2g} %"]


def parts(rows):
    heads = columns(("elements", "boundary", "inner nodes"),
                    ("inverted at first", "RMS at first", "RMS", "least RMS", "above it", "sweeps", "s"))
    table(heads, [
        [str(row["elements"]), row["map"], row["start"], str(row["inverted_before"]), ratio(row["rms_before"]),
         ratio(row["rms"]), *(above_optimum(row) if "optimum_rms" in row else ["", ""]), str(row["sweeps"]),
         seconds(row["seconds"])] for row in rows])


def layers(rows):
    heads = columns(("wall",), ("growth", "moves by", "first, like", "all, like", "first, plain", "s, like",
                                "s, plain"))
    table(heads, [
        [f"{like['body']}, {like['motion']}", str(like["growth"]), str(like["first_heights"]), percent(like["first"]),
         percent(like["all"]), percent(plain["first"]), seconds(like["seconds"]), seconds(plain["seconds"])]
        for like, plain in zip(rows[::2], rows[1::2])])


def period(rows):
    heads = columns(("elements",), ("nodes", "tolerance", "after 1 period", "after 10", "inverted", "sweeps a step",
                                    "ms a step"))
    table(heads, [
        [row["kind"], str(row["nodes"]), f"{row['tolerance']:.0e}", f"{row['distances'][0]:.1e}",
         f"{row['distances'][-1]:.1e}", str(row["inverted"]), f"{row['sweeps_a_step']:.0f}",
         f"{1000 * row['seconds'] / row['steps']:.0f}"] for row in rows])


def sizes(rows):
    heads = columns(("elements",), ("number", "weight", "log(size / wanted) at first", "RMS", "RMS of AR", "worst AR",
                                    "sweeps", "s"))
    table(heads, [
        [row["kind"], str(row["elements"]), str(row["weight"]), f"{row['before']:.3f}", f"{row['after']:.3f}",
         f"{row['rms']:.2f}", f"{row['worst']:.2f}", str(row["sweeps"]), seconds(row["seconds"])] for row in rows])


def metrics(rows):
    heads = columns(("elements",), ("number", "weight", "RMS of AR at first", "RMS of AR", "log(size / wanted) at first",
                                    "RMS", "sweeps", "s"))
    table(heads, [
        [row["kind"], str(row["elements"]), str(row["weight"]), *(f"{row[when][0]:.2f}" for when in ("before", "after")),
         *(f"{row[when][1]:.3f}" for when in ("before", "after")), str(row["sweeps"]), seconds(row["seconds"])]
        for row in rows])


def speed(rows):
    heads = columns(("elements",), ("number", "ns a visit, plain", "with targets", "ratio"))
    table(heads, [
        [row["kind"], str(row["elements"]), *(f"{1e9 * row['seconds_per_visit'][way]:.0f}" for way in WAYS),
         f"{row['ratio']:.2f}"] for row in rows])


def pair(row, key, text):
    """A figure of MFEM's result and of planish's."""
    return [text(row[name][key]) for name in ("mfem", "planish")]


def tmop_shapes(rows):
    heads = columns(("elements", "start"), (
        "RMS at first", "RMS, MFEM", "RMS, planish", "worst AR, MFEM", "worst AR, planish", "iterations", "sweeps",
        "s, MFEM", "s, planish", "s to MFEM's RMS"))
    table(heads, [
        [f"{row['elements']} {row['kind']}", row["start"], ratio(row["before"]["rms"]), *pair(row, "rms", ratio),
         *pair(row, "worst", "{:.2f}".format), *pair(row, "iterations", str), *pair(row, "seconds", seconds),
         seconds(row["planish"]["reached"]) if row["planish"]["reached"] else "never"]
        for row in rows if "energy" in row["mfem"]])


def tmop_sizes(rows):
    heads = columns(("elements", "sizes"), (
        "log at first", "log, MFEM", "log, planish", "RMS, MFEM", "RMS, planish", "F, MFEM", "F, planish", "iterations",
        "sweeps", "s, MFEM", "s, planish"))
    table(heads, [
        [f"{row['elements']} {row['kind']}", row["start"], f"{row['before']['spread']:.3f}",
         *pair(row, "spread", "{:.3f}".format), *pair(row, "rms", "{:.3f}".format),
         *pair(row, "planish_goal", "{:.4f}".format), *pair(row, "iterations", str), *pair(row, "seconds", seconds)]
        for row in rows if "spread" in row["mfem"]])


def main():
    path, part = sys.argv[1:]
    found = results.load(path)
    if part in ("parts", "tmop-shapes"):
        print(machine.line(found["machine"]) + "\n")
    if part.startswith("tmop"):
        {"tmop-shapes": tmop_shapes, "tmop-sizes": tmop_sizes}[part](found["rows"])
    else:
        {"parts": parts, "layers": layers, "period": period, "sizes": sizes, "metrics": metrics, "speed": speed}[part](
            found[part])


if __name__ == "__main__":
    main()
