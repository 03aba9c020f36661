#!/usr/bin/env python3
"""boxes: a curved box of quadrilaterals, hexahedra or wedges, with inner nodes displaced at random.

   boxes.py TYPE N OUT.vtk      TYPE: quad, hex or wedge; N: elements along each side"""
import sys

import numpy

import bases
import cells
import meshfile

PUSH = 0.2  # of the spacing, at most


def grid_of(kind, n):
    """Points with spacing 1, and elements, of a box with n elements along each side."""
    if kind == "wedge":
        points, nodes = bases.grid(n, n)
        return bases.extruded(points, cells.Cells(("triangle", bases.in_two(nodes))), n, 1)
    points, nodes = bases.grid(*[n] * cells.KINDS[kind].dim)
    return points, cells.Cells((kind, nodes))


def pushed(points, n):
    """The points, those inside pushed about."""
    inside = ((points > 0) & (points < n)).all(1)
    push = numpy.random.RandomState(1).uniform(-PUSH, PUSH, points.shape)
    return numpy.where(inside[:, None], points + push, points)


def curved(points):
    """A sector of a ring from radius 1 to 2, thicker at one corner; points [n][dim] in the unit box."""
    radius, angle = 1 + points[:, 0], 1.2 * points[:, 1]
    columns = [radius * numpy.cos(angle), radius * numpy.sin(angle)]
    if points.shape[1] == 3:
        columns.append(points[:, 2] * (1 + 0.3 * points[:, 0] * points[:, 1]))
    return numpy.stack(columns, 1)


def main():
    kind, n, target = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    points, elements = grid_of(kind, n)
    points = curved(pushed(points, n) / n)
    if not cells.is_valid(points, elements):
        sys.exit(f"boxes: {target} has inverted elements")
    meshfile.write_vtk(target, points, elements)


if __name__ == "__main__":
    main()
