"""Load baked faces (.fbk) and pose them; see facebaker.h for what everything means."""

from typing import TYPE_CHECKING

from ._character import Channel, Control, Image, Joint, Material, MaterialRun, Mesh, Skin, Socket, Texture
from ._errors import Error
from ._face import ExpectedError, Face, load
from ._rig import Clip, Rig

__all__ = [
    "Channel", "Clip", "Control", "Error", "ExpectedError", "Face", "Image", "Joint", "Material", "MaterialRun", "Mesh",
    "Rig", "Skin", "Socket", "Texture", "load", "__version__",
]  # fmt: skip

if TYPE_CHECKING:
    __version__: str
else:

    def __getattr__(name):
        """__version__ is the library's, which is opened by then."""
        if name != "__version__":
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from ._library import library

        return library.fb_version_string().decode()
