#!/usr/bin/env python3
"""spelling.py: words of documents, public headers, help texts and docstrings are British English.

They are in aspell's dictionary or in words.txt, and nothing in the source is a common mistake (codespell).
"""
import ast
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORD = re.compile(r"(?<![\w.\\/@-])[^\W\d_]+(?:'[^\W\d_]+)?(?![\w/@(=]|-[\d_])")
CODE = re.compile(r"^```.*?^```|<!--.*?-->|^    .*?$|``?[^`]*``?|\]\([^)]*\)|https?:\S+"
                  r"|constrained optimization|via optimization", re.S | re.M)  # the last two are of titles of papers
# Words that codespell takes for others: names of people, of norms and of fields of files, and ends of escapes.
FOLDERS = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "bench", "docs", "include", "packaging", "src", "tools")
OTHERS = "coo,fo,fro,nam,nin,nnumber,noe,numer,te,ue,weill"


def blank(match):
    """Return as many lines as were matched."""
    return re.sub(r"[^\n]", " ", match.group())


def of_markdown(text):
    """Return the prose of a document."""
    return CODE.sub(blank, text)


def of_header(text):
    """Return the comments of a header."""
    return re.sub(r"\*/.*?(?:/\*|\Z)", blank, text, flags=re.S)


def of_strings(text):
    """Return the texts in C of more than a word, without what printf makes of them."""
    found = re.findall(r'"[^"\n]*"|\n', re.sub(r"/\*.*?\*/", blank, text, flags=re.S))
    return re.sub(r'\\n|%[^\s"]*', " ", "".join(one for one in found if one == "\n" or " " in one))


def of_docstrings(text):
    """Return the docstrings of a module, at their lines."""
    lines = [""] * (text.count("\n") + 2)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
            start = node.body[0].lineno - 1
            for i, line in enumerate(node.body[0].value.value.split("\n")):
                lines[start + i] = line
    return "\n".join(lines)


READERS = (("*.md", of_markdown), ("[bdpt]*/**/*.md", of_markdown), ("include/*/*.h", of_header), ("tools/options/options.c", of_strings),
           ("tools/python/planish/*.py", of_docstrings))


def words():
    """Return the place where each word stands first; names with a capital inside are none."""
    places = {}
    for pattern, prose in READERS:
        for path in sorted(ROOT.glob(pattern)):
            for n, line in enumerate(prose(path.read_text(encoding="utf-8")).split("\n"), 1):
                for word in WORD.findall(line):
                    if word[1:] == word[1:].lower():
                        places.setdefault(word, f"{path.relative_to(ROOT)}:{n}")
    return places


def main():
    """Check all; return the exit status."""
    places = words()
    known = set((HERE / "words.txt").read_text(encoding="utf-8").lower().split())
    said = subprocess.run(["aspell", "list", "--lang=en_GB-ise", "--encoding=utf-8", "--ignore=1"], text=True, check=True,
                          input="\n".join(places), stdout=subprocess.PIPE).stdout.split()
    unknown = [word for word in said if word.lower().removesuffix("'s") not in known]
    for word in unknown:
        print(f"{places[word]}: {word}: misspelt, or missing in tests/docs/words.txt")
    mistakes = subprocess.run(["codespell", "-L", OTHERS, *FOLDERS], cwd=ROOT, check=False).returncode
    print(f"{len(places)} words, {len(unknown)} unknown")
    return int(mistakes or bool(unknown) or not places)


if __name__ == "__main__":
    sys.exit(main())
