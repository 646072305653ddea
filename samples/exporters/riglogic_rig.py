"""A MetaHuman's DNA file as a rig that FaceBaker bakes with its joints. NOT RUN HERE: written from the headers, examples and
tests of OpenRigLogic, on a machine without it and without a DNA file; only its own formulas are tested, with a reader made up
for that.

OpenRigLogic (https://github.com/EpicGames/OpenRigLogic, MIT licence) has the Python modules `dna` and `riglogic`, which are
built by CMake and SWIG. With both, NumPy and facebaker on PYTHONPATH:

    python3 samples/exporters/riglogic_rig.py head.dna head.fbk --poses 5000

or, from Python, facebaker.bake(riglogic_rig.load("head.dna"), "head.fbk", recipe="untrained"). The rig is baked in this process:
the rig protocol has no skinned rigs.

WHAT THE LICENCE OF A CHARACTER ALLOWS IS YOURS TO FIND OUT. That of OpenRigLogic is not that of the characters. Epic's
licence of MetaHumans is reported to forbid their use "for the training or testing of any artificial intelligence, machine
learning, deep learning, neural network or similar technology". So the rig says of itself that it may not be learned from, and a
bake takes the recipe `untrained`: what the rig does control by control, pair by pair and so on, without networks and without a
fit to poses. Such a rig needs no more: its correctives are products. FaceBaker then refuses the recipes that learn; of a file
that is your own, or with Epic's leave, --may-learn leaves that out. Whether a bake without learning is allowed is a question that
this file does not answer: ask Epic, or use a rig of your own that was made without MetaHuman.

What is taken from the file, at its finest level of detail:

- Controls: the raw controls (CTRL_expressions...), 0 to 1, or with gui=True those of the face board, in the ranges that are
  mapped to raw ones. Raw controls that are parts of a quaternion (NAME.qx to NAME.qw), by which a body's joints drive those
  of the neck, stay at no rotation.
- Joints: a joint that the file moves is driven, and so is all that hangs on it; the others are left to a host. A pose
  adds its translation to the neutral one, turns the joint within its neutral rotation (neutral times delta, as
  quaternions), and adds its scale to the neutral one, as OpenRigLogic's examples/Advanced.cpp does. Scales go on to the joints
  below.
- Blend shapes move vertices before joints do. Animated maps (masks of wrinkles) are not taken.

MetaHumans' files are in centimetres with y up; for one that was written with z up say --up z.
"""
import argparse
import hashlib
import re
import sys

import numpy as np

import facebaker

LEVEL = 0  # the finest
NO_LEARNING = {"rights": {"learning": "forbidden"}}
QUATERNION_PART = re.compile(r"\.q[xyzw]$")


def load(path, gui=False, up_axis="y", about=NO_LEARNING):
    """A facebaker.Rig of a DNA file. about: what is said about the character, None for nothing. Raises ImportError without OpenRigLogic's modules, and RuntimeError on a file that
    they refuse."""
    import dna
    import riglogic

    stream = dna.FileStream(path, dna.FileStream.AccessMode_Read, dna.FileStream.OpenMode_Binary)
    reader = dna.BinaryStreamReader(stream)
    reader.read()
    if not dna.Status.isOk():
        raise RuntimeError("%s: %s" % (path, dna.Status.get().message))
    configuration = riglogic.Configuration()
    configuration.floatingPointType = riglogic.FloatingPointType_Float
    configuration.rotationType = riglogic.RotationType_Quaternions
    logic = riglogic.RigLogic(reader, configuration)
    units = {dna.TranslationUnit_cm: "cm", dna.TranslationUnit_m: "m"}[reader.getTranslationUnit()]
    with open(path, "rb") as file:
        version = hashlib.sha256(file.read()).hexdigest()
    return rig_of(reader, logic, riglogic.RigInstance(logic), gui, units=units, up_axis=up_axis, about=about, version=version)


def rig_of(reader, logic, instance, gui=False, **options):
    """A facebaker.Rig of a reader, a RigLogic whose rotations are quaternions, and an instance of it. options: of
    facebaker.Rig."""
    controls = GuiControls(reader, logic, instance) if gui else RawControls(reader, instance)
    joints, meshes = Joints(reader, logic), Meshes(reader)
    skin = facebaker.Skin(joints.place_of[meshes.skin_joints], meshes.skin_weights)

    def evaluate(poses):
        positions, frames = [], []
        for pose in poses:
            controls.set(pose)
            logic.calculate(instance)
            frames.append(joints.frames(instance.getJointOutputs()))
            before = meshes.shaped(instance.getBlendShapeOutputs())
            positions.append(skinned(before, skin, joints.motions(frames[-1])))
        return np.array(positions), np.array(frames)

    return facebaker.Rig(
        controls.described(), evaluate, name=reader.getName() or "MetaHuman", rest_positions=meshes.points,
        polygons=meshes.polygons, uvs=meshes.uvs, uv_polygons=meshes.uv_polygons, meshes=meshes.meshes,
        joints=joints.described(), skin=skin, skinned=True, **options,
    )  # fmt: skip


class RawControls:
    """The raw controls but for parts of quaternions."""

    def __init__(self, reader, instance):
        self.instance = instance
        names = [reader.getRawControlName(i) for i in range(reader.getRawControlCount())]
        self.indices = [i for i, name in enumerate(names) if not QUATERNION_PART.search(name)]
        self.names = [names[i] for i in self.indices]
        self.still = [(i, float(name.endswith("w"))) for i, name in enumerate(names) if QUATERNION_PART.search(name)]

    def described(self):
        """facebaker.Controls."""
        return [control_of(name, 0, 1, self.names) for name in self.names]

    def set(self, pose):
        for index, value in zip(self.indices, pose):
            self.instance.setRawControl(index, float(value))
        self.keep_still()

    def keep_still(self):
        for index, value in self.still:
            self.instance.setRawControl(index, value)


class GuiControls:
    """The controls of the face board that are mapped to raw ones."""

    def __init__(self, reader, logic, instance):
        self.logic, self.instance, self.raw = logic, instance, RawControls(reader, instance)
        self.ranges = {}
        mapped = zip(reader.getGUIToRawInputIndices(), reader.getGUIToRawFromValues(), reader.getGUIToRawToValues())
        for index, start, end in mapped:
            low, high = self.ranges.get(index, (0.0, 0.0))  # the rest value is within
            self.ranges[index] = (min(low, start, end), max(high, start, end))
        self.indices = sorted(self.ranges)
        self.names = [reader.getGUIControlName(i) for i in self.indices]

    def described(self):
        return [control_of(name, *self.ranges[i], self.names) for i, name in zip(self.indices, self.names)]

    def set(self, pose):
        for index, value in zip(self.indices, pose):
            self.instance.setGUIControl(index, float(value))
        self.logic.mapGUIToRawControls(self.instance)
        self.raw.keep_still()


def control_of(name, low, high, names):
    """The first word of a name is its group; CTRL_L_... and CTRL_R_..., or names that end with L and R, mirror each other."""
    word = re.match(r"(?:CTRL_expressions\.|CTRL_[CLR]_)?([a-z]+)", name)
    sides = {"L": "R", "R": "L"}
    if re.match("CTRL_[LR]_", name):
        mirror = name[:5] + sides[name[5]] + name[6:]
    else:
        mirror = name[:-1] + sides.get(name[-1:], "")
    return facebaker.Control(name, word.group(1) if word else "", low, high, 0, mirror=mirror if mirror in names else "")


class Joints:
    """The skeleton, parents before children, where the reader may have them in any order."""

    def __init__(self, reader, logic):
        count = reader.getJointCount()
        parents = [reader.getJointParentIndex(i) for i in range(count)]
        above = [None if parent == i or parent >= count else parent for i, parent in enumerate(parents)]
        self.order = sorted(range(count), key=lambda i: depth(i, above))
        self.place_of = np.argsort(self.order)  # of the reader's joints, among these
        self.names = [reader.getJointName(i) for i in self.order]
        self.parents = [None if above[i] is None else int(self.place_of[above[i]]) for i in self.order]
        self.numbers = moving_numbers(reader.getJointVariableAttributeIndices(LEVEL), count)
        self.neutral = np.array(logic.getNeutralJointValues(), float).reshape(count, 10)
        self.local_rest = local_frames(self.neutral)[self.order]
        self.rest = composed(self.local_rest, self.parents)
        self.rest_inverse = np.linalg.inv(square(self.rest))

    def described(self):
        """facebaker.Joints."""
        parts = zip(self.names, self.parents, self.local_rest, self.order)
        return [facebaker.Joint(name, parent, rest, None, self.numbers[i]) for name, parent, rest, i in parts]

    def frames(self, outputs):
        """Where the joints are, (joints, 3, 4), by the joint outputs of a pose."""
        deltas = np.array(outputs, float).reshape(self.neutral.shape)
        return composed(local_frames(self.neutral, deltas)[self.order], self.parents)

    def motions(self, frames):
        """What takes points from where they are at rest."""
        return (square(frames) @ self.rest_inverse)[:, :3]


def depth(joint, above):
    """Joints above this one."""
    steps = 0
    while above[joint] is not None:
        joint, steps = above[joint], steps + 1
        if steps > len(above):
            raise ValueError("joint %d is below itself" % joint)
    return steps


def moving_numbers(attributes, count):
    """Of each joint which numbers move it, as facebaker.Joint has them. attributes: indices, nine a joint: translation,
    rotation and scale by x, y and z. Translations are along the axes of the parent, and two angles make a rotation about any
    axis: of these all three are taken."""
    moved = np.zeros((count, 3, 3), bool)
    moved.reshape(-1)[list(attributes)] = True
    moved[:, 0] |= moved[:, 0].any(1, keepdims=True)
    moved[:, 1] |= moved[:, 1].sum(1, keepdims=True) > 1
    words = [kind + "_" + axis for kind in ("move", "rotate", "scale") for axis in "xyz"]
    return [tuple(word for word, moves in zip(words, row.ravel()) if moves) for row in moved]


def local_frames(neutral, deltas=None):
    """Frames of joints in their parents, (joints, 3, 4), of values of joints, ten each: translation, quaternion (x, y, z,
    w) and scale."""
    if deltas is None:
        deltas = np.zeros_like(neutral)
    rotations = quaternion_matrices(neutral[:, 3:7]) @ quaternion_matrices(deltas[:, 3:7])
    scaled = rotations * (neutral[:, None, 7:] + deltas[:, None, 7:])
    return np.concatenate([scaled, (neutral[:, :3] + deltas[:, :3])[..., None]], 2)


def quaternion_matrices(quaternions):
    """(n, 4), x, y, z and w, of any length, to (n, 3, 3); no rotation where they are 0."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    x, y, z, w = np.where(lengths > 0, quaternions / np.where(lengths > 0, lengths, 1), (0, 0, 0, 1)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def square(frames):
    """(n, 3, 4) to (n, 4, 4)."""
    return np.concatenate([frames, np.broadcast_to([[[0.0, 0, 0, 1]]], (len(frames), 1, 4))], 1)


def composed(local, parents):
    """Frames in parents, which come first, to frames in one space."""
    frames = square(local)
    for joint, parent in enumerate(parents):
        if parent is not None:
            frames[joint] = frames[parent] @ frames[joint]
    return frames[:, :3]


class Meshes:
    """The meshes of the finest level, one after the other: points, polygons, texture coordinates, blend shapes and skin."""

    def __init__(self, reader):
        points, uvs, weights, joints = [], [], [], []
        self.meshes, self.polygons, self.uv_polygons, self.targets = [], [], [], []
        for mesh in reader.getMeshIndicesForLOD(LEVEL):
            first, first_uv = len(points), len(uvs)
            points += zip(*columns(reader, "getVertexPosition", mesh))
            uvs += zip(reader.getVertexTextureCoordinateUs(mesh), reader.getVertexTextureCoordinateVs(mesh))
            self.add_polygons(reader, mesh, first, first_uv)
            self.add_targets(reader, mesh, first)
            for vertex in range(len(points) - first):
                weights.append(reader.getSkinWeightsValues(mesh, vertex))
                joints.append(reader.getSkinWeightsJointIndices(mesh, vertex))
            self.meshes.append(facebaker.Mesh(reader.getMeshName(mesh), len(points) - first, reader.getFaceCount(mesh)))
        self.points = np.array(points, float)
        self.uvs = np.array(uvs, float)
        if len(self.uv_polygons) < len(self.polygons):  # a mesh has none
            self.uvs = self.uv_polygons = None
        self.skin_weights = padded(weights, float)
        sums = self.skin_weights.sum(1, keepdims=True)
        self.skin_weights /= np.where(sums > 0, sums, 1)
        self.skin_joints = padded(joints, int)

    def add_polygons(self, reader, mesh, first, first_uv):
        corners = reader.getVertexLayoutPositionIndices(mesh)
        uv_corners = reader.getVertexLayoutTextureCoordinateIndices(mesh)
        for face in range(reader.getFaceCount(mesh)):
            layouts = reader.getFaceVertexLayoutIndices(mesh, face)
            self.polygons.append([first + corners[layout] for layout in layouts])
            if uv_corners:
                self.uv_polygons.append([first_uv + uv_corners[layout] for layout in layouts])

    def add_targets(self, reader, mesh, first):
        for target in range(reader.getBlendShapeTargetCount(mesh)):
            vertices = first + np.array(reader.getBlendShapeTargetVertexIndices(mesh, target), int)
            deltas = np.array(columns(reader, "getBlendShapeTargetDelta", mesh, target), float).T
            self.targets.append((reader.getBlendShapeChannelIndex(mesh, target), vertices, deltas))

    def shaped(self, outputs):
        """Points as blend shapes move them, before joints do."""
        points = self.points.copy()
        for channel, vertices, deltas in self.targets:
            if outputs[channel] != 0:
                points[vertices] += outputs[channel] * deltas
        return points


def columns(reader, method, *arguments):
    """The three arrays of coordinates that a reader has under a name."""
    return [getattr(reader, method + axis)(*arguments) for axis in ("Xs", "Ys", "Zs")]


def padded(rows, kind):
    """Rows of different lengths, with zeros behind each."""
    array = np.zeros((len(rows), max([1, *map(len, rows)])), kind)
    for place, row in zip(array, rows):
        place[: len(row)] = row
    return array


def skinned(points, skin, motions):
    """Points moved by the weighted sums of the motions of their joints; those without weights stay."""
    blend = np.zeros((len(points), 3, 4))
    for k in range(skin.weights.shape[1]):
        blend += skin.weights[:, k, None, None] * (motions - np.eye(3, 4))[skin.joints[:, k]]
    return points + (blend[..., :3] @ points[..., None])[..., 0] + blend[..., 3]


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Bakes a MetaHuman's DNA file. Read the licence of your character first.")
    parser.add_argument("dna", help="the DNA file")
    parser.add_argument("out", help="the archive to write (.fbk)")
    parser.add_argument("--gui", action="store_true", help="controls of the face board in place of raw ones")
    parser.add_argument("--up", choices=("y", "z"), default="y", help="the axis that points up in the file")
    parser.add_argument("--recipe", default="untrained")
    parser.add_argument("--may-learn", action="store_true", help="the character's owner allows learning from it")
    parser.add_argument("--poses", type=int, default=20000, help="poses to sample: to measure the face, and to train on")
    options = parser.parse_args(arguments)
    rig = load(options.dna, options.gui, options.up, None if options.may_learn else NO_LEARNING)
    facebaker.bake(rig, options.out, recipe=options.recipe, poses=options.poses, note=lambda text: print(text, file=sys.stderr))
    return 0


if __name__ == "__main__":
    sys.exit(main())
