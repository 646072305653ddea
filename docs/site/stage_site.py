#!/usr/bin/env python3
"""Lays out the pages of the site for mkdocs: the Markdown of the tree in the tree's own folders, so that links between pages
hold, with the files they link to, and mkdocs.yml with the entries whose page is there.

    stage_site.py ROOT STAGE [--viewer] [--packages FOLDER]

--viewer: with the demo. --packages: with a page of the files in a folder that build_dist.py or build_debs.sh of packager/packages made.
Fails where a page of docs/ is in no entry of the navigation."""

from __future__ import annotations

import pathlib
import re
import shutil
import sys
from typing import Any, List, Set

import yaml  # type: ignore[import]

PAGES = ("*.md", "docs/*.md", "core/archive/*.md", "samples/*/README.md", "bindings/*/README.md")
OF_DOXYGEN = "docs/reference.md"  # its front page
LINK = re.compile(r"\[([^\[\]]*)\]\(([^)\s#]+)([^)]*)\)")


def copy_page(root: pathlib.Path, stage: pathlib.Path, page: pathlib.Path, pages: Set[pathlib.Path]) -> None:
    """Copies one page and the files it links to; the tree's README.md becomes overview.md, for the front page is index.md."""

    def linked(match: "re.Match[str]") -> str:
        text, target, rest = match.groups()
        if re.match(r"[a-z]+:|/", target):
            return match.group(0)
        file = (page.parent / target).resolve()
        if file == root / "README.md":
            target = re.sub(r"README\.md$", "overview.md", target)
        elif file.is_dir() and file / "README.md" in pages:
            target = f"{target.rstrip('/')}/README.md"
        elif file.is_dir():
            return text  # there is no page of it
        elif file not in pages and file.is_file():
            place(stage / file.relative_to(root), file)
        return f"[{text}]({target}{rest})"

    relative = page.relative_to(root)
    text = LINK.sub(linked, page.read_text(encoding="utf-8"))
    to = stage / ("overview.md" if relative == pathlib.Path("README.md") else relative)
    to.parent.mkdir(parents=True, exist_ok=True)
    to.write_text(text, encoding="utf-8")


def place(to: pathlib.Path, file: pathlib.Path) -> None:
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, to)


def present(entries: List[Any], stage: pathlib.Path) -> List[Any]:
    """The entries of a navigation whose pages are there."""
    kept: List[Any] = []
    for entry in entries:
        if isinstance(entry, str):
            kept += [entry] if (stage / entry).exists() else []
            continue
        for title, what in entry.items():
            if isinstance(what, list):
                inner = present(what, stage)
                kept += [{title: inner}] if inner else []
            elif (stage / what).exists():
                kept.append({title: what})
    return kept


def named(entries: List[Any]) -> Set[str]:
    found: Set[str] = set()
    for entry in entries:
        for what in entry.values() if isinstance(entry, dict) else [entry]:
            found |= named(what) if isinstance(what, list) else {what}
    return found


def add_downloads(intro: str, folder: pathlib.Path, pages: pathlib.Path) -> None:
    """Copies the files of a folder to be downloaded, and writes their page: what a reader wants first, then by name."""
    order = [".zip", ".tar.gz", ".tgz", ".whl", ".nupkg", ".deb", "SUMS"]
    files = [path for path in folder.iterdir() if any(path.name.endswith(suffix) for suffix in order)]
    if not files:
        raise SystemExit(f"{folder}: there are no packages; packager/packages/build_dist.py and build_debs.sh build them")
    files.sort(key=lambda path: ([path.name.endswith(suffix) for suffix in order].index(True), path.name))
    for path in files:
        place(pages / "downloads" / path.name, path)
    rows = [f"| [{path.name}](../downloads/{path.name}) | {path.stat().st_size / 1e6:.1f} MB |" for path in files]
    page = "\n".join([intro.rstrip(), "", "| file | size |", "| --- | ---: |", *rows, ""])
    (pages / "docs" / "downloads.md").write_text(page, encoding="utf-8")


def main(arguments: List[str]) -> int:
    root, stage = pathlib.Path(arguments[0]).resolve(), pathlib.Path(arguments[1]).resolve()
    pages = {page for pattern in PAGES for page in root.glob(pattern)} - {root / OF_DOXYGEN}
    pictures = stage / "pages"
    for page in sorted(pages):
        copy_page(root, pictures, page, pages)
    own = root / "docs" / "site"
    copies = {"index.md": "index.md", "api.md": "docs/api.md"}
    if "--viewer" in arguments[2:]:
        copies["demo.md"] = "docs/demo.md"
    for name, to in copies.items():
        place(pictures / to, own / name)
    if "--packages" in arguments:
        folder = pathlib.Path(arguments[arguments.index("--packages") + 1])
        add_downloads((own / "downloads.md").read_text(encoding="utf-8"), folder, pictures)
    for name in ("site.css", "site.js", "icon.svg"):
        place(pictures / "docs" / "site" / name, own / name)
    for header in (root / "capi" / "include" / "facebaker").iterdir():
        place(pictures / header.relative_to(root), header)
    settings = yaml.safe_load((own / "mkdocs.yml").read_text(encoding="utf-8"))
    in_navigation = named(settings["nav"])
    lost = sorted(str(page.relative_to(root)) for page in pages if page.parent == root / "docs")
    lost = [page for page in lost if page not in in_navigation]
    if lost:
        print(f"docs/site/mkdocs.yml: no entry for {', '.join(lost)}", file=sys.stderr)
        return 1
    settings["nav"] = present(settings["nav"], pictures)
    settings["docs_dir"] = "pages"
    (stage / "mkdocs.yml").write_text(yaml.safe_dump(settings, sort_keys=False), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
