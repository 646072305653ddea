"""Baking in this process: rigs of every form, options, results, errors and what stops a call."""

import datetime
import inspect
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest

try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
import toy_rig
from facebaker import _interop
from facebaker._library import bake_library as library
from facebaker._calls import Call

TESTS = pathlib.Path(__file__).parent


def error_of(face, count=50):
    """The largest distance of a vertex from the rig on poses of another seed, over the diagonal."""
    controls = toy_rig.poses(count, 7)
    distances = np.linalg.norm(face.evaluate_batch(controls) - toy_rig.positions(controls), axis=2)
    return distances.max() / face.diagonal


class BakingTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def bake(self, rig, **options):
        given = {"use": "variant", "poses": 300, **options}
        return facebaker.bake(rig, self.folder / "toy.fbk", **given)


class SourcesTest(BakingTest):
    def test_a_callable(self):
        shot = facebaker.Clip("shot", toy_rig.poses(40, 3), split="test", fps=24)
        rig = toy_rig.make(clips=[shot], about={"author": "Ada Example"}, version="1")
        result = self.bake(rig, licence="CC0-1.0", measure="quality")
        face = result.load()
        self.assertLess(error_of(face), 1e-4)
        self.assertEqual(
            [(c.name, c.group, c.minimum, c.maximum, c.rest) for c in face.controls],
            [tuple(c) for c in toy_rig.CONTROLS],
        )
        self.assertEqual([c.mirror for c in face.controls], ["", "smile_R", "smile_L"])
        self.assertEqual((face.controls[0].arkit, face.controls[0].facs), ("jawOpen", "AU26"))
        self.assertEqual((face.find("jawOpen"), face.find("AU26")), (0, 0))
        self.assertEqual((face.licence, face.about), ("CC0-1.0", {"author": "Ada Example"}))
        self.assertEqual(result.method.name, "hero")
        self.assertEqual(result.method.archive, result.path.read_bytes())
        self.assertEqual([(c.name, c.split, c.errors.frames) for c in result.method.clips], [("shot", "test", 40)])
        self.assertEqual(result.method.unseen.frames, 40)
        self.assertLess(result.method.unseen.max, 1e-4)
        self.assertEqual(face.certificate["independent"]["frames"], 40)
        self.assertGreater(len(result.details()["methods"][0]["quality"]["vertex_rms"]), 80)
        self.assertIn("mse", repr(result))
        again = pickle.loads(pickle.dumps(result))
        self.assertEqual(again.document, result.document)
        with self.assertRaisesRegex(ValueError, "pickled"):
            again.details()
        self.assertEqual(facebaker.verify(face).vertices, 81)

    def test_sources_say_what_joints_are_and_draw_test_poses(self):
        with self.assertRaisesRegex(ValueError, 'joints is "some", none of auto, ignore, controls'):
            facebaker.Source(toy_rig.make(), joints="some")
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "joints are of glTF files"):
            facebaker.Source(toy_rig.make(), control_joints=["jaw"])
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "skip_broken is of glTF files"):
            facebaker.Source(toy_rig.make(), skip_broken=True)
        with facebaker.Source(toy_rig.make(), test_poses=20) as source:
            self.assertEqual([clip.split for clip in source.clips], ["test"] * 3)
            self.assertEqual(sum(len(np.asarray(clip.controls)) for clip in source.clips), 20)

    def test_arrays(self):
        result = self.bake(toy_rig.make_recording(), recipe="linear")
        self.assertEqual(result.method.poses, 300)
        self.assertIn("not measured", repr(result.method))
        compact = self.bake(toy_rig.make_recording(), recipe="compact")
        self.assertIn(f"mse {compact.held_back.mse:.2g}", repr(compact))
        face = result.load()
        self.assertEqual(face.polygon_sizes.tolist(), [4] * 64)
        self.assertLess(error_of(face), 0.05)

    def test_a_dataset_folder_of_everything(self):
        rest, quads = toy_rig.REST, toy_rig.QUADS
        picture = facebaker.Image("skin", "image/png", b"not looked at")
        recording = toy_rig.make_recording()
        clips = [
            facebaker.Clip(c.name, c.controls, c.kind, c.split, 25, c.positions, np.asarray(c.controls)[:, :1] ** 2)
            for c in recording.clips
        ]
        rig = toy_rig.make(
            None,
            clips=clips,
            uvs=rest[:, :2] / 2 + 0.5,
            meshes=[facebaker.Mesh("face", 81, 64, (facebaker.MaterialRun(60, 0), facebaker.MaterialRun(4)))],
            materials=[facebaker.Material("skin", roughness=0.5, textures=(facebaker.Texture("base_colour", 0),))],
            images=[picture],
            sockets=[facebaker.Socket("brow", [70, 71, 80])],
            channels=[facebaker.Channel("crease", unit="m")],
            joints=[facebaker.Joint("neck"), facebaker.Joint("head", 0)],
            skin=facebaker.Skin(np.ones((81, 1), int), np.ones((81, 1))),
        )  # fmt: skip
        facebaker.save_dataset(rig, self.folder / "toy")
        baked = [
            self.bake(source, recipe="linear").load() for source in (self.folder / "toy", str(self.folder / "toy"), rig)
        ]
        self.assertEqual(baked[0].source, baked[1].source)
        face = baked[0]
        live = self.bake(toy_rig.make(
            lambda controls: (toy_rig.positions(controls), controls[:, :1] ** 2), uvs=rig.uvs, meshes=rig.meshes,
            materials=rig.materials, images=rig.images, sockets=rig.sockets, channels=rig.channels, joints=rig.joints,
            skin=rig.skin,
        )).load()  # fmt: skip
        for face in *baked, live:
            self.assertEqual(face.meshes[0].materials, rig.meshes[0].materials)
            self.assertEqual(face.meshes[0].vertex_slice, slice(0, 81))
            self.assertEqual(face.materials, rig.materials)
            self.assertEqual(face.images, (picture,))
            self.assertEqual([(s.name, s.vertices.tolist()) for s in face.sockets], [("brow", [70, 71, 80])])
            self.assertEqual(face.channels, rig.channels)
            self.assertEqual([(j.name, j.parent) for j in face.joints], [("neck", None), ("head", 0)])
            self.assertEqual(face.skin.joints.tolist(), [[1]] * 81)
            self.assertTrue((face.skin.weights == 1).all())
            np.testing.assert_allclose(face.uvs, rig.uvs, atol=1e-3)
            values = np.empty((20, 1), np.float32)
            controls = toy_rig.poses(20, 5)
            face.evaluate_batch(controls, channels=values)
            self.assertLess(abs(values - controls[:, :1] ** 2).max(), 0.3 if face is not live else 1e-3)
        self.assertEqual([q for q in np.split(face.polygon_corners, 64)][5].tolist(), list(quads[5]))

    def test_a_served_rig(self):
        program = f"{sys.executable} -B -m facebaker.serve toy_rig:make"
        os.environ["PYTHONPATH"] = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
        here, there = self.folder / "here.fbk", self.folder / "there.fbk"
        with facebaker.Source("exec:" + program, workers=2) as source:
            self.assertTrue(source.live)
            controls = toy_rig.poses(9)
            np.testing.assert_allclose(source.evaluate(controls), toy_rig.positions(controls), atol=1e-6)
            facebaker.bake(source, there, use="variant", poses=200)
        facebaker.bake(toy_rig.make(), here, use="variant", poses=200)
        controls = toy_rig.poses(50)
        np.testing.assert_array_equal(*(facebaker.load(face).evaluate_batch(controls) for face in (here, there)))

    def test_a_source_says_what_it_is(self):
        with facebaker.Source(toy_rig.make(clips=[facebaker.Clip("shot", toy_rig.poses(5), split="test")])) as source:
            self.assertEqual((source.name, source.units, source.up_axis, source.live), ("toy", "cm", "y", True))
            self.assertEqual(source.controls, tuple(toy_rig.CONTROLS))
            self.assertEqual(source.controls[1].mirror, "smile_R")
            np.testing.assert_array_equal(source.rest_positions, toy_rig.REST)
            self.assertEqual(source.clips[0].split, "test")
            for clip in 0, "shot":
                np.testing.assert_allclose(source.read(clip, 1, 3), toy_rig.positions(toy_rig.poses(5)[1:4]), atol=1e-6)
            with self.assertRaisesRegex(ValueError, 'no clip "short"; there are shot'):
                source.read("short")
            with self.assertRaisesRegex(ValueError, "frames 3 to 6 of a clip that has 5"):
                source.read(0, 3, 3)
            self.assertEqual(source.evaluate(np.zeros((0, 3))).shape, (0, 81, 3))
            with self.assertRaisesRegex(facebaker.InvalidArgumentError, "jaw_open"):
                source.evaluate([[2, 0, 0]])
        self.assertIn("closed", repr(source))
        with self.assertRaisesRegex(ValueError, "closed"):
            source.evaluate(toy_rig.poses(1))

    def test_options_reach_the_library(self):
        np.save(self.folder / "curves.npy", toy_rig.poses(30, 9))
        examples = self.folder / "curves.npy"
        exact = toy_rig.poses(2, 11)
        shot = facebaker.Clip("shot", exact, split="test")
        result = self.bake(
            toy_rig.make(clips=[shot]), recipe="compact", exact=["shot:0,1"], level_shares=[0.5, 0.2], work=self.folder / "work",
            examples=[examples], seed=5, normal_weight=0, created="2030-01-01", learning_curve=True, threads=1,
        )  # fmt: skip
        face = result.load()
        self.assertEqual([pose.name for pose in face.exact_poses], ["shot:0", "shot:1"])
        away = np.linalg.norm(face.evaluate_batch(exact) - toy_rig.positions(exact), axis=2).max()
        self.assertLess(away, 3e-6 * face.diagonal)
        self.assertEqual(face.level_count, 3)
        self.assertTrue((self.folder / "work").is_dir())
        self.assertIn("2030-01-01", face.provenance.values())
        self.assertEqual(face.provenance["seed"], 5)
        names = [option.name for option in facebaker.options()]
        self.assertIn("normal_weight", names)
        for option in facebaker.options():
            self.assertEqual(option.kind == "word", bool(option.words), option)
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, 'no option "normal_wieght"; the closest is "normal_weight"'):
            self.bake(toy_rig.make(), recipe="compact", normal_wieght=1)
        with self.assertRaisesRegex(facebaker.Error, "earlier"):
            self.bake(toy_rig.make(), recipe="compact", reuse=self.folder / "earlier")
        with self.assertRaisesRegex(facebaker.BadDataError, "PNG"):
            self.bake(toy_rig.make(), recipe="linear", thumbnail=b"GIF89a")
        with self.assertRaises(facebaker.LimitError):
            self.bake(toy_rig.make(), recipe="compact", max_bytes=100)
        self.bake(toy_rig.make(), recipe="compact", max_bytes=100, force=True)

    def test_a_rig_whose_opening_was_interrupted_is_closed(self):
        class Enough(Exception):
            pass

        def stop(note):
            raise Enough

        recording = toy_rig.make_recording()
        shifted = facebaker.Clip("wide", toy_rig.poses(3) * 3, "dense", positions=toy_rig.positions(toy_rig.poses(3)))
        rig = toy_rig.make(None, clips=[*recording.clips, shifted])
        with self.assertRaises(Enough):
            facebaker.Source(rig, note=stop)
        self.assertTrue(any("wide" in note for note in facebaker.Source(rig).notes))

    def test_sampling_resumes_and_its_folder_is_a_source(self):
        shot = facebaker.Clip("extra", toy_rig.poses(7), split="test")
        given = {"poses": 120, "clips": [shot], "seed": 3}
        first = facebaker.sample(toy_rig.make(), self.folder / "poses", **given)
        self.assertGreaterEqual(first.poses, 120)
        self.assertGreater(first.evaluated, 0)
        self.assertEqual(facebaker.sample(toy_rig.make(), self.folder / "poses", **given).evaluated, 0)
        result = self.bake(self.folder / "poses", recipe="linear")
        measured = facebaker.evaluate(result.path, self.folder / "poses")
        self.assertEqual([clip.name for clip in measured.method.clips], ["extra"])

    def test_a_plan_is_evaluated_by_hand_checked_and_baked(self):
        shot = facebaker.Clip("extra", toy_rig.poses(7), split="test")
        plan = facebaker.plan(toy_rig.make(), self.folder / "plan", poses=300, clips=[shot], seed=3)
        self.assertGreaterEqual(plan.poses, 307)
        unfinished = facebaker.check(plan.folder)
        self.assertFalse(unfinished.bakeable)
        self.assertEqual((unfinished.poses, unfinished.evaluated), (plan.poses, 0))
        self.assertTrue(any("train" in fault for fault in unfinished.faults), unfinished.faults)
        for clip in json.loads((plan.folder / "dataset.json").read_text())["clips"]:
            controls = np.load(plan.folder / clip["controls"])
            np.save(plan.folder / clip["points"], toy_rig.positions(controls).astype("f4"))
        done = facebaker.check(plan.folder)
        self.assertTrue(done.bakeable, done.faults)
        self.assertEqual(done.evaluated, plan.poses)
        face = self.bake(plan.folder).load()
        self.assertLess(error_of(face), 3e-2)  # without a rig to ask

    def test_a_schema_is_planned(self):
        controls = [{"name": "a", "min": 0, "max": 1, "default": 0, "group": "g"}]
        schema = {"format": "facebaker-dataset", "version": 1, "name": "s", "units": "cm", "up_axis": "y"}
        (self.folder / "s.json").write_text(json.dumps({**schema, "controls": controls}))
        self.assertGreater(facebaker.plan(self.folder / "s.json", self.folder / "plan", poses=20).poses, 20)
        with self.assertRaisesRegex(ValueError, "clips of a schema"):
            clip = facebaker.Clip("c", [[0.5]])
            facebaker.plan(self.folder / "s.json", self.folder / "plan", poses=20, clips=[clip])
        with self.assertRaises(facebaker.NotFoundError):
            facebaker.check(self.folder / "none")


class ToolsTest(BakingTest):
    def test_comparing(self):
        result = facebaker.compare(toy_rig.make_recording(), methods=["linear", "compact"])
        self.assertEqual([method.name for method in result.methods], ["linear", "compact"])
        self.assertLess(result.methods[1].unseen.mse, result.methods[0].unseen.mse)
        self.assertEqual(result.failures, ())
        self.assertEqual(result.methods[0].load().vertex_count, 81)
        self.assertIn("linear (variant): mse", repr(result))

    def test_options_without_a_keyword_go_by_their_name(self):
        def bytes_of(**named):
            result = facebaker.compare(toy_rig.make_recording(), methods=["compact"], **named)
            return result.methods[0].archive

        self.assertEqual(bytes_of(), bytes_of(normal_weight=1, skip_failing=True))
        self.assertNotEqual(bytes_of(), bytes_of(normal_weight=0.0))
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "normal_weight is 5, not 0 to 4"):
            bytes_of(normal_weight=5)

    def test_measuring_inspecting_and_packing(self):
        result = self.bake(toy_rig.make(), recipe="compact")
        recording = toy_rig.make_recording()
        for archive in result.path, result.method.archive, result.load(), facebaker.load(result.method.archive):
            measured = facebaker.evaluate(archive, recording)
            self.assertEqual(measured.method.unseen.frames, 40)
            self.assertLess(measured.method.unseen.max, 1e-3)
        everything = facebaker.evaluate(result.path, recording, split="all")
        self.assertEqual([clip.split for clip in everything.method.clips], ["train", "test"])
        self.assertEqual(facebaker.inspect(result.path).document["vertices"], 81)
        packed = facebaker.pack(result.method.archive, self.folder / "less.fbk", licence="MIT", max_error=0.01,
                                about={"author": "Bo Example"}, sockets=[facebaker.Socket("chin", [0, 1, 9])])  # fmt: skip
        self.assertEqual(packed.bytes_before, len(result.method.archive))
        self.assertLess(packed.displacement.max, 0.01)
        self.assertEqual(packed.archive, (self.folder / "less.fbk").read_bytes())
        face = facebaker.load(self.folder / "less.fbk")
        self.assertEqual((face.licence, face.about["author"], face.sockets[0].name), ("MIT", "Bo Example", "chin"))
        self.assertTrue(packed.within_limits)
        changes = facebaker.diff(result.path, face)
        self.assertIn("licence", str(changes.document))
        with self.assertRaises(facebaker.LimitError):
            facebaker.pack(result.path, max_bytes=10)

    def test_rights_are_judged_by_a_day(self):
        baked = self.bake(toy_rig.make(), recipe="linear")
        self.assertFalse(facebaker.rights(baked.path).stated)
        said = {"expires": "2024-02-29", "ai_training": "notAllowed", "learning": "allowed", "suspendable": "yes"}
        face = facebaker.load(facebaker.pack(baked.path, about={"rights": said}).archive)
        held, ended = facebaker.rights(face, on="2024-02-29"), facebaker.rights(face, on=datetime.date(2024, 3, 1))
        self.assertEqual((held.stated, held.expired, ended.expired), (True, False, True))
        self.assertTrue(facebaker.rights(face).expired)
        self.assertEqual(held.last_day, datetime.date(2024, 2, 29))
        permissions = held.learning, held.ai_training, held.ai_generative_training, held.data_mining
        self.assertEqual(permissions, ("forbidden", "notAllowed", "allowed", None))
        self.assertTrue(held.suspendable)
        self.assertEqual(ended.binding[0], "expired: the rights ended on 2024-02-29")
        self.assertEqual(ended.unread, ())
        self.assertIn("expired: the rights ended on 2024-02-29", repr(ended))
        self.assertEqual(facebaker.inspect(face).document["rights"]["expired"], True)
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "soon is no day"):
            facebaker.rights(face, on="soon")
        with self.assertRaisesRegex(facebaker.BadDataError, 'rights ai_training is "no"'):
            facebaker.pack(baked.path, about={"rights": {"ai_training": "no"}})

    def test_damage_is_found(self):
        data = bytearray(self.bake(toy_rig.make(), recipe="linear").method.archive)
        data[len(data) // 2] ^= 1
        with self.assertRaises(facebaker.CorruptError):
            facebaker.verify(bytes(data))

    def test_bags(self):
        face = self.bake(toy_rig.make(), recipe="linear").path
        (self.folder / "rig.txt").write_text("a rig")
        stages = []
        bag = self.folder / "bag"
        written = facebaker.bag([face], bag, sources=[self.folder / "rig.txt"], files={"access/model.glb": self.folder / "rig.txt"},
                                info=[("Source-Organization", "Examples")], date="2026-11-29",
                                progress=lambda stage, *_: stages.append(stage))  # fmt: skip
        self.assertTrue(written.valid)
        self.assertIn("verifying archives", stages)
        self.assertEqual((bag / "data/access/model.glb").read_text(), "a rig")
        self.assertIn("Source-Organization: Examples\n", (bag / "bag-info.txt").read_text())
        found = facebaker.check_bag(bag)
        self.assertEqual((found.valid, found.archives, found.faults), (True, 1, ()))
        self.assertEqual((found.files, found.bytes), (written.files, written.bytes))
        (bag / "data/source/rig.txt").unlink()
        found = facebaker.check_bag(bag)
        self.assertFalse(found.valid)
        self.assertIn(("data/source/rig.txt", "is missing; manifest-sha512.txt names it"), found.faults)
        with self.assertRaisesRegex(facebaker.FileError, "is not empty"):
            facebaker.bag([face], bag)
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "give a day as"):
            facebaker.bag(face, self.folder / "other", date="today")
        with self.assertRaises(facebaker.NotFoundError):
            facebaker.check_bag(self.folder / "none")

    def test_recipes(self):
        self.assertLessEqual({"hero", "compact", "linear"}, set(facebaker.recipes()))

    def test_defaults_are_those_of_the_library(self):
        words = {"use": facebaker._results.USES, "split": facebaker._rig.SPLITS, "joints": facebaker._source.JOINTS}
        for function, kind in (
            (facebaker.bake, "bake"), (facebaker.sample, "sample"), (facebaker.compare, "compare"),
            (facebaker.evaluate, "eval"), (facebaker.pack, "pack"), (facebaker.Source, "source"),
        ):  # fmt: skip
            desc = library.filled(getattr(_interop, f"fb_{kind}_desc"))
            fields = {name for name, *_ in desc._fields_}
            for name, parameter in inspect.signature(function).parameters.items():
                if parameter.kind != inspect.Parameter.KEYWORD_ONLY or name in ("progress", "note"):
                    continue
                self.assertIn(name, fields)
                default = parameter.default
                if isinstance(default, (tuple, type(None))):  # lists and texts that the caller need not give
                    self.assertFalse(getattr(desc, name), name)
                elif name in words:
                    self.assertEqual(getattr(desc, name), words[name].index(default), name)
                else:
                    value = getattr(desc, name)
                    self.assertEqual(value.decode() if isinstance(value, bytes) else value, default, name)


class FailingTest(BakingTest):
    def test_what_the_rig_raises_is_the_cause(self):
        def evaluate(controls):
            if (controls[:, 0] > 0.9).any():
                raise ArithmeticError("the jaw is off")
            return toy_rig.positions(controls)

        with self.assertRaises(facebaker.RigError) as caught:
            self.bake(toy_rig.make(evaluate))
        self.assertIsInstance(caught.exception.__cause__, ArithmeticError)
        self.assertRegex(
            str(caught.exception), r"jaw_open.*ArithmeticError: the jaw is off \(test_baking.py, line \d+\)"
        )
        with facebaker.Source(toy_rig.make(evaluate)) as source:
            with self.assertRaisesRegex(facebaker.RigError, "^pose 2.*the jaw is off") as of_pose:
                source.evaluate([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [0.95, 0, 0]])
            self.assertIsInstance(of_pose.exception.__cause__, ArithmeticError)
        self.assertFalse((self.folder / "toy.fbk").exists())
        pickled = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((type(pickled), pickled.status), (facebaker.RigError, 11))

    def test_poses_that_fail_are_left_out_if_asked(self):
        def evaluate(controls):
            if ((controls[:, 1] > 0.8) & (controls[:, 2] > 0.8)).any():
                raise ArithmeticError("torn")
            return toy_rig.positions(controls)

        result = facebaker.sample(toy_rig.make(evaluate), self.folder / "poses", poses=400, skip_failing=True)
        self.assertGreater(result.left_out, 0)
        self.assertTrue(any("torn" in note for note in result.notes), result.notes)

    def test_contracts(self):
        cases = {
            "shape \\(4, 81, 3\\), not": lambda c: np.repeat(toy_rig.REST[None], 4, 0),
            "not finite": lambda c: toy_rig.positions(c) + np.where(c[:, :1, None] > 0.5, np.nan, 0),
            "rest": lambda c: toy_rig.positions(c) + 1,
        }
        for sentence, evaluate in cases.items():
            with self.assertRaisesRegex(facebaker.Error, sentence):
                self.bake(toy_rig.make(evaluate))

    def test_what_is_wrong_is_named(self):
        with self.assertRaisesRegex(facebaker.NotFoundError, "nowhere"):
            self.bake("nowhere")
        with self.assertRaisesRegex(facebaker.NotFoundError, "herb"):
            self.bake(toy_rig.make(), recipe="herb")
        with self.assertRaisesRegex(ValueError, "use is 'film', none of variant, backlot"):
            self.bake(toy_rig.make(), use="film")
        with self.assertRaisesRegex(ValueError, "measure is 'speed'"):
            self.bake(toy_rig.make(), measure=["speed"])
        with self.assertRaisesRegex(facebaker.Error, '"smile_L"'):
            toy_rig.CONTROLS.append(facebaker.Control("smile_L"))
            try:
                self.bake(toy_rig.make())
            finally:
                toy_rig.CONTROLS.pop()
        with self.assertRaisesRegex(ValueError, "zero byte"):
            self.bake(toy_rig.make(), licence="a\0b")
        for name, value in {
            "poses": -1,
            "epochs": 1 << 32,
            "seed": 1 << 64,
            "max_error": float("nan"),
            "threads": -2,
        }.items():
            with self.assertRaisesRegex(ValueError, f"{name} is "):
                self.bake(toy_rig.make(), **{name: value})
        with self.assertRaisesRegex(ValueError, "workers is -1"):
            facebaker.Source(toy_rig.make(), workers=-1)
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "5000 threads"):
            self.bake(toy_rig.make(), threads=5000)
        with self.assertRaisesRegex(TypeError, "recording"):
            toy_rig.make_recording().evaluate_poses(toy_rig.poses(1))
        with self.assertRaisesRegex(ValueError, "is live"):
            facebaker.save_dataset(toy_rig.make(), self.folder)

    def test_what_leaves_the_rig_leaves_the_call(self):
        def evaluate(controls):
            if (controls[:, 0] > 0.9).any():
                sys.exit(3)
            return toy_rig.positions(controls)

        with self.assertRaises(SystemExit):
            self.bake(toy_rig.make(evaluate))


class StoppingTest(BakingTest):
    def test_progress_is_told_and_may_stop(self):
        told, notes = [], []
        result = self.bake(toy_rig.make(), progress=lambda *step: told.append(step), note=notes.append)
        self.assertEqual(list(result.notes), notes)
        self.assertGreater(len({stage for stage, _, _ in told}), 3)
        self.assertTrue(all(0 <= done for _, done, _ in told))

        class Enough(Exception):
            pass

        def stop(stage, done, total):
            if len(told) > 5:
                raise Enough(stage)

        with self.assertRaises(Enough):
            self.bake(toy_rig.make(), progress=stop)

    def run_interrupted(self, body):
        """Runs a program that prints READY, interrupts it once, and gives its output and how long it took to end."""
        program = "import time, os, signal, sys, facebaker, toy_rig\n" + textwrap.dedent(body)
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS), os.environ["PYTHONPATH"]])}
        child = subprocess.Popen([sys.executable, "-B", "-c", program], cwd=self.folder, env=environment, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
        for line in child.stdout:
            if line == "READY\n":
                break
        time.sleep(0.3)
        child.send_signal(signal.SIGINT)
        began = time.monotonic()
        out, errors = child.communicate(timeout=60)
        return out + errors, time.monotonic() - began

    def test_interrupting_a_rig(self):
        output, seconds = self.run_interrupted(
            """
            def slow(controls):
                if len(controls) > 0 and not hasattr(slow, "told"):
                    slow.told = print("READY", flush=True)
                time.sleep(0.005 * len(controls))
                return toy_rig.positions(controls)
            try:
                facebaker.bake(toy_rig.make(slow), "toy.fbk", poses=100000)
            except KeyboardInterrupt:
                print("stopped", os.path.exists("toy.fbk"), signal.getsignal(signal.SIGINT) is signal.default_int_handler)
            """
        )
        self.assertIn("stopped False True", output)
        self.assertNotIn("Traceback", output)
        self.assertLess(seconds, 5)

    def test_interrupting_what_is_no_rig(self):
        output, seconds = self.run_interrupted(
            """
            told = []
            def progress(stage, done, total):
                if stage == "training" and not told:
                    told.append(print("READY", flush=True))
            try:
                facebaker.bake(toy_rig.make_recording(3000), "toy.fbk", recipe="paper", epochs=100000, progress=progress)
            except KeyboardInterrupt:
                print("stopped")
            """
        )
        self.assertIn("stopped", output)
        self.assertLess(seconds, 5)

    def test_a_call_in_another_thread(self):
        results = []
        threads = [
            threading.Thread(target=lambda name=name: results.append(
                facebaker.bake(toy_rig.make(), self.folder / name, use="variant", poses=200).method.archive))
            for name in ("a.fbk", "b.fbk")
        ]  # fmt: skip
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(results), 2)
        self.assertEqual(results[0], results[1])

    def test_a_thread_safe_rig_on_several_threads(self):
        seen = set()

        def evaluate(controls):
            seen.add(threading.get_ident())
            time.sleep(0.002)
            return toy_rig.positions(controls)

        with facebaker.Source(toy_rig.make(evaluate, thread_safe=True)) as source:
            np.testing.assert_allclose(
                source.evaluate(toy_rig.poses(100), 3), toy_rig.positions(toy_rig.poses(100)), atol=1e-6
            )
        self.assertGreater(len(seen), 1)

    def test_a_second_interrupt_is_raised_in_the_rig(self):
        def evaluate(controls):
            signal.raise_signal(signal.SIGINT)
            for _ in range(3):
                signal.raise_signal(signal.SIGINT)
            raise AssertionError("not reached")

        with self.assertRaises(KeyboardInterrupt):
            self.bake(toy_rig.make(evaluate))
        self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)

    def test_a_handler_of_the_host_is_left_alone(self):
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            with Call():
                self.assertEqual(signal.getsignal(signal.SIGINT), signal.SIG_IGN)
        finally:
            signal.signal(signal.SIGINT, before)


if __name__ == "__main__":
    unittest.main()
