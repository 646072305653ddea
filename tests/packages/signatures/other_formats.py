"""Small files of other formats: what lies beside faces on disks, and what begins or ends its name alike. Made by Python's library
where it writes the format, and otherwise the bytes that a file of the format begins with, as its specification gives them."""

import bz2
import csv
import gzip
import io
import json
import lzma
import plistlib
import sqlite3
import struct
import tarfile
import wave
import xml.etree.ElementTree as ElementTree
import zipfile
import zlib


def png():
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(4))) + chunk(b"IEND", b"")


def firebird_backup():
    """What gbak of Firebird 3.0 writes first: a record of attributes, each a number, a length and a value. Such files are called
    .fbk, too."""
    numbers = ((2, 10), (4, 1), (5, 1), (6, 0x40000), (8, 1))  # format, transportable, compressed, size of blocks, volume
    texts = ((7, b"people.fdb"), (1, b"Sun Nov 29 15:31:20 2026"))
    record = [bytes((number, 4)) + struct.pack("<I", value) for number, value in numbers]
    record += [bytes((number, len(text))) + text for number, text in texts]
    return b"\0" + b"".join(record) + bytes(64)


def glb():
    text = json.dumps({"asset": {"version": "2.0"}}).encode().ljust(28)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


def zipped(files, stored_first=False):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data, zipfile.ZIP_STORED if stored_first else None)
    return stream.getvalue()


def tar():
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w") as archive:
        member = tarfile.TarInfo("face.fbk")
        member.size = 4
        archive.addfile(member, io.BytesIO(b"face"))
    return stream.getvalue()


def sqlite():
    base = sqlite3.connect(":memory:")
    base.execute("CREATE TABLE face (name TEXT)")
    data = base.serialize()
    base.close()
    return data


def wav():
    stream = io.BytesIO()
    with wave.open(stream, "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(48000)
        sound.writeframes(bytes(64))
    return stream.getvalue()


def comma_separated():
    stream = io.StringIO()
    csv.writer(stream).writerows([["frame", "jaw_open"], [0, 0.5]])
    return stream.getvalue().encode()


def npy():
    header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }"
    header = header.ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + struct.pack("<2f", 0, 1)


def riff(kind, data):
    return b"RIFF" + struct.pack("<I", 4 + len(data)) + kind + data


def mp4():
    return struct.pack(">I4s4sI4s4s", 24, b"ftyp", b"isom", 512, b"isom", b"mp42") + struct.pack(">I4s", 8, b"mdat")


def made_by_libraries():
    bag = {"bag/bagit.txt": "BagIt-Version: 1.0\nTag-File-Character-Encoding: UTF-8\n", "bag/data/face.fbk": b"\x89FBK\r\n\x1a\n"}
    return {
        "png": png(),
        "zip": zipped({"face.fbk": "face"}),
        "bag.zip": zipped(bag, stored_first=True),
        "usdz": zipped({"face.usda": "#usda 1.0\n"}, stored_first=True),
        "tar": tar(),
        "gz": gzip.compress(b"\x89FBK\r\n\x1a\n\x02\0\0\0", mtime=0),
        "xz": lzma.compress(b"\x89FBK\r\n\x1a\n"),
        "bz2": bz2.compress(b"\x89FBK\r\n\x1a\n"),
        "zlib": zlib.compress(b"\x89FBK\r\n\x1a\n\x02\0\0\0"),
        "sqlite": sqlite(),
        "wav": wav(),
        "csv": comma_separated(),
        "json": json.dumps({"format": "fbk"}).encode(),
        "gltf": json.dumps({"asset": {"version": "2.0"}}).encode(),
        "xml": ElementTree.tostring(ElementTree.Element("face"), encoding="utf-8", xml_declaration=True),
        "bplist": plistlib.dumps({"name": "face"}, fmt=plistlib.FMT_BINARY),
        "glb": glb(),
        "npy": npy(),
        "mp4": mp4(),
        "webp": riff(b"WEBP", b"VP8L" + struct.pack("<I", 6) + b"\x2f\0\0\0\0\0"),
    }


def made_by_hand():
    return {
        "firebird.fbk": firebird_backup(),
        "firebird.fdb": struct.pack("<BBHIII", 1, 0, 0x11, 3, 0, 0) + bytes(64),
        "jpg": bytes.fromhex("FFD8FFE000104A46494600010100000100010000FFD9"),
        "gif": b"GIF89a\x01\0\x01\0\0\0\0;",
        "tif": b"II*\0\x08\0\0\0\0\0",
        "exr": bytes.fromhex("762F310102000000") + b"channels\0chlist\0",
        "ktx2": b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", 37, 1, 1, 1, 0, 0, 1, 1, 0),
        "ktx": b"\xabKTX 11\xbb\r\n\x1a\n\x01\x02\x03\x04",
        "pdf": b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n%%EOF\n",
        "elf": b"\x7fELF\x02\x01\x01" + bytes(57),
        "exe": b"MZ" + bytes(58) + struct.pack("<I", 64) + b"PE\0\0\x64\x86",
        "wasm": b"\0asm\x01\0\0\0",
        "onnx": b"\x08\x08\x12\x09facebaker\x3a\x02\x12\x00",
        "usdc": b"PXR-USDC\0\x08" + bytes(78),
        "usda": b"#usda 1.0\ndef Mesh \"face\" {}\n",
        "obj": b"# a face\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nend_header\n",
        "fbx": b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7700),
        "abc": b"Ogawa\xff\0\x01" + bytes(8),
        "h5": b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0" + bytes(80),
        "mng": b"\x8aMNG\r\n\x1a\n" + bytes(16),
        "jng": b"\x8bJNG\r\n\x1a\n" + bytes(16),
        "jp2": b"\0\0\0\x0cjP  \r\n\x87\n",
        "7z": b"7z\xbc\xaf\x27\x1c\0\x04",
        "zst": b"\x28\xb5\x2f\xfd\x04\0\x01\0\0",
        "flac": b"fLaC\0\0\0\x22" + bytes(34),
        "ogg": b"OggS\0\x02" + bytes(20),
        "dna": b"DNA" + struct.pack(">HH", 2, 1) + bytes(16),
        "blend": b"BLENDER-v300",
        "mdd": struct.pack(">II", 1, 3) + bytes(40),
        "pc2": b"POINTCACHE2\0" + struct.pack("<IIffI", 1, 3, 0, 1, 1),
        "utf16.txt": "FBK\r\n\x1a\n".encode("utf-16"),
        "fbk.txt": b"\xc2\x89FBK\r\n\x1a\n",  # an archive that was taken for Latin-1 and written as UTF-8
        "empty": b"",
    }


def other_formats():
    """Names, which end in the extension of the format, and bytes."""
    return {**made_by_libraries(), **made_by_hand()}
