#!/usr/bin/env python3
"""headings.py: the lists at the top of the public headers have each function once, in the order of the file.

The names of a list lack their common prefix. planish.h lists sections with functions and types. planish_io.h lists
planish_file_NAME; the text of its heading names the other functions.
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def read(name):
    """The heading of a header, the rest, and the functions that it declares."""
    with open(os.path.join(ROOT, "include", "planish", name), encoding="utf-8") as text:
        heading, code = text.read().split(" */\n#ifndef", 1)
    return heading, code, re.findall(r"^PLANISH_API\b[^(;]*?(\w+)\(", code, re.M)


def compare(name, listed, found):
    """Say where a list differs from the file; return how often."""
    bad = [f"{word} is listed and is not in the file" for word in sorted(set(listed) - set(found))]
    bad += [f"{word} is not listed" for word in sorted(set(found) - set(listed))]
    if not bad and listed != found:
        listed = listed + ["nothing"]
        bad.append(next(f"{a} is listed before {b}" for a, b in zip(listed, found + ["nothing"]) if a != b))
    for text in bad:
        print(f"{name}: {text}")
    return len(bad)


def check_planish():
    heading, code, found = read("planish.h")
    rows = re.findall(r"^ \*     (.{25})  (\S.*)$", heading, re.M)
    titles = [title.strip() for title, _ in rows if title.strip()]
    names = [f"planish_{name}" for _, names in rows for name in re.findall(r"[\w-]+", names)]
    others = [name for name in names if name not in found]
    return (compare("planish.h", titles, re.findall(r"^/\* ---- (.*?) -+ \*/$", code, re.M))
            + compare("planish.h", [name for name in names if name in found], found)
            + compare("planish.h", others, [name for name in others if re.search(rf"\b{name}\b", code)]))


def check_planish_io():
    heading, _, found = read("planish_io.h")
    names = re.findall(r"^ \*     (\S.*?)   ", heading, re.M)
    listed = [f"planish_file_{name}" for row in names for name in re.findall(r"\w+", row)]
    said = [name for name in found if not name.startswith("planish_file_") and re.search(rf"\b{name}\b", heading)]
    return compare("planish_io.h", listed, [name for name in found if name not in said])


if __name__ == "__main__":
    sys.exit(check_planish() + check_planish_io() > 0)
