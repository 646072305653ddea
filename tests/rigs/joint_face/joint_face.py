"""A face of joints as engines have them, as large as the largest: 870 joints in chains of six, 24,000 vertices in ten
meshes, each following eight joints, 250 controls that turn and move joints along curves, and 800 correctives that are
products of two and three controls. NumPy and formulas; it shares nothing with what bakes it.

    joint_face.py OUT.fbk [POSES [SCALE [RECIPE]]]

bakes it and says how exact the face is and how long a pose takes; SCALE (default 1) makes everything smaller. RECIPE is
compact if not given.
Needs facebaker on PYTHONPATH."""

import sys
import time

import numpy as np

import facebaker

CHAIN, INFLUENCES, MESHES = 6, 8, 10


def rotations(vectors):
    """(..., 3) rotation vectors in radians to (..., 3, 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*x.shape, 3, 3)
    sine = np.sinc(angle / np.pi)
    half = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + sine * cross + half * (cross @ cross)


def grids(columns, rows):
    """Sheets round a head of radius 10: positions and quads of all, and sizes of each."""
    all_points, quads, sizes = [], [], []
    for mesh in range(MESHES):
        u, v = np.meshgrid(np.linspace(-1.2, 1.2, columns), np.linspace(-1, 1, rows))
        radius = 10 - 0.4 * mesh + 0.3 * np.sin(5 * u) * np.cos(4 * v)
        at = np.stack([radius * np.sin(u) * np.cos(v), 1.2 * radius * np.sin(v), radius * np.cos(u) * np.cos(v)], -1)
        first = len(all_points) * columns * rows
        corner = first + np.arange((rows - 1) * columns).reshape(rows - 1, columns)[:, :-1].ravel()
        quads.append(np.stack([corner, corner + 1, corner + columns + 1, corner + columns], -1))
        all_points.append(at.reshape(-1, 3))
        sizes.append((columns * rows, len(corner)))
    return np.concatenate(all_points), np.concatenate(quads), sizes


class JointFace:
    """Chains of joints, each of which starts on the surface and leads along it."""

    def __init__(self, scale=1.0, seed=1):
        random = np.random.default_rng(seed)
        self.rest, self.quads, self.sizes = grids(round(60 * scale**0.5), round(40 * scale**0.5))
        chains, self.controls, correctives = max(4, round(145 * scale)), max(10, round(250 * scale)), round(800 * scale)
        starts = self.rest[random.choice(len(self.rest), chains, replace=False)]
        self.heads = (starts[:, None] + np.outer(np.arange(CHAIN), [0, -0.35, 0.05])).reshape(-1, 3)
        # A control moves the joints of four chains that are near each other: rotation vectors and translations of each.
        near = np.argsort(np.linalg.norm(starts[:, None] - starts[None], axis=-1), 1)[:, :4]
        self.shapes = [(c,) for c in range(self.controls)]
        reach = np.zeros((self.controls, chains), bool)
        for c in range(self.controls):
            reach[c, near[random.integers(chains)]] = True
        neighbours = reach.astype(int) @ reach.T > 0
        while len(self.shapes) < self.controls + correctives:
            first = random.integers(self.controls)
            others = np.setdiff1d(np.flatnonzero(neighbours[first]), [first])
            size = min(len(others), random.integers(1, 3))
            if size:
                self.shapes.append(tuple(sorted({first, *random.choice(others, size, replace=False)})))
        self.parts = np.zeros((len(self.shapes), CHAIN * chains, 6))
        for s, shape in enumerate(self.shapes):
            strength = 1.0 if len(shape) == 1 else 0.35
            for chain in np.flatnonzero(np.logical_and.reduce(reach[list(shape)])):
                first = CHAIN * chain
                self.parts[s, first : first + CHAIN, :3] = strength * random.normal(0, 0.06, (CHAIN, 3))
                self.parts[s, first, 3:] = strength * random.normal(0, 0.15, 3)
        self._bind()

    def _bind(self):
        """The eight joints next to each vertex, weighted by distance, in steps of 1/32768."""
        self.joints = np.empty((len(self.rest), INFLUENCES), int)
        self.weights = np.empty((len(self.rest), INFLUENCES))
        for first in range(0, len(self.rest), 2000):
            part = slice(first, first + 2000)
            distance = np.linalg.norm(self.rest[part, None] - self.heads[None], axis=-1)
            nearest = np.argpartition(distance, INFLUENCES - 1, 1)[:, :INFLUENCES]
            near = np.take_along_axis(distance, nearest, 1)
            weights = np.exp(-near / 1.2) + 1e-9
            self.joints[part], self.weights[part] = nearest, weights / weights.sum(1, keepdims=True)
        steps = np.round(self.weights * 32768)
        most = steps.argmax(1)
        steps[np.arange(len(steps)), most] += 32768 - steps.sum(1)
        self.weights = (steps / 32768).astype(np.float32)

    def frames(self, poses):
        """(poses, controls) to (poses, joints, 3, 4): where the joints are."""
        amounts = np.stack([poses[:, shape].prod(1) for shape in map(list, self.shapes)], 1)
        parts = (amounts @ self.parts.reshape(len(self.shapes), -1)).reshape(len(poses), -1, CHAIN, 6)
        heads = self.heads.reshape(-1, CHAIN, 3)
        local = np.concatenate([rotations(parts[..., :3]), parts[..., 3:, None] + heads[..., None]], -1)
        local[:, :, 1:, :, 3] -= heads[:, :-1]
        for link in range(1, CHAIN):  # from within the joint before it to the space of positions
            above, here = local[:, :, link - 1], local[:, :, link]
            here[:] = above[..., :3] @ here
            here[..., 3] += above[..., 3]
        return local.reshape(len(poses), -1, 3, 4)

    def evaluate(self, poses):
        frames = self.frames(poses.astype(float))
        moved = frames.copy()
        moved[..., 3] -= (frames[..., :3] * self.heads[:, None]).sum(-1)
        moved = (moved - np.eye(3, 4)).reshape(len(poses), -1, 12).astype(np.float32)
        positions = np.empty((len(poses), *self.rest.shape))
        for pose, motions in enumerate(moved):
            blend = np.zeros((len(self.rest), 12), np.float32)
            for k in range(INFLUENCES):
                blend += self.weights[:, k, None] * motions[self.joints[:, k]]
            blend = blend.reshape(-1, 3, 4)
            positions[pose] = self.rest + (blend[..., :3] * self.rest[:, None]).sum(-1) + blend[..., 3]
        return positions, frames

    def rig(self):
        numbers = [f"{kind}_{axis}" for kind in ("rotate", "move") for axis in "xyz"]
        joints = []
        for j, head in enumerate(self.heads):
            parent = j - 1 if j % CHAIN else None
            rest = np.c_[np.eye(3), head if parent is None else head - self.heads[parent]]
            used = tuple(number for number, part in zip(numbers, self.parts[:, j].T) if part.any())
            joints.append(facebaker.Joint(f"chain{j // CHAIN}.{j % CHAIN}", parent, rest, None, used))
        meshes = [facebaker.Mesh(f"mesh{m}", *size) for m, size in enumerate(self.sizes)]
        controls = [facebaker.Control(f"c{c:03}", f"group{c % 10}", 0, 1, 0) for c in range(self.controls)]
        return facebaker.Rig(
            controls, self.evaluate, name="joint face", rest_positions=self.rest, polygons=self.quads, meshes=meshes,
            joints=joints, skin=facebaker.Skin(self.joints, self.weights), skinned=True, version="1",
        )  # fmt: skip


def poses_of(controls, count, share, seed):
    random = np.random.default_rng(seed)
    poses = random.uniform(0, 1, (count, controls)) * (random.random((count, controls)) < share)
    return poses.astype(np.float32)


def main():
    out, poses = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 2000
    source = JointFace(float(sys.argv[3]) if len(sys.argv) > 3 else 1)
    print(f"{len(source.heads)} joints, {len(source.rest)} vertices, {source.controls} controls, "
          f"{len(source.shapes) - source.controls} correctives")  # fmt: skip
    started = time.time()
    recipe = sys.argv[4] if len(sys.argv) > 4 else "compact"
    result = facebaker.bake(source.rig(), out, recipe=recipe, poses=poses, progress=True)
    print(f"baked in {time.time() - started:.0f} s from {result.document['rig_calls']} evaluations: "
          f"{result.document['bytes']} bytes")  # fmt: skip
    face = facebaker.load(out)
    diagonal = np.linalg.norm(np.ptp(source.rest, 0))
    for share in (0.04, 0.15):
        unseen = poses_of(source.controls, 60, share, 7)
        true, _ = source.evaluate(unseen)
        distance = np.linalg.norm(face.evaluate_batch(unseen) - true, axis=-1)
        print(f"{share:.0%} of the controls on: worst vertex {distance.max() * 10:.2g} mm, {distance.max() / diagonal:.1e} "
              f"of the diagonal, mse {np.mean(distance**2) / diagonal**2:.1e}")  # fmt: skip


if __name__ == "__main__":
    main()
