"""Checks a packed Unity package: check_package.py DIR. Every file has its .meta with an identifier of its own, which does not
depend on where it is packed; manifests are JSON; the version is VERSION's."""

import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "bindings" / "csharp"))
import pack_unity  # noqa: E402


def main() -> int:
    package = pathlib.Path(sys.argv[1])
    files = [path for path in package.rglob("*") if path.suffix != ".meta"]
    seen = {}
    for path in files:
        text = path.with_name(path.name + ".meta").read_text(encoding="utf-8")
        found = re.search(r"^guid: ([0-9a-f]{32})$", text, flags=re.M)
        assert found, f"{path} has no identifier"
        assert found[1] not in seen, f"{path} has the identifier of {seen[found[1]]}"
        assert found[1] == pack_unity.guid(path.relative_to(package).as_posix()), path
        seen[found[1]] = path
        if path.suffix in (".json", ".asmdef"):
            json.loads(path.read_text(encoding="utf-8"))
    metas = {path for path in package.rglob("*.meta")}
    assert len(metas) == len(files), "there are .meta files without a file"
    manifest = json.loads((package / "package.json").read_text(encoding="utf-8"))
    assert manifest["version"] == (ROOT / "VERSION").read_text(encoding="utf-8").strip(), manifest["version"]
    plugin = (package / "Plugins" / "linux-x64" / "libfacebaker.so.meta").read_text(encoding="utf-8")
    assert "OS: Linux" in plugin and "Standalone: Linux64" in plugin, plugin
    for arguments in (["--out", str(package)], ["--out", str(package) + ".new", "--library", "amiga=x"],
                      ["--out", str(package) + ".new", "--library", "macos=no/such/file"]):
        assert pack_unity.main(arguments) == 1, arguments
    assert not pathlib.Path(str(package) + ".new").exists()
    print(f"{len(files)} files of the package have identifiers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
