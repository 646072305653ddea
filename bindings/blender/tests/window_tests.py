"""The panel, without a window: what it draws, and its buttons that need no bake; in_blender.py runs it."""

import math
import types
import unittest
from unittest import mock

import bpy
from addon_support import add_action
from blender_scenes import constraint_scene, shape_key_scene

import facebaker_blender
from facebaker_blender import window_controls, window_errors, window_panel, window_solve, window_text
from facebaker_blender.channels import SettingsError
from facebaker_blender.control_rows import UNGROUPED

PANELS = (
    window_panel.FACEBAKER_PT_rig, window_panel.FACEBAKER_PT_bake, window_panel.FACEBAKER_PT_preview, window_solve.FACEBAKER_PT_solve,
)  # fmt: skip
NARROW, USUAL = 220, 280  # sidebars at scale 1: Blender 3.4's own, and a usual one


class FakeLayout:
    """In place of Blender's: keeps what is drawn, in rows of (kind, text or name, options)."""

    def __init__(self, rows):
        self.rows = rows

    def _same(self, **_):
        return FakeLayout(self.rows)

    row = column = box = _same

    def label(self, text="", icon="NONE"):
        self.rows.append(("label", text, icon))

    def prop(self, owner, name, text=None, icon="NONE", emboss=True):
        shown = owner.bl_rna.properties[name].name if text is None else text
        self.rows.append(("prop", shown, (owner, name, getattr(self, "use_property_split", False))))

    def operator(self, name, text=None, icon="NONE", emboss=True):
        group, name = name.split(".")
        shown = getattr(getattr(bpy.ops, group), name).get_rna_type().name if text is None else text
        pressed = types.SimpleNamespace(name=name)
        self.rows.append(("operator", shown, pressed))
        return pressed

    def template_list(self, kind, name, *_, **__):
        self.rows.append(("list", name, kind))


def drawn(panel, width=NARROW):
    """The rows that a panel draws in a sidebar of this width."""
    rows = []
    view = types.SimpleNamespace(region_to_view=lambda x, y: (x, y))
    region = types.SimpleNamespace(type="UI", width=width, view2d=view)
    context = types.SimpleNamespace(scene=bpy.context.scene, preferences=bpy.context.preferences, region=region)
    panel.draw(types.SimpleNamespace(layout=FakeLayout(rows)), context)
    return rows


def labels(rows):
    return [text for kind, text, _ in rows if kind == "label"]


class WindowTest(unittest.TestCase):
    """With the controls of constraint_scene(), or another scene, in the window."""

    def setUp(self):
        facebaker_blender.register()
        self.open(constraint_scene)

    def tearDown(self):
        for part in "rig", "bake", "face":
            window_errors.set_problem(part, "")
        facebaker_blender.unregister()

    def open(self, scene):
        scene()
        bpy.ops.facebaker.choose()
        with mock.patch("facebaker_blender.window_operators.still_controls", return_value=[]):
            self.assertEqual(bpy.ops.facebaker.find(), {"FINISHED"})
        self.chosen = bpy.context.scene.facebaker

    def control(self, name):
        return next(item for item in self.chosen.controls if item.name == name)

    def used(self):
        return [item.name for item in self.chosen.controls if item.use]


class TextTest(WindowTest):
    def test_nothing_is_cut(self):
        rig = bpy.data.objects["rig"]
        add_action(rig, "an action with a long name that tells what it is for", "jaw", "rotation_euler", [(0, 0, 0), (0.5, 0, 0)])
        bpy.ops.facebaker.find()
        window_errors.set_problem("face", "/a/long/path/to/characters/and/their/faces.fbk: cannot be read " * 3)
        for width in NARROW, USUAL:
            for panel in PANELS:
                rows = drawn(panel, width)
                self.assertTrue(rows)
                for kind, text, options in rows:
                    room = width - 55 - (20 if kind == "label" and options != "NONE" else 0)
                    if kind == "prop" and text and options[2]:
                        room *= 0.4
                    self.assertLessEqual(window_text.measured(text), room, f"{panel.__name__}, {width}: {text}")

    def test_a_wide_sidebar_has_fewer_rows(self):
        window_errors.set_problem("rig", "word " * 50)
        rows = [labels(drawn(PANELS[0], width)) for width in (NARROW, USUAL, 900)]
        self.assertGreater(len(rows[0]), len(rows[1]))
        self.assertGreater(len(rows[1]), len(rows[2]))
        for lines in rows:
            self.assertEqual(" ".join(lines).lower().count("word"), 50)

    def test_errors_are_told_whole_and_copied(self):
        self.chosen.out = "/proc/nowhere/face.fbk"
        with self.assertRaises(RuntimeError):
            bpy.ops.facebaker.bake()
        message = window_errors.problem_of("bake")
        self.assertRegex(message, "^/proc/nowhere: nothing can be written there: ")
        rows = drawn(PANELS[1])
        self.assertIn(message.replace(" ", ""), "".join(labels(rows)).replace(" ", ""))
        (copy,) = [pressed for kind, _, pressed in rows if kind == "operator" and pressed.name == "copy"]
        self.assertEqual(copy.text, message)
        holder = types.SimpleNamespace(window_manager=types.SimpleNamespace(clipboard=""))
        window_errors.FACEBAKER_OT_copy.execute(copy, holder)
        self.assertEqual(holder.window_manager.clipboard, message)
        for item in self.chosen.controls:
            item.use = False
        bpy.data.objects["face"].name = "another"
        with self.assertRaises(RuntimeError):
            bpy.ops.facebaker.report()
        self.assertIn("bake it first", window_errors.problem_of("face"))

    def test_an_error_goes_when_the_button_succeeds(self):
        with mock.patch("facebaker_blender.window_operators.chosen_meshes", side_effect=SettingsError("no mesh")):
            with self.assertRaises(RuntimeError):
                bpy.ops.facebaker.choose()
        self.assertEqual(window_errors.problem_of("rig"), "no mesh")
        bpy.ops.facebaker.choose()
        self.assertEqual(window_errors.problem_of("rig"), "")

    def test_what_should_not_happen_is_told_too(self):
        with mock.patch("traceback.print_exception") as printed:
            text = window_errors.message_of(KeyError("jaw"))
        self.assertEqual(text, "failed, which it should not: KeyError: 'jaw'")
        printed.assert_called_once()


class RangeTest(WindowTest):
    def test_rotations_are_edited_in_degrees(self):
        jaw = self.control("jaw.rot_x")
        self.assertEqual(jaw.range_names, ("minimum_angle", "rest_angle", "maximum_angle"))
        self.assertEqual(self.control("jaw.loc_z").range_names, ("minimum", "rest", "maximum"))
        for name in jaw.range_names:
            self.assertEqual(jaw.bl_rna.properties[name].unit, "ROTATION")
        self.assertAlmostEqual(jaw.maximum_angle, 0.5)
        jaw.maximum_angle = math.radians(45)
        settings = self.chosen.settings()
        saved = next(control for control in settings.controls if control.name == "jaw.rot_x")
        self.assertAlmostEqual(saved.maximum, math.pi / 4, 6)  # radians
        self.chosen.control = list(self.chosen.controls).index(jaw)
        bpy.ops.facebaker.fold(group=jaw.group)
        shown = [(options[1], text) for kind, text, options in drawn(PANELS[0]) if kind == "prop" and text in ("Minimum", "Maximum")]
        self.assertEqual(shown, [("minimum_angle", "Minimum"), ("maximum_angle", "Maximum")])

    def test_a_range_that_is_none(self):
        self.control("jaw.rot_x").maximum_angle = -1
        with self.assertRaisesRegex(SettingsError, '"jaw.rot_x": its minimum is not below its maximum'):
            self.chosen.settings()


class TickTest(WindowTest):
    def test_all_none_and_groups(self):
        every = self.used()
        bpy.ops.facebaker.tick(every=True, use=False)
        self.assertEqual(self.used(), [])
        bpy.ops.facebaker.tick(group="jaw", use=True)
        self.assertEqual(set(self.used()), {item.name for item in self.chosen.controls if item.group == "jaw"})
        self.assertEqual([control.name for control in self.chosen.settings().controls], self.used())
        self.control("jaw.rot_x").use = False
        count = sum(item.group == "jaw" for item in self.chosen.controls)
        self.assertIn(f"{count - 1} of {count}", labels(drawn(PANELS[0])))
        # The tick of a group some of which is ticked ticks the rest.
        ticks = [pressed for kind, _, pressed in drawn(PANELS[0]) if kind == "operator" and pressed.name == "tick"]
        self.assertEqual([(tick.use, tick.every) for tick in ticks[:2]], [(True, True), (False, True)])
        self.assertTrue(next(tick for tick in ticks[2:] if tick.group == "jaw").use)
        bpy.ops.facebaker.tick(every=True, use=True)
        self.assertEqual(self.used(), every)

    def test_folding(self):
        lists = lambda: [name for kind, name, _ in drawn(PANELS[0]) if kind == "list"]
        groups = list(dict.fromkeys(item.group for item in self.chosen.controls))
        self.assertGreater(len(groups), 1)
        self.assertEqual(lists(), [])
        bpy.ops.facebaker.fold(group="jaw")
        self.assertEqual(lists(), ["group jaw"])
        bpy.ops.facebaker.fold(group="jaw")
        self.assertEqual(lists(), [])

    def test_searching(self):
        self.chosen.search = "JAW.rot"
        self.assertEqual([name for kind, name, _ in drawn(PANELS[0]) if kind == "list"], ["group jaw"])
        bpy.ops.facebaker.tick(every=True, use=False)
        self.assertEqual({item.name for item in self.chosen.controls if not item.use}, {f"jaw.rot_{axis}" for axis in "xyz"})

    def test_lists_show_their_group(self):
        kind = window_controls.FACEBAKER_UL_controls

        def shown(**state):
            given = {"filter_name": "", "use_filter_invert": False, "use_filter_sort_alpha": False, "bitflag_filter_item": 4}
            flags, _ = kind.filter_items(types.SimpleNamespace(**{**given, **state}), bpy.context, self.chosen, "controls")
            # Blender inverts them then.
            return [c.name for c, flag in zip(self.chosen.controls, flags) if bool(flag) != state.get("use_filter_invert", False)]

        jaw = [item.name for item in self.chosen.controls if item.group == "jaw"]
        self.assertEqual(shown(list_id="group jaw"), jaw)
        self.assertEqual(shown(list_id="group jaw", filter_name="rot_X"), ["jaw.rot_x"])
        self.assertEqual(
            shown(list_id="group jaw", filter_name="rot_x", use_filter_invert=True), [name for name in jaw if name != "jaw.rot_x"]
        )

    def test_controls_without_a_group_are_headed(self):
        self.open(shape_key_scene)
        for item in self.chosen.controls:
            item.group = "" if item.name == "head.rot_z" else item.group
        headings = labels(drawn(PANELS[0]))
        self.assertIn(UNGROUPED, headings)
        self.assertGreater(headings.index(UNGROUPED), headings.index("mouth"))


class BakePanelTest(WindowTest):
    """States of a bake, as the panel shows them."""

    def state(self, **values):
        progress = types.SimpleNamespace(lines=["Training: 60 %", "About 2 minutes left"])
        given = {"running": False, "failure": "", "document": None, "unfinished": False, "progress": progress, **values}
        job = types.SimpleNamespace(process=types.SimpleNamespace(**given))
        with mock.patch.object(window_panel, "job_of", return_value=job), mock.patch.object(window_panel, "start_watching"):
            return drawn(PANELS[1])

    def test_the_first_line_is_the_verdict(self):
        verdict = "Worst vertex of 240 frames: off by 0.31 mm (mouth, left, frame 12 of \"talk\")."
        rows = self.state(document={"verdict": verdict, "bytes": 350_000, "poses": 12000, "rig_calls": 13000})
        text = " ".join(labels(rows))
        self.assertTrue(text.startswith(verdict), text)
        self.assertEqual(rows[0][0], "label")

    def test_warnings_are_behind_an_arrow(self):
        document = {"verdict": "", "warnings": ["the first of them is long " * 5, "a second"]}
        rows = self.state(document=document)
        self.assertIn("2 warnings", [text for kind, text, _ in rows if kind == "prop"])
        self.assertNotIn("A second.", labels(rows))
        self.chosen.show_warnings = True
        self.assertIn("A second.", labels(self.state(document=document)))

    def test_progress_is_that_of_the_tool(self):
        rows = self.state(running=True)
        self.assertEqual(labels(rows), ["Training: 60 %", "About 2 minutes left"])
        self.assertEqual([text for kind, text, _ in rows if kind == "operator"], ["Stop"])

    def test_pages_are_offered_where_there_is_a_face(self):
        archive = types.SimpleNamespace(is_file=lambda: True)
        job = types.SimpleNamespace(archive=archive, report_page=archive)
        viewer = types.SimpleNamespace(running=True, address="http://127.0.0.1:4711/?token=" + 32 * "f")
        buttons = lambda: [text for kind, text, _ in drawn(PANELS[2]) if kind == "operator"]
        self.assertEqual(buttons(), ["Show baked face"])
        with mock.patch.object(window_panel, "job_of", return_value=job), mock.patch.object(window_panel, "viewer", viewer):
            self.assertEqual(
                buttons(), ["Show baked face", "Open report", "Open viewer", "Copy address", "End viewer"]
            )
            self.assertIn(viewer.address, "".join(labels(drawn(PANELS[2]))))
            job.report_page = types.SimpleNamespace(is_file=lambda: False)
            self.assertNotIn("Open report", buttons())

    def test_failures(self):
        rows = self.state(failure="the rig said no", unfinished=True)
        self.assertEqual(labels(rows)[0], "The rig said no")
        self.assertIn("Continue the bake", [text for kind, text, _ in rows if kind == "operator"])
        rows = self.state(failure="interrupted; what is done is kept, run the same command to go on", unfinished=True)
        self.assertIn("The bake was stopped.", " ".join(labels(rows)))
        self.assertNotIn("run the same command", " ".join(labels(rows)))
