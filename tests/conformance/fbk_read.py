#!/usr/bin/env python3
"""An independent reader of .fbk archives, written from the documents in core/archive alone.

    fbk_read.py FILE...

reads every file, evaluates the poses of its proof and compares them with what was archived, bit for bit. Exit code 0
if all agree, 1 at the first difference or corrupt archive, 2 on wrong use. With --positions it prints the positions of
the proof's poses as hexadecimal bits instead of comparing them, for other programs to compare.

Needs Python 3.8 and NumPy. It is slow and meant to be read.
"""
import sys
import zlib

import numpy as np

import fbk_evaluate
from fbk_bytes import Contents, Corrupt, require, xxh64
from fbk_sections import READERS, REQUIRED


def read_sections(data):
    """Flags, codec, raw size and stored bytes of every section."""
    c, sections = Contents("file", data), {}

    def read_checksum():
        require(xxh64(c.data[: c.at]) == c.u64(), "the header, the section table or the file is corrupt")

    require(c.take(8) == b"\x89FBK\r\n\x1a\n", "not an .fbk archive")
    major, _ = c.array("u2", 2)
    require(major == 2, f"unsupported: major version {major}")
    count, size = c.u32(most=64), c.u64()
    rows = [(c.take(32), c.u32(), c.u32(), c.u64(), c.u64(), c.u64(), c.u64()) for _ in range(count)]
    read_checksum()
    require(len(data) == size, "truncated, or followed by other bytes")
    for name, flags, codec, offset, stored_size, raw_size, checksum in rows:
        name = name.rstrip(b"\0").decode("latin-1")
        require(name and all("!" <= letter <= "~" for letter in name), "a section's name is not printable")
        require(name not in sections, f"{name}: there already is a section of this name")
        require(flags <= 1, f"{name}: unsupported flags")
        require(offset == c.at, f"{name}: does not follow the part before it")
        stored = c.take(stored_size)
        require(xxh64(stored) == checksum, f"{name}: corrupt")
        sections[name] = flags, codec, raw_size, stored
    read_checksum()
    c.end()
    return sections


def decompress(sections, name):
    require(name in sections, f"no section {name}")
    _, codec, raw_size, contents = sections[name]
    require(codec <= 1, f"{name}: unsupported codec {codec}")
    if codec == 1:
        stream = zlib.decompressobj()
        contents = stream.decompress(contents, raw_size + 1)
        require(stream.eof and not stream.unused_data, f"{name}: not exactly one zlib stream")
    require(len(contents) == raw_size, f"{name}: decompresses to another size")
    return Contents(name, contents)


class Face:
    # What stays so where a section is missing.
    channels = uvs = images = materials = meshes = joints = sockets = levels = exact = driven = influences = ()
    errors, proof, first_number = None, {"controls": ()}, 0

    def __init__(self, data):
        sections = read_sections(data)
        for name, (flags, *_) in sections.items():
            require(name in READERS or flags == 0, f"{name}: required and unknown")
        for name, read in READERS.items():
            if name in sections or name in REQUIRED:
                contents = decompress(sections, name)
                read(contents, self)
                contents.end()
        fbk_evaluate.prepare(self)

    @property
    def mesh_of(self):
        """The number of the mesh of each point; what carries numbers is not of the meshes."""
        sizes = [mesh.vertices for mesh in self.meshes] or [self.vertices]
        sizes.append(self.points - self.vertices)
        return np.repeat(np.arange(len(sizes)), sizes)

    def evaluated(self, controls):
        """What a proof has of a pose."""
        def hash_of(positions):
            require(not np.isnan(positions).any(), "a position is NaN")
            return np.uint64(xxh64(positions.astype("<f4").tobytes()))

        positions, channels, joints = fbk_evaluate.evaluate(self, controls)
        yield "positions", positions.reshape(-1, 3)[self.proof_vertices]
        yield "hash", hash_of(positions)
        yield "frames", np.array([fbk_evaluate.posed_frame(self, socket, positions) for socket in self.sockets])
        yield "channels", channels
        if self.errors:
            errors, outside = fbk_evaluate.expected_errors(self, controls)
            yield "expected errors", errors
            yield "controls outside", np.uint32(outside)
        levels = [fbk_evaluate.positions_at(self, controls, half / 2) for half in range(1, 2 * len(self.levels) + 1)]
        yield "hashes at levels of detail", np.array([hash_of(positions) for positions in levels], np.uint64)
        if self.driven:
            yield "hash of joints", hash_of(joints)

    def verify(self):
        for pose, controls in enumerate(self.proof["controls"]):
            for name, found in self.evaluated(controls):
                require(found.tobytes() == self.proof[name][pose].tobytes(), f"pose {pose}: {name}: not as archived")
        return len(self.proof["controls"])


def main(arguments):
    show = "--positions" in arguments
    paths = [a for a in arguments if a != "--positions"]
    if not paths:
        print(__doc__, file=sys.stderr)
        return 2
    for path in paths:
        try:
            with np.errstate(all="ignore"):
                with open(path, "rb") as file:
                    face = Face(file.read())
                if show:
                    for controls in face.proof["controls"]:
                        print(fbk_evaluate.evaluate(face, controls)[0].astype(">f4").tobytes().hex())
                else:
                    print(f"{path}: {face.verify()} poses evaluate as archived")
        except (Corrupt, ValueError, zlib.error) as error:
            print(f"{path}: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
