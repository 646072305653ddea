"""Evaluates the scene as a rig: controls in, positions of the meshes' vertices out."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, List, Optional, Sequence, Tuple

import bpy
import numpy as np

from .bake_settings import BakeSettings
from .channels import SettingsError, bones_of
from .mesh_modifiers import count_changers, refuse_count_changers
from .scene_channels import SceneChannels, find_object
from .time_dependence import refuse_time_dependence

# Names of units, by their metres.
_UNITS = {1.0: "m", 0.1: "dm", 0.01: "cm", 0.001: "mm"}


def scene_units(scene: Any, reference: "np.ndarray[Any, Any]") -> Tuple[str, float]:
    """The name of the unit of positions, and what coordinates in the space of the reference are multiplied by to be in it.
    reference: (4, 4), from that space to the world. What importers of FBX bring often has objects that are scaled, such
    as a hundred times down: coordinates are then in centimetres."""
    scale = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    scale *= abs(float(np.linalg.det(reference[:3, :3]))) ** (1 / 3)
    for known, name in _UNITS.items():
        if abs(scale - known) <= 1e-5 * known:
            return name, 1.0
    return "m", scale


class SceneEvaluator:
    """The rig that settings describe, in the open file. Use it inside `with`: that prepares the scene (meshes shown,
    armatures posed, animation of controls still), and leaving it, also by an exception, restores all of it exactly.

    Attributes, valid inside: vertex_counts, of each mesh; diagonal, of the rest positions' bounding box; to_reference,
    (4, 4), from the world to the space of positions, which are multiplied by `scale` there. SceneEvaluator.active: how
    many are entered; previews wait until there is none."""

    active = 0

    def __init__(self, settings: BakeSettings, context: Any = None) -> None:
        self.settings = settings
        self.context = context or bpy.context
        self.vertex_counts: List[int] = []
        self._stack: Optional[contextlib.ExitStack] = None

    def __enter__(self) -> "SceneEvaluator":
        self._stack = contextlib.ExitStack()
        SceneEvaluator.active += 1
        self._stack.callback(self._count_down)
        try:
            self._prepare(self._stack)
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: Any) -> None:
        if self._stack:
            self._stack.close()
        self._stack = None

    @staticmethod
    def _count_down() -> None:
        SceneEvaluator.active -= 1

    def _prepare(self, stack: contextlib.ExitStack) -> None:
        if self.context.mode not in ("OBJECT", "POSE"):
            raise SettingsError(f"the scene is in {self.context.mode.lower()} mode; leave it for object or pose mode")
        settings = self.settings
        self.objects = [find_object(name) for name in settings.meshes]
        self.reference = find_object(settings.reference or settings.meshes[0])
        for mesh_object in self.objects:
            if mesh_object.type != "MESH":
                raise SettingsError(f'"{mesh_object.name}" is of type {mesh_object.type}, no mesh')
        self.channels = SceneChannels(settings.controls)
        state = self.channels.state()
        stack.callback(self._restore, state)
        self._show(stack)
        stack.callback(self._restore, state)  # first while all is shown: what is hidden would keep the last pose
        self._settle_modifiers(stack)
        self.rest_controls = np.array([control.rest for control in settings.controls], np.float32)
        self.pose_scene(self.rest_controls)
        # Positions are in the space that the reference has at rest: a face that it carries along moves.
        reference = world_matrix(self.evaluated(self.reference))
        self.to_reference = np.linalg.inv(reference)
        self.units, self.scale = scene_units(self.context.scene, reference)
        self.vertex_counts = [len(self.evaluated(mesh_object).data.vertices) for mesh_object in self.objects]
        if 0 in self.vertex_counts:
            raise SettingsError(f'"{settings.meshes[self.vertex_counts.index(0)]}" has no vertices')
        self.rest_positions = self.positions()
        self.diagonal = float(np.linalg.norm(np.ptp(self.rest_positions, 0)))

    def _show(self, stack: contextlib.ExitStack) -> None:
        """What is hidden is not evaluated."""
        armatures = [find_object(name) for name in dict.fromkeys(o for o, _ in bones_of(self.settings.controls))]
        for shown in [*self.objects, *armatures]:
            if shown.name not in self.context.view_layer.objects:
                raise SettingsError(f'"{shown.name}" is not in the view layer "{self.context.view_layer.name}"')
            if shown.hide_viewport:
                keep(stack, shown, "hide_viewport", False)
            if shown.hide_get():
                shown.hide_set(False)
                stack.callback(shown.hide_set, True)
            if shown.type == "ARMATURE" and shown.data.pose_position != "POSE":
                keep(stack, shown.data, "pose_position", "POSE")

    def _restore(self, state: List[Any]) -> None:
        """Brings the controls back. An update that shows or hides objects runs their animation, which would undo edits
        that have no key: then they are set again."""
        for _ in range(2):
            self.channels.restore(state)
            self.context.view_layer.update()
            if self.channels.state() == state:
                break

    def _settle_modifiers(self, stack: contextlib.ExitStack) -> None:
        for mesh_object in self.objects:
            refuse_time_dependence(mesh_object)
            if self.settings.modifiers == "refuse":
                refuse_count_changers(self.context, mesh_object)
            elif self.settings.modifiers == "off":
                for modifier in count_changers(self.context, mesh_object):
                    keep(stack, modifier, "show_viewport", False)

    def pose_scene(self, controls: "np.ndarray[Any, Any]") -> None:
        """Has the scene evaluated with these values of the controls (controls,)."""
        self.channels.write(controls)
        self.context.view_layer.update()
        self._graph = self.context.evaluated_depsgraph_get()

    def evaluated(self, scene_object: Any) -> Any:
        """The object as the dependency graph has it now."""
        return scene_object.evaluated_get(self._graph)

    def positions(self) -> "np.ndarray[Any, np.dtype[np.float32]]":
        """(vertices, 3), float32, of the scene as it is evaluated now. Raises SettingsError if a mesh has another number
        of vertices than at rest."""
        return evaluated_positions(self.objects, self._graph, self.to_reference, self.scale, self.vertex_counts)

    def evaluate(
        self, controls: "np.ndarray[Any, Any]", step: Optional[Callable[[int], Any]] = None
    ) -> "np.ndarray[Any, np.dtype[np.float32]]":
        """(poses, controls) -> (poses, vertices, 3), float32, in `units`, in the reference's space. step: called with the
        number of poses done."""
        result = np.empty((len(controls), *self.rest_positions.shape), np.float32)
        for pose, values in enumerate(np.asarray(controls, np.float32)):
            self.pose_scene(values)
            result[pose] = self.positions()
            if step:
                step(pose + 1)
        return result


def evaluated_positions(
    objects: Sequence[Any], graph: Any, to_reference: Any, scale: float, counts: Sequence[int] = ()
) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(vertices, 3), float32, of mesh objects as a dependency graph has them, one after the other. to_reference: (4, 4),
    from the world to the space of positions, which are multiplied by scale. counts: how many vertices each object has to
    have, if anybody knows; another number raises SettingsError."""
    parts: List[Any] = []
    for index, mesh_object in enumerate(objects):
        evaluated = mesh_object.evaluated_get(graph)
        vertices = evaluated.data.vertices
        if counts and len(vertices) != counts[index]:
            raise SettingsError(
                f'"{mesh_object.name}" has {len(vertices)} vertices in this pose, {counts[index]} at rest'
            )
        parts.append(transformed(mesh_points(evaluated), to_reference @ world_matrix(evaluated), scale))
    joined: "np.ndarray[Any, np.dtype[np.float32]]" = parts[0] if len(parts) == 1 else np.concatenate(parts)
    return joined


def mesh_points(evaluated: Any) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(vertices, 3), of an evaluated mesh object, in its own space."""
    vertices = evaluated.data.vertices
    local = np.empty(3 * len(vertices), np.float32)
    vertices.foreach_get("co", local)
    return local.reshape(-1, 3)


def transformed(points: Any, matrix: Any, scale: float) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(points, 3), taken to another space by a matrix (4, 4) and multiplied by scale. Where both change nothing, points keep
    their bits."""
    if scale != 1 or not np.allclose(matrix, np.eye(4), rtol=0, atol=1e-7):
        linear, offset = (scale * matrix[:3, :3].T).astype("f4"), (scale * matrix[:3, 3]).astype("f4")
        points = points @ linear + offset
    moved: "np.ndarray[Any, np.dtype[np.float32]]" = points
    return moved


def world_matrix(scene_object: Any) -> "np.ndarray[Any, np.dtype[np.float64]]":
    """(4, 4), from the object's space to the world."""
    return np.array(scene_object.matrix_world, np.float64)


def keep(stack: contextlib.ExitStack, owner: Any, attribute: str, value: Any) -> None:
    """Sets an attribute until the stack is closed."""
    stack.callback(setattr, owner, attribute, getattr(owner, attribute))
    setattr(owner, attribute, value)
