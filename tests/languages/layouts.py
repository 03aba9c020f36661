"""Print a program in C that compares structures and functions which examples in other languages declare with
those of the header.

    layouts.py HEADER EXAMPLE...    .rs, .f90 or .jl
"""
import os
import re
import sys

# Types by language: size in bytes, which is the alignment, too.
SIZES = {
    ".rs": {"c_int": 4, "i64": 8, "c_char": 1},
    ".f90": {"integer(c_int)": 4, "integer(c_int64_t)": 8, "type(c_ptr)": 8, "character(c_char)": 1},
    ".jl": {"Cint": 4, "Int64": 8, "UInt8": 1},
}


def size_of(kind, language):
    """Size of one and number of a type."""
    array = re.fullmatch(r"\[(.+); (\d+)\]", kind) or re.fullmatch(r"NTuple\{(\d+), (.+)\}", kind)
    if array:
        kind, count = sorted(array.groups(), key=str.isdigit)
        return size_of(kind, language)[0], int(count)
    if kind.startswith(("*const ", "*mut ", "Ptr{")):
        return 8, 1
    return SIZES[language][kind], 1


def fields_of_fortran(body):
    for kind, names in re.findall(r"^ *(\S+) :: ([^!\n]*)", body, re.M):
        for name, count in re.findall(r"(\w+)(?:\((\d+)\))?(?: = \w+)?(?:, |\s*$)", names):
            yield name, (SIZES[".f90"][kind], int(count or 1))


def structures(text, language):
    """Name in C and [(field, (size, count))] of each."""
    if language == ".f90":
        for name, body in re.findall(r"type, bind\(c\) :: (\w+)(.*?)end type", text, re.S):
            yield name, list(fields_of_fortran(body))
        return
    pattern, field = {
        ".rs": (r"struct \w+ \{ // (planish_\w+)[^\n]*\n(.*?)\n\}", r"(\w+): ([^,]+),"),
        ".jl": (r"struct \w+ # (planish_\w+)[^\n]*\n(.*?)\nend", r"(\w+)::([^;\n]+)"),
    }[language]
    for name, body in re.findall(pattern, text, re.S):
        yield name, [(name, size_of(kind, language)) for name, kind in re.findall(field, body)]


def checks_of_structure(name, fields):
    """Expressions in C and their values, as C lays out these fields."""
    at = 0
    for field, (size, count) in fields:
        at += -at % size
        yield f"offsetof({name}, {field})", at
        yield f"sizeof((({name} *)0)->{field})", size * count
        at += size * count
    yield f"sizeof({name})", at + -at % 8


def count_arguments(text, language):
    """Names of functions and how many arguments the example says that they have."""
    pattern = {
        ".rs": r"fn (planish_\w+)\(([^)]*)\)",
        ".f90": r"(?:function|subroutine) (planish_\w+)\(([^)]*)\) bind",
        ".jl": r"ccall\(\(:(planish_\w+), lib\), \w+, \(([^)]*)\)",
    }[language]
    for name, arguments in re.findall(pattern, text):
        yield name, len([a for a in arguments.split(",") if a.strip()])


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        header = dict(count_arguments(re.sub(r"PLANISH_API [^;]*?\b(planish_\w+)\(", r"fn \1(", file.read()), ".rs"))
    print("#include <planish/planish.h>\n#include <stdio.h>\nint main(void) {\n    int bad = 0;")
    for path in sys.argv[2:]:
        language = os.path.splitext(path)[1]
        with open(path, encoding="utf-8") as file:
            text = file.read()
        found, functions = list(structures(text, language)), list(count_arguments(text, language))
        if {name for name, _ in found} != {"planish_mesh", "planish_error"} or len(functions) < 4:
            sys.exit(f"{path}: its structures or functions were not found")
        checks = [check for structure in found for check in checks_of_structure(*structure)]
        checks += [(str(header[name]), count) for name, count in functions]
        for expression, value in checks:
            print(f'    if ({expression} != {value}) bad = printf("{path}: %s is %zu, not {value}\\n", '
                  f'"{expression}", (size_t)({expression}));')
    print("    return bad != 0;\n}")


if __name__ == "__main__":
    main()
