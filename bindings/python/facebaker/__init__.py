"""Load baked faces (.fbk) and pose them; see facebaker.h for what everything means."""

from ._face import Control, Face, load
from ._library import Error, __version__

__all__ = ["Control", "Error", "Face", "load", "__version__"]
