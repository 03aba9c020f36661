"""How Sphinx makes the site of docs/: tools/site runs it, with the top of the project as the source."""
import pathlib
import re
import sys
import unittest.mock

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "tools/python")]

from header import NAME, HeaderParser, linked, paragraphs  # noqa: E402

project = "planish"
version = release = re.search(r'PLANISH_VERSION "(.*)"', (ROOT / "include/planish/planish.h").read_text()).group(1)
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown", ".h": "header", ".rst": "restructuredtext"}
include_patterns = ["*.md", "docs/*.md", "docs/site/*.rst", "include/planish/*.h", "bench/*.md", "packaging/*.md",
                    "tests/**.md"]
root_doc = "README"
highlight_language = "none"

# Anchors of headings are those of GitHub.
myst_heading_anchors = 6
suppress_warnings = ["myst.header"]  # tables have smaller headings than the level would ask for

# Of the package only the words are needed: no library, and no Gmsh.
with unittest.mock.patch("ctypes.CDLL"):
    import planish  # noqa: E402, F401
autodoc_mock_imports = ["gmsh"]
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"planish {version}"
html_static_path = ["static"]
html_js_files = [("site.js", {"priority": 900})]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False


def add_contents(_app: Sphinx, name: str, source: list[str]) -> None:
    """Give the first page the tables of contents: documents as the headings of docs/README.md group them."""
    if name != root_doc:
        return
    seen = ["/docs/README.md"]
    tables = [("", seen)]
    for title, text in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", (ROOT / "docs/README.md").read_text(), re.S | re.M):
        paths = [(ROOT / "docs" / path).resolve() for path in re.findall(r"\]\(([^)#]+\.(?:md|h|rst))\)", text)]
        entries = ["/" + str(path.relative_to(ROOT)) for path in dict.fromkeys(paths)]
        tables.append((title, [entry for entry in entries if entry not in seen]))
        seen = seen + entries
    for title, entries in tables:
        if entries:
            caption = [f":caption: {title}"] if title else []
            source[0] += "\n".join(["", "```{toctree}", ":hidden:", *caption, "", *entries, "```", ""])


def mark_up_docstring(_app: Sphinx, what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Mark up the code and the names in a docstring; what Python itself says of a named tuple's fields is left out."""
    if what == "module":
        lines[:] = paragraphs("\n".join(lines))
    elif lines and lines[0].startswith("Alias for field number"):
        lines.clear()
    else:
        # Napoleon would take what stands before a colon in the first line of a property for its type.
        lines[:] = [*([""] if what == "property" else []), *map(linked, lines)]


def link_names(app: Sphinx, document: nodes.document) -> None:
    """Link each name of the library that stands as code in a document to its place in the reference."""
    for literal in list(document.findall(nodes.literal)):
        if NAME.fullmatch(literal.astext()) and not isinstance(literal.parent, (nodes.reference, addnodes.pending_xref)):
            to = addnodes.pending_xref("", literal.deepcopy(), refdomain="c", reftype="type",
                                       reftarget=literal.astext(), refdoc=app.env.docname)
            literal.replace_self(to)


def setup(app: Sphinx) -> None:
    """Tell Sphinx of headers, contents and names."""
    app.add_source_parser(HeaderParser)
    app.connect("source-read", add_contents)
    app.connect("autodoc-process-docstring", mark_up_docstring, priority=400)  # before Napoleon
    app.connect("doctree-read", link_names)
