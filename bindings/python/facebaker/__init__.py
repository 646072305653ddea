"""Load baked faces (.fbk) and pose them; see facebaker.h for what everything means."""

from ._face import Control, ExpectedError, Face, load
from ._library import Error, __version__

__all__ = ["Control", "Error", "ExpectedError", "Face", "load", "__version__"]
