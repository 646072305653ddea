"""Measures a baked face against its rig, in one process: errors, those of linear blendshapes, and the time of both."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Dict, List, Optional

import numpy as np

from .action_shots import shot_values
from .channels import SettingsError
from .scene_evaluator import SceneEvaluator
from .shown_lengths import length_text

if TYPE_CHECKING:
    import facebaker

Array = Any  # of NumPy


@dataclass
class PoseErrors:
    """Errors over a set of poses. mse: mean of squared distances of vertices, over the squared diagonal of the rest mesh.
    max: the largest distance, over the diagonal. linear_mse: the mse of linear blendshapes, None if not measured."""

    name: str
    poses: int
    mse: float
    max: float
    linear_mse: Optional[float] = None


@dataclass
class FaceMeasure:
    """errors: of each test shot, and of drawn poses. rig_ms, face_ms: medians of the time of one pose: setting controls,
    updating the dependency graph and reading positions; and evaluating the archive, on one thread. rig_cpu_ms,
    face_cpu_ms: means of the processor time that they took, which a busy machine does not lengthen. batch_ms: of a
    pose among many, on all cores."""

    diagonal: float
    units: str
    rig_ms: float = 0.0
    face_ms: float = 0.0
    rig_cpu_ms: float = 0.0
    face_cpu_ms: float = 0.0
    batch_ms: float = 0.0
    errors: List[PoseErrors] = field(default_factory=list)

    @property
    def times_faster(self) -> float:
        return self.rig_ms / self.face_ms if self.face_ms else 0.0

    @property
    def times_cheaper(self) -> float:
        return self.rig_cpu_ms / self.face_cpu_ms if self.face_cpu_ms else 0.0

    def document(self) -> Dict[str, Any]:
        return {**asdict(self), "times_faster": self.times_faster, "times_cheaper": self.times_cheaper}

    def _worst(self, errors: PoseErrors) -> str:
        """How far the worst vertex is off."""
        return f"worst vertex off by {length_text(errors.max * self.diagonal, self.units)}"

    def lines(self) -> List[str]:
        """For people."""
        lines = []
        for errors in self.errors:
            line = f"{errors.name}: {errors.poses} poses, {self._worst(errors)}, {errors.max:.2e}, mse {errors.mse:.2e}"
            if errors.linear_mse is not None and errors.mse > 0:
                line += f"; linear blendshapes {errors.linear_mse:.2e}, {errors.linear_mse / errors.mse:.1f} times as much"
            lines.append(line)
        return [*lines, *self.time_lines()]

    def time_lines(self) -> List[str]:
        return [
            f"a pose of the rig: {self.rig_ms:.2f} ms, {self.rig_cpu_ms:.2f} of a processor",
            f"of the face: {self.face_ms:.3f} ms, {self.face_cpu_ms:.3f} of a processor",
            f"{self.times_faster:.0f} times faster, by processor time {self.times_cheaper:.0f}",
            f"in batches: {self.batch_ms:.3f} ms",
        ]

    def short_lines(self) -> List[str]:
        """For the panel, which is narrow."""
        return [
            *(f"{errors.name}: {self._worst(errors)}" for errors in self.errors),
            f"rig: {self.rig_ms:.2f} ms a pose",
            f"face: {self.face_ms:.3f} ms a pose",
            f"{self.times_faster:.0f} times faster",
        ]


class LinearShapes:
    """Linear blendshapes of a rig: the displacement at either end of each control's range, scaled by the control."""

    def __init__(self, evaluator: SceneEvaluator) -> None:
        controls = evaluator.settings.controls
        self._rest_controls, self._rest = evaluator.rest_controls, evaluator.rest_positions
        self._spans: List[Array] = []
        self._shapes: List[Array] = []
        for end in "minimum", "maximum":
            ends = np.array([getattr(control, end) for control in controls], np.float32)
            shapes = np.zeros((len(controls), self._rest.size), np.float32)
            for index in np.flatnonzero(ends != self._rest_controls):
                pose = self._rest_controls.copy()
                pose[index] = ends[index]
                shapes[index] = (evaluator.evaluate(pose[None])[0] - self._rest).ravel()
            self._spans.append(np.abs(ends - self._rest_controls))
            self._shapes.append(shapes)

    def evaluate(self, controls: Array) -> Array:
        """(poses, controls) -> (poses, vertices, 3)."""
        away = controls - self._rest_controls
        result = np.repeat(self._rest.ravel()[None], len(controls), 0)
        for sign, span, shapes in zip((-1, 1), self._spans, self._shapes):
            weights = np.maximum(sign * away, 0) / np.where(span > 0, span, 1)
            result += weights.astype(np.float32) @ shapes
        return result.reshape(len(controls), -1, 3)


def drawn_poses(evaluator: SceneEvaluator, count: int, seed: int) -> Array:
    """(count, controls), float32: poses with a tenth to half of the controls off rest, anywhere within their ranges."""
    random = np.random.default_rng(seed)
    controls = evaluator.settings.controls
    low, high = (np.array([getattr(c, end) for c in controls], np.float32) for end in ("minimum", "maximum"))
    share = random.uniform(0.1, 0.5, (count, 1))
    moved = random.uniform(size=(count, len(controls))) < share
    values = random.uniform(low, high, (count, len(controls)))
    return np.where(moved, values, evaluator.rest_controls).astype(np.float32)


def check_face(face: "facebaker.Face", evaluator: SceneEvaluator) -> None:
    """Raises SettingsError if the face is not one of this rig."""
    names = [control.name for control in evaluator.settings.controls]
    theirs = [control.name for control in face.controls]
    if names != theirs:
        differing = sorted(set(names) ^ set(theirs))
        what = f'"{differing[0]}" is not in both' if differing else "in another order"
        raise SettingsError(f"the face has other controls than the settings: {what}")
    if face.vertex_count != len(evaluator.rest_positions):
        raise SettingsError(f"the face has {face.vertex_count} vertices, the scene {len(evaluator.rest_positions)}")


def measure_face(
    face: "facebaker.Face", evaluator: SceneEvaluator, drawn: int = 200, seed: int = 7, linear: bool = True
) -> FaceMeasure:
    """Errors on all test shots and on so many drawn poses, and times. The scene evaluator has been entered."""
    check_face(face, evaluator)
    settings = evaluator.settings
    sets = {shot.action: shot_values(settings, shot) for shot in settings.shots if shot.split == "test"}
    if drawn:
        sets["drawn poses"] = drawn_poses(evaluator, drawn, seed)
    shapes = LinearShapes(evaluator) if linear and sets else None
    result = FaceMeasure(evaluator.diagonal, evaluator.units)
    rig_times: List[float] = []
    used = 0.0
    for name, controls in sets.items():
        begin = time.process_time()
        positions = _timed_evaluation(evaluator, controls, rig_times)
        used += time.process_time() - begin
        errors = _errors(name, face.evaluate_batch(controls), positions, evaluator.diagonal)
        if shapes is not None:
            errors.linear_mse = _errors(name, shapes.evaluate(controls), positions, evaluator.diagonal).mse
        result.errors.append(errors)
    if not rig_times:
        raise SettingsError("nothing to measure on: there are no test shots, and no poses are drawn")
    result.rig_ms, result.rig_cpu_ms = 1e3 * float(np.median(rig_times)), 1e3 * used / len(rig_times)
    _measure_face_times(face, result, next(iter(sets.values())))
    return result


def _timed_evaluation(evaluator: SceneEvaluator, controls: Array, times: List[float]) -> Array:
    """The rig's positions, and the seconds that each pose took."""
    marks = [time.perf_counter()]
    positions = evaluator.evaluate(controls, lambda _: marks.append(time.perf_counter()))
    times += np.diff(marks).tolist()
    return positions


def _measure_face_times(face: "facebaker.Face", result: FaceMeasure, poses: Array) -> None:
    out = np.empty((face.vertex_count, 3), np.float32)
    many = np.resize(poses, (max(400, len(poses)), poses.shape[1]))
    used, marks = time.process_time(), [time.perf_counter()]
    for pose in many:
        face.evaluate(pose, out)
        marks.append(time.perf_counter())
    result.face_cpu_ms = 1e3 * (time.process_time() - used) / len(many)
    result.face_ms = 1e3 * float(np.median(np.diff(marks)))
    face.evaluate_batch(many)
    begin = time.perf_counter()
    face.evaluate_batch(many)
    result.batch_ms = 1e3 * (time.perf_counter() - begin) / len(many)


def _errors(name: str, positions: Array, true: Array, diagonal: float) -> PoseErrors:
    squared = ((positions.astype(np.float64) - true) ** 2).sum(-1) / diagonal**2
    return PoseErrors(name, len(true), float(squared.mean()), float(np.sqrt(squared.max())))
