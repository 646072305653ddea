"""The baked face beside its rig: an object whose mesh follows the controls of the scene."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any, Dict, Optional

import bpy
import numpy as np

from .bake_settings import BakeSettings, settings_document, settings_of
from .baked_state import add_baked_meshes, baked_meshes, keep_modifiers, remove_baked_meshes
from .channels import SettingsError
from .error_colours import error_colours
from .preview_object import ATTRIBUTE, make_object, show_error_material
from .scene_channels import SceneChannels, find_object
from .scene_evaluator import SceneEvaluator, evaluated_positions, scene_units, world_matrix
from .shown_lengths import length_text

if TYPE_CHECKING:
    import facebaker

ARCHIVE, SETTINGS, SCALE, COLOURS = "facebaker_archive", "facebaker_settings", "facebaker_scale", "facebaker_colours"


class FacePreview:
    """What an object of a baked face needs while it follows the rig. Attributes: face_ms, of the last evaluation; max_error,
    the largest distance from the rig in the last pose, over the diagonal, if colours are shown; problem: why they are
    not, "" if they are."""

    def __init__(self, preview: Any, face: "facebaker.Face", settings: BakeSettings) -> None:
        self.name, self.face, self.settings = preview.name, face, settings
        self.positions = np.empty((face.vertex_count, 3), np.float32)
        self.face_ms, self.max_error = 0.0, 0.0
        self.problem = ""
        self._seen: Optional[bytes] = None
        self._low, self._high = (
            np.array([getattr(c, end) for c in face.controls], np.float32) for end in ("minimum", "maximum")
        )

    def update(self, graph: Any, again: bool = False) -> bool:
        """Poses the mesh as a dependency graph has the scene's controls, which in a render are not those of the window;
        whether anything changed. again: even if they are as before."""
        preview = bpy.data.objects.get(self.name)
        if preview is None:
            return False
        # Found by their names each time: an undo replaces them all.
        controls = np.clip(SceneChannels(self.settings.controls, graph).read(), self._low, self._high)
        if controls.tobytes() == self._seen and not again:
            return False
        self._seen = controls.tobytes()
        begin = time.perf_counter()
        self.face.evaluate(controls, self.positions)
        self.face_ms = 1e3 * (time.perf_counter() - begin)
        mesh = preview.data
        mesh.vertices.foreach_set("co", self.positions.ravel())
        if preview.get(COLOURS):
            self._colour(preview, graph, float(preview.get(SCALE, 1e-3)))
        mesh.update()
        return True

    @property
    def max_length(self) -> str:
        """The largest distance, for people."""
        return length_text(self.max_error * float(self.face.diagonal), str(self.face.units))

    def _colour(self, preview: Any, graph: Any, scale: float) -> None:
        """Distances from where the rig has the vertices now, in the state in which it was baked."""
        objects = baked_meshes(preview) or [find_object(name) for name in self.settings.meshes]
        reference = world_matrix(find_object(self.settings.reference or self.settings.meshes[0], graph))
        factor = scene_units(graph.scene, reference)[1]
        true = evaluated_positions(objects, graph, np.linalg.inv(reference), factor)
        colours = preview.data.color_attributes[ATTRIBUTE].data
        if true.shape != self.positions.shape:
            self.problem = f"the rig has {len(true)} vertices now, the face {len(self.positions)}"
            colours.foreach_set("color", np.ones(4 * len(self.positions), np.float32))
            return
        distances = np.linalg.norm(self.positions - true, axis=1) / float(self.face.diagonal)
        self.max_error, self.problem = float(distances.max()), ""
        colours.foreach_set("color", error_colours(distances, scale).ravel())


_loaded: Dict[str, FacePreview] = {}
_busy = False


def add_preview(
    context: Any, archive: str, settings: BakeSettings, place: int = 1, colours: bool = False, scale: float = 1e-3,
    replace: bool = False,
) -> Any:  # fmt: skip
    """Adds the object of a baked face, so many faces' widths beside the rig. colours: show errors, red from `scale`, a
    share of the diagonal, on. replace: in place of those of the same meshes, where the last of them is. Raises
    facebaker.Error, OSError; SettingsError if the face is not one of these settings."""
    import facebaker

    face = facebaker.load(archive)
    if [control.name for control in face.controls] != [control.name for control in settings.controls]:
        raise SettingsError(f"{archive}: has other controls than the settings")
    where = _remove_previews(context.scene, settings) if replace else None
    reference = world_matrix(find_object(settings.reference or settings.meshes[0]))
    preview = make_object(face, settings, place, scene_units(context.scene, reference)[1])
    if where is not None:
        preview.location = where
    context.scene.collection.objects.link(preview)
    preview[ARCHIVE], preview[SETTINGS] = str(archive), json.dumps(settings_document(settings))
    # A render in the window poses the mesh in a thread of its own, while the window would draw it.
    context.scene.render.use_lock_interface = True
    state = _loaded[preview.name] = FacePreview(preview, face, settings)
    keep_modifiers(context, settings, preview)
    show_colours(context, preview, colours, scale)
    context.view_layer.update()
    state.update(context.evaluated_depsgraph_get(), again=True)
    return preview


def _remove_previews(scene: Any, settings: BakeSettings) -> Any:
    """Removes the baked faces of these meshes from a scene; the place of the last one, None if there was none."""
    where = None
    for preview in [found for found in scene.objects if ARCHIVE in found.keys()]:
        if json.loads(preview[SETTINGS])["meshes"] != list(settings.meshes):
            continue
        where, mesh = preview.location.copy(), preview.data
        remove_baked_meshes(preview)
        _loaded.pop(preview.name, None)
        bpy.data.objects.remove(preview)
        if not mesh.users:
            bpy.data.meshes.remove(mesh)
    return where


def show_colours(context: Any, preview: Any, colours: bool, scale: float) -> None:
    """Whether a preview shows its errors, red from `scale` on. Raises SettingsError."""
    state = preview_of(preview)
    if colours and state is not None:
        add_baked_meshes(context, state.settings, preview)
    else:
        remove_baked_meshes(preview)
    show_error_material(preview, colours)
    preview[COLOURS], preview[SCALE] = colours, scale


def preview_of(scene_object: Any) -> Optional[FacePreview]:
    """What a preview object needs, loaded when it is first asked for; None for other objects, and where the archive
    cannot be read."""
    import facebaker

    if ARCHIVE not in scene_object.keys():
        return None
    known = _loaded.get(scene_object.name)
    if known is None:
        try:
            settings = settings_of(json.loads(scene_object[SETTINGS]))
            face = facebaker.load(bpy.path.abspath(scene_object[ARCHIVE]))
            known = FacePreview(scene_object, face, settings)
        except (facebaker.Error, SettingsError, OSError, ValueError) as error:
            print(f"FaceBaker: {scene_object[ARCHIVE]}: {error}")
            return None
        _loaded[scene_object.name] = known
    return known


def shown_preview(scene_object: Any) -> Optional[FacePreview]:
    """What preview_of() has loaded already, for drawing."""
    return _loaded.get(scene_object.name)


def update_previews(scene: Any, graph: Any, again: bool = False) -> None:
    """Poses all preview objects of a scene that a dependency graph shows. Called by Blender after updates and changes of
    the frame, of the window and of renders."""
    global _busy
    if _busy or SceneEvaluator.active:
        return
    _busy = True
    try:
        for scene_object in scene.objects:
            if ARCHIVE not in scene_object.keys() or not _is_shown(scene_object, graph):
                continue
            state = preview_of(scene_object)
            if state is not None:
                try:
                    state.update(graph, again)
                except SettingsError as error:
                    state.problem = str(error)
    finally:
        _busy = False


def _is_shown(preview: Any, graph: Any) -> bool:
    if graph.mode == "RENDER":
        return not preview.hide_render
    return bool(preview.visible_get(view_layer=graph.view_layer))


def _after_update(scene: Any, graph: Any = None) -> None:
    update_previews(scene, graph or bpy.context.evaluated_depsgraph_get())


def _after_undo(scene: Any, _: Any = None) -> None:
    """The mesh is as it was then, whatever the controls are."""
    update_previews(scene, bpy.context.evaluated_depsgraph_get(), again=True)


def _after_load(_: Any, __: Any = None) -> None:
    _loaded.clear()
    update_previews(bpy.context.scene, bpy.context.evaluated_depsgraph_get(), again=True)


def add_handlers() -> None:
    """Has Blender call this module, also in files that are opened later."""
    for place, handler in _PLACES:
        bpy.app.handlers.persistent(handler)
        if handler not in getattr(bpy.app.handlers, place):
            getattr(bpy.app.handlers, place).append(handler)


def remove_handlers() -> None:
    """The reverse of add_handlers()."""
    for place, handler in _PLACES:
        if handler in getattr(bpy.app.handlers, place):
            getattr(bpy.app.handlers, place).remove(handler)
    _loaded.clear()


_PLACES = (
    ("depsgraph_update_post", _after_update),
    ("frame_change_post", _after_update),
    ("undo_post", _after_undo),
    ("redo_post", _after_undo),
    ("load_post", _after_load),
)
