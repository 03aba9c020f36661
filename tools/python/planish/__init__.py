"""planish: smooth, untangle and measure meshes of elements of any type, in place.

    import planish
    mesh = planish.read("part.msh")                 # any format of docs/formats.md
    planish.smooth(mesh, fix=["wall"], slide="auto")
    mesh.write("out.msh")                           # the bytes of part.msh, but for coordinates

    result = planish.smooth(points, cells)          # points [n, 2 or 3], cells [m, 3 or 4] of numpy
    result = planish.smooth(mesh)                   # a mesh of meshio or PyVista
    result = planish.smooth(points, {"hexahedron": a, "wedge": b})
    print(planish.quality(points, cells))

    with planish.Plan(points, cells) as plan:       # once for a connectivity, for many positions
        for points in positions:
            plan.smooth(points)

The environment variable PLANISH_LIBRARY names the library. Without it the package searches itself, then its
installation, then the folders of the system's linker.
docs/python.md is the introduction. Modules whose names begin with _ are not for callers.
"""

from . import accessor  # registers itself where PyVista is
from ._errors import ConversionWarning, Error, FileError
from ._files import Mesh, read, write
from ._formats import Format, formats
from ._library import version
from ._plan import Plan
from ._quality import checksum, find_layers, find_sizes, find_slides, layer_heights, quality, size_quality
from ._results import (CellMeasures, CellQuality, CellValues, FitInfo, LayerHeights, LayerRow, Quality, Result,
                       ShapeDistance, ShapeInfo, SizeQuality, SlideInfo, Slides, Spread)
from ._run import Progress
from ._shapes import Shape
from ._smooth import smooth

__version__ = version()

__all__ = ["CellMeasures", "CellQuality", "CellValues", "ConversionWarning", "Error", "FileError", "FitInfo", "Format",
           "LayerHeights", "LayerRow", "Mesh", "Plan", "Progress", "Quality", "Result", "Shape", "ShapeDistance",
           "ShapeInfo", "SizeQuality", "SlideInfo", "Slides", "Spread", "accessor", "checksum", "find_layers",
           "find_sizes", "find_slides", "formats", "layer_heights", "quality", "read", "size_quality", "smooth", "version",
           "write"]
