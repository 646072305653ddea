"""Solving the poses of a clip, one after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional

import numpy as np

from ._arrays import Controls, floats
from ._errors import Error
from ._solutions import Solution

if TYPE_CHECKING:
    from ._solver import Solver

FRAME = (3, 4)


class ClipTargets:
    """Targets and weights by pose, checked."""

    def __init__(self, solver: Solver, targets: Any, distances: Any, frames: Any, weights: Any) -> None:
        given = {
            "targets": (targets, (None, solver.point_count, 3)),
            "distances": (distances, (None, solver.pair_count)),
            "frames": (frames, (None, solver.frame_count, *FRAME)),
        }
        if np.ndim(weights) != 1:
            given["weights"] = (weights, (None, solver.point_count))
        self._by_pose = {
            name: floats(array, shape, name) for name, (array, shape) in given.items() if array is not None
        }
        self._shared = {"weights": weights} if np.ndim(weights) == 1 else {}
        counts = {name: len(array) for name, array in self._by_pose.items()}
        if not counts.keys() - {"weights"}:
            raise ValueError("a clip needs targets, distances or frames")
        if len(set(counts.values())) > 1:
            raise ValueError(f"poses differ: {', '.join(f'{name} of {count}' for name, count in counts.items())}")
        self._count = next(iter(counts.values()))

    def __len__(self) -> int:
        return self._count

    def of_pose(self, pose: int) -> Dict[str, Any]:
        """Arguments of Solver.solve."""
        return {**self._shared, **{name: array[pose] for name, array in self._by_pose.items()}}


class ClipSweep:
    """Goes through the poses of a clip. found: by pose, once it has gone forwards. before: what smoothness holds the first
    pose to, or None. options: of Solver.solve, for all poses."""

    def __init__(
        self,
        solver: Solver,
        targets: ClipTargets,
        smoothness: float,
        before: Optional[Controls],
        options: Dict[str, Any],
    ) -> None:
        self.found: List[Solution] = []
        self._solver, self._targets, self._smoothness, self._options = solver, targets, smoothness, options
        self._before = before

    def go_forwards(self, start: Optional[Controls], motion: Any) -> None:
        """Each pose starts from the one before it, and is held to it."""
        before = self._before
        for pose in range(len(self._targets)):
            self.found.append(self._solve(pose, start, motion, before))
            before = start = self.found[pose].controls
            motion = self.found[pose].motion

    def go_backwards(self) -> None:
        """Each pose but the last, which has one neighbour alone, starts from where it is, and is held to both neighbours."""
        for pose in range(len(self.found) - 2, -1, -1):
            before = self.found[pose - 1].controls if pose > 0 else self._before
            one = self.found[pose]
            self.found[pose] = self._solve(pose, one.controls, one.motion, before, self.found[pose + 1].controls)

    def _solve(self, pose: int, start: Any, motion: Any, *neighbours: Optional[Controls]) -> Solution:
        held = [self._solver.face._one_pose(controls) for controls in neighbours if controls is not None]
        try:
            # The sum of two quadratic terms is one around their mean with twice the weight, and a constant.
            return self._solver.solve(
                **self._targets.of_pose(pose),
                start=start,
                motion=motion,
                before=np.mean(held, 0) if held else None,
                smoothness=self._smoothness * max(len(held), 1),
                **self._options,
            )
        except Error as error:
            raise type(error)(error.status, error.status_name, f"pose {pose}: {error}") from None
