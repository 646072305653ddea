"""From a bag to a posed face without any of our programs: the bag lies alone in an empty folder, and the commands are
those that its own README.txt gives.

test_drill.py FACEBAKER FACE.fbk...
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from array import array
from typing import List

from lone_folder import LoneFolder, numpy_of_the_system

TOOL, FACES = sys.argv[1], [pathlib.Path(face) for face in sys.argv[2:]]


def commands_of(readme: str) -> List[str]:
    """Lines that a reader would type: those indented by four spaces that begin with a program."""
    return [line.strip() for line in readme.splitlines() if re.match(r" {4}(sha512sum|python3|for) ", line)]


def vertices_of(obj: str) -> array:  # type: ignore[type-arg]
    """The numbers of all vertices as their bits in 32."""
    return array("f", [float(x) for line in obj.splitlines() if line.startswith("v ") for x in line.split()[1:4]])


class TestDrill(unittest.TestCase):
    folder: pathlib.Path
    lone: LoneFolder

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.lone = cls.enterClassContext(LoneFolder())
        subprocess.run([TOOL, "bag", *map(str, FACES), "--out", cls.folder / "bag"], check=True, capture_output=True)
        shutil.move(cls.folder / "bag", cls.lone.path / "bag")
        (cls.lone.path / "tmp").mkdir(exist_ok=True)
        cls.readme = (cls.lone.path / "bag/data/README.txt").read_text(encoding="utf-8")

    def obey(self, command: str) -> str:
        run = self.lone.run(command, "bag")
        self.assertEqual((run.returncode, run.stderr), (0, ""), command)
        return run.stdout

    def test_nothing_of_ours_is_there(self) -> None:
        run = self.lone.run("command -v facebaker || find / -xdev -name 'libfacebaker*' | grep . ", "bag")
        if not self.lone.is_root:
            self.skipTest("not root: the file system is seen as it is")
        self.assertEqual(run.stdout, "")

    def test_the_commands_of_the_readme(self) -> None:
        commands = commands_of(self.readme)
        self.assertEqual(len(commands), 6)
        before = sorted(path for path in self.lone.path.joinpath("bag").rglob("*"))
        for face in FACES:
            listed = self.obey(commands[3].replace("NAME.fbk", face.name))
            control = listed.splitlines()[2].split("  ")[1]
            highest = re.search(r" to (\S+),", listed.splitlines()[2])
            assert highest
            for command in commands:
                for name, value in (("NAME.fbk", face.name), ("jaw_open=0.5", f"{control}={highest[1]}"),
                                    ("/tmp", "tmp" if not self.lone.is_root else "/tmp")):  # fmt: skip
                    command = command.replace(name, value)
                if not self.lone.is_root:
                    command = command.replace("--out tmp/", "--out ../tmp/")
                printed = self.obey(command)
                if "sha512sum" in command:
                    self.assertEqual(printed, "")
                elif "fbk_read.py" in command:
                    self.assertEqual(printed.count(" poses evaluate as archived"), len(FACES))
                elif "--proof" in command:
                    self.assertIn("pose 1 of the proof evaluates as archived, bit for bit", printed)
            self.assertGreater(len(vertices_of((self.lone.path / "tmp/proof.obj").read_text())), 0)
            # And the program, had it been there, would have written the same bits.
            posed = self.folder / "posed.obj"
            subprocess.run([TOOL, "pose", face, "--set", f"{control}={highest[1]}", "--out", posed], check=True,
                           capture_output=True)  # fmt: skip
            self.assertEqual(vertices_of((self.lone.path / "tmp/posed.obj").read_text()), vertices_of(posed.read_text()))
        self.assertEqual(before, sorted(path for path in self.lone.path.joinpath("bag").rglob("*")), "files in the bag")

    def test_damage_is_found_without_us(self) -> None:
        damaged = self.lone.path / "damaged"
        shutil.copytree(self.lone.path / "bag", damaged)
        archive = damaged / "data/archives" / FACES[0].name
        data = bytearray(archive.read_bytes())
        data[len(data) // 2] ^= 1
        archive.write_bytes(data)
        run = self.lone.run(commands_of(self.readme)[0], "damaged")
        self.assertEqual(run.returncode, 1)
        self.assertIn(f"data/archives/{FACES[0].name}: FAILED", run.stdout)
        run = self.lone.run(f"python3 -B data/reader/fbk_read.py data/archives/{FACES[0].name}", "damaged")
        self.assertEqual(run.returncode, 1)
        self.assertIn("corrupt", run.stderr)


if __name__ == "__main__":
    if reason := numpy_of_the_system():
        print(reason)
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
