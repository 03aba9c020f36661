"""Fits: the surface of a mesh is moved onto another surface."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_double, c_void_p
from typing import Optional

import numpy as np

from ._arrays import Points, address, pointer
from ._library import call, library
from ._results import FitInfo, ShapeDistance
from ._shapes import Shape
from ._structures import MeshView, Options
from ._view import View


class Fit:
    """Places on another surface for the boundary nodes of a mesh."""

    def __init__(self, view: View, own: Shape, onto: Shape, options: Options) -> None:
        """Find places on the shape onto for the nodes of view. own: the shape of view."""
        self._fit: Optional[c_void_p] = c_void_p()
        self.info = FitInfo()
        self._view = view
        self._shapes = own.handle(), onto.handle()  # needed as long as the fit is
        call(library.planish_fit_create, byref(view.mesh), own.pointer(), onto.pointer(), c_double(0), byref(options),
             byref(self._fit), byref(self.info))

    def is_held(self) -> bool:
        """Whether all nodes of the surface are held, so that none can be moved."""
        return self.info.n_held == self.info.n_nodes

    def move(self, options: Options) -> None:
        """Move the points to their places, in place, as far as elements stay valid."""
        view = self._view
        taken = Points(view.given, 3, view.points.strides, writes=True)
        call(library.planish_fit_move, self._fit, byref(view.mesh), pointer(taken.array), byref(options),
             byref(self.info))
        taken.write_back()
        view.points.array[...] = taken.array

    def let_slide(self, options: Options) -> None:
        """Let nodes slide along the other surface from now on."""
        constraint = np.zeros(self._view.n, np.uint8) if self._view.constraint is None else self._view.constraint
        library.planish_fit_constrain(self._fit, address(constraint))
        self._view.constrain(constraint, self._view.direction)
        options.project = ctypes.cast(library.planish_fit_project, c_void_p).value
        options.project_user = None if self._fit is None else self._fit.value

    def distance(self, points: Points) -> ShapeDistance:
        """Return proved distances: from the surface at points to the other surface, and back."""
        found, mesh = ShapeDistance(), MeshView.from_buffer_copy(self._view.mesh)
        mesh.coordinates = address(points.array)
        call(library.planish_fit_measure, self._fit, byref(mesh), byref(found))
        return found

    def close(self) -> None:
        """Release the memory of the fit."""
        fit, self._fit = self._fit, None
        if fit:
            library.planish_fit_destroy(fit)

    def __del__(self) -> None:
        """Release the memory of a fit that was not closed."""
        self.close()
