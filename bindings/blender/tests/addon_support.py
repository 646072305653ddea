"""What tests of the add-on share: paths, scenes as found, and bakes by Blenders without a window."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import bpy  # noqa: E402
from blender_scenes import shape_key_scene  # noqa: E402

from facebaker_blender.tool_command import add_package_path  # noqa: E402

add_package_path()

from facebaker_blender import find_controls  # noqa: E402
from facebaker_blender.bake_job import this_blender  # noqa: E402
from facebaker_blender.bake_settings import BakeSettings  # noqa: E402
from facebaker_blender.bone_choice import FindOptions  # noqa: E402
from facebaker_blender.scene_choice import chosen_armatures, chosen_meshes  # noqa: E402

HEADLESS = HERE.parent / "facebaker_blender" / "headless.py"


def found(options=FindOptions(), reference=""):
    meshes = chosen_meshes(bpy.context, [])
    controls, notes = find_controls.find_controls(chosen_armatures(meshes, []), meshes, options)
    return BakeSettings("face", tuple(mesh.name for mesh in meshes), tuple(controls), reference), notes


def scene_state():
    """Everything about a scene that evaluating it might change."""
    state = {}
    for scene_object in bpy.data.objects:
        shown = [(m.name, m.show_viewport) for m in scene_object.modifiers]
        state[scene_object.name] = (
            scene_object.hide_viewport, scene_object.hide_get(), shown, [list(row) for row in scene_object.matrix_world],
            {key: scene_object[key] for key in scene_object.keys() if not hasattr(scene_object[key], "keys")},
        )  # fmt: skip
        if scene_object.pose:
            state[scene_object.name] += (scene_object.data.pose_position, [
                (b.name, b.rotation_mode, tuple(b.location), tuple(b.rotation_quaternion), tuple(b.rotation_euler),
                 tuple(b.rotation_axis_angle), tuple(b.scale), [tuple(row) for row in b.matrix])
                for b in scene_object.pose.bones
            ])  # fmt: skip
        keys = getattr(scene_object.data, "shape_keys", None)
        if keys:
            state[scene_object.name] += ([(block.name, block.value) for block in keys.key_blocks],)
        animation = scene_object.animation_data
        if animation:
            state[scene_object.name] += (animation.action, [t.mute for t in animation.nla_tracks])
    return state


def add_action(rig, name, bone, attribute, values, step=10):
    rig.animation_data_create()
    rig.animation_data.action = action = bpy.data.actions.new(name)
    for index, value in enumerate(values):
        setattr(rig.pose.bones[bone], attribute, value)
        rig.pose.bones[bone].keyframe_insert(attribute, frame=1 + step * index)
    return action


def headless(scene, *words, ends=0):
    """What headless.py printed for a scene file; it has to end with this code."""
    blender = this_blender().program
    command = [blender, "-b", str(scene), "--factory-startup", "-P", str(HEADLESS), "--", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert done.returncode == ends, f"ended with {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout + done.stderr


class BakingTest(unittest.TestCase):
    """Has a folder with scene.blend: shape_key_scene() with an action "nod" that nothing uses."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="facebaker-blender-"))
        shape_key_scene()
        rig = bpy.data.objects["rig"]
        add_action(rig, "nod", "head", "rotation_euler", [(0, 0, 0), (0, 0, 0.3), (0, 0, -0.3)])
        rig.animation_data.action = None
        rig.pose.bones["head"].rotation_euler = (0, 0, 0)
        bpy.data.actions["nod"].use_fake_user = True
        cls.scene = cls.folder / "scene.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(cls.scene))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def headless(self, *words, scene=None, ends=0):
        return headless(scene or self.scene, *words, ends=ends)
