"""The script that makes all packages, without building anything: what it chooses, what it says is missing, how files appear; and
archives that are the same bytes for the same files."""

import hashlib
import io
import os
import pathlib
import sys
import tarfile
import tempfile
import unittest
import zipfile
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packager" / "packages"))
import build_dist  # noqa: E402
import dist_builds  # noqa: E402
import package_archives  # noqa: E402
from package_archives import Member  # noqa: E402


class FolderTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def files(self, name, **contents):
        made = self.folder / name
        made.mkdir()
        for file, text in contents.items():
            (made / file).write_text(text)
        return made

    def read(self, folder):
        return {path.name: path.read_text() for path in folder.iterdir() if path.name != "SHA256SUMS"}


class DeliveryTest(FolderTest):
    def test_a_whole_run_leaves_nothing_old(self):
        out = self.files("out", old="old", wheel="old")
        build_dist.deliver(self.files("made", wheel="new"), out, whole=True)
        self.assertEqual(self.read(out), {"wheel": "new"})
        self.assertEqual([path.name for path in self.folder.iterdir()], ["out"])

    def test_some_parts_leave_the_others_and_sums_are_of_all(self):
        out = self.files("out", other="other", wheel="old", SHA256SUMS="old")
        build_dist.deliver(self.files("made", wheel="new"), out, whole=False)
        self.assertEqual(self.read(out), {"other": "other", "wheel": "new"})
        expected = [f"{hashlib.sha256(text.encode()).hexdigest()}  {name}" for name, text in (("other", "other"), ("wheel", "new"))]
        self.assertEqual((out / "SHA256SUMS").read_text().splitlines(), expected)


class ChoiceTest(unittest.TestCase):
    def chosen(self, *words):
        return build_dist.chosen_parts(build_dist.parse(list(words)))

    def test_parts(self):
        with mock.patch.object(sys, "platform", "linux"):
            everything = self.chosen()
            self.assertIn("nupkg", everything)
            self.assertNotIn("debs", everything)
            self.assertIn("debs", self.chosen("--debs"))
            self.assertEqual(self.chosen("--only", "wheels,source"), ["source", "wheels"])
            self.assertEqual(self.chosen("--without", "npm"), [name for name in everything if name != "npm"])
        with mock.patch.object(sys, "platform", "darwin"):
            self.assertEqual(self.chosen(), ["runtime", "wheels"])

    def test_what_is_missing_is_named_with_its_package(self):
        with mock.patch.dict(os.environ, PATH="/nowhere"), mock.patch.object(sys, "platform", "linux"):
            problems = dist_builds.missing_tools(["linux-x64", "linux-arm64", "macos"])
            self.assertEqual(problems[0], "linux-arm64 needs aarch64-linux-gnu-g++: install g++-aarch64-linux-gnu")
            self.assertIn("macos is built on darwin", problems[1])
            self.assertEqual(build_dist.problems_with(["npm"], [], uncommitted=True),
                             ["npm needs npm: install nodejs and npm, or leave it out: --without npm"])


class ArchiveTest(FolderTest):
    MEMBERS = {"b/tool": Member(b"#!", program=True), "a": Member(b"text")}

    def test_the_order_and_the_time_of_files_do_not_matter(self):
        for make in package_archives.zip_bytes, package_archives.tar_bytes:
            self.assertEqual(make(self.MEMBERS), make(dict(reversed(self.MEMBERS.items()))))
            with mock.patch.dict(os.environ, SOURCE_DATE_EPOCH="1700000000"):
                dated = make(self.MEMBERS)
            self.assertNotEqual(make(self.MEMBERS), dated)

    def test_programs_and_links_stay_what_they_are(self):
        made = self.files("made", tool="#!", text="text")
        (made / "tool").chmod(0o755)
        (made / "link").symlink_to("text")
        members = package_archives.read_members(made, "p/")
        with tarfile.open(fileobj=io.BytesIO(package_archives.tar_bytes(members))) as archive:
            self.assertEqual({entry.name: entry.mode for entry in archive if entry.isfile()}, {"p/text": 0o644, "p/tool": 0o755})
            self.assertEqual(archive.getmember("p/link").linkname, "text")
        with self.assertRaisesRegex(ValueError, "p/link is a link"):
            package_archives.zip_bytes(members)
        del members["p/link"]
        with zipfile.ZipFile(io.BytesIO(package_archives.zip_bytes(members))) as archive:
            self.assertEqual([entry.external_attr >> 16 & 0o777 for entry in archive.infolist()], [0o644, 0o755])


if __name__ == "__main__":
    unittest.main()
