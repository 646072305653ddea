"""What solving found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np
import numpy.typing as npt

from ._arrays import Floats


@dataclass(frozen=True, eq=False)
class Solution:
    """The controls that were found for one pose.

    controls: (controls,), float32, within ranges. motion: (3, 4), float32, the frame of the head, which takes positions of
    the face to the targets as to_face leaves them; None unless it was asked for. rms_difference, max_difference: the root
    mean square distance and the largest of points from their targets, in units. worst_point: the farthest; None without
    targets of points. point_count: how many had a target. point_differences: (points,), float32, the distance of each; NaN
    where there was no target. iterations: how often derivatives were found. converged: whether it ended before
    max_iterations. objective: what was minimised. decided: (controls,), float32, the share of what decides each control that
    comes from the targets, from 0, nothing but preferences, to 1; None unless it was asked for."""

    controls: Floats
    motion: Optional[Floats]
    rms_difference: float
    max_difference: float
    worst_point: Optional[int]
    point_count: int
    point_differences: Floats
    iterations: int
    converged: bool
    objective: float
    decided: Optional[Floats]

    def __repr__(self) -> str:
        ended = "converged" if self.converged else "not converged"
        return (
            f"<facebaker.Solution: {self.point_count} points, rms {self.rms_difference:.3g}, "
            f"max {self.max_difference:.3g}, {ended} after {self.iterations} iterations>"
        )


@dataclass(frozen=True, eq=False)
class ClipSolution:
    """The controls that were found for the poses of a clip; the fields are those of Solution, with one row a pose.

    controls: (poses, controls). motions: (poses, 3, 4), or None. rms_differences, max_differences: (poses,), in units.
    worst_points: (poses,), -1 for a pose without targets of points. point_differences: (poses, points). iterations, converged: (poses,).
    decided: (poses, controls), or None."""

    controls: Floats
    motions: Optional[Floats]
    rms_differences: Floats
    max_differences: Floats
    worst_points: npt.NDArray[np.int64]
    point_differences: Floats
    iterations: npt.NDArray[np.int64]
    converged: npt.NDArray[np.bool_]
    decided: Optional[Floats]

    def __repr__(self) -> str:
        worst = float(self.max_differences.max(initial=0))
        return (
            f"<facebaker.ClipSolution: {len(self.controls)} poses, max {worst:.3g}, "
            f"{int(self.converged.sum())} converged>"
        )


def clip_solution(poses: Sequence[Solution], control_count: int, point_count: int) -> ClipSolution:
    """Stacks them; those of one clip have motions and what is decided all, or none of them does."""

    def stacked(field: str, shape: Sequence[int]) -> Any:
        rows = [getattr(pose, field) for pose in poses]
        return None if any(row is None for row in rows) else np.array(rows, np.float32).reshape(len(rows), *shape)

    return ClipSolution(
        controls=stacked("controls", [control_count]),
        motions=stacked("motion", [3, 4]) if poses else None,
        rms_differences=stacked("rms_difference", []),
        max_differences=stacked("max_difference", []),
        worst_points=np.array([-1 if p.worst_point is None else p.worst_point for p in poses], np.int64),
        point_differences=stacked("point_differences", [point_count]),
        iterations=np.array([pose.iterations for pose in poses], np.int64),
        converged=np.array([pose.converged for pose in poses], np.bool_),
        decided=stacked("decided", [control_count]) if poses else None,
    )
