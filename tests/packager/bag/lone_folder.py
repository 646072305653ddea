"""A place where commands find nothing of FaceBaker but what they are given."""

import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import Any, List, Optional

SYSTEM = ("usr", "bin", "lib", "lib64", "sbin", "etc/alternatives")  # of what commands may need of the system
INTERPRETER = "/usr/bin/python3"


class LoneFolder:
    """A folder, which is the root of the file system for commands where this process may arrange that (root, on Linux):
    besides it there are the system's programs, read-only. Elsewhere commands run in it with an empty environment."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self._folder.name)
        self.is_root = os.geteuid() == 0 and self._run_as_root("true").returncode == 0

    def __enter__(self) -> "LoneFolder":
        return self

    def __exit__(self, *_: Any) -> None:
        self._folder.cleanup()

    def _run_as_root(self, command: str) -> "subprocess.CompletedProcess[str]":
        """Mounts are seen by this command alone, and end with it."""
        lines: List[str] = ["set -e"]
        for name in SYSTEM:
            if os.path.islink(f"/{name}"):
                lines.append(f"test -L ./{name} || cp -P /{name} ./{name}")
            elif os.path.isdir(f"/{name}"):
                lines.append(f"mkdir -p ./{name}; mount --bind /{name} ./{name}; mount -o remount,ro,bind ./{name}")
        lines.append("mkdir -p ./dev ./tmp; test -e ./dev/null || mknod -m 666 ./dev/null c 1 3")
        lines.append('exec chroot . /bin/sh -c "$1"')
        unshare = shutil.which("unshare")
        if unshare is None:
            return subprocess.CompletedProcess([], 1, "", "no unshare")
        return subprocess.run(
            [unshare, "--mount", "--propagation", "private", "/bin/sh", "-c", "\n".join(lines), "sh", command],
            cwd=self.path, env={"PATH": "/usr/bin:/bin:/usr/sbin:/sbin"}, capture_output=True, text=True,
        )  # fmt: skip

    def run(self, command: str, folder: str = "") -> "subprocess.CompletedProcess[str]":
        """Runs a command line of the shell in a folder below."""
        if self.is_root:
            return self._run_as_root(f"cd /{folder} && {command}")
        return subprocess.run(["/bin/sh", "-c", command], cwd=self.path / folder, env={"PATH": "/usr/bin:/bin"},
                              capture_output=True, text=True)  # fmt: skip


def numpy_of_the_system() -> Optional[str]:
    """The reason why the system's Python cannot run the reader; None if it can."""
    run = subprocess.run([INTERPRETER, "-c", "import numpy"], env={"PATH": "/usr/bin:/bin"}, capture_output=True)
    return None if run.returncode == 0 else f"{INTERPRETER} has no NumPy"
