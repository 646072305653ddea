"""Which groups the add-on puts controls into; in_blender.py runs it."""

import unittest

import bpy
from addon_support import found
from blender_scenes import armature, empty_scene, grid

from facebaker_blender.bone_groups import bone_groups, layer_names

LAYERS = bpy.app.version < (4, 0, 0)  # of bones, in place of collections
# Meaningless names: a head on two bones, from which an arm, a leg and two bones alone hang; a hand with three fingers.
TREE = {
    "Bone": "", "Bone.001": "Bone", "Bone.002": "Bone.001", "Bone.003": "Bone.002", "Bone.004": "Bone.003",
    "Bone.005": "Bone.001", "Bone.006": "Bone.005", "Bone.007": "Bone.001", "Bone.008": "Bone.001",
}  # fmt: skip


def tree(parents):
    """An armature of bones {name: parent's name}, with a mesh that all of them move."""
    empty_scene()
    rig = armature([(name, (0, 0, place), (0, 0, place + 0.5), parent) for place, (name, parent) in enumerate(parents.items())])
    face = grid()
    for name in parents:
        face.vertex_groups.new(name=name).add(range(len(face.data.vertices)), 1, "REPLACE")
    face.modifiers.new("Armature", "ARMATURE").object = rig
    bpy.context.view_layer.update()
    return rig


def sort_bones(rig, name, bones):
    """Puts bones into a collection, before Blender 4 into a bone group."""
    if LAYERS:
        group = rig.pose.bone_groups.new(name=name)
        for bone in bones:
            rig.pose.bones[bone].bone_group = group
        return
    collection = rig.data.collections.new(name)
    for bone in bones:
        collection.assign(rig.data.bones[bone])


def members(rig, names=None):
    """{group: its bones}"""
    groups = {}
    bones = [bone for bone in rig.pose.bones if names is None or bone.name in names]
    for bone, group in bone_groups(rig, bones).items():
        groups.setdefault(group, []).append(bone)
    return groups


class GroupTest(unittest.TestCase):
    def test_meaningless_names_are_grouped_by_what_hangs_together(self):
        rig = tree(TREE)
        numbered = lambda *numbers: [f"Bone.{number:03}" for number in numbers]
        self.assertEqual(
            members(rig),
            {"Bone": ["Bone", *numbered(1, 7, 8)], "Bone.002": numbered(2, 3, 4), "Bone.005": numbered(5, 6)},
        )
        # Without the two at the top, which an artist may have locked or hidden.
        chosen = numbered(*range(2, 9))
        self.assertEqual(
            members(rig, chosen),
            {"Bone.002": numbered(2, 3, 4), "Bone.005": numbered(5, 6), "Bone.001": numbered(7, 8)},
        )

    def test_a_chain_is_one_group_and_most_of_a_rig_is_divided(self):
        rig = tree({"a": "", "b": "a", "c": "b"})
        self.assertEqual(members(rig), {"a": ["a", "b", "c"]})
        face = {"top": "", "arm": "top", "arm2": "arm", "skull": "top"}
        for side in "lr":
            face.update({f"{side}{place}": f"{side}{place - 1}" if place else "skull" for place in range(3)})
        self.assertEqual(
            members(tree(face)),
            {"top": ["top"], "arm": ["arm", "arm2"], "skull": ["skull"], "l0": ["l0", "l1", "l2"], "r0": ["r0", "r1", "r2"]},
        )

    def test_parts_of_the_face_come_first(self):
        rig = tree({"head": "", "jaw": "head", "Bone": "jaw", "Bone.001": "head", "lip": "head", "Bone.002": "head"})
        sort_bones(rig, "Brows", ["Bone.002", "lip"])
        self.assertEqual(
            members(rig),
            {"neck": ["head"], "jaw": ["jaw", "Bone"], "mouth": ["lip"], "brows": ["Bone.002"], "Bone.001": ["Bone.001"]},
        )

    def test_collections_that_tell_bones_apart(self):
        rig = tree(TREE)
        sort_bones(rig, "Everything", TREE)
        if not LAYERS:  # a bone has one bone group
            sort_bones(rig, "Left", ["Bone.002", "Bone.003"])
            self.assertEqual(members(rig)["Left"], ["Bone.002", "Bone.003"])
        self.assertNotIn("Everything", members(rig))
        self.assertIn("Bone.005", members(rig))

    def test_bone_groups_or_collections_of_some(self):
        rig = tree(TREE)
        sort_bones(rig, "Antennae", ["Bone.007", "Bone.008"])
        self.assertEqual(members(rig)["Antennae"], ["Bone.007", "Bone.008"])
        settings, _ = found()
        self.assertIn("Antennae", {control.group for control in settings.controls})

    def test_collections_around_collections(self):
        rig = tree(TREE)
        if not hasattr(rig.data, "collections_all"):
            self.skipTest("this Blender's bone collections do not nest")
        outer = rig.data.collections.new("Mouth controls")
        inner = rig.data.collections.new("Fine", parent=outer)
        inner.assign(rig.data.bones["Bone.007"])
        self.assertEqual(members(rig)["mouth"], ["Bone.007"])

    def test_names_of_layers(self):
        if not LAYERS:
            self.skipTest("this Blender's bones have no layers")
        rig = tree(TREE)
        for bone in rig.data.bones:
            bone.layers = [layer == (5 if bone.name > "Bone.004" else 3) for layer in range(32)]
        rig.data.layers = [True] * 32
        self.assertEqual(layer_names(rig), {})
        text = bpy.data.texts.new("panel.py")
        text.write("row.prop(context.active_object.data, 'layers', index=5, toggle=True, text='Whiskers (fine)')\n")
        rig["panel"] = text
        self.assertEqual(layer_names(rig), {5: "Whiskers (fine)"})
        self.assertEqual(members(rig)["Whiskers (fine)"], ["Bone.005", "Bone.006", "Bone.007", "Bone.008"])

    def test_shape_keys_are_of_the_part_that_their_mesh_is(self):
        empty_scene()
        for name in "teeth", "head":
            mesh = grid(name)
            mesh.shape_key_add(name="Basis")
            mesh.shape_key_add(name="Key 1")
            mesh.shape_key_add(name="smile")
        bpy.context.view_layer.update()
        settings, _ = found()
        self.assertEqual(
            {control.name: control.group for control in settings.controls},
            {"teeth.Key 1": "jaw", "teeth.smile": "mouth", "head.Key 1": "", "head.smile": "mouth"},
        )


class RigifyGroupTest(unittest.TestCase):
    def test_a_whole_human(self):
        empty_scene()
        bpy.ops.preferences.addon_enable(module="rigify")
        bpy.ops.object.armature_human_metarig_add()
        metarig = bpy.context.object
        bpy.ops.pose.rigify_generate()
        rig = bpy.context.object
        for kept in True, False:  # with the metarig, and where an artist has deleted it
            names = [bone.name for bone in rig.pose.bones if not bone.name.startswith(("ORG-", "MCH-", "DEF-"))]
            groups = members(rig, names)
            self.assertLessEqual({"brows", "eyes", "nose", "cheeks", "mouth", "jaw", "tongue", "ears", "neck"}, set(groups))
            self.assertIn("hand_ik.L", groups["Arm.L (IK)"])
            self.assertIn("thigh_fk.R", groups["Leg.R (FK)"])
            self.assertTrue(set(groups).isdisjoint({"FK", "IK", "Tweak", "Special", ""}), list(groups))
            if kept:
                bpy.data.objects.remove(metarig)
