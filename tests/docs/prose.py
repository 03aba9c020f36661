#!/usr/bin/env python3
"""prose.py: documents are short, their sentences, too, and docs/README.md lists each of them."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_WORDS = 26000  # in all documents; tables, code and headings do not count
LONG = 25  # words of a sentence
MOST_LONG = 0.03  # of all sentences


def sentences(text):
    """Return the sentences of a document as (words, text): of paragraphs and lists."""
    text = re.sub(r"^```.*?^```|<!--.*?-->", " ", text, flags=re.S | re.M)
    lines = [line for line in text.split("\n") if not line.startswith(("    ", "|", "#", "!["))]
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", "\n".join(lines))
    text = re.sub(r"`[^`]*`", "code", text)
    for paragraph in re.split(r"\n\s*\n|\n\s*[-*] |\n\d+\. ", text):
        for sentence in re.split(r"(?<=[.!?:;])\s+", " ".join(paragraph.split())):
            n = len(re.findall(r"[A-Za-z][A-Za-z'-]*", sentence))
            if n > 2:
                yield n, sentence


def main():
    """Check all; return the exit status."""
    files = [*ROOT.glob("*.md"), *ROOT.glob("[bdpt]*/**/*.md")]
    files = [path for path in files if not path.relative_to(ROOT).parts[0].startswith("build")]
    found = [(n, path.relative_to(ROOT), text) for path in files for n, text in sentences(path.read_text(encoding="utf-8"))]
    words, long = sum(n for n, _, _ in found), [one for one in found if one[0] > LONG]
    listed = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    failures = [f"docs/README.md does not list {path.name}" for path in ROOT.glob("docs/*.md")
                if path.name != "README.md" and f"({path.name})" not in listed]
    if words > MOST_WORDS:
        failures.append(f"documents have {words} words; {MOST_WORDS} are allowed: shorten some")
    if len(long) > MOST_LONG * len(found):
        failures += [f"{path}: {n} words: {text}" for n, path, text in sorted(long, reverse=True)]
        failures.append(f"{len(long)} sentences of {len(found)} have more than {LONG} words: split some")
    print("\n".join([*failures, f"{words} words, {len(found)} sentences, {len(long)} of them long"]))
    return int(bool(failures) or not found)


if __name__ == "__main__":
    sys.exit(main())
