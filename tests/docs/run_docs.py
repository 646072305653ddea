#!/usr/bin/env python3
"""Runs every code block of the pages, and checks their links and the paths they name.

    run_docs.py SOURCE BUILD [PAGE...]
    run_docs.py --write SOURCE BUILD PAGE...    writes the numbers that are printed into the pages' text blocks

SOURCE is the root of the tree, BUILD a build folder of it. With --write no block is shortened, so that the figures of a page come from one run of its commands. Blocks run in the order of the pages, all in one temporary
folder that looks like a fresh clone whose build/release is BUILD:

    sh      is run by bash; the first command that fails ends the test
    python  is run by this interpreter, with the Python package and libfacebaker of the build
    c, cpp  is compiled with warnings as errors against the public headers, or as code of core/ if it includes "..." files;
            with a main() it is linked and run too
    text    after one of these: what it prints. Words must agree; numbers only after <!-- exact -->, because they depend
            on the machine; "..." stands for anything, on a line of its own for any number of lines
    others  are not looked at

HTML comments right before a block say more:

    <!-- skip: reason -->               it is not run
    <!-- file: hello.c -->              it is written to this file, for a later block to use, and not run by itself
    <!-- replace "this" with "that" --> for the test, to keep it short
    <!-- exact -->                      its numbers must agree too

Standard library only, but for what the pages import.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

from doc_pages import PageError, anchors_of, links_of, paths_of, read_blocks

ORDER = ("README.md", "docs/README.md", "docs/how-it-works.md", "docs/how-a-bake-works.md", "docs/measuring.md",
         "docs/characters.md", "docs/gltf.md", "docs/datasets.md", "docs/extending.md", "docs/rig-protocol.md")
NUMBER = r"[-+]?(?:\d[\d,]*\.?\d*|\.\d+)(?:e[-+]?\d+)?"
VARIABLE = f"((?<!\\w){NUMBER}|\\.\\.\\.)"
RULE = "|-: "  # what empty lines and the rules below the heads of tables are made of
C_FLAGS = {"c": ["-std=c99", "-pedantic"], "cpp": ["-std=c++17"], "core": ["-std=c++20", "-Icore", "-Ipackager"]}


def pages_of(root):
    """All pages that have commands: README and docs first, in reading order, then the READMEs of folders."""
    found = [os.path.relpath(p, root) for pattern in ("docs/*.md", "samples/*/README.md", "bindings/*/README.md")
             for p in sorted(glob.glob(os.path.join(root, pattern)))]
    return [p for p in ORDER if os.path.exists(os.path.join(root, p))] + [p for p in found if p not in ORDER]


# ---- Links and paths


def check_links(root, page):
    with open(os.path.join(root, page), encoding="utf-8") as file:
        text = file.read()
    problems = []
    for link in links_of(text):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not os.path.exists(os.path.join(root, target)):
            problems.append(f"{page}: the link to {link} leads nowhere")
        elif anchor and target.endswith(".md"):
            with open(os.path.join(root, target), encoding="utf-8") as file:
                if anchor not in anchors_of(file.read()):
                    problems.append(f"{page}: {target} has no heading #{anchor}")
    return problems


def files_of(root):
    """Paths of all files of the tree but for build folders, relative to it."""
    files = []
    for folder, folders, names in os.walk(root):
        folders[:] = [f for f in folders if not f.startswith((".", "__")) and not (folder == root and f in ("build", "install"))]
        files += [os.path.relpath(os.path.join(folder, name), root) for name in names]
    return files


def check_paths(root, page, files, written):
    """`written`: names of files that the pages' blocks write, which are not in the tree."""
    names = {os.path.basename(f) for f in files}
    folders = {f.split("/")[0] for f in files if "/" in f}
    known = set(files) | {os.path.dirname(f) for f in files}
    with open(os.path.join(root, page), encoding="utf-8") as file:
        text = file.read()
    problems = []
    for path in paths_of(text, folders):
        if path.split("/")[0] in folders and "/" in path:
            exists = glob.glob(os.path.join(root, path)) if "*" in path else (
                path.rstrip("/") in known or os.path.isdir(os.path.join(root, path)))
        else:
            here = os.path.normpath(os.path.join(os.path.dirname(page), path))
            exists = here in known or os.path.basename(path) in names and any(
                f == path or f.endswith("/" + path) for f in files)
        if not exists and os.path.basename(path) not in written:
            problems.append(f"{page}: there is no {path}")
    return problems


# ---- Output


def words_of(line):
    """A line without what may differ in how a table is set: runs of spaces are one."""
    return re.sub(r"\s+", " ", line).strip()


def pattern_of(line, exact):
    """What a line may look like: numbers may be any, each a group, and ... is anything, a group too."""
    parts = re.split(VARIABLE, words_of(line))
    texts = [re.escape(part) for part in parts]
    for i in range(1, len(parts), 2):
        texts[i] = "(" + (".*" if parts[i] == "..." else re.escape(parts[i]) if exact else NUMBER) + ")"
    return re.compile("".join(texts))


def with_numbers(line, match):
    """The line with the numbers of a match of its pattern."""
    parts = re.split(VARIABLE, line)
    for i, text in zip(range(1, len(parts), 2), match.groups()):
        if parts[i] != "...":
            parts[i] = text
    return "".join(parts)


def compare(expected, printed, exact, filled=None):
    """None if what was printed is what the page shows, else what is wrong. Appends the page's lines with the numbers that
    were printed to `filled`, if that is a list."""
    filled = [] if filled is None else filled
    lines = [words_of(line) for line in printed.splitlines() if line.strip(RULE)]
    place, free = 0, False
    for line in expected.splitlines():
        if not line.strip(RULE) or line.strip() == "...":
            free = free or line.strip() == "..."
            filled.append(line)
            continue
        pattern = pattern_of(line, exact)
        at = place
        while free and at < len(lines) and not pattern.fullmatch(lines[at]):
            at += 1
        if at >= len(lines) or not pattern.fullmatch(lines[at]):
            return f"the page shows \"{line}\", but printed was \"{lines[place] if place < len(lines) else ''}\""
        filled.append(with_numbers(line, pattern.fullmatch(lines[at])))
        place, free = at + 1, False
    if place < len(lines) and not free:
        return f"the page ends, but printed was also \"{lines[place]}\""
    return None


# ---- Blocks


class Runner:
    def __init__(self, root, build, folder, shortened=True):
        self.root, self.build, self.folder, self.shortened = root, build, folder, shortened
        self.count = self.skipped = 0
        python = os.path.join(folder, ".python")  # python3 of the pages is this interpreter
        os.mkdir(python)
        os.symlink(sys.executable, os.path.join(python, "python3"))
        self.environment = dict(
            os.environ, PATH=os.pathsep.join([os.path.join(build, "bin"), python, os.environ["PATH"]]), OMP_WAIT_POLICY="PASSIVE",
            FACEBAKER_LIBRARY=os.path.join(build, "lib", "libfacebaker.so"), PYTHONDONTWRITEBYTECODE="1",
            PYTHONPATH=os.path.join(root, "bindings", "python"), LC_ALL="C.UTF-8")
        for entry in os.listdir(root):
            if not entry.startswith(".") and entry not in ("build", "install"):
                os.symlink(os.path.join(root, entry), os.path.join(folder, entry))
        os.makedirs(os.path.join(folder, "build", "quickstart"))
        os.symlink(build, os.path.join(folder, "build", "release"))

    def code(self, block):
        return block.code if self.shortened else block.text

    def call(self, command, block):
        result = subprocess.run(command, cwd=self.folder, env=self.environment, text=True, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                timeout=300 if self.shortened else None)
        if result.returncode != 0:
            raise PageError(f"{block}: ended with {result.returncode}\n{result.stdout[-2000:]}{result.stderr[-3000:]}")
        return result.stdout

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        if os.path.islink(path):
            raise PageError(f"{name}: there is a file of this name in the tree")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def run_c(self, block):
        self.count += 1
        source = self.write(f"block_{self.count}.{block.language}", self.code(block))
        compiler = "cc" if block.language == "c" else "c++"
        inside = '#include "' in block.text  # an example of code of this tree, not of its users
        command = [compiler, *C_FLAGS["core" if inside else block.language], "-Wall", "-Wextra", "-Werror", source, "-Icapi/include"]
        if not re.search(r"\bint main\(", block.text):
            self.call([*command, "-fsyntax-only"], block)
            return ""
        libraries = os.path.join(self.build, "lib")
        name = "facebaker_bake" if "facebaker_bake.h" in block.text else "facebaker"
        self.call([*command, "-L" + libraries, "-l" + name, "-lm", "-Wl,-rpath," + libraries, "-o", source + ".out"], block)
        return self.call([source + ".out"], block)

    def run(self, block):
        """What a block prints; None if there is nothing to run."""
        if block.language not in ("sh", "c", "cpp", "python") and not block.file:
            return None
        if block.skip:
            self.skipped += 1
            return None
        if block.file:
            self.write(block.file, self.code(block))
            return None
        if block.language == "sh":
            return self.call(["bash", "-euo", "pipefail", "-c", self.code(block)], block)
        if block.language == "python":
            return self.call([sys.executable, "-c", self.code(block)], block)
        return self.run_c(block)


def run_page(runner, root, page, write=False):
    start, printed, ran, filled = time.monotonic(), None, 0, []
    for block in read_blocks(root, page):
        if block.language == "text":
            if printed is not None and not block.skip:
                lines = []
                problem = compare(block.text, printed, block.exact and not write, lines)
                if problem:
                    raise PageError(f"{block}: {problem}\n--- printed:\n{printed[-3000:]}")
                filled.append((block, lines))
            continue
        result = runner.run(block)
        printed = result if block.language in ("sh", "c", "cpp", "python") else printed
        ran += result is not None
    if write:
        write_lines(os.path.join(root, page), filled)
    print(f"{page}: {ran} blocks in {time.monotonic() - start:.1f} s", flush=True)


def write_lines(path, filled):
    """Puts new lines into blocks of a page, which have as many."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    for block, texts in filled:
        lines[block.line:block.line + len(texts)] = texts
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def main(arguments):
    write = arguments[:1] == ["--write"]
    arguments = arguments[1 if write else 0:]
    if len(arguments) < (3 if write else 2):
        print(__doc__, file=sys.stderr)
        return 2
    root, build = os.path.abspath(arguments[0]), os.path.abspath(arguments[1])
    pages, files, problems = pages_of(root), files_of(root), []
    try:
        blocks = [block for page in pages for block in read_blocks(root, page)]
    except PageError as error:
        print(error)
        return 1
    written = {os.path.basename(block.file) for block in blocks if block.file}
    for page in [*pages, "CHANGELOG.md", "CONTRIBUTING.md"]:
        problems += check_links(root, page)
        if page != "CHANGELOG.md":  # it names what is gone, too
            problems += check_paths(root, page, files, written)
    folder = tempfile.mkdtemp(prefix="facebaker-docs-")
    try:
        runner = Runner(root, build, folder, shortened=not write)
        for page in arguments[2:] or pages:
            try:
                run_page(runner, root, page, write)
            except (PageError, subprocess.TimeoutExpired) as error:
                problems.append(str(error))
    finally:
        shutil.rmtree(folder)
    for problem in problems:
        print(problem)
    print(f"{len(pages)} pages, {len(problems)} problems, {runner.skipped} blocks skipped")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
