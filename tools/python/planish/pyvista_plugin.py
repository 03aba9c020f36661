"""PyVista's plugin of planish: PyVista imports this module when mesh.planish is first asked for.

import planish does not import it. If it did, and PyVista came later, PyVista's import would do nothing.
"""

# PyVista may be missing where types are checked.
# mypy: no-warn-unused-ignores

import pyvista  # type: ignore[import]

from .accessor import register

register(pyvista)
