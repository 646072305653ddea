"""What the panel says, without Blender: lines that fit, progress, and why a bake ended."""

import json
import pathlib
import sys
import tempfile
import unittest

from facebaker_blender.bake_process import BakeProcess
from facebaker_blender.bake_result import result_lines, warnings_of
from facebaker_blender.progress_lines import BakeProgress, spoken_time
from facebaker_blender.shown_lengths import length_text
from facebaker_blender.text_wrap import wrapped


class WrapTest(unittest.TestCase):
    def test_nothing_is_left_out(self):
        text = "Worst vertex of 240 frames: off by 0.31 mm.\nIts archive is /home/ann/characters/ann/baked/face.fbk"
        for width in 1, 7, 12, 20, 200:
            lines = wrapped(text, width, len)
            self.assertLessEqual(max(map(len, lines)), width)
            self.assertEqual("".join(lines).replace(" ", ""), "".join(text.split()))
        self.assertEqual(lines, text.split("\n"))
        self.assertEqual(wrapped("", 10, len), [])

    def test_where_it_is_broken(self):
        self.assertEqual(wrapped("off by 0.31 mm", 9, len), ["off by", "0.31 mm"])
        self.assertEqual(wrapped("in /made/folder/face.fbk", 14, len), ["in", "/made/folder/", "face.fbk"])
        self.assertEqual(wrapped("abcdefgh", 3, len), ["abc", "def", "gh"])


class ProgressLinesTest(unittest.TestCase):
    def test_what_the_panel_tells(self):
        progress = BakeProgress()
        self.assertEqual(progress.lines, ["Starting"])
        progress.read("analysing the rig: 12 %")
        self.assertEqual(progress.lines, ["Analysing the rig: 12 %"])
        progress.read("training: 60 %, about 2:07 left")
        self.assertEqual(progress.lines, ["Training: 60 %", "About 2 minutes left"])

    def test_times_in_words(self):
        for text, spoken in {
            "9 s": "9 seconds", "about 1 s": "About 1 second", "1:05": "1 minute", "about 59:40": "About 1 hour",
            "1:30:10": "1 hour 30 minutes", "about 2:00:00": "About 2 hours",
            "less than 2:07": "Less than 3 minutes", "less than 1:00": "Less than 1 minute",
        }.items():  # fmt: skip
            self.assertEqual(spoken_time(text), spoken)

    def test_an_error_of_several_lines(self):
        progress = BakeProgress()
        for line in "facebaker bake: the rig failed:", "  no bone \"jaw\"", "", "Blender quit":
            progress.read(line)
        self.assertEqual(progress.error, 'the rig failed:\n  no bone "jaw"')


class LengthTest(unittest.TestCase):
    def test_millimetres(self):
        for length, units, text in (
            (0.00031, "m", "0.31 mm"), (0.153, "m", "153 mm"), (2, "cm", "20 mm"), (1e-8, "m", "less than 0.001 mm"),
            (0, "m", "0 mm"), (0.5, "", "0.5 units"), (0.25, "au", "0.25 au"),
        ):  # fmt: skip
            self.assertEqual(length_text(length, units), text)


class ResultTest(unittest.TestCase):
    def test_the_verdict_is_first(self):
        document = {"verdict": "Worst vertex of 3 frames: off by 0.2 mm.", "bytes": 4970, "poses": 12000, "rig_calls": 13001}
        self.assertEqual(
            result_lines(document),
            [document["verdict"], "5 kB, trained on 12,000 poses", "The rig was evaluated 13,001 times"],
        )
        more = result_lines({"bytes": 2_340_000, "reused": 33, "verdict": ""})
        self.assertEqual(more[0], "2.34 MB, trained on 0 poses")
        self.assertEqual(more[2:], ["33 answers of the rig were taken over"])
        self.assertEqual(warnings_of({"warnings": ["one control jumps"]}), ["One control jumps."])
        self.assertEqual(warnings_of(document), [])


class FailureTest(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def failure(self, code):
        """Why a bake failed that runs this Python; as another session finds it."""
        process = BakeProcess(self.folder)
        process.start([sys.executable, "-c", code])
        self.assertTrue(process.wait(20))
        return BakeProcess(self.folder).failure

    def test_all_of_a_message(self):
        self.assertEqual(BakeProcess(self.folder).failure, "")
        long = "x" * 3000
        write = f"import sys; sys.stderr.write('facebaker bake: {long}\\nsecond line\\n'); sys.exit(1)"
        self.assertEqual(self.failure(write), f"{long}\nsecond line")

    def test_a_bake_that_died_without_a_word(self):
        self.assertIn("bake.log is empty", self.failure("import os; os.abort()"))
        state = self.folder / "process.json"  # as of one that ended at once
        state.write_text(json.dumps({**json.loads(state.read_text()), "began": ""}))
        self.assertIn("bake.log is empty", BakeProcess(self.folder).failure)
        loader = "error while loading shared libraries: libgomp.so.1"
        said = self.failure(f"import sys; sys.exit('{loader}')")
        self.assertIn("without a result", said)
        self.assertTrue(said.endswith(loader), said)

    def test_a_result_is_no_failure(self):
        self.assertEqual(self.failure("print('{}')"), "")


if __name__ == "__main__":
    unittest.main()
