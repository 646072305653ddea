"""Meshes that depend on time are refused by name; in_blender.py runs it."""

import unittest

import bpy
import numpy as np
from addon_support import found
from blender_scenes import geometry_nodes, grid, shape_key_scene

from facebaker_blender.channels import SettingsError
from facebaker_blender.scene_evaluator import SceneEvaluator


def lift_by_time(tree, geometry, linked=True, mute=False):
    """Moves points up by the seconds of the scene."""
    clock, move, combine = (tree.nodes.new(f"{kind}") for kind in (
        "GeometryNodeInputSceneTime", "GeometryNodeSetPosition", "ShaderNodeCombineXYZ",
    ))  # fmt: skip
    clock.label, clock.mute = "clock", mute
    tree.links.new(clock.outputs["Seconds"], combine.inputs["Z"])
    tree.links.new(geometry, move.inputs["Geometry"])
    if linked:
        tree.links.new(combine.outputs["Vector"], move.inputs["Offset"])
    return move.outputs["Geometry"]


def simulated(tree, geometry):
    """Keeps in a simulation zone what the first frame had."""
    start, end = tree.nodes.new("GeometryNodeSimulationInput"), tree.nodes.new("GeometryNodeSimulationOutput")
    start.pair_with_output(end)
    tree.links.new(geometry, start.inputs["Geometry"])
    tree.links.new(start.outputs["Geometry"], end.inputs["Geometry"])
    return end.outputs["Geometry"]


class TimeTest(unittest.TestCase):
    def setUp(self):
        self.face, _ = shape_key_scene()
        self.settings, _ = found()

    def refused(self, pattern):
        with self.assertRaisesRegex(SettingsError, pattern):
            with SceneEvaluator(self.settings):
                pass

    def accepted(self):
        with SceneEvaluator(self.settings) as evaluator:
            poses = np.array([[c.maximum for c in self.settings.controls]], np.float32)
            self.assertGreater(np.abs(evaluator.evaluate(poses)[0] - evaluator.rest_positions).max(), 0.1)

    def test_scene_time(self):
        geometry_nodes(self.face, lift_by_time, "Lift")
        self.refused('"face": modifier "Lift": node "clock" of "Lift" depends on the frame')
        self.face.modifiers[0].show_viewport = False
        self.accepted()

    def test_scene_time_that_has_no_effect(self):
        geometry_nodes(self.face, lambda tree, geometry: lift_by_time(tree, geometry, linked=False))
        self.accepted()
        self.face.modifiers.clear()
        geometry_nodes(self.face, lambda tree, geometry: lift_by_time(tree, geometry, mute=True))
        self.accepted()

    def test_a_group_within(self):
        inner = geometry_nodes(None, lift_by_time, "inner")

        def outer(tree, geometry):
            group = tree.nodes.new("GeometryNodeGroup")
            group.node_tree = inner
            tree.links.new(geometry, group.inputs[0])
            return group.outputs[0]

        geometry_nodes(self.face, outer, "outer")
        self.refused('"face": modifier "outer": node "clock" of "inner" depends on the frame')

    def test_a_simulation_zone(self):
        if not hasattr(bpy.types, "GeometryNodeSimulationInput"):
            self.skipTest("this Blender has no simulation zones")
        geometry_nodes(self.face, simulated, "Zone")
        self.refused('"face": modifier "Zone": node "Simulation (In|Out)put" of "Zone" depends on the frames before')

    def test_modifiers(self):
        for kind in "WAVE", "MESH_CACHE", "OCEAN", "BUILD", "MESH_SEQUENCE_CACHE":
            self.face.modifiers.new("Water", kind)
            self.refused(rf'"face": modifier "Water" \({kind}\) depends on the frame, ')
            self.face.modifiers.clear()
        for kind in "CLOTH", "SOFT_BODY", "DYNAMIC_PAINT":
            self.face.modifiers.new("Rags", kind)
            self.refused(rf'"face": modifier "Rags" \({kind}\) depends on the frames before, ')
            self.face.modifiers.clear()

    def test_the_shape_of_another_object(self):
        hull = grid("hull")
        wrap = self.face.modifiers.new("Wrap", "SHRINKWRAP")
        wrap.target = hull
        wrap.wrap_method, wrap.offset = "NEAREST_SURFACEPOINT", 0.1
        self.accepted()
        hull.modifiers.new("Rags", "CLOTH")
        self.refused('modifier "Wrap" takes the shape of another object: "hull": modifier "Rags".*the frames before')
        for kind, attribute in {
            "SURFACE_DEFORM": "target", "VERTEX_WEIGHT_PROXIMITY": "target", "MESH_DEFORM": "object",
            "DATA_TRANSFER": "object", "BOOLEAN": "object",
        }.items():  # fmt: skip
            self.face.modifiers.clear()
            setattr(self.face.modifiers.new("Near", kind), attribute, hull)
            self.refused('modifier "Near" takes the shape of another object: "hull": modifier "Rags"')
        self.face.modifiers.clear()

        def with_hull(tree, geometry):
            info, join = tree.nodes.new("GeometryNodeObjectInfo"), tree.nodes.new("GeometryNodeJoinGeometry")
            info.inputs["Object"].default_value = hull
            tree.links.new(info.outputs["Geometry"], join.inputs[0])
            tree.links.new(geometry, join.inputs[0])
            return join.outputs[0]

        geometry_nodes(self.face, with_hull, "Joined")
        self.refused('modifier "Joined" takes the shape of another object: "hull": modifier "Rags"')
        # Or as an input that the modifier gives.
        self.face.modifiers.clear()
        tree = geometry_nodes(self.face, lambda _, geometry: geometry, "Given")
        if hasattr(tree, "interface"):
            key = tree.interface.new_socket("Hull", in_out="INPUT", socket_type="NodeSocketObject").identifier
        else:
            key = tree.inputs.new("NodeSocketObject", "Hull").identifier
        self.accepted()
        modifier = self.face.modifiers["Given"]
        if hasattr(modifier, "properties"):  # from Blender 5.2 on
            getattr(modifier.properties.inputs, key).value = hull
        else:
            modifier[key] = hull
        self.refused('modifier "Given" takes the shape of another object: "hull": modifier "Rags"')

    def test_drivers_that_read_the_frame_are_noted(self):
        keys = self.face.data.shape_keys
        self.assertEqual([note for note in found()[1] if "frame" in note], [])
        keys.key_blocks["turn"].driver_remove("value")
        keys.key_blocks["turn"].driver_add("value").driver.expression = "sin(frame / 10)"
        notes = [note for note in found()[1] if "reads the frame; it is baked as in frame 1" in note]
        self.assertEqual(len(notes), 1, found()[1])
        self.assertIn('key_blocks["turn"].value', notes[0])
