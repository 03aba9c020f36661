#!/usr/bin/env python3
"""names.py: names of functions and types in comments and documents exist in the code.

A name begins with a prefix of the project (pl_, planish_, io_, PL_, PLANISH_, IO_, in comments also that of a format:
xdmf_, foam_, ...), or is that of a file or a test. Names that end in "_" or "_NAME", or are followed by "*", stand for
several. After a name an end stands for a name that begins likewise: pl_own_free, _block.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PREFIXES = "pl|planish|io|PL|PLANISH|IO"
FORMATS = "vtu|gmsh2|gmsh4|" + "|".join(sorted(
    entry for entry in os.listdir(os.path.join(ROOT, "src", "io")) if entry not in ("core", "file", "view")))
NAME = re.compile(rf"\b((?:{PREFIXES})_[A-Za-z0-9_]*[A-Za-z0-9])\b(?![*_])")
NAME_IN_CODE = re.compile(rf"\b((?:{PREFIXES}|{FORMATS})_[A-Za-z0-9_]*[A-Za-z0-9])\b(?![*_])")
ENDS = re.compile(r"(?:, _[a-z]\w*)*")
COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|/\*.*?\*/|//[^\n]*', re.S)


def tracked(*patterns):
    found = subprocess.run(["git", "-C", ROOT, "ls-files", *patterns], capture_output=True, text=True, check=False)
    return [name for name in found.stdout.split() if os.path.exists(os.path.join(ROOT, name))]


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8", errors="replace") as text:
        return text.read()


def split(text):
    """The code without comments, with its strings; and (position, comment)."""
    comments = [(m.start(), m.group()) for m in COMMENT.finditer(text) if m.group()[0] == "/"]
    return COMMENT.sub(lambda m: " " if m.group()[0] == "/" else m.group(), text), comments


def main():
    known, said = {os.path.splitext(os.path.basename(name))[0] for name in tracked()}, []
    known.update(re.sub(r"^tests/(\w+)/test_(\w+)\.\w+$", r"\1_\2", name) for name in tracked("tests/*"))
    for name in tracked("*.c", "*.h", "*.cpp", "*.inc"):
        code, comments = split(read(name))
        known.update(re.findall(rf"\b(?:{PREFIXES}|{FORMATS})_\w+", code))
        if not name.startswith("tests/"):
            said += [(name, text, at, comment, NAME_IN_CODE) for text in [read(name)] for at, comment in comments]
    for name in tracked("CMakeLists.txt", "*.py", "*.sh", "*.cmake", "*.in", ".ci/*", "tools/*"):
        if not name.endswith((".c", ".h", ".cpp", ".inc")):
            known.update(re.findall(rf"\b(?:{PREFIXES})_\w+", read(name)))
    for name in tracked("docs/*.md"):
        said.append((name, read(name), 0, read(name), NAME))
    missing = 0
    for name, text, at, comment, pattern in said:
        for match in pattern.finditer(comment):
            absent = [] if match.group(1) in known or match.group(1).endswith("_NAME") else [match.group(1)]
            for word in re.findall(r"_\w*[a-z0-9]\b", ENDS.match(comment, match.end()).group()):
                begins = [match.group(1)[:i.start()] for i in re.finditer("_|$", match.group(1))]
                absent += [] if any(begin + word in known for begin in begins) else [word + " of " + match.group(1)]
            for word in absent:
                line = text.count("\n", 0, at + match.start()) + 1
                print(f"{name}:{line}: there is no {word}")
            missing += len(absent)
    print(f"{missing} names that do not exist")
    return missing > 0


if __name__ == "__main__":
    sys.exit(main())
