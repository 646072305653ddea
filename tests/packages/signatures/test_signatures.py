"""Whether archives are found by their bytes: the signatures of packager/desktop, in the syntax of DROID and of fido, over the
golden archives and over files of other formats; that they, the magic of file(1), that of desktops and the documents say the same;
and what file(1) itself makes of all those files.
    test_signatures.py [FILE]      FILE: the program file(1); without it its test is skipped"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import format_signatures
from other_formats import firebird_backup, other_formats

ROOT = pathlib.Path(__file__).resolve().parents[3]
DESKTOP = ROOT / "packager" / "desktop"
SIGNATURE = b"\x89FBK\r\n\x1a\n"
FILE = None


def golden_archives():
    """All of tests/golden: whether readers accept it, its name, its bytes."""
    for path in sorted(ROOT.glob("tests/golden/2.*/*/*.fbk")):
        yield path.parent.name == "accepted", path.name, path.read_bytes()


def expected_of(data):
    """As FORMAT.md has it, from the bytes: eight of the signature, then major and minor version."""
    if data[:8] != SIGNATURE:
        return []
    version = f"{int.from_bytes(data[8:10], 'little')}.{int.from_bytes(data[10:12], 'little')}"
    return ["dev/facebaker-" + version] if version in ("2.0", "2.1") else ["dev/facebaker"]


class SignaturesTest(unittest.TestCase):
    def setUp(self):
        self.droid, self.beginnings = format_signatures.droid_formats(DESKTOP / "facebaker-signature.xml")
        self.fido = format_signatures.fido_formats(DESKTOP / "facebaker-fido.xml")

    def both(self, data, what):
        """What both files identify data as, which has to be the same."""
        found = format_signatures.identify(self.droid, data)
        self.assertEqual(found, format_signatures.identify(self.fido, data), what)
        return found

    def test_accepted_archives_are_found_with_their_version(self):
        count = 0
        for accepted, name, data in golden_archives():
            if accepted:
                count += 1
                self.assertEqual(self.both(data, name), expected_of(data), name)
                self.assertEqual(data[:8], SIGNATURE, name)
        self.assertGreaterEqual(count, 39)

    def test_refused_archives_are_found_unless_their_signature_is_damaged(self):
        """To identify is not to validate: what is corrupt behind the header still is an archive, to be told by verify."""
        missed = set()
        for accepted, name, data in golden_archives():
            if not accepted:
                found = self.both(data, name)
                self.assertEqual(found, expected_of(data), name)
                missed |= {name} if not found else set()
        self.assertEqual(missed, {"corrupt-cut-in-signature.fbk", "corrupt-line-ends.fbk", "not_an_archive-empty.fbk",
                                  "not_an_archive-text.fbk"})

    def test_each_byte_of_the_signature_counts(self):
        data = (ROOT / "tests/golden/2.0/accepted/tiny.fbk").read_bytes()
        for place in range(8):
            for bit in range(8):
                damaged = bytearray(data)
                damaged[place] ^= 1 << bit
                self.assertEqual(self.both(bytes(damaged), place), [], f"bit {bit} of byte {place}")
        for place in range(8, 12):
            damaged = bytearray(data)
            damaged[place] ^= 0x80
            self.assertEqual(self.both(bytes(damaged), place), ["dev/facebaker"], f"version, byte {place}")
        self.assertEqual(self.both(b"\0" + data, "shifted"), [])

    def test_nothing_else_is_found(self):
        others = other_formats()
        self.assertGreaterEqual(len(others), 45)
        self.assertGreaterEqual(len(set(others.values())), 45)
        for name, data in others.items():
            self.assertEqual(self.both(data, name), [], name)

    def test_a_firebird_backup_has_the_extension_and_not_the_signature(self):
        extensions = {extension for one in self.droid for extension in one.extensions}
        self.assertEqual(extensions, {"fbk"})
        self.assertEqual(self.both(firebird_backup(), "backup of Firebird"), [])

    def test_all_files_say_the_same(self):
        for magic in (format_signatures.file_magic(DESKTOP / "facebaker.magic"),
                      format_signatures.desktop_magic(DESKTOP / "facebaker.xml")):
            self.assertEqual(magic, (SIGNATURE, "application/x-facebaker", ["fbk"]))
        for one in self.droid:
            self.assertEqual((one.name, one.media_type, one.extensions),
                             ("FaceBaker archive", "application/x-facebaker", ["fbk"]), one.puid)
        described = [[(one.puid, one.name, one.version, one.media_type, one.extensions, one.overrules) for one in formats]
                     for formats in (self.droid, self.fido)]
        self.assertEqual(*described)

    def test_every_version_of_the_format_has_a_signature(self):
        text = (ROOT / "core/archive/FORMAT.md").read_text(encoding="utf-8")
        major, minor = re.search(r"^Format version \*\*(\d+)\.(\d+)\*\*", text, flags=re.M).groups()
        self.assertEqual([one.version for one in self.droid], [""] + [f"{major}.{y}" for y in range(int(minor) + 1)])
        self.assertIn("signature | " + SIGNATURE.hex(" ").upper(), text)
        self.assertIn("The media type is `application/x-facebaker`, the extension `.fbk`", text)

    def test_the_submission_quotes_them(self):
        text = (ROOT / "docs/pronom.md").read_text(encoding="utf-8")
        quoted = re.findall(r"^\| FaceBaker archive \|(.*?)\| `([0-9A-F]+)` \|", text, flags=re.M)
        self.assertEqual([(version.strip(), bytes.fromhex(digits)) for version, digits in quoted],
                         [(one.version or "any", *self.beginnings[one.puid]) for one in self.droid])

    def test_file_finds_the_same(self):
        if FILE is None:
            self.skipTest("there is no file(1)")
        files = {name: data for name, data in other_formats().items()}
        files |= {f"{accepted} {name}": data for accepted, name, data in golden_archives()}
        with tempfile.TemporaryDirectory() as folder:
            paths = [pathlib.Path(folder, str(number)) for number in range(len(files))]  # names that say nothing
            for path, data in zip(paths, files.values()):
                path.write_bytes(data)
            run = subprocess.run([FILE, "--brief", "--mime-type", "--magic-file", DESKTOP / "facebaker.magic", *paths],
                                 check=True, capture_output=True, text=True)
        for name, kind in zip(files, run.stdout.splitlines(), strict=True):
            self.assertEqual(kind == "application/x-facebaker", bool(expected_of(files[name])), f"{name}: {kind}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        FILE = sys.argv.pop(1)
    unittest.main()
