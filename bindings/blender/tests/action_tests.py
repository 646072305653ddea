"""Which curves of actions animate which rig; in_blender.py runs it."""

import unittest

import bpy
import numpy as np
from addon_support import found
from blender_scenes import two_rigs

from facebaker_blender import action_shots
from facebaker_blender.action_curves import ActionCurves

SLOTS = hasattr(bpy.types, "ActionSlot")


def animate(rig, action, turns, frames=(1, 11)):
    """Turns a rig's jaw about x, in the action's slot for this rig where there are slots."""
    animation = rig.animation_data_create()
    animation.action = action
    if SLOTS:
        own = [slot for slot in action.slots if slot.name_display == rig.name]
        animation.action_slot = own[0] if own else action.slots.new("OBJECT", rig.name)
    for frame, turn in zip(frames, turns):
        rig.pose.bones["jaw"].rotation_euler.x = turn
        rig.pose.bones["jaw"].keyframe_insert("rotation_euler", frame=frame, index=0)


def action_of(name):
    action = bpy.data.actions.new(name)
    action.use_fake_user = True
    return action


def range_of(settings, rig):
    control = next(c for c in settings.controls if c.channel.object == rig and c.name.endswith("jaw.rot_x"))
    return round(control.minimum, 3), round(control.maximum, 3)


class ActionTest(unittest.TestCase):
    def animated(self, together):
        """Both rigs animated, with slots of one action, or by an action each."""
        ann, bob = two_rigs()
        actions = [action_of("talk")] * 2 if together else [action_of("ann talks"), action_of("bob talks")]
        animate(ann, actions[0], (0, -0.6))
        animate(bob, actions[1], (0, 1.5), (1, 31))
        return actions

    def test_a_range_is_of_the_own_rig(self):
        for together in (False, True) if SLOTS else (False,):
            self.animated(together)
            settings, _ = found()
            self.assertEqual(range_of(settings, "ann"), (-0.66, 0.349))
            self.assertEqual(range_of(settings, "bob"), (-0.349, 1.65))

    def test_shots_are_of_both_rigs(self):
        if not SLOTS:
            self.skipTest("this Blender's actions have no slots")
        self.animated(True)
        settings, _ = found()
        shot, = action_shots.find_shots(settings.controls)
        self.assertEqual((shot.action, shot.first, shot.last), ("talk", 1, 31))
        values = action_shots.shot_values(settings, shot)
        peaks = {c.channel.object: values[:, i] for i, c in enumerate(settings.controls) if c.name.endswith("jaw.rot_x")}
        self.assertAlmostEqual(float(peaks["ann"].min()), -0.6, 5)
        self.assertAlmostEqual(float(peaks["ann"].max()), 0, 5)
        self.assertAlmostEqual(float(peaks["bob"].max()), 1.5, 5)
        # Of one rig the shot is as long as its own curves.
        own = [c for c in settings.controls if c.channel.object == "ann"]
        self.assertEqual(action_shots.find_shots(own)[0].last, 11)

    def test_actions_that_nothing_uses(self):
        ann, bob = two_rigs()
        action = action_of("library")
        animate(ann, action, (0, 0.8))
        ann.animation_data.action = None
        curves = ActionCurves()
        # A slot that is named after one of them is its own; without slots nothing says whose the action is.
        self.assertEqual([len(curves.of(action, rig)) for rig in (ann, bob)], [1, 0] if SLOTS else [1, 1])
        ann.name = "carl"
        self.assertEqual([len(ActionCurves().of(action, rig)) for rig in (ann, bob)], [1, 1])
        self.assertEqual(len(ActionCurves().of(action, bob.data)), 0)

    def test_strips_use_actions(self):
        actions = self.animated(SLOTS)
        for rig in bpy.data.objects["ann"], bpy.data.objects["bob"]:
            animation = rig.animation_data
            action, slot = animation.action, getattr(animation, "action_slot", None)
            animation.action = None
            strip = animation.nla_tracks.new().strips.new("below", 1, action)
            if slot:
                strip.action_slot = slot
        settings, _ = found()
        self.assertEqual(range_of(settings, "ann"), (-0.66, 0.349))
        self.assertEqual(len(actions), 2)
        np.testing.assert_equal(range_of(settings, "bob"), (-0.349, 1.65))
