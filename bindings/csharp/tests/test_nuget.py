"""The packer of the NuGet package, with files that stand for the assembly and the libraries; and the check of packages
that are made of real ones."""

import contextlib
import io
import os
import pathlib
import sys
import tempfile
import unittest
import zipfile

sys.path[:0] = [str(pathlib.Path(__file__).parent), str(pathlib.Path(__file__).parents[1])]
import check_nuget  # noqa: E402
import pack_nuget  # noqa: E402

START = {"libfacebaker.so": b"\x7fELF", "facebaker.dll": b"MZ", "libfacebaker.dylib": b"\xca\xfe\xba\xbe"}


class NugetTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "assembly").mkdir()
        for name in "FaceBaker.dll", "FaceBaker.xml":
            (self.folder / "assembly" / name).write_bytes(b"made up " + name.encode())

    def library(self, platform):
        """The option for a made-up library, which has the bytes of its platform's name."""
        file = self.folder / platform / pack_nuget.PLATFORMS[platform].file
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(START[file.name] + platform.encode())
        return f"--library={platform}={file}"

    def pack(self, *words, out="out"):
        """The exit code and what was said."""
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            code = pack_nuget.main(["--out", str(self.folder / out), "--assembly", str(self.folder / "assembly"), *words])
        return code, said.getvalue()

    def packed(self, out="out"):
        (package,) = (self.folder / out).glob("*")
        return package

    def test_every_platform_has_its_library(self):
        self.assertEqual(self.pack(*[self.library(one) for one in pack_nuget.PLATFORMS]), (0, ""))
        version = (check_nuget.ROOT / "VERSION").read_text().strip()
        self.assertEqual(self.packed().name, f"FaceBaker.{version}.nupkg")
        self.assertEqual(check_nuget.problems_of(self.packed(), list(pack_nuget.PLATFORMS)), [])
        with zipfile.ZipFile(self.packed()) as package:
            self.assertEqual(package.read("runtimes/win-x64/native/facebaker.dll"), b"MZwindows-x64")
            self.assertEqual(package.read("runtimes/linux-arm64/native/libfacebaker.so"), b"\x7fELFlinux-arm64")
            self.assertEqual(package.read("lib/netstandard2.1/FaceBaker.dll"), b"made up FaceBaker.dll")
            self.assertIn("\nzlib", package.read("THIRD-PARTY.txt").decode())

    def test_the_same_files_give_the_same_bytes_of_the_date_that_is_given(self):
        os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
        self.addCleanup(os.environ.pop, "SOURCE_DATE_EPOCH")
        words = [self.library("linux-x64"), self.library("windows-x64")]
        self.assertEqual([self.pack(*words, out=out)[0] for out in ("out", "again")], [0, 0])
        self.assertEqual(self.packed("out").read_bytes(), self.packed("again").read_bytes())
        with zipfile.ZipFile(self.packed()) as package:
            self.assertEqual({entry.date_time for entry in package.infolist()}, {(2023, 11, 14, 22, 13, 20)})
        os.environ["SOURCE_DATE_EPOCH"] = "1800000000"
        self.pack(*words, out="later")
        self.assertNotEqual(self.packed("out").read_bytes(), self.packed("later").read_bytes())

    def test_what_cannot_be_packed_is_named(self):
        other = self.folder / "libother.so"
        other.write_bytes(b"\x7fELF")
        for words, said in (
            ([f"--library=linux-x64={other}"], "libother.so: a library for linux-x64 is called libfacebaker.so"),
            ([f"--library=amiga={other}"], "--library takes PLATFORM=FILE"),
            (["--library=macos=no/such/file"], "there is no library no/such/file"),
            ([self.library("linux-x64")] * 2, "--library names a platform twice"),
        ):
            code, shown = self.pack(*words)
            self.assertEqual(code, 1)
            self.assertIn(said, shown)
        (self.folder / "assembly" / "FaceBaker.xml").unlink()
        self.assertIn("FaceBaker.xml", self.pack()[1])
        self.assertFalse((self.folder / "out").exists())

    def test_the_check_finds_what_is_wrong(self):
        self.pack(self.library("linux-x64"))
        self.assertEqual(check_nuget.problems_of(self.packed(), ["linux-x64"]), [])
        self.assertEqual(check_nuget.problems_of(self.packed(), ["linux-x64", "macos"]),
                         ["there is no runtimes/osx/native/libfacebaker.dylib"])
        self.assertEqual(check_nuget.problems_of(self.packed(), []), ["there is runtimes/linux-x64/native/libfacebaker.so"])
        for path, change, said in (
            ("_rels/.rels", (b"/FaceBaker.nuspec", b"/Other.nuspec"), "_rels/.rels points at /Other.nuspec"),
            ("[Content_Types].xml", (b'"so"', b'"os"'), "runtimes/linux-x64/native/libfacebaker.so has no content type"),
            ("FaceBaker.nuspec", (b"<id>FaceBaker", b"<id>Other"), "FaceBaker.nuspec: id is Other"),
            ("runtimes/linux-x64/native/libfacebaker.so", (b"\x7fELF", b"MZ"), "is no library of its platform"),
        ):
            with self.subTest(path=path):
                broken = self.folder / "broken.zip"
                with zipfile.ZipFile(self.packed()) as package, zipfile.ZipFile(broken, "w") as changed:
                    for name in package.namelist():
                        data = package.read(name)
                        changed.writestr(name, data.replace(*change) if name == path else data)
                self.assertIn(said, "\n".join(check_nuget.problems_of(broken, ["linux-x64"])))


if __name__ == "__main__":
    unittest.main()
