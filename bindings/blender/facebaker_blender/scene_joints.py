"""The bones that the controls move and meshes follow, as joints of the baked face."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Set, Tuple

import numpy as np

from .channels import NAMED
from .joint_motion import NUMBERS, can_be_followed, joint_numbers, number_reach, upright
from .mesh_skins import Bone, MeshSkin, mesh_skin
from .scene_channels import find_object
from .scene_evaluator import SceneEvaluator, world_matrix

if TYPE_CHECKING:
    import facebaker

POSES = 32  # that numbers of joints are looked for in
# Of the diagonal: a number that moves what follows its joint by less is left to displacements. Frames of Rigify's bones
# that stretch are off by up to a third of that.
MOVES = 1e-5
UNBOUND = 1e-3  # of the diagonal: bones that take vertices further at rest from where they are bound are told


class SceneJoints:
    """The joints of an evaluator that has been entered, and how vertices follow them.

    Joints are the bones that meshes follow, and those above at least two of these. What moves with the joint above it
    is no joint of its own, and what no control moves is none: vertices stay there. Which numbers a joint has is found
    in a few drawn poses, in which every control moves. Evaluates POSES + 1 poses.

    Attributes: joints, of class facebaker.Joint; skin, facebaker.Skin, None where there are no joints; notes, what is
    left to displacements."""

    def __init__(self, evaluator: SceneEvaluator) -> None:
        self._evaluator = evaluator
        self._far = UNBOUND * evaluator.diagonal
        self.joints: "List[facebaker.Joint]" = []
        self.skin: "Optional[facebaker.Skin]" = None
        self.notes: List[str] = []
        self._bones: List[Bone] = []  # of each joint
        skins = self._skins()
        followed = list(dict.fromkeys(bone for skin in skins for bone in skin.bones))
        if followed:
            self._find(skins, followed)

    def frames(self) -> "np.ndarray[Any, np.dtype[np.float64]]":
        """(joints, 4, 4): where the joints are, in the space of positions, as the scene is evaluated now."""
        frames: "np.ndarray[Any, np.dtype[np.float64]]" = self._frames_of(self._bones)
        return frames

    def _skins(self) -> List[MeshSkin]:
        skins = []
        for mesh_object in self._evaluator.objects:
            skins.append(mesh_skin(mesh_object, self._evaluator.evaluated(mesh_object)))
            if skins[-1].reason:
                self.notes.append(f'"{mesh_object.name}" follows no joints: {skins[-1].reason}; blendshapes move it')
        return skins

    def _frames_of(self, bones: Sequence[Bone], bound: bool = False) -> Any:
        """(bones, 4, 4), as the scene is evaluated now, or where meshes were bound to them."""
        evaluator = self._evaluator
        frames = np.empty((len(bones), 4, 4))
        for name in dict.fromkeys(armature for armature, _ in bones):
            armature = evaluator.evaluated(find_object(name))
            posed = armature.data.bones if bound else armature.pose.bones
            matrices = np.empty(16 * len(posed), np.float32)
            posed.foreach_get("matrix_local" if bound else "matrix", matrices)
            here = [place for place, (of, _) in enumerate(bones) if of == name]
            numbers = [posed.find(bones[place][1]) for place in here]
            local = matrices.reshape(-1, 4, 4)[numbers].transpose(0, 2, 1).astype(np.float64)
            frames[here] = evaluator.to_reference @ world_matrix(armature) @ local
        frames[:, :3, 3] *= evaluator.scale
        return frames

    def _find(self, skins: Sequence[MeshSkin], followed: Sequence[Bone]) -> None:
        """Fills joints, skin and notes."""
        candidates = _with_branches(followed)
        rest = self._frames_of(candidates)
        poses = self._evaluated_frames(candidates, drawn_poses(self._evaluator.settings.controls, POSES))
        flat = np.abs(np.linalg.det(rest[:, :3, :3])) < 1e-12
        motions = poses @ np.linalg.inv(np.where(flat[:, None, None], np.eye(4), rest))
        turned = [bone for place, bone in enumerate(candidates) if not can_be_followed(motions[:, place])]
        if turned:
            what = "are mirrored or flat in some poses; blendshapes move what follows them"
            self.notes.append(f"{_named(turned)} {what}")
        points = self._points_below(skins, candidates)
        self._note_unbound(followed, points)
        found = _Found(rest, motions, self._evaluator.diagonal)
        for place, bone in enumerate(candidates):
            above = [found.joint_of[candidates.index(b)] for b in _above(bone) if b in candidates]
            found.add(place, [joint for joint in above if joint is not None], bone not in turned, points[bone])
        found.drop_unused([place for place, bone in enumerate(candidates) if bone in followed])
        self._take(found, candidates)
        self._set_skin(skins, {bone: found.joint_of[place] for place, bone in enumerate(candidates)})
        self._note_bends()

    def _evaluated_frames(self, bones: Sequence[Bone], poses: Any) -> Any:
        frames: List[Any] = []
        for pose in poses:
            self._evaluator.pose_scene(pose)
            frames.append(self._frames_of(bones))
        self._evaluator.pose_scene(self._evaluator.rest_controls)
        return np.array(frames)

    def _points_below(self, skins: Sequence[MeshSkin], candidates: Sequence[Bone]) -> Dict[Bone, Any]:
        """At rest, the vertices that follow each of these bones or one below it."""
        masks = {bone: np.zeros(len(self._evaluator.rest_positions), bool) for bone in candidates}
        first = 0
        for skin, count in zip(skins, self._evaluator.vertex_counts):
            for number, bone in enumerate(skin.bones):
                follows = ((skin.indices == number) & (skin.weights > 0)).any(1)
                for holder in (b for b in [bone, *_above(bone)] if b in masks):
                    masks[holder][first : first + count] |= follows
            first += count
        return {bone: self._evaluator.rest_positions[mask] for bone, mask in masks.items()}

    def _take(self, found: "_Found", candidates: Sequence[Bone]) -> None:
        import facebaker

        self._bones = [candidates[place] for place in found.places]
        names = [bone for _, bone in self._bones]
        for (armature, bone), place, parent, numbers in zip(self._bones, found.places, found.parents, found.numbers):
            name = bone if names.count(bone) == 1 else f"{armature}.{bone}"
            local = found.rest[place]
            if parent is not None:
                local = np.linalg.inv(found.rest[found.places[parent]]) @ local
            self.joints.append(facebaker.Joint(name, parent, local[:3], numbers=numbers))

    def _set_skin(self, skins: Sequence[MeshSkin], joint_of: Dict[Bone, Optional[int]]) -> None:
        import facebaker

        if not self.joints:
            return
        width = max(skin.weights.shape[1] for skin in skins if skin.bones)
        vertices = sum(self._evaluator.vertex_counts)
        indices, weights = np.zeros((vertices, width), np.int64), np.zeros((vertices, width), np.float32)
        first = 0
        for skin, count in zip(skins, self._evaluator.vertex_counts):
            if skin.bones:
                numbers = [joint_of[bone] for bone in skin.bones]
                used = skin.weights.shape[1]
                indices[first : first + count, :used] = np.array([number or 0 for number in numbers])[skin.indices]
                stays = np.array([number is None for number in numbers])[skin.indices]
                weights[first : first + count, :used] = np.where(stays, 0, skin.weights)
            first += count
        self.skin = facebaker.Skin(indices, weights)

    def _note_unbound(self, followed: Sequence[Bone], points: Dict[Bone, Any]) -> None:
        """A blend of bones is that of their joints where all are, at rest, moved alike from where they were bound."""
        moved = self._frames_of(followed) @ np.linalg.inv(self._frames_of(followed, bound=True))
        apart = moved - np.median(moved, 0)
        far = [
            bone
            for bone, motion in zip(followed, apart)
            if len(points[bone]) and np.abs(points[bone] @ motion[:3, :3].T + motion[:3, 3]).max() > self._far
        ]
        if far:
            what = "are, with controls at rest, other than where they are bound"
            self.notes.append(f"{_named(far)} {what}; blendshapes correct vertices that follow several bones")

    def _note_bends(self) -> None:
        bent = [b for b in self._bones if find_object(b[0]).data.bones[b[1]].bbone_segments > 1]
        if bent:
            self.notes.append(f"{_named(bent)} bend; joints are rigid, and blendshapes add the bend")


class _Found:
    """Joints while they are found. joint_of: of each candidate the joint that takes along what follows it, or None. places:
    of each joint, which candidate it is; parents, numbers: of each joint."""

    def __init__(self, rest: Any, motions: Any, diagonal: float) -> None:
        self.rest, self._motions, self._least = rest, motions, MOVES * diagonal
        self.joint_of: List[Optional[int]] = []
        self.places: List[int] = []
        self.parents: List[Optional[int]] = []
        self.numbers: List[Tuple[str, ...]] = []

    def add(self, place: int, above: Sequence[int], movable: bool, points: Any) -> None:
        """The next candidate. above: the joints above it, nearest first; points: that follow it or a bone below it."""
        nearest = above[0] if above else None
        self.joint_of.append(nearest)
        if not movable or not len(points):
            return
        upright_rest = upright(self.rest[place])
        reach = number_reach(upright_rest, points)
        best: Any = None
        for parent in [*above, None]:
            motion = self._motions[:, self.places[parent]] if parent is not None else np.eye(4)[None]
            moves = np.abs(joint_numbers(self._motions[:, place], motion, upright_rest)) * reach
            numbers = tuple(name for name, most in zip(NUMBERS, moves.max(0)) if most > self._least)
            # The parent beside which it has fewest numbers, and then moves least; the nearest of equals.
            cost = len(numbers), float(moves.sum())
            if best is None or cost < best[0]:
                best = cost, parent, numbers
        _, parent, numbers = best
        if not numbers:
            self.joint_of[-1] = parent
            return
        self.joint_of[-1] = len(self.places)
        self.places.append(place)
        self.parents.append(parent)
        self.numbers.append(numbers)

    def drop_unused(self, followed: Sequence[int]) -> None:
        """Removes joints that neither vertices nor joints follow. followed: candidates that vertices follow."""
        used = {self.joint_of[place] for place in followed}
        for joint in reversed(range(len(self.places))):
            if joint in used:
                used.add(self.parents[joint])
        kept = [joint for joint in range(len(self.places)) if joint in used]
        self.joint_of = [kept.index(joint) if joint in used and joint is not None else None for joint in self.joint_of]
        parents = [self.parents[joint] for joint in kept]
        self.parents = [None if parent is None else kept.index(parent) for parent in parents]
        self.places, self.numbers = [self.places[joint] for joint in kept], [self.numbers[joint] for joint in kept]


def drawn_poses(controls: Sequence[Any], count: int, seed: int = 0) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(count, controls): all controls within half of their ranges, and in every other pose a fifth of them anywhere."""
    rest, low, high = (np.array([getattr(c, end) for c in controls]) for end in ("rest", "minimum", "maximum"))
    random = np.random.default_rng(seed)
    values = random.uniform(low, high, (count, len(controls)))
    some = (random.uniform(size=values.shape) < 0.2).astype(np.float64)
    share = np.where(np.arange(count)[:, None] % 2, some, 0.5)
    drawn: "np.ndarray[Any, np.dtype[np.float32]]" = (rest + share * (values - rest)).astype(np.float32)
    drawn.clip(low.astype(np.float32), high.astype(np.float32), out=drawn)
    return drawn


def _above(bone: Bone) -> List[Bone]:
    """The bones above one, nearest first."""
    armature, name = bone
    return [(armature, holder.name) for holder in find_object(armature).data.bones[name].parent_recursive]


def _with_branches(followed: Sequence[Bone]) -> List[Bone]:
    """These bones and those above at least two of them, parents first."""
    counts: Dict[Bone, int] = {}
    for bone in followed:
        for holder in _above(bone):
            counts[holder] = counts.get(holder, 0) + 1
    chosen: Set[Bone] = {*followed, *(bone for bone, count in counts.items() if count > 1)}
    # In the order of the armature, where parents come first.
    order = [
        (armature, bone.name)
        for armature in dict.fromkeys(armature for armature, _ in followed)
        for bone in find_object(armature).data.bones
    ]
    return [bone for bone in order if bone in chosen]


def _named(bones: Sequence[Bone]) -> str:
    more = f" and {len(bones) - NAMED} more" if len(bones) > NAMED else ""
    return "bones " + ", ".join(f'"{name}"' for _, name in bones[:NAMED]) + more
