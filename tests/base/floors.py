"""Floors of the house (docs/architecture.md): no file knows or calls one that is above it.

    floors.py BUILD     BUILD has object files of the libraries and the program

A module is NAME.c with NAME.h. A module knows another one if it includes its header, or if its object file
needs a function or array that the other's defines. No module knows one of a higher floor, or one that its
floor may not know; modules that know one another are of one folder and at most MOST. A function that its file alone
names is static.
"""
import collections
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MOST = 4  # modules of a circle

# Formats of mesh files have a folder each.
FORMATS = sorted(set(os.listdir(os.path.join(ROOT, "src", "io"))) - {"core", "hdf5", "netcdf", "view", "file", "xml"})

# What each folder may know beside itself and what its neighbours below know.
KNOWS = {
    "src/base": [],
    "src/geometry": ["src/base"],
    "src/star": ["src/geometry"],
    "src/topology": ["src/geometry"],
    "src/shape": ["src/topology"],
    "src/quality": ["src/geometry"],
    "src/plan": ["src/topology", "src/shape", "src/star", "src/quality"],
    "src/sweep": ["src/plan", "src/shape"],
    "src/improve": ["src/sweep"],
    "src/surface": ["src/sweep", "src/shape"],
    "src/fit": ["src/shape", "src/quality"],
    "src/api": ["src/improve", "src/shape", "src/surface", "src/fit"],
    "src/io/core": ["src/base"],
    "src/io/hdf5": ["src/io/core"],
    "src/io/netcdf": ["src/io/hdf5", "src/io/view"],
    "src/io/xml": ["src/io/core"],
    "src/io/view": ["src/io/core"],
    **{"src/io/" + name: ["src/io/view", "src/io/netcdf", "src/io/xml"] for name in FORMATS},
    "src/io/file": ["src/io/" + name for name in FORMATS],
    "tools/terminal": ["src/base"],
    "tools/options": ["tools/terminal"],
    "tools/job": ["tools/options"],
    "tools/report": ["tools/job"],
    "tools/commands": ["tools/report"],
    "tools": ["tools/commands"],
    "tools/mpi": ["tools/commands"],
}

# Single arrows that are allowed beside these: from and to are beginnings of modules.
ALLOWED = [
    ("src/io/xdmf/", "src/io/vtk/", "XDMF's cells and numbers are VTK's"),
    ("tools/job/output", "src/io/file/", "names of the files of a mesh"),
    ("tools/job/angles", "src/geometry/", "angles"),
    ("tools/job/held", "src/geometry/", "ends of an edge"),
    ("tools/job/curved", "src/geometry/", "facets of a type"),
    ("tools/job/unjoined", "src/geometry/", "facets of a type"),
    ("tools/report/drawn_triangles", "src/topology/", "facets"),
    ("tools/report/drawn_triangles", "src/geometry/", "facets of a type"),
    ("tools/report/drawn_surface", "src/geometry/", "facets of a type"),
    ("tools/report/drawn_inside", "src/geometry/", "facets of a type"),
    ("tools/mpi/slides", "src/topology/", "facets"),
    ("tools/mpi/plexrows", "src/io/", "where coordinates stand in HDF5"),
]


def floor_of(module):
    """The folder of KNOWS that a module is in."""
    return max((f for f in KNOWS if module.startswith(f + "/")), key=len, default=None)


def all_below(folder, found=None):
    found = set() if found is None else found
    for other in KNOWS[folder]:
        if other not in found:
            found.add(other)
            all_below(other, found)
    return found


def module_of(path):
    return os.path.splitext(path)[0]


def sources(*tops):
    for top in tops:
        for folder, _, names in os.walk(os.path.join(ROOT, top)):
            for name in names:
                if name.endswith((".c", ".h", ".cpp", ".inc")):
                    yield os.path.relpath(os.path.join(folder, name), ROOT)


def arrows_of_includes(files):
    for path in files:
        with open(os.path.join(ROOT, path), encoding="utf-8") as text:
            for name in re.findall(r'^ *# *include *"([^"]+)"', text.read(), re.M):
                for top in ("src", "tools"):
                    if os.path.exists(os.path.join(ROOT, top, name)):
                        yield module_of(path), module_of(os.path.join(top, name)), name
                        break


def objects(build):
    for folder, _, names in os.walk(build):
        match = re.search(r"/CMakeFiles/(planish_objects|planish_io_objects|planish_tools|planish_mpi|planish_program)"
                          r"\.dir/?(.*)$", folder)
        for name in names if match else ():
            path = os.path.join(match[2], name)
            source = re.sub(r"\.o(bj)?$", "", path)
            if source != path and os.path.exists(os.path.join(ROOT, source)):
                yield os.path.join(folder, name), module_of(source)


def symbols(build):
    """(module, name, kind) of all symbols of the object files, as nm tells them."""
    modules = dict(objects(build))
    if not modules:
        sys.exit(f"no object files in {build}")
    told = subprocess.run(["nm", "-A", "-P", *modules], capture_output=True, text=True, check=True).stdout
    for line in told.splitlines():
        path, rest = line.split(": ", 1)
        yield (modules[path], *rest.split()[:2])


def arrows_of_calls(found):
    defined, needed = {}, collections.defaultdict(set)
    for module, name, kind in found:
        if kind in "TRDB":
            defined[name] = module
        elif kind == "U":
            needed[module].add(name)
    for module, names in needed.items():
        for name in names:
            if name in defined and defined[name] != module:
                yield module, defined[name], name


def functions_alone(found):
    """Functions that other files could call, and that no file but their own names."""
    needed, defined, words = set(), {}, collections.Counter()
    for module, name, kind in found:
        if kind == "T" and name != "main" and not name.startswith("planish_"):
            defined[name] = module
        elif kind == "U":
            needed.add(name)
    for path in sources("src", "tools", "tests", "bench", "docs"):
        if not path.endswith(".h"):
            with open(os.path.join(ROOT, path), encoding="utf-8", errors="replace") as text:
                words.update(set(re.findall(r"\w+", text.read())))
    return sorted((module, name) for name, module in defined.items()
                  if name not in needed and words[name] == 1)


def is_allowed(a, b, names):
    folder, other = floor_of(a), floor_of(b)
    if not folder.startswith("src") or folder.startswith("src/io"):
        names = {name for name in names if not name.startswith("planish_")}  # public functions
        if not names:
            return True
    return other == folder or other in all_below(folder) or any(
        a.startswith(begin) and b.startswith(end) for begin, end, _ in ALLOWED)


def circles(graph):
    """Strongly connected modules (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in graph[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            at = stack.index(v)
            found.append(sorted(stack[at:]))
            del stack[at:]

    for v in list(graph):
        if v not in index:
            visit(v)
    return [circle for circle in found if len(circle) > 1]


def main():
    sys.setrecursionlimit(10000)
    found = list(symbols(sys.argv[1]))
    arrows = collections.defaultdict(set)
    for a, b, name in [*arrows_of_includes(list(sources("src", "tools"))), *arrows_of_calls(found)]:
        if a != b and floor_of(a) and floor_of(b):
            arrows[a, b].add(name)
    bad = [(a, b) for a, b in sorted(arrows) if not is_allowed(a, b, arrows[a, b])]
    for a, b in bad:
        print(f"{a} must not know {b}: {', '.join(sorted(arrows[a, b]))}")
    graph = collections.defaultdict(set)
    for a, b in arrows:
        graph[a].add(b)
        graph[b]  # pylint: disable=pointless-statement
    for circle in circles(graph):
        across = len({os.path.dirname(module) for module in circle}) > 1
        if across or len(circle) > MOST:
            bad.append(circle)
            print(f"a circle{' across folders' if across else ''} of {len(circle)}: {', '.join(circle)}")
    for module, name in functions_alone(found):
        bad.append(name)
        print(f"{name} must be static: {module} alone names it")
    print(f"{len(arrows)} arrows, {len(bad)} that must not be")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
