#!/usr/bin/env python3
"""write_case: one case of the catalogue as a file.

   write_case.py NAME OUT [VALID]      the tangled mesh and the known solution, .vtk or .mesh; says
                                       which elements are planted flaws, by their numbers in OUT
                                       (from 0 in VTK, from 1 in Medit)
   write_case.py --list [PATTERN]      names"""
import fnmatch
import sys

import cases
import meshfile


def main():
    if sys.argv[1:2] == ["--list"]:
        pattern = sys.argv[2] if len(sys.argv) > 2 else "*"
        print(*fnmatch.filter(cases.catalogue(), pattern), sep="\n")
        return
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    case = cases.build(sys.argv[1])
    meshfile.write(sys.argv[2], case.points, case.elements, case.fixed)
    for flaw in case.flaws:
        print("unfixable:", *(element + sys.argv[2].endswith(".mesh") for element in flaw))
    if len(sys.argv) == 4:
        meshfile.write(sys.argv[3], case.valid, case.elements, case.fixed)


if __name__ == "__main__":
    main()
