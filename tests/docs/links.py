#!/usr/bin/env python3
"""links.py: links of documents lead somewhere.

    links.py          Markdown files of the project, with anchors as GitHub makes them
    links.py FOLDER   pages of a site: also that they load nothing from elsewhere
"""
import html.parser
import pathlib
import re
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("bench", "docs", "packaging", "src", "tests", "tools")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.S | re.M)


def slugs(text):
    """Return the anchors of the headings of a Markdown text: GitHub counts those that occur again."""
    found = set()
    for heading in re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M), re.M):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        slug = first = re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")
        n = 0
        while slug in found:
            n += 1
            slug = f"{first}-{n}"
        found.add(slug)
    return found


def read_markdown(path):
    """Return the links (line, target) and the anchors of a Markdown file."""
    text = path.read_text(encoding="utf-8")
    plain = CODE.sub(lambda code: re.sub(r"[^\n]", " ", code.group()), text)
    links = [(plain.count("\n", 0, link.start()) + 1, link.group(1)) for link in re.finditer(r"\]\(([^)\s]+)\)", plain)]
    return links, slugs(text)


class Page(html.parser.HTMLParser):
    """Links and anchors of a page, and what it loads from elsewhere."""

    def __init__(self):
        super().__init__()
        self.links, self.anchors, self.foreign = [], set(), []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors.update(given[name] for name in ("id", "name") if given.get(name))
        target = given.get("href") or given.get("src") or given.get("action")
        if target is None:
            return
        self.links.append((self.getpos()[0], target))
        if tag != "a" and re.match(r"\w+:|//", target) and not target.startswith("data:"):
            self.foreign.append(f"{tag} loads {target}")


def read_page(path):
    """Return the links and the anchors of a page; say what it loads from elsewhere."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    for text in page.foreign:
        print(f"{path}: {text}")
    return page.links + [(0, "") for _ in page.foreign], page.anchors


def why_broken(path, target, known):
    """Return what is wrong with a link from path, or None."""
    if not target:
        return "it must not"
    if re.match(r"(https?|mailto|data):", target):
        return None
    place, _, anchor = urllib.parse.unquote(target).partition("#")
    file = (path.parent / place.partition("?")[0]).resolve() if place else path
    if not file.exists():
        return "there is no such file"
    if anchor and file in known and anchor not in known[file][1]:
        return "the file has no such heading"
    return None


def main():
    """Check all files; return the exit status."""
    if len(sys.argv) > 1:
        files, read = pathlib.Path(sys.argv[1]).resolve().rglob("*.html"), read_page
    else:
        files = [*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.md"))]
        read = read_markdown
    known = {path: read(path) for path in files}
    broken = n = 0
    for path, (links, _) in known.items():
        for line, target in links:
            n += 1
            why = why_broken(path, target, known)
            if why:
                print(f"{path}:{line}: {target}: {why}")
                broken += 1
    print(f"{len(known)} files, {n} links, {broken} broken")
    return int(broken > 0 or n == 0)


if __name__ == "__main__":
    sys.exit(main())
