"""Names and patterns that choose nothing are errors that name what there is; in_blender.py runs it."""

import unittest

import bpy
from addon_support import BakingTest, found
from blender_scenes import constraint_scene, select_bone

from facebaker_blender import headless
from facebaker_blender.bone_choice import FindOptions
from facebaker_blender.channels import SettingsError, there_are

LAYERS = bpy.app.version < (4, 0, 0)  # of bones, in place of collections


class ChoiceTest(unittest.TestCase):
    def refused(self, pattern, **options):
        with self.assertRaisesRegex(SettingsError, pattern):
            found(FindOptions(**options))

    def test_bones(self):
        _, _, rig = constraint_scene()
        self.refused('no bone that is shown matches "jw\\*"; there are "jaw", ', bones=("jaw", "jw*"))
        self.refused('no kind of channel is called "spin"; there are "location", "rotation", "scale"', kinds=("spin",))
        bones = rig.pose.bones
        for bone in bones:
            owner = bone if hasattr(bone, "select") else bone.bone
            owner.select = False
        self.refused("no bone is selected", selected=True)
        select_bone(rig, "jaw")
        settings, _ = found(FindOptions(selected=True))
        self.assertEqual({c.channel.bone for c in settings.controls}, {"jaw"})

    def test_collections(self):
        _, _, rig = constraint_scene()
        if LAYERS:
            rig.data.bones["jaw"].layers = [layer == 3 for layer in range(32)]
            self.refused('no bone collection is called "7"; there are "3", "0"|there are "0", "3"', collections=("3", "7"))
            name = "3"
        else:
            face = rig.data.collections.new("Face")
            face.assign(rig.data.bones["jaw"])
            rig.data.collections.new("Empty")
            self.refused('no bone collection is called "face"; there are "Face", ', collections=("Face", "face"))
            self.refused('the bone collection "Empty" has no bone that is shown', collections=("Empty",))
            name = "Face"
        settings, _ = found(FindOptions(collections=(name,)))
        self.assertEqual({c.channel.bone for c in settings.controls}, {"jaw"})

    def test_collections_within_collections(self):
        _, _, rig = constraint_scene()
        if LAYERS or not hasattr(rig.data, "collections_all"):
            self.skipTest("this Blender's bone collections do not nest")
        face = rig.data.collections.new("Face")
        rig.data.collections.new("Finer", parent=face).assign(rig.data.bones["jaw"])
        settings, _ = found(FindOptions(collections=("Face",)))
        self.assertEqual({c.channel.bone for c in settings.controls}, {"jaw"})

    def test_lists_of_names(self):
        self.assertEqual(there_are([]), "there are none")
        self.assertEqual(there_are(["a", "talk", "b"], "tlk"), 'there are "talk", "a", "b"')
        self.assertTrue(there_are(map(str, range(50))).endswith('"11" and 38 more'))


class HeadlessChoiceTest(BakingTest):
    def test_what_the_command_line_names(self):
        out, name = self.folder / "x.fbk", "18" if LAYERS else "Fce"
        for words, message in {
            ("--mesh", "fce"): 'there is no object "fce"; there are "face", "rig"',
            ("--mesh", "rig"): '"rig" is of type ARMATURE, no mesh',
            ("--armature", "rgi"): 'there is no object "rgi"; there are "rig", ',
            ("--bones", "hd*"): 'no bone that is shown matches "hd*"; there are "head"',
            ("--collections", name): f'no bone collection is called "{name}"; there are ',
            ("--channels", "location,rotatoin"): 'no kind of channel is called "rotatoin"',
            ("--train-shot", "nd"): 'no action that animates controls is called "nd"; there are "nod"',
            ("--settings", "x.json", "--bones", "head"): "--settings says what is baked; --bones has no meaning beside it",
        }.items():
            printed = self.headless("bake", "--out", out, *words, ends=1)
            self.assertIn(message, printed)
            self.assertNotIn("Traceback", printed)

    def test_whatever_fails_ends_with_an_error(self):
        damaged = self.folder / "damaged.fbk"
        damaged.write_bytes(b"no archive")
        settings = self.folder / "face.json"
        self.headless("controls", "--out", settings)
        printed = self.headless("show", damaged, "--settings", settings, ends=1)
        self.assertIn("facebaker_blender show: ", printed)
        self.assertNotIn("Traceback", printed)

        def fail(_):
            raise AttributeError("no such attribute")

        before, headless.run_show = headless.run_show, fail
        try:
            self.assertEqual(headless.main(["show", str(damaged)]), 1)
        finally:
            headless.run_show = before
