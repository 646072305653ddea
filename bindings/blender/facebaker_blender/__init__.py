"""FaceBaker for Blender: bakes the face of a scene, and shows the baked face beside its rig; see docs/blender.md."""

bl_info = {
    "name": "FaceBaker",
    "author": "The FaceBaker contributors",
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > FaceBaker",
    "description": "Bake facial rigs into small files that pose in microseconds",
    "category": "Rigging",
}


def register() -> None:
    """Called by Blender. What needs Blender is imported here, so that the rest of the package can be used without it."""
    from . import window

    window.register()


def unregister() -> None:
    from . import window

    window.unregister()
