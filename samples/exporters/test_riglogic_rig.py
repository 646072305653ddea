#!/usr/bin/env python3
"""Tests riglogic_rig.py with a reader, a logic and an instance made up here, which have the methods of OpenRigLogic's that it
calls and behave as those are documented. OpenRigLogic itself is not run. Needs NumPy, and facebaker on PYTHONPATH."""
import os
import sys
import tempfile
import types
import unittest
from unittest import mock

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
import riglogic_rig

RAW = ["CTRL_expressions.jawOpen", "CTRL_expressions.mouthSmileL", "CTRL_expressions.mouthSmileR", "neck_01.qx", "neck_01.qw"]
GUI = ["CTRL_C_jaw.ty", "CTRL_L_mouth.tx", "CTRL_R_mouth.tx", "CTRL_nothing.tx"]
HEAD, TONGUE, JAW = range(3)  # a child may come before its parent
GRID = [(float(x), float(y), 0.25 * x * y) for y in range(4) for x in range(4)]
TEETH = [(1.0, 0.0, -1.0), (2.0, 0.0, -1.0), (1.0, 1.0, -1.0)]


def turn(axis, angle):
    """A quaternion, and the same as a matrix."""
    quaternion = [0.0, 0.0, 0.0, np.cos(angle / 2)]
    quaternion[axis] = np.sin(angle / 2)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[j, i] = np.sin(angle)
    matrix[i, j] = -matrix[j, i]
    return quaternion, matrix


def shift(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


class FakeReader:
    """Two meshes in the finest level, one of them with blend shapes, and one of another level."""

    points = {0: GRID, 2: TEETH}

    def getName(self):
        return "fake"

    def getRawControlCount(self):
        return len(RAW)

    def getRawControlName(self, index):
        return RAW[index]

    def getGUIControlName(self, index):
        return GUI[index]

    def getGUIToRawInputIndices(self):
        return [0, 0, 1, 2]

    def getGUIToRawFromValues(self):
        return [0.0, -1.0, 0.0, 0.0]

    def getGUIToRawToValues(self):
        return [1.0, 0.0, 1.0, 1.0]

    def getJointCount(self):
        return 3

    def getJointName(self, index):
        return ["head", "FACIAL_C_Tongue", "FACIAL_C_Jaw"][index]

    def getJointParentIndex(self, index):
        return [HEAD, JAW, HEAD][index]  # a root is its own parent

    def getJointVariableAttributeIndices(self, lod):
        assert lod == 0
        return [9 * JAW + 3, 9 * TONGUE + 2, 9 * TONGUE + 7]  # rotation by x; translation along z, scale of y

    def getMeshIndicesForLOD(self, lod):
        assert lod == 0
        return [0, 2]

    def getMeshName(self, mesh):
        return ["head_lod0_mesh", "head_lod1_mesh", "teeth_lod0_mesh"][mesh]

    def getVertexPositionXs(self, mesh):
        return [point[0] for point in self.points[mesh]]

    def getVertexPositionYs(self, mesh):
        return [point[1] for point in self.points[mesh]]

    def getVertexPositionZs(self, mesh):
        return [point[2] for point in self.points[mesh]]

    def getVertexTextureCoordinateUs(self, mesh):
        return [0.25 * point[0] for point in reversed(self.points[mesh])]

    def getVertexTextureCoordinateVs(self, mesh):
        return [0.25 * point[1] for point in reversed(self.points[mesh])]

    def getVertexLayoutPositionIndices(self, mesh):
        return list(reversed(range(len(self.points[mesh]))))

    def getVertexLayoutTextureCoordinateIndices(self, mesh):
        return list(range(len(self.points[mesh])))

    def getFaceCount(self, mesh):
        return 9 if mesh == 0 else 1

    def getFaceVertexLayoutIndices(self, mesh, face):
        if mesh == 2:
            return [0, 1, 2]
        corner = 15 - (4 * (face // 3) + face % 3)  # layouts are the points, last to first
        return [corner, corner - 1, corner - 5, corner - 4]

    def getSkinWeightsValues(self, mesh, vertex):
        return [1.0] if mesh == 2 or vertex < 8 else [0.75, 0.25]

    def getSkinWeightsJointIndices(self, mesh, vertex):
        return [JAW] if mesh == 2 else [HEAD] if vertex < 8 else [TONGUE, JAW]

    def getBlendShapeTargetCount(self, mesh):
        return 2 if mesh == 0 else 0

    def getBlendShapeChannelIndex(self, mesh, target):
        return 1 - target

    def getBlendShapeTargetVertexIndices(self, mesh, target):
        return [[0, 3], [12]][target]

    def getBlendShapeTargetDeltaXs(self, mesh, target):
        return [[0.5, 0.5], [-0.25]][target]

    def getBlendShapeTargetDeltaYs(self, mesh, target):
        return [[0.0, 0.25], [0.0]][target]

    def getBlendShapeTargetDeltaZs(self, mesh, target):
        return [[0.0, 0.0], [0.5]][target]


class FakeInstance:
    def __init__(self):
        self.raw, self.gui = [0.0] * len(RAW), [0.0] * len(GUI)

    def setRawControl(self, index, value):
        assert isinstance(value, float)
        self.raw[index] = value

    def setGUIControl(self, index, value):
        assert isinstance(value, float)
        self.gui[index] = value

    def getJointOutputs(self):
        return self.joints

    def getBlendShapeOutputs(self):
        return self.shapes


def numbers_of(jaw, left, right):
    """What the controls do: angle of the jaw, shift and growth of the tongue, and weights of two blend shapes."""
    return 0.5 * jaw, 0.3 * jaw * left, 0.2 * left, (right, jaw * right)


class FakeLogic:
    """Ten values a joint: translation, quaternion and scale. Quaternions of deltas are not of unit length."""

    def getNeutralJointValues(self):
        head = [0, 1, 0, *turn(1, 0.3)[0], 1, 1, 1]
        tongue = [0, 0.5, 0.25, *turn(0, 0.2)[0], 1, 1, 1]
        return head + tongue + [1, 0, 0, *turn(2, 0.4)[0], 1, 1, 1]

    def mapGUIToRawControls(self, instance):
        jaw, left, right, _ = instance.gui
        instance.raw = [max(jaw, -0.5 * jaw), left, right, 7.0, 7.0]

    def calculate(self, instance):
        assert instance.raw[3:] == [0.0, 1.0], "the neck is not turned"
        angle, out, wide, instance.shapes = numbers_of(*instance.raw[:3])
        still = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0]
        tongue = [0, 0, out, 0, 0, 0, 1, 0, wide, 0]
        jaw = [0, 0, 0, *(1.5 * part for part in turn(0, angle)[0]), 0, 0, 0]
        instance.joints = still + tongue + jaw


def expected(jaw, left, right):
    """Positions, and frames of head, jaw and tongue, by products of matrices."""
    angle, out, wide, shapes = numbers_of(jaw, left, right)
    head = shift(0, 1, 0) @ turn(1, 0.3)[1]
    frames, rest = [], []
    for place, angle, out, wide in ((frames, angle, out, wide), (rest, 0, 0, 0)):
        at_jaw = head @ shift(1, 0, 0) @ turn(2, 0.4)[1] @ turn(0, angle)[1]
        at_tongue = at_jaw @ shift(0, 0.5, 0.25 + out) @ turn(0, 0.2)[1] @ np.diag([1, 1 + wide, 1, 1])
        place += [head, at_jaw, at_tongue]
    points = np.array(GRID + TEETH)
    points[[0, 3]] += shapes[1] * np.array([(0.5, 0, 0), (0.5, 0.25, 0)])
    points[12] += shapes[0] * np.array((-0.25, 0, 0.5))
    moved = [frame @ np.linalg.inv(still) for frame, still in zip(frames, rest)]
    for v in range(len(points)):
        blend = moved[0] if v < 8 else moved[1] if v >= 16 else 0.75 * moved[2] + 0.25 * moved[1]
        points[v] = (blend @ [*points[v], 1])[:3]
    return points, np.array(frames)[:, :3]


def rig(gui=False, about=None):
    return riglogic_rig.rig_of(FakeReader(), FakeLogic(), FakeInstance(), gui, about=about, version="1")


class RigLogicRig(unittest.TestCase):
    def test_poses_are_those_of_the_joints_and_shapes(self):
        poses = np.random.default_rng(1).uniform(0, 1, (20, 3)).astype(np.float32)
        positions, frames = rig().evaluate(poses)
        for pose, found, places in zip(poses, positions, frames):
            points, true = expected(*pose.astype(float))
            np.testing.assert_allclose(places, true, atol=1e-6)
            np.testing.assert_allclose(found, points, atol=1e-6)
        np.testing.assert_allclose(rig().evaluate(np.zeros((1, 3), np.float32))[0][0], GRID + TEETH, atol=1e-12)

    def test_what_the_rig_has(self):
        found = rig()
        self.assertEqual([control.name for control in found.controls], RAW[:3])
        self.assertEqual([control.group for control in found.controls], ["jaw", "mouth", "mouth"])
        self.assertEqual([control.mirror for control in found.controls], ["", RAW[2], RAW[1]])
        self.assertEqual([joint.name for joint in found.joints], ["head", "FACIAL_C_Jaw", "FACIAL_C_Tongue"])
        self.assertEqual([joint.parent for joint in found.joints], [None, 0, 1])
        self.assertEqual(
            [joint.numbers for joint in found.joints],
            [(), ("rotate_x",), ("move_x", "move_y", "move_z", "scale_y")],
        )
        self.assertEqual([(mesh.name, mesh.vertices, mesh.polygons) for mesh in found.meshes],
                         [("head_lod0_mesh", 16, 9), ("teeth_lod0_mesh", 3, 1)])  # fmt: skip
        self.assertEqual(found.polygon_corners[:4].tolist(), [0, 1, 5, 4])
        self.assertEqual(found.polygon_corners[-3:].tolist(), [18, 17, 16])
        corners, uvs = found.rest_positions[found.polygon_corners], found.uvs[found.uv_corners]
        np.testing.assert_allclose(uvs, 0.25 * corners[:, :2])

    def test_controls_of_the_face_board(self):
        found = rig(gui=True)
        self.assertEqual([(c.name, c.minimum, c.maximum) for c in found.controls],
                         [(GUI[0], -1, 1), (GUI[1], 0, 1), (GUI[2], 0, 1)])  # fmt: skip
        self.assertEqual([control.mirror for control in found.controls], ["", GUI[2], GUI[1]])
        positions, _ = found.evaluate(np.array([(-1, 0.5, 0.25)], np.float32))
        np.testing.assert_allclose(positions[0], expected(0.5, 0.5, 0.25)[0], atol=1e-6)

    def test_it_bakes_with_its_joints_and_without_learning(self):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "face.fbk")
            kept = rig(about=riglogic_rig.NO_LEARNING)
            with self.assertRaisesRegex(facebaker.InvalidArgumentError, "learning from it is forbidden"):
                facebaker.bake(kept, out, recipe="compact", poses=300, progress=None)
            baked = facebaker.bake(kept, out, recipe="untrained", poses=300, progress=None)
            self.assertFalse(baked.document["learned"])
            face = baked.load()
        self.assertEqual([joint.name for joint in face.driven_joints], ["FACIAL_C_Jaw", "FACIAL_C_Tongue"])
        self.assertEqual([joint.name for joint in face.joints], ["head"])
        poses = np.random.default_rng(2).uniform(0, 1, (50, 3)).astype(np.float32)
        off = np.linalg.norm(face.evaluate_batch(poses) - rig().evaluate(poses)[0], axis=-1)
        self.assertLess(off.max(), 1e-3 * np.linalg.norm(np.ptp(GRID, 0)))

    def test_two_angles_are_a_rotation_about_any_axis(self):
        self.assertEqual(riglogic_rig.moving_numbers([3, 5, 9 + 4, 9 + 8], 2),
                         [("rotate_x", "rotate_y", "rotate_z"), ("rotate_y", "scale_z")])  # fmt: skip

    def test_joints_in_a_circle_are_refused(self):
        with self.assertRaisesRegex(ValueError, "below itself"):
            riglogic_rig.depth(0, [1, 0])

    def test_without_texture_coordinates_of_a_mesh_there_are_none(self):
        reader = FakeReader()
        reader.getVertexLayoutTextureCoordinateIndices = lambda mesh: [] if mesh == 2 else list(range(16))
        meshes = riglogic_rig.Meshes(reader)
        self.assertIsNone(meshes.uvs)
        self.assertIsNone(meshes.uv_polygons)

    def test_a_file_is_read_by_the_modules_and_baked(self):
        reader = FakeReader()
        reader.read = lambda: None
        reader.getTranslationUnit = lambda: 1
        status = types.SimpleNamespace(isOk=lambda: True, get=lambda: types.SimpleNamespace(message="no DNA"))
        opened, configured = [], []

        class FileStream:
            AccessMode_Read, OpenMode_Binary = "read", "binary"

            def __init__(self, *arguments):
                opened.append(arguments)

        def make_logic(given, configuration):
            configured.append((given, configuration.floatingPointType, configuration.rotationType))
            return FakeLogic()

        dna = types.SimpleNamespace(FileStream=FileStream, BinaryStreamReader=lambda stream: reader, Status=status,
                                    TranslationUnit_cm=0, TranslationUnit_m=1)  # fmt: skip
        riglogic = types.SimpleNamespace(
            Configuration=types.SimpleNamespace, FloatingPointType_Float="float", RotationType_Quaternions="quaternions",
            RigLogic=make_logic, RigInstance=lambda logic: FakeInstance(),
        )  # fmt: skip
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, dna=dna, riglogic=riglogic):
            path, out = os.path.join(folder, "face.dna"), os.path.join(folder, "face.fbk")
            with open(path, "wb") as file:
                file.write(b"DNA")
            self.assertEqual(riglogic_rig.main([path, out, "--poses", "100", "--up", "z"]), 0)
            face = facebaker.load(out)
            status.isOk = lambda: False
            with self.assertRaisesRegex(RuntimeError, "face.dna: no DNA"):
                riglogic_rig.load(path)
        self.assertEqual(opened[0], (path, "read", "binary"))
        self.assertEqual(configured, [(reader, "float", "quaternions")])
        self.assertEqual((face.units, face.up_axis, len(face.driven_joints)), ("m", "z", 2))

    def test_without_the_modules_it_says_so(self):
        with self.assertRaisesRegex(ImportError, "dna"):
            riglogic_rig.load("no such file.dna")


if __name__ == "__main__":
    unittest.main()
