"""ParaView's plugin of planish: load this file by Tools > Manage Plugins > Load New.

It has a name of its own, as ParaView calls the module by the name of the file.
"""

import pathlib
import sys

_FOLDER = str(pathlib.Path(__file__).resolve().parent.parent)
if _FOLDER not in sys.path:
    sys.path.append(_FOLDER)

from planish.paraview import Smooth  # noqa: E402  # pylint: disable=wrong-import-position,unused-import

paraview_plugin_name = "planish"
