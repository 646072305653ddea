"""The scene as a facebaker.Rig."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Tuple

import bpy
import numpy as np

from .action_shots import shot_values
from .bake_settings import BakeSettings
from .control_names import other_side
from .scene_evaluator import SceneEvaluator
from .scene_joints import SceneJoints

if TYPE_CHECKING:
    import facebaker


def scene_rig(evaluator: SceneEvaluator, version: str = "") -> "facebaker.Rig":
    """The rig of an evaluator that has been entered, with its shots as clips. version: of the deformation, see
    facebaker.Rig."""
    import facebaker

    settings = evaluator.settings
    meshes, polygons, uvs, uv_polygons, materials = _surfaces(evaluator)
    controls = [
        facebaker.Control(c.name, c.group, c.minimum, c.maximum, c.rest, unit=c.channel.unit, mirror=c.mirror)
        for c in settings.controls
    ]
    found = SceneJoints(evaluator) if settings.driven_joints == "keep" else None
    return facebaker.Rig(
        controls,
        _skinned(evaluator, found) if found and found.joints else evaluator.evaluate,
        name=settings.name,
        units=evaluator.units,
        up_axis="z",
        rest_positions=evaluator.rest_positions,
        polygons=polygons,
        uvs=uvs,
        uv_polygons=uv_polygons,
        meshes=meshes,
        materials=materials,
        joints=found.joints if found else (),
        skin=found.skin if found else None,
        skinned=bool(found and found.joints),
        clips=scene_clips(settings),
        version=version,
        notes=[*_notes(settings), *(found.notes if found else ())],
    )


def _skinned(evaluator: SceneEvaluator, found: SceneJoints) -> Any:
    """Of controls (poses, controls): positions and frames of joints, as facebaker.Rig takes them."""

    def evaluate(controls: Any) -> Tuple[Any, Any]:
        frames = np.empty((len(controls), len(found.joints), 3, 4), np.float32)

        def keep_frames(done: int) -> None:
            frames[done - 1] = found.frames()[:, :3]

        return evaluator.evaluate(controls, keep_frames), frames

    return evaluate


def scene_clips(settings: BakeSettings) -> "List[facebaker.Clip]":
    """The shots as clips of controls."""
    import facebaker

    render = bpy.context.scene.render
    fps = render.fps / render.fps_base
    return [
        facebaker.Clip(shot.action, shot_values(settings, shot), split=shot.split, fps=fps) for shot in settings.shots
    ]


def _notes(settings: BakeSettings) -> List[str]:
    sided = [c for c in settings.controls if c.channel.bone and other_side(c.channel.bone) and not c.mirror]
    notes = []
    if not settings.shots:
        notes.append("the file has no actions that animate these controls, so errors are of drawn poses alone")
    if len(sided) == len(settings.controls) and sided:
        notes.append("no control has a mirror partner")
    return notes


def _surfaces(evaluator: SceneEvaluator) -> "Tuple[Any, Any, Any, Any, Any]":
    """Meshes, polygons (-1 behind the last corner), texture coordinates and their polygons, materials."""
    import facebaker

    meshes: List[Any] = []
    rows: List[Any] = []
    uv_rows: List[Any] = []
    uvs: List[Any] = []
    materials: Dict[str, Tuple[int, Any]] = {}
    first_vertex = first_uv = 0
    mapped = any(evaluator.evaluated(mesh_object).data.uv_layers.active for mesh_object in evaluator.objects)
    for mesh_object in evaluator.objects:
        evaluated = evaluator.evaluated(mesh_object)
        data = evaluated.data
        sizes, corners = _polygons(data)
        coordinates, uv_corners = _uvs(data, corners)
        runs = _material_runs(evaluated, materials)
        meshes.append(facebaker.Mesh(mesh_object.name, len(data.vertices), len(sizes), runs))
        rows.append(_padded(sizes, corners + first_vertex))
        uv_rows.append(_padded(sizes, uv_corners + first_uv))
        uvs.append(coordinates)
        first_vertex += len(data.vertices)
        first_uv += len(coordinates)
    width = max((row.shape[1] for row in rows), default=0)
    return (
        meshes,
        np.concatenate([_widened(row, width) for row in rows]),
        np.concatenate(uvs) if mapped else None,
        np.concatenate([_widened(row, width) for row in uv_rows]) if mapped else None,
        [material for _, material in materials.values()],
    )


def _polygons(data: Any) -> Tuple[Any, Any]:
    sizes = np.empty(len(data.polygons), np.int32)
    corners = np.empty(len(data.loops), np.int32)
    data.polygons.foreach_get("loop_total", sizes)
    data.loops.foreach_get("vertex_index", corners)
    return sizes, corners


def _uvs(data: Any, corners: Any) -> Tuple[Any, Any]:
    """Texture coordinates, each pair of a vertex once, and those of the corners. One pair, for all
    corners, where a mesh has none: the meshes of a character all have some, or none has."""
    layer = data.uv_layers.active
    if layer is None:
        return np.zeros((1, 2), np.float32), np.zeros(len(corners), np.int32)
    pairs = np.empty(2 * len(corners), np.float32)
    layer.data.foreach_get("uv", pairs)
    keyed = np.column_stack([corners.astype(np.float64), pairs.reshape(-1, 2)])
    unique, inverse = np.unique(keyed, axis=0, return_inverse=True)
    return unique[:, 1:].astype(np.float32), inverse.reshape(-1).astype(np.int32)


def _padded(sizes: Any, corners: Any) -> Any:
    """Polygons as rows of one width, with -1 behind the last corner of those that have fewer."""
    rows = np.full((len(sizes), int(sizes.max(initial=3))), -1, np.int32)
    rows[np.arange(rows.shape[1])[None] < sizes[:, None]] = corners
    return rows


def _widened(rows: Any, width: int) -> Any:
    return np.pad(rows, ((0, 0), (0, width - rows.shape[1])), constant_values=-1)


def _material_runs(mesh_object: Any, materials: Dict[str, Tuple[int, Any]]) -> Tuple[Any, ...]:
    """Runs of polygons of one material, and the materials that are met first here."""
    import facebaker

    polygons = mesh_object.data.polygons
    slots = np.zeros(len(polygons), np.int32)
    polygons.foreach_get("material_index", slots)
    if not len(polygons) or not any(slot.material for slot in mesh_object.material_slots):
        return ()
    starts = [0, *(np.flatnonzero(np.diff(slots)) + 1).tolist()]
    runs = []
    for start, end in zip(starts, [*starts[1:], len(slots)]):
        slot = int(slots[start])
        material = mesh_object.material_slots[slot].material if slot < len(mesh_object.material_slots) else None
        index = None
        if material is not None:
            known = materials.setdefault(material.name, (len(materials), _material(material)))
            index = known[0]
        runs.append(facebaker.MaterialRun(end - start, index))
    return tuple(runs)


def _material(material: Any) -> Any:
    """Colour, metallic and roughness of the shader where they are plain numbers, else of the viewport."""
    import facebaker

    colour, metallic, roughness = tuple(material.diffuse_color), float(material.metallic), float(material.roughness)
    # Without nodes there may be a tree that is not used, until Blender 5.
    used = material.node_tree and (bpy.app.version >= (5, 0, 0) or material.use_nodes)
    nodes = material.node_tree.nodes if used else ()
    for node in nodes:
        if node.type == "BSDF_PRINCIPLED":
            inputs = node.inputs
            colour = tuple(inputs["Base Color"].default_value) if not inputs["Base Color"].is_linked else colour
            metallic = float(inputs["Metallic"].default_value) if not inputs["Metallic"].is_linked else metallic
            roughness = float(inputs["Roughness"].default_value) if not inputs["Roughness"].is_linked else roughness
            break
    colour = tuple(min(max(float(part), 0.0), 1.0) for part in colour)
    return facebaker.Material(material.name, colour, metallic, roughness)
