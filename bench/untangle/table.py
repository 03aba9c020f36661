#!/usr/bin/env python3
"""table: the results of run.py as Markdown.

   table.py RESULTS.jsonl [PART]    families, cells, deformed, unfixable or lists; without PART all of them"""
import json
import statistics
import sys
from itertools import groupby


def median_and_most(values, form):
    return f"{statistics.median(values):{form}} / {max(values):{form}}" if values else "- / -"


def row(name, lines):
    good = [line for line in lines if line["passed"]]
    ran = [line for line in lines if "inverted" in line]
    share = 100 * len(good) / len(lines)
    ratios = [line["rms"] / line["reference_rms"] for line in good
              if line["rms"] and line["reference_rms"]]
    return (f"| {name} | {len(lines)} | {len(good)} | {share:.1f} | "
            f"{sum(line['inverted_elsewhere'] for line in ran)} | "
            f"{sum(1 for line in lines if line.get('false_reports'))} | "
            f"{median_and_most([line['untangle_sweeps'] for line in ran], '.0f')} | "
            f"{median_and_most([line['seconds'] for line in ran], '.3f')} | "
            f"{median_and_most(ratios, '.4f')} |")


def print_table(title, lines):
    if not lines:
        return
    print(f"| {title} | cases | passed | % | inverted left | with false reports "
          "| untangle sweeps (median / max) | seconds (median / max) "
          "| RMS / RMS of the smoothed original (median / max) |")
    print("| --- |" + " --: |" * 8)
    families = sorted(lines, key=lambda line: line["family"])
    for family, members in groupby(families, key=lambda line: line["family"]):
        print(row(family, list(members)))
    print(row("**all**", lines) + "\n")


def deformed_by(line):
    """The share of the largest strength, and what happened to the inside."""
    _, shape, spoiler = line["name"].split("_")
    return f"{shape.split('-')[1]} %, {spoiler.split('-')[0]}"


def print_names(title, lines, show):
    if lines:
        print(f"{title}: {len(lines)}\n")
        print("\n".join(f"- {line['name']}: {show(line)}" for line in lines) + "\n")


def why_none(line):
    return line["no_case"]


def show_failed(line):
    if "inverted" not in line:
        return "timed out" if line["timed_out"] else f"status {line['status']}"
    return (f"{line['inverted_elsewhere']} of {line['inverted_before']} inverted left"
            + (f", false reports {line['false_reports']}" if line["false_reports"] else "")
            + (f", flaws found {line['flaws_found']} of {line['flaws']}" if line["flaws"] else "")
            + (", planish fails on the known solution" if line["reference_failed"] else "")
            + (f", held nodes moved: {line['held_moved']}" if line["held_moved"] else "")
            + (", timed out" if line["timed_out"] else ""))


def is_unfixable(line):
    return " unfixable: " in line["family"]


def is_grid(line):
    return not line["family"].startswith(("2-D", "3-D"))


def show_families(real):
    print_table("family", [line for line in real if not is_unfixable(line) and not is_grid(line)])


def show_cells(real):
    lines = [line for line in real if is_grid(line)]
    print_table("elements of a grid", lines)
    print_names("Failed", [line for line in lines if not line["passed"]], show_failed)


def show_deformed(real):
    deformed = [line for line in real if " deformed: " in line["family"]]
    print_table("share of the largest strength, inside",
                [{**line, "family": deformed_by(line)} for line in deformed])


def show_unfixable(real):
    print_table("cannot be repaired", [line for line in real if is_unfixable(line)])


def show_lists(real, none):
    simplices = [line for line in real if not is_grid(line)]
    failed = [line for line in simplices if not line["passed"]]
    if simplices:
        print(f"{len(simplices) - len(failed)} of {len(simplices)} cases passed.\n")
    print_names("Failed", failed, show_failed)
    for reason, lines in groupby(sorted(none, key=why_none), key=why_none):
        print(f"No case ({reason}): {len(list(lines))}\n")
    disputed = [line for line in real if line.get("inverted") != line.get("inverted_by_numpy")]
    print_names("planish and numpy disagree on the inverted elements", disputed,
                lambda line: f"{line['inverted']} and {line['inverted_by_numpy']}")


PARTS = {"families": show_families, "cells": show_cells, "deformed": show_deformed,
         "unfixable": show_unfixable}


def show(lines, part=None):
    real = [line for line in lines if "no_case" not in line]
    for name, show_part in PARTS.items():
        if part in (None, name):
            show_part(real)
    if part in (None, "lists"):
        show_lists(real, [line for line in lines if "no_case" in line])


def main():
    path, *part = sys.argv[1:]
    if part not in ([], ["lists"], *([name] for name in PARTS)):
        sys.exit(__doc__)
    with open(path, encoding="ascii") as file:
        show([json.loads(line) for line in file], *part)


if __name__ == "__main__":
    main()
