"""Shapes that a face is solved for: mesh objects of the scene that have the vertices of the face, or of some of its
meshes."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generator, List, Optional, Sequence, Tuple

import numpy as np

from .bake_settings import BakeSettings
from .channels import SettingsError
from .mesh_modifiers import count_changers
from .scene_channels import SceneChannels, find_object
from .scene_evaluator import SceneEvaluator, keep, mesh_points, transformed, world_matrix
from .solve_request import WHOLE, matched_meshes

if TYPE_CHECKING:
    import facebaker

_ARCHIVE = "facebaker_archive"  # the property of a baked face's object, whose mesh is in the face's own space
Matrix = Any  # (4, 4), float64


class _RestSpaces(SceneEvaluator):
    """The spaces of a rig's meshes at rest. Modifiers may be any: no vertex is asked for."""

    def _settle_modifiers(self, stack: contextlib.ExitStack) -> None:
        pass


@dataclass(frozen=True)
class _Part:
    """An object, and which vertices of the face it has the shape of. matrix: from the object's space to the face's but for
    units; None: as the object stands in the scene."""

    name: str
    first: int
    count: int
    matrix: Optional[Matrix]
    scale: float


class SolveShapes:
    """The shapes of selected meshes, as positions of a face. Use it inside `with`: leaving it restores the frame, the
    controls and what the viewport shows.

    Attributes: missing, names of the face's meshes that have no shape."""

    def __init__(self, context: Any, settings: BakeSettings, face: "facebaker.Face", in_world: bool) -> None:
        self.context, self.settings, self._in_world = context, settings, in_world
        self._meshes = [(name, mesh.vertices) for name, mesh in zip(settings.meshes, face.meshes)]
        self._count = int(face.vertex_count)
        if len(self._meshes) != len(face.meshes) or len(self._meshes) != len(settings.meshes):
            raise SettingsError(f"the face has {len(face.meshes)} meshes, its settings {len(settings.meshes)}")
        self.missing: List[str] = []
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> "SolveShapes":
        try:
            self._prepare()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: Any) -> None:
        self._stack.close()

    def _prepare(self) -> None:
        objects = self._chosen()
        self._show(objects)
        counts = [(shape.name, self._settled_count(shape)) for shape in objects]
        found = matched_meshes(counts, self._meshes)
        self.missing = [] if WHOLE in found else [mesh[0] for i, mesh in enumerate(self._meshes) if i not in found]
        with _RestSpaces(self.settings, self.context) as rest:
            self._to_reference, self._scale = rest.to_reference, rest.scale
            spaces = [rest.to_reference @ world_matrix(rest.evaluated(find_object(name))) for name in self.settings.meshes]
        starts = np.cumsum([0, *(count for _, count in self._meshes)])
        self._parts = [
            self._part(shape, count, int(starts[max(index, 0)]), spaces[max(index, 0)])
            for shape, (_, count), index in zip(objects, counts, found)
        ]

    def _part(self, shape: Any, count: int, first: int, space: Matrix) -> _Part:
        if self._in_world:
            return _Part(shape.name, first, count, None, self._scale)
        if _ARCHIVE in shape.keys():
            return _Part(shape.name, first, count, np.eye(4), 1.0)
        return _Part(shape.name, first, count, space, self._scale)

    def _chosen(self) -> List[Any]:
        """The active mesh if it has the vertices of the whole face; else the selected meshes, or of several meshes those
        that are selected."""
        active = self.context.view_layer.objects.active
        if active is None or active.type != "MESH":
            raise SettingsError("no mesh is active: select the mesh whose shape the face is to take")
        if len(active.data.vertices) == self._count:
            return [active]
        others = [found for found in self.context.selected_objects if found.type == "MESH" and found != active]
        return [active, *others]

    def _show(self, objects: Sequence[Any]) -> None:
        """What is hidden is not evaluated."""
        for shape in objects:
            if shape.name not in self.context.view_layer.objects:
                raise SettingsError(f'"{shape.name}" is not in the view layer "{self.context.view_layer.name}"')
            if shape.hide_viewport:
                keep(self._stack, shape, "hide_viewport", False)
            if shape.hide_get():
                shape.hide_set(False)
                self._stack.callback(shape.hide_set, True)
        self.context.view_layer.update()

    def _settled_count(self, shape: Any) -> int:
        """How many vertices a shape has as it is evaluated, without the modifiers that were switched off for the bake.
        Raises SettingsError that names modifiers which keep it from having those of the face."""
        sizes = [self._count, *(count for _, count in self._meshes)]
        count = len(shape.evaluated_get(self.context.evaluated_depsgraph_get()).data.vertices)
        own = len(shape.data.vertices)
        if count in sizes or own not in sizes:
            return count
        changers = count_changers(self.context, shape)
        if self.settings.modifiers != "off":
            names = ", ".join(f'"{modifier.name}" ({modifier.type})' for modifier in changers)
            raise SettingsError(
                f'"{shape.name}": modifiers make {count:,} vertices of its {own:,}, which are those of the face: {names}; '
                "switch them off in the viewport"
            )
        for modifier in changers:
            keep(self._stack, modifier, "show_viewport", False)
        self.context.view_layer.update()
        return own

    def positions(self) -> "np.ndarray[Any, np.dtype[np.float32]]":
        """(vertices, 3), float32, of the face, in its units and space, as the shapes are evaluated now; NaN where there is
        none. Raises SettingsError if a shape has another number of vertices now, or one that is not finite."""
        graph = self.context.evaluated_depsgraph_get()
        result = np.full((self._count, 3), np.nan, np.float32)
        for part in self._parts:
            evaluated = find_object(part.name).evaluated_get(graph)
            points, frame = mesh_points(evaluated), self.context.scene.frame_current
            if len(points) != part.count:
                raise SettingsError(
                    f'"{part.name}" has {len(points):,} vertices in frame {frame}, and had {part.count:,} before'
                )
            if not np.isfinite(points).all():
                vertex = int(np.flatnonzero(~np.isfinite(points).all(1))[0])
                raise SettingsError(f'"{part.name}": vertex {vertex} is nowhere in frame {frame}')
            matrix = part.matrix if part.matrix is not None else self._to_reference @ world_matrix(evaluated)
            result[part.first : part.first + part.count] = transformed(points, matrix, part.scale)
        return result

    def frames(self, frames: Optional[Tuple[int, int]]) -> "Generator[np.ndarray[Any, np.dtype[np.float32]], None, None]":
        """positions() as they are now, or of each frame from the first to the last. Afterwards, also when it is closed before
        its end, the frame and the controls are as they were."""
        if frames is None:
            yield self.positions()
            return
        scene, was = self.context.scene, self.context.scene.frame_current
        channels = SceneChannels(self.settings.controls)
        state = channels.state()
        try:
            for frame in range(frames[0], frames[1] + 1):
                scene.frame_set(frame)
                self.context.view_layer.update()  # of meshes that handlers of the frame have changed
                yield self.positions()
        finally:
            scene.frame_set(was)
            channels.restore(state)  # edits without a key
            self.context.view_layer.update()
