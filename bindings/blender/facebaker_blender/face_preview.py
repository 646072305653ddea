"""The baked face beside its rig: an object whose mesh follows the controls of the scene."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any, Dict, List, Optional

import bpy
import numpy as np

from .bake_settings import BakeSettings, settings_document, settings_of
from .channels import SettingsError
from .error_colours import error_colours
from .scene_channels import SceneChannels, find_object
from .scene_evaluator import SceneEvaluator, evaluated_positions, scene_units, world_matrix

if TYPE_CHECKING:
    import facebaker

ARCHIVE, SETTINGS, SCALE, COLOURS = "facebaker_archive", "facebaker_settings", "facebaker_scale", "facebaker_colours"
ATTRIBUTE = "facebaker_error"
BESIDE = 1.15  # widths of the face from one to the next


class FacePreview:
    """What an object of a baked face needs while it follows the rig. Attributes: face_ms, of the last evaluation; max_error,
    the largest distance from the rig in the last pose, over the diagonal, if colours are shown."""

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
        """Poses the mesh as the scene's controls are; whether anything changed. again: even if they are as before."""
        preview = bpy.data.objects.get(self.name)
        if preview is None:
            return False
        # Found by their names each time: an undo replaces them all.
        controls = np.clip(SceneChannels(self.settings.controls).read(), self._low, self._high)
        if controls.tobytes() == self._seen and not again:
            return False
        self._seen = controls.tobytes()
        begin = time.perf_counter()
        self.face.evaluate(controls, self.positions)
        self.face_ms = 1e3 * (time.perf_counter() - begin)
        mesh = preview.data
        mesh.vertices.foreach_set("co", self.positions.ravel())
        if preview.get(COLOURS):
            self._colour(mesh, graph, float(preview.get(SCALE, 1e-3)))
        mesh.update()
        return True

    def _colour(self, mesh: Any, graph: Any, scale: float) -> None:
        """Distances from where the rig has the vertices now."""
        objects = [find_object(name) for name in self.settings.meshes]
        reference = find_object(self.settings.reference or self.settings.meshes[0]).evaluated_get(graph)
        factor = scene_units(bpy.context.scene)[1]
        true = evaluated_positions(objects, graph, np.linalg.inv(world_matrix(reference)), factor)
        if true.shape != self.positions.shape:
            self.problem = f"the rig has {len(true)} vertices now, the face {len(self.positions)}"
            return
        distances = np.linalg.norm(self.positions - true, axis=1) / self.diagonal
        self.max_error, self.problem = float(distances.max()), ""
        mesh.color_attributes[ATTRIBUTE].data.foreach_set("color", error_colours(distances, scale).ravel())

    @property
    def diagonal(self) -> float:
        return float(self.face.diagonal)


_loaded: Dict[str, FacePreview] = {}
_busy = False


def add_preview(
    context: Any, archive: str, settings: BakeSettings, place: int = 1, colours: bool = False, scale: float = 1e-3
) -> Any:
    """Adds the object of a baked face, so many faces' widths beside the rig. colours: show errors, red from `scale`, a
    share of the diagonal, on. Raises facebaker.Error, OSError; SettingsError if the face is not one of these settings."""
    import facebaker

    face = facebaker.load(archive)
    if [control.name for control in face.controls] != [control.name for control in settings.controls]:
        raise SettingsError(f"{archive}: has other controls than the settings")
    mesh = bpy.data.meshes.new(f"{settings.name} baked")
    mesh.from_pydata(face.rest_positions.tolist(), [], _polygons(face))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
    mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
    preview = bpy.data.objects.new(mesh.name, mesh)
    context.scene.collection.objects.link(preview)
    preview[ARCHIVE], preview[SETTINGS] = str(archive), json.dumps(settings_document(settings))
    preview[SCALE], preview[COLOURS] = scale, colours
    _place(preview, face, settings, place, scene_units(context.scene)[1])
    _add_materials(mesh, settings, colours)
    state = _loaded[preview.name] = FacePreview(preview, face, settings)
    context.view_layer.update()
    state.update(context.evaluated_depsgraph_get(), again=True)
    return preview


def _polygons(face: "facebaker.Face") -> List[List[int]]:
    ends = np.cumsum(face.polygon_sizes)
    corners = face.polygon_corners.tolist()
    return [corners[end - size : end] for size, end in zip(face.polygon_sizes.tolist(), ends.tolist())]


def _place(preview: Any, face: "facebaker.Face", settings: BakeSettings, place: int, factor: float) -> None:
    from mathutils import Matrix

    reference = find_object(settings.reference or settings.meshes[0])
    width = float(np.ptp(face.rest_positions[:, 0])) / factor
    beside = Matrix.Translation((BESIDE * place * width, 0, 0))
    preview.matrix_world = reference.matrix_world @ beside @ Matrix.Scale(1 / factor, 4)


def _add_materials(mesh: Any, settings: BakeSettings, colours: bool) -> None:
    """The rig's own, or one that shows errors."""
    if not colours:
        sources = [find_object(name).data for name in settings.meshes]
        slots: Dict[str, int] = {}
        indices: List[int] = []
        for source in sources:
            known = []
            for material in source.materials:
                if material is not None and material.name not in slots:
                    slots[material.name] = len(slots)
                    mesh.materials.append(material)
                known.append(slots[material.name] if material is not None else 0)
            indices += [known[p.material_index] if p.material_index < len(known) else 0 for p in source.polygons]
        if slots and len(indices) == len(mesh.polygons):
            mesh.polygons.foreach_set("material_index", indices)
        return
    material = bpy.data.materials.new("FaceBaker error")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    attribute = nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = ATTRIBUTE
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    mesh.materials.append(material)


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
    """Poses all preview objects of a scene. Called by Blender after updates and changes of the frame."""
    global _busy
    if _busy or SceneEvaluator.active:
        return
    _busy = True
    try:
        for scene_object in scene.objects:
            if ARCHIVE not in scene_object.keys() or not scene_object.visible_get():
                continue
            state = preview_of(scene_object)
            if state is not None:
                try:
                    state.update(graph, again)
                except SettingsError as error:
                    state.problem = str(error)
    finally:
        _busy = False


def _after_update(scene: Any, graph: Any = None) -> None:
    update_previews(scene, graph or bpy.context.evaluated_depsgraph_get())


def _after_load(_: Any, __: Any = None) -> None:
    _loaded.clear()


def add_handlers() -> None:
    """Has Blender call this module, also in files that are opened later."""
    handlers = bpy.app.handlers
    for handler in _after_update, _after_load:
        handlers.persistent(handler)
    for place, handler in _places():
        if handler not in getattr(handlers, place):
            getattr(handlers, place).append(handler)


def remove_handlers() -> None:
    """The reverse of add_handlers()."""
    for place, handler in _places():
        if handler in getattr(bpy.app.handlers, place):
            getattr(bpy.app.handlers, place).remove(handler)
    _loaded.clear()


def _places() -> Any:
    return ("depsgraph_update_post", _after_update), ("frame_change_post", _after_update), ("load_post", _after_load)
