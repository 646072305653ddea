"""Signing files and asking who vouches for them, with keys that the openssl command makes."""

import datetime
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker

OPENSSL = shutil.which("openssl")


@unittest.skipUnless(OPENSSL, "there is no openssl command")
class SigningTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.face = self.folder / "face.fbk"
        shutil.copy(os.environ["FB_FIXTURE"], self.face)
        self.make_key("ada")

    def make_key(self, name):
        key, certificate = self.folder / f"{name}.key", self.folder / f"{name}.pem"
        curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-noenc", "-days", "30"]
        command = [OPENSSL, "req", "-x509", *curve, "-subj", f"/CN={name}", "-keyout", key, "-out", certificate]
        subprocess.run(command, check=True, capture_output=True)
        return certificate

    def sign(self, file, **options):
        return facebaker.sign(file, self.folder / "ada.key", certificate=self.folder / "ada.pem", **options)

    def test_who_signed(self):
        before = self.face.read_bytes()
        signed = self.sign(self.face)
        self.assertEqual(signed.document["signature"], f"{self.face}.sig")
        self.assertEqual(self.face.read_bytes(), before)
        trusted = [self.folder / "ada.pem"]
        checked = facebaker.verify_signature(self.face, trusted=trusted).document
        self.assertEqual(checked["signer"]["subject"], "CN = ada")
        self.assertEqual(checked["signer"], signed.document["signer"])
        self.assertEqual(checked["sha256"], signed.document["sha256"])
        self.assertEqual(checked["trusted"]["file"], str(trusted[0]))
        for face in (before, facebaker.load(self.face), facebaker.load(before)):
            document = facebaker.verify_signature(face, f"{self.face}.sig", trusted=trusted).document
            self.assertEqual(document["signer"], checked["signer"])

    def test_what_is_not_so_is_raised(self):
        self.sign(self.face)
        with self.assertRaisesRegex(facebaker.BadDataError, "no certificate or key is given that is trusted"):
            facebaker.verify_signature(self.face)
        with self.assertRaisesRegex(facebaker.BadDataError, "not trusted: CN = ada.*trusted are: CN = bob"):
            facebaker.verify_signature(self.face, trusted=[self.make_key("bob")])
        trusted, late = [self.folder / "ada.pem"], datetime.date.today() + datetime.timedelta(40)
        for on in (late, late.isoformat()):
            with self.assertRaisesRegex(facebaker.BadDataError, "has expired by"):
                facebaker.verify_signature(self.face, trusted=trusted, on=on)
        accepted = facebaker.verify_signature(self.face, trusted=trusted, on=late, accept_expired=True)
        self.assertTrue(accepted.document["signer"]["expired"])
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "soon is no day"):
            facebaker.verify_signature(self.face, trusted=trusted, on="soon")
        with self.assertRaisesRegex(facebaker.InvalidArgumentError, "would replace"):
            self.sign(self.face, out=self.face)

    def test_withdrawn_by_its_bytes(self):
        sha256 = self.sign(self.face, out=self.folder / "its.sig").document["sha256"]
        entry = {"sha256": sha256, "since": "2026-01-01", "reason": "by letter"}
        today = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
        written = self.folder / "list.json"
        for entries, text in (([entry], "is withdrawn since 2026-01-01: by letter"), ([], "")):
            written.write_text(
                json.dumps({"format": "facebaker-withdrawals", "version": 1, "issued": today, "withdrawn": entries})
            )
            self.sign(written)
            options = {"trusted": [self.folder / "ada.pem"], "withdrawn": [written]}
            if text:
                with self.assertRaisesRegex(facebaker.BadDataError, text):
                    facebaker.verify_signature(self.face, self.folder / "its.sig", **options)
            else:
                lists = facebaker.verify_signature(self.face, self.folder / "its.sig", **options).document["withdrawn"]
                self.assertEqual([(one["file"], one["issued"]) for one in lists], [(str(written), today)])


if __name__ == "__main__":
    unittest.main()
