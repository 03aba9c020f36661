"""The reference of the C library from its headers: their comments and declarations, as Sphinx understands them."""
import re
import textwrap

from sphinx.parsers import RSTParser

NAME = re.compile(r"\b(?:planish|PLANISH)_\w*[a-zA-Z0-9](?:\.\w+)?(?![\w*])")
ITEM = re.compile(r"""
    /\*\ -+\ (?P<section>.*?)\ -+\ \*/
  | (?:/\*\*(?P<text>(?:(?!\*/).)*)\*/\s*)?
    (?: typedef\ (?P<kind>struct|enum)\ (?P<name>\w+)\ \{(?P<body>.*?)^\}\ \w+;
      | \#define\ (?P<macro>(?!PLANISH_API)\w+(?:\(\w+\))?)\ (?P<value>.*?)$
      | (?:PLANISH_API\ |(?P<type>typedef\ ))(?P<declaration>[^;{}]*);$)
""", re.S | re.M | re.X)
COMMENT = r"/\*((?:(?!\*/).)*)\*/"
MEMBER = re.compile(rf"(?:{COMMENT}\s*)?([^;/]+);[ \t]*(?:{COMMENT})?", re.S)
ENUMERATOR = re.compile(rf"(?:{COMMENT}\s*)?(\w+(?: = [-\w]+)?),?[ \t]*(?:{COMMENT})?", re.S)


def linked(line):
    """Return a line with links at the names of documents and of the library."""
    line = re.sub(r"\bdocs/([\w-]+)\.md\b", r":doc:`docs/\1.md </docs/\1>`", line)
    return NAME.sub(lambda match: f":c:type:`{match.group()}`", line)


def marked_up(line):
    """Return a line of a comment with what is special to Sphinx escaped, and with links."""
    return linked(re.sub(r"([\\*`|]|_(?!\w))", r"\\\1", line))


def paragraphs(comment):
    """Return the lines of the text of a comment: paragraphs, lists, and lines that are indented as they are."""
    first, _, rest = (comment or "").lstrip("*").strip().partition("\n")
    rest = textwrap.dedent(re.sub(r"(?m)^ \*( |$)", "", rest))
    lines, state = [], ""
    for line in [first, *rest.splitlines()]:
        indented = line.startswith("  ")
        now = "list" if line.startswith("- ") or (indented and state == "list") else "as is" if indented else "text"
        if now != state and line:
            lines += ["", "::", ""] if now == "as is" else [""]
        state = now if line else state
        lines.append(line if now == "as is" else marked_up(line))
    return lines


def directive(kind, signatures, comment, inner=()):
    """Return the lines that declare signatures, with a comment and what is inside."""
    first = f".. c:{kind}:: "
    heads = [" ".join(signature.split()) for signature in signatures]
    lines = [first + heads[0], *(" " * len(first) + head for head in heads[1:]), *[""], *paragraphs(comment), "", *inner]
    return [lines[0], *("   " + line if line.strip() else "" for line in lines[1:]), ""]


def declared(member):
    """Return a declaration for each of the names that a member of a structure declares."""
    if "(" in member or "," not in member:
        return [member]
    first, *others = member.split(",")
    return [first] + [re.sub(r"[*\s]*\w+$", " ", first) + other for other in others]


def inside(kind, body):
    """Return the lines of the members of a structure, or of the enumerators of a type."""
    lines, pattern = [], MEMBER if kind == "struct" else ENUMERATOR
    for before, member, after in pattern.findall(body):
        if re.search(r"\breserved\b", member):
            continue
        if before and after:  # the comment before is about several
            lines += [*paragraphs(before), ""]
        lines += directive("member" if kind == "struct" else "enumerator", declared(member.strip()), after or before)
    return lines


def functions(header, start):
    """Return a line of links to the functions from start to the next section."""
    section = header[start:].partition("/* ----")[0]
    return ", ".join(f":c:func:`{name}`" for name in re.findall(r"^PLANISH_API [^(;]*?(\w+)\(", section, re.M))


def item(match):
    """Return the lines of a section's heading, or of a declaration."""
    section, text, kind, name, body, macro, value, is_type, declaration = match.groups()
    if section:
        return [section, "=" * len(section), "", functions(match.string, match.end()), ""]
    if kind:
        return directive(kind, [name], text, inside(kind, body))
    if macro:
        return directive("macro", [macro], text, [] if "(" in macro else [f"Its value is ``{value}``."])
    opaque = re.fullmatch(r"struct (\w+) \w+", declaration)
    if opaque:
        return directive("struct", [opaque.group(1)], text)
    return directive("type" if is_type else "function", [declaration], text)


def reference(header):
    """Return the text of the reference of a header."""
    intro, name = re.match(r"/\* ((\w+): .*?)\s*(?=\*/|\* Sections:)", header, re.S).groups()
    start = header.index('extern "C"')
    lines = [name + ".h", "#" * len(name + ".h"), *paragraphs(intro), "", functions(header, start), ""]
    for match in ITEM.finditer(header, start):
        lines += item(match)
    return "\n".join(lines)


class HeaderParser(RSTParser):
    """Parser of headers."""

    supported = ("header",)

    def parse(self, inputstring, document):
        """Parse a header."""
        super().parse(reference(str(inputstring)), document)
