"""Archives of packages that are the same bytes for the same files: sorted, dated by SOURCE_DATE_EPOCH or 1980, owned by nobody.
Standard library only."""

from __future__ import annotations

import gzip
import io
import os
import pathlib
import tarfile
import time
import zipfile
from typing import Dict, NamedTuple

EARLIEST = 315532800  # 1980-01-01, of which zip has no earlier date


class Member(NamedTuple):
    """A file: its bytes and whether it is a program; or a symbolic link, to what the bytes name."""

    data: bytes
    program: bool = False
    link: bool = False


Members = Dict[str, Member]


def epoch() -> int:
    return max(EARLIEST, int(os.environ.get("SOURCE_DATE_EPOCH") or EARLIEST))


def read_members(folder: pathlib.Path, prefix: str = "") -> Members:
    """All files of a folder, by their paths in it behind the prefix. Raises OSError."""
    members = {}
    for path in sorted(folder.rglob("*")):
        name = prefix + path.relative_to(folder).as_posix()
        if path.is_symlink():
            members[name] = Member(os.readlink(path).encode(), link=True)
        elif path.is_file():
            members[name] = Member(path.read_bytes(), program=bool(path.stat().st_mode & 0o100))
    return members


def zip_bytes(members: Members) -> bytes:
    """In the order of the members' paths. Raises ValueError on links, which not every system unpacks."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, member in sorted(members.items()):
            if member.link:
                raise ValueError(f"{name} is a link, and cannot be in a zip file")
            entry = zipfile.ZipInfo(name, time.gmtime(epoch())[:6])
            entry.create_system = 3  # Unix, whatever this machine is: it is what knows programs
            entry.external_attr = (0o100755 if member.program else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, member.data)
    return written.getvalue()


def tar_bytes(members: Members) -> bytes:
    """A .tar.gz, in the order of the members' paths."""
    written = io.BytesIO()
    with tarfile.open(fileobj=written, mode="w", format=tarfile.GNU_FORMAT) as archive:
        for name, member in sorted(members.items()):
            entry = tarfile.TarInfo(name)
            entry.mtime = epoch()
            if member.link:
                entry.type, entry.linkname, entry.mode = tarfile.SYMTYPE, member.data.decode(), 0o777
                archive.addfile(entry)
            else:
                entry.size, entry.mode = len(member.data), 0o755 if member.program else 0o644
                archive.addfile(entry, io.BytesIO(member.data))
    return gzip.compress(written.getvalue(), compresslevel=9, mtime=0)


def write_whole(path: pathlib.Path, data: bytes) -> None:
    """The file appears complete or not at all. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".partial")
    partial.write_bytes(data)
    os.replace(partial, path)
