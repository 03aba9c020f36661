#!/usr/bin/env python3
"""names.py: names of functions and types in comments and documents exist in the code.

A name begins with a prefix of the project (pl_, planish_, io_, PL_, PLANISH_, IO_), or is that of a file or a test.
Names that end in "_" or "_NAME", or are followed by "*", stand for several.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NAME = re.compile(r"\b((?:pl|planish|io|PL|PLANISH|IO)_[A-Za-z0-9_]*[A-Za-z0-9])\b(?![*_])")
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
        known.update(NAME.findall(code))
        known.update(re.findall(r"\b(?:pl|planish|io|PL|PLANISH|IO)_\w+", code))
        if not name.startswith("tests/"):
            said += [(name, text, at, comment) for text in [read(name)] for at, comment in comments]
    for name in tracked("CMakeLists.txt", "*.py", "*.sh", "*.cmake", "*.in", ".ci/*", "tools/*"):
        known.update(re.findall(r"\b(?:pl|planish|io|PL|PLANISH|IO)_\w+", read(name)))
    for name in tracked("docs/*.md"):
        said.append((name, read(name), 0, read(name)))
    missing = 0
    for name, text, at, comment in said:
        for match in NAME.finditer(comment):
            if match.group(1) not in known and not match.group(1).endswith("_NAME"):
                line = text.count("\n", 0, at + match.start()) + 1
                print(f"{name}:{line}: there is no {match.group(1)}")
                missing += 1
    print(f"{missing} names that do not exist")
    return missing > 0


if __name__ == "__main__":
    sys.exit(main())
