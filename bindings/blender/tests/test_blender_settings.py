"""What of the Blender add-on needs no Blender: settings, names, ranges, rotations, progress, command lines, processes."""

import json
import math
import os
import pathlib
import shlex
import signal
import sys
import tempfile
import time
import unittest

from facebaker_blender.bake_process import BakeProcess
from facebaker_blender.bake_settings import (
    BakeOptions, BakeSettings, Shot, load_settings, save_settings, settings_document, settings_of,
)  # fmt: skip
from facebaker_blender.channels import Channel, SceneControl, SettingsError, named_apart
from facebaker_blender.control_names import face_part, mirror_channel_name, other_side
from facebaker_blender.progress_lines import BakeProgress
from facebaker_blender.ranges import assumed_range, control_range, tighter
from facebaker_blender.rotations import quaternion_of_vector, vector_of_quaternion
from facebaker_blender.tool_command import BlenderCommand, bake_words, library_of, source_text


def example():
    controls = (
        SceneControl("lip.L.loc_x", Channel("location", "rig", "lip.L", 0), -0.1, 0.2, 0.0, "mouth"),
        SceneControl("smile", Channel("shape_key", "face", key="smile"), 0.0, 1.0, 0.0, mirror=""),
        SceneControl("mode", Channel("property", "rig", "jaw", key="mode", whole=True), 0.0, 3.0, 1.0),
    )
    shots = (Shot("talk", 1, 20), Shot("walk", 5, 9, "train"))
    bake = BakeOptions("compact", rig_budget=500, extra=("--max-bytes", "100000"))
    return BakeSettings("Ann", ("face", "teeth"), controls, "rig", shots, "apply", bake, "none")


class LibraryTest(unittest.TestCase):
    def test_a_library_is_found_beside_its_program(self):
        with tempfile.TemporaryDirectory() as folder:
            tool = pathlib.Path(folder).resolve() / "bin" / "facebaker"
            for path in tool, tool.parents[1] / "lib" / "some-processor" / "libfacebaker.so.0":
                path.parent.mkdir(parents=True)
                path.touch()
            self.assertEqual(library_of(str(tool)), path)
            path.with_name("libfacebaker.so").touch()
            self.assertEqual(library_of(str(tool)), path.with_name("libfacebaker.so"))
            self.assertIsNone(library_of(str(tool.parent / "bin" / "facebaker")))
            self.assertIsNone(library_of(None))


class SettingsTest(unittest.TestCase):
    def test_a_file_holds_all(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "face.json"
            save_settings(example(), path)
            self.assertEqual(load_settings(path), example())
            self.assertEqual(os.listdir(folder), ["face.json"])
            path.write_text("{")
            with self.assertRaisesRegex(SettingsError, "face.json: "):
                load_settings(path)

    def test_faults_are_named(self):
        def broken(change):
            document = json.loads(json.dumps(settings_document(example())))
            change(document)
            with self.assertRaises(SettingsError) as caught:
                settings_of(document)
            return str(caught.exception)

        cases = {
            "format is not facebaker-blender": lambda d: d.update(format="x"),
            "version 9": lambda d: d.update(version=9),
            '"name" is missing': lambda d: d.pop("name"),
            '"meshes", entry 0: 1': lambda d: d.update(meshes=[1]),
            "no mesh": lambda d: d.update(meshes=[]),
            'two of mesh "face"': lambda d: d.update(meshes=["face", "face"]),
            'two of control "smile"': lambda d: d["controls"].append(d["controls"][1]),
            "a range from 1.0 to 1.0": lambda d: d["controls"][1].update(min=1),
            "a range from nan": lambda d: d["controls"][1].update(min=math.nan),
            "rests at 5.0": lambda d: d["controls"][1].update(rest=5),
            '"max" is "high"': lambda d: d["controls"][1].update(max="high"),
            'a channel of kind "spin"': lambda d: d["controls"][0]["channel"].update(kind="spin"),
            "needs a bone and an axis": lambda d: d["controls"][0]["channel"].update(axis=3),
            "without a key": lambda d: d["controls"][1]["channel"].pop("key"),
            'has no "axes"': lambda d: d["controls"][0]["channel"].update(axes=1),
            'bake: has no "epoch"': lambda d: d["bake"].update(epoch=3),
            'bake: "workers" is "2"': lambda d: d["bake"].update(workers="2"),
            'split "learn"': lambda d: d["shots"][0].update(split="learn"),
            "ends at frame 0": lambda d: d["shots"][0].update(last=0),
            'modifiers "bake"': lambda d: d.update(modifiers="bake"),
            'driven_joints "auto" is none of keep, none': lambda d: d.update(driven_joints="auto"),
        }
        for message, change in cases.items():
            self.assertIn(message, broken(change))

    def test_the_digest_is_of_the_deformation(self):
        settings = example()
        digest = settings.deformation
        same = BakeSettings("Ann", settings.meshes, settings.controls, "rig", (), "apply", driven_joints="none")
        self.assertEqual(same.deformation, digest)
        self.assertNotEqual(settings.without(["smile"]).deformation, digest)

    def test_controls_of_one_name(self):
        def key(mesh, name, mirror=""):
            return SceneControl(name, Channel("shape_key", mesh, key=name), 0, 1, 0, mirror=mirror)

        named = named_apart([key("a", "x_L", "x_R"), key("a", "x_R", "x_L"), key("b", "x_L", "x_R"), key("b", "y", "z")])
        self.assertEqual([(c.name, c.mirror) for c in named], [("a.x_L", ""), ("x_R", ""), ("b.x_L", ""), ("y", "")])
        both = [key(mesh, f"x_{side}", f"x_{other}") for mesh in "ab" for side, other in ("LR", "RL")]
        self.assertEqual(named_apart(both)[2].mirror, "b.x_R")


class NamesTest(unittest.TestCase):
    def test_sides(self):
        for here, there in {
            "lip.T.L.001": "lip.T.R.001", "eye_l": "eye_r", "browDownLeft": "browDownRight", "L_brow": "R_brow",
            "mouthSmile_R": "mouthSmile_L", "browDownL": "browDownR", "LEFT eye": "RIGHT eye", "left.up": "right.up",
        }.items():  # fmt: skip
            self.assertEqual(other_side(here), there)
            self.assertEqual(other_side(there), here)
        for name in "jaw", "upright", "lips", "Lid", "tongue.001", "cleft":
            self.assertEqual(other_side(name), "", name)

    def test_only_channels_that_do_the_same_are_mirrored(self):
        def mirror(kind, axis):
            return mirror_channel_name(Channel(kind, "rig", "lip.L", axis))

        self.assertEqual([mirror("location", a) for a in range(3)], ["", "lip.R.loc_y", "lip.R.loc_z"])
        self.assertEqual([mirror("rotation", a) for a in range(3)], ["lip.R.rot_x", "", ""])
        self.assertEqual(mirror("scale", 0), "lip.R.scale_x")
        self.assertEqual(mirror_channel_name(Channel("shape_key", "face", key="smileLeft")), "smileRight")
        self.assertEqual(mirror_channel_name(Channel("property", "rig", "arm.L", key="follow")), "arm.R.follow")

    def test_parts(self):
        for name, part in {
            "lip.T.L": "mouth", "brow.B.R.002": "brows", "lid.T.L": "eyes", "jaw_master": "jaw", "ear.L": "ears",
            "eyeBlinkLeft": "eyes", "mouthSmile_L": "mouth", "gear.L": "", "slider": "", "clear": "", "spine": "",
        }.items():  # fmt: skip
            self.assertEqual(face_part(name), part, name)


class RangesTest(unittest.TestCase):
    def test_ranges(self):
        self.assertEqual(control_range((None, None), None, (-1, 1), 0), (-1, 1, 0))
        self.assertEqual(control_range((0.2, 0.5), (-3, 3), (-1, 1), 0), (0.2, 0.5, 0.2))
        low, high, rest = control_range((None, 0.5), (-3, 3), (-1, 1), 0)
        self.assertEqual((high, rest), (0.5, 0))
        self.assertAlmostEqual(low, -3.6)
        self.assertEqual(control_range((0, 0), None, (-1, 1), 0), (0, 0, 0))
        self.assertEqual(control_range((None, None), (0, 0.5), (-1, 1), 0), (-1, 1, 0))
        self.assertEqual(assumed_range("location", 0.02, 1), (-0.01, 0.01))
        self.assertEqual(assumed_range("location", 2, 1), (-0.03, 0.03))
        self.assertEqual(tighter((None, 2), (-1, 3)), (-1, 2))

    def test_rotations(self):
        for vector in (0.3, -0.5, 0.2), (0, 0, 0), (1e-12, 0, 0), (3.1, 0, 0), (0, -2, 2):
            quaternion = quaternion_of_vector(vector)
            self.assertAlmostEqual(sum(q * q for q in quaternion), 1)
            for one, other in zip(vector_of_quaternion(quaternion), vector):
                self.assertAlmostEqual(one, other)
            for one, other in zip(vector_of_quaternion([-3 * q for q in quaternion]), vector):
                self.assertAlmostEqual(one, other)
        half = quaternion_of_vector((math.pi / 2, 0, 0))
        self.assertAlmostEqual(half[0], math.sqrt(0.5))
        self.assertAlmostEqual(half[1], math.sqrt(0.5))


class ProgressTest(unittest.TestCase):
    def test_lines(self):
        progress = BakeProgress()
        self.assertEqual(progress.text, "starting")
        for line in (
            "Blender 3.4.1\n", "note: what the rig will be asked, at 7 ms a pose:\n", "sampling poses: 45 %, 1:05 left\n",
        ):  # fmt: skip
            progress.read(line)
        self.assertEqual(progress.text, "sampling poses: 45 %, 1:05 left")
        progress.read("sampling poses: 2:07")
        progress.read("training: 3 %, 9 s left")
        self.assertEqual((progress.finished, progress.percent, progress.left), (["sampling poses: 2:07"], 3, "9 s"))
        progress.read("facebaker bake: face.fbk: no space left on device")
        self.assertEqual(progress.text, "face.fbk: no space left on device")
        self.assertEqual(len(progress.notes), 1)


class CommandTest(unittest.TestCase):
    def test_words_survive_the_shell(self):
        blender = BlenderCommand("/opt/my blender/blender", ["--factory-startup"])
        source = source_text(blender, "/a b/it's.blend", "/a b/settings.json")
        self.assertTrue(source.startswith("exec:"))
        words = shlex.split(source[len("exec:") :])
        self.assertEqual(words[0], "/opt/my blender/blender")
        self.assertIn("/a b/it's.blend", words)
        self.assertEqual(words[-2:], ["--", "/a b/settings.json"])
        options = BakeOptions("hero", rig_budget=0, poses=7, workers=3, extra=("--levels", "3"))
        words = bake_words("tool", source, "/x/face.fbk", "/x/work", options)
        self.assertEqual(words[:3], ["tool", "bake", source])
        self.assertNotIn("--rig-budget", words)
        self.assertEqual(words[words.index("--poses") + 1], "7")
        self.assertEqual(words[-2:], ["--levels", "3"])


class ProcessTest(unittest.TestCase):
    TOOL = (
        "import sys, time\n"
        "print('sampling poses: 3 s', file=sys.stderr, flush=True)\n"
        "print('training: 50 %, 9 s left', file=sys.stderr, flush=True)\n"
        "time.sleep(float(sys.argv[1]))\n"
        "print('{\"bytes\": 7}')"
    )

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def words(self, seconds):
        return [sys.executable, "-c", self.TOOL, str(seconds)]

    def test_a_bake_that_completes(self):
        process = BakeProcess(self.folder)
        self.assertFalse(process.unfinished)
        process.start(self.words(0))
        self.assertTrue(process.wait(30))
        self.assertFalse(process.poll())
        self.assertEqual((process.document, process.unfinished), ({"bytes": 7}, False))
        self.assertEqual(process.progress.finished, ["sampling poses: 3 s"])

    def test_another_session_finds_it(self):
        first = BakeProcess(self.folder)
        first.start(self.words(60))
        other = BakeProcess(self.folder)
        self.assertTrue(other.running)
        with self.assertRaises(RuntimeError):
            other.start(self.words(0))
        for _ in range(300):
            if other.poll() and other.progress.stage == "training":
                break
            time.sleep(0.1)
        self.assertEqual(other.progress.text, "training: 50 %, 9 s left")
        other.stop()
        self.assertTrue(first.wait(30))
        self.assertFalse(other.running)
        self.assertTrue(other.unfinished)
        self.assertEqual(other.command, self.words(60))

    def test_a_number_that_another_process_has_got(self):
        state = {"process": os.getpid(), "began": "1", "command": ["x"]}
        (self.folder / "process.json").write_text(json.dumps(state))
        process = BakeProcess(self.folder)
        self.assertFalse(process.running)
        process.stop()  # leaves that process alone: this test goes on
        self.assertTrue(process.unfinished)
        self.assertEqual(signal.getsignal(signal.SIGINT), signal.default_int_handler)


if __name__ == "__main__":
    unittest.main()
