#!/usr/bin/env python3
"""bores: a cube with a bore and a spherical hole, meshed and optimised by Netgen.   bores.py OUT.msh"""
import sys

from netgen.csg import CSGeometry, Cylinder, OrthoBrick, Pnt, Sphere

shape = CSGeometry()
shape.Add(OrthoBrick(Pnt(0, 0, 0), Pnt(1, 1, 1)) - Sphere(Pnt(0.5, 0.5, 0.5), 0.3)
          - Cylinder(Pnt(0.2, 0.2, -1), Pnt(0.2, 0.2, 2), 0.1))
shape.GenerateMesh(maxh=0.06).Export(sys.argv[1], "Gmsh2 Format")
