#!/usr/bin/env python3
"""show: the results of bench/public/run as Markdown.   show.py PUBLIC.json"""
import collections
import json
import sys

MESHERS = {"cgal": "CGAL", "gmsh": "Gmsh", "netgen": "Netgen", "tetgen": "TetGen"}  # of the folders of models.py
WAY_NAMES = {"default": "no option", "slide": "`--slide auto`", "best": "`--best`"}


def at(values, share):
    """The value that so large a share of the values does not exceed."""
    values = sorted(values)
    return f"{values[min(len(values) - 1, int(share * len(values)))]:.4g}" if values else "-"


def pairs(rows, key):
    """Median and 90 % of a figure before and after."""
    both = [(row["before"][key], row["after"][key]) for row in rows
            if row.get("before") and row["before"][key] is not None and row["after"][key] is not None]
    return " | ".join(f"{at([b for b, _ in both], share)} → {at([a for _, a in both], share)}" for share in (0.5, 0.9))


def cells(lines):
    """A row of the table for each way."""
    read = [line for line in lines if line["rows"]]
    for way, name in WAY_NAMES.items():
        rows = [row for line in read for row in line["rows"] if row["way"] == way]
        if not rows:
            continue
        judged = [row for row in rows if row.get("before")]
        smoothed = [row for row in rows if "refused" not in row]
        invalid = [sum(row[when]["inverted"] > 0 for row in judged) for when in ("before", "after")]
        faults = sum(bool(row.get("faults")) for row in rows)
        yield (f"{len(lines)} | {len(read)} | {name} | {len(smoothed)} | {len(judged)} | "
               f"{invalid[0]} → {invalid[1]} | {pairs(judged, 'worst')} | {faults}")


def show_sources(lines):
    print("| source | files | read | options | smoothed | judged | meshes with invalid elements | worst ratio, median | "
          "worst ratio, 90 % | faults |\n| --- | --: | --: | --- | --: | --: | --: | --: | --: | --: |")
    sources = collections.defaultdict(list)
    for line in lines:
        sources[line["source"]].append(line)
    for source, mine in (*sources.items(), ("**all**", lines)):
        for i, row in enumerate(cells(mine)):
            print(f"| {MESHERS.get(source, source) if i == 0 else ''} | {row} |")


def show_counts(title, what, found):
    if found:
        print(f"\n| {title} | {what} |\n| --- | --: |")
        for text, n in collections.Counter(found).most_common():
            print(f"| {text.replace('|', '/')} | {n} |")


def show(lines):
    show_sources(lines)
    rows = [row for line in lines for row in line["rows"]]
    show_counts("refused", "files", [line["refused"] for line in lines if "refused" in line])
    show_counts("read, but not smoothed", "runs", [row["refused"] for row in rows if "refused" in row])
    show_counts("not judged", "runs", [row["not_judged"] for row in rows if "not_judged" in row])
    show_counts("not decided", "runs", [text for row in rows for text in row.get("unknown", [])])
    show_counts("stopped by the time limit", "runs", [row["way"] for row in rows if row.get("stop") == "time-limit"])
    faults = [f"{line['path']}: {fault}" for line in lines for fault in
              (line.get("faults", []) + [f"{row['way']}: {fault}" for row in line["rows"] for fault in row.get("faults", [])])]
    if faults:
        print("\nFaults:\n\n" + "\n".join(f"- {fault}" for fault in faults))


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as results:
        show(json.load(results)["files"])
