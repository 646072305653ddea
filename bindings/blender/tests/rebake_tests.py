"""Bakes of a rig that was edited, or has other controls; in_blender.py runs it."""

import json
import re

import bpy
from addon_support import BakingTest
from blender_scenes import grid

import facebaker
from facebaker_blender.bake_job import BakeJob
from facebaker_blender.bake_settings import load_settings, save_settings

BAKE = "--recipe", "linear", "--rig-budget", 150, "--workers", 1, "--drawn", 5


def slow_down():
    """Gives the face a fine mesh to wrap, so that evaluations take long enough to be kept."""
    face, hull = bpy.data.objects["face"], grid("hull", 60)
    hull.location.y = 0.05
    hull.modifiers.new("Finer", "SUBSURF").levels = 1
    hull.hide_render = True
    keys = hull.shape_key_add(name="Basis"), hull.shape_key_add(name="bulge")
    hull.data.shape_keys.key_blocks["bulge"].driver_add("value").driver.expression = "0"
    for point in keys[1].data:
        point.co.y += 0.01
    driver = hull.data.shape_keys.animation_data.drivers[0].driver
    variable = driver.variables.new()
    variable.name, variable.targets[0].id_type = "smile", "KEY"
    variable.targets[0].id, variable.targets[0].data_path = face.data.shape_keys, 'key_blocks["smile.L"].value'
    driver.expression = "smile"
    modifier = face.modifiers.new("Near", "DATA_TRANSFER")
    modifier.object = hull


class RebakeTest(BakingTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        slow_down()
        bpy.ops.wm.save_as_mainfile(filepath=str(cls.scene))

    def taken_over(self, printed):
        counts = re.search(r"of (\d+) evaluations (\d+) are reused and (\d+) dropped", printed)
        self.assertIsNotNone(counts, printed)
        return tuple(map(int, counts.groups()))

    def bake(self, out, *words):
        return self.headless("bake", "--out", out, "--mesh", "face", *BAKE, *words)

    def edit(self, key):
        """Another shape of one key, which is saved."""
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        for point in bpy.data.objects["face"].data.shape_keys.key_blocks[key].data:
            point.co.y += 0.05
        bpy.ops.wm.save_as_mainfile(filepath=str(self.scene))

    def test_after_an_edit(self):
        out = self.folder / "face.fbk"
        self.assertNotIn("are reused", self.bake(out))
        self.edit("smile.R")
        printed = self.bake(out)
        all_of, reused, dropped = self.taken_over(printed)
        self.assertIn('changed: "smile.R"', printed)
        self.assertGreater(reused, 20)
        self.assertGreater(dropped, 20)
        self.assertEqual(all_of, reused + dropped)
        job = BakeJob(out)
        self.assertGreater(job.process.document["reused"], 20)
        self.assertFalse(job.earlier.exists())
        # The face is that of a bake from nothing.
        self.bake(self.folder / "fresh.fbk")
        self.assertEqual(out.read_bytes(), (self.folder / "fresh.fbk").read_bytes())
        # The work folder itself may be named, as if by hand.
        self.edit("smile.L")
        self.assertIn('changed: "smile.L"', self.bake(out, "--reuse", job.work))

    def test_one_control_less_and_one_more(self):
        out, fewer = self.folder / "some.fbk", self.folder / "fewer.json"
        self.bake(out)
        settings = load_settings(self.folder / "some.blender" / "settings.json")
        save_settings(settings.without(["jaw_open"]), fewer)
        words = "bake", "--out", out, "--settings", fewer, "--drawn", 10
        printed = self.headless(*words)
        _, reused, dropped = self.taken_over(printed)
        self.assertIn('the control "jaw_open" is gone', printed)
        self.assertGreater(reused, 20)
        self.assertGreater(dropped, 20)
        self.assertEqual([c.name for c in facebaker.load(out).controls], [c.name for c in load_settings(fewer).controls])
        printed = self.bake(out)
        self.assertIn('the control "jaw_open" is new', printed)
        self.assertGreater(self.taken_over(printed)[1], 20)

    def test_another_mesh(self):
        out = self.folder / "other.fbk"
        self.bake(out)
        printed = self.headless("bake", "--out", out, "--mesh", "face", "--mesh", "hull", "--modifiers", "off", *BAKE)
        self.assertIn("no evaluation is reused: the mesh had 64 vertices and has 3664", printed)
        self.assertEqual(facebaker.load(out).vertex_count, 3664)

    def test_the_larger_of_two_is_kept(self):
        job = BakeJob(self.folder / "kept.fbk")
        for folder, size in ((job.work, 10), (job.earlier, 20)):
            folder.mkdir(parents=True)
            (folder / "rig.evaluations").write_bytes(bytes(size))
        job._set_aside("another rig")
        self.assertFalse(job.work.exists())
        self.assertEqual((job.earlier / "rig.evaluations").stat().st_size, 20)
        job.work.mkdir()
        (job.work / "rig.evaluations").write_bytes(bytes(30))
        job._set_aside("another rig")
        self.assertTrue(job.work.exists())
        job._set_aside("a third rig")
        self.assertEqual((job.earlier / "rig.evaluations").stat().st_size, 30)

    def test_in_the_window(self):
        import facebaker_blender
        from facebaker_blender import window_jobs
        from facebaker_blender.bake_result import result_lines

        facebaker_blender.register()
        try:
            bpy.ops.wm.open_mainfile(filepath=str(self.scene))
            for scene_object in bpy.context.scene.objects:
                scene_object.select_set(scene_object.name == "face")
            bpy.ops.facebaker.choose()
            bpy.ops.facebaker.find()
            chosen = bpy.context.scene.facebaker
            chosen.out, chosen.recipe, chosen.rig_budget, chosen.workers = "//window.fbk", "linear", 150, 1
            for less in False, True:
                chosen.controls[0].use = not less
                self.assertEqual(bpy.ops.facebaker.bake(), {"FINISHED"})
                job = window_jobs.job_of(bpy.context)
                self.assertTrue(job.process.wait(200))
                window_jobs.watch()
                self.assertIsNotNone(job.process.document, job.process.log.read_text())
            self.assertGreater(job.process.document["reused"], 20)
            self.assertTrue(any("were taken over" in line for line in result_lines(job.process.document)))
        finally:
            facebaker_blender.unregister()
        self.assertTrue(json.loads((job.folder / "settings.json").read_text()))
