#!/usr/bin/env python3
"""The pictures that need no baked face are what docs/draw_figures.py draws; all pictures are small, and shown by a page.

    test_pictures.py DOCS
"""
import os
import subprocess
import sys
import tempfile

LARGEST = 200_000


def main(docs):
    problems = []
    committed = os.path.join(docs, "pictures")
    with tempfile.TemporaryDirectory() as drawn:
        subprocess.run([sys.executable, "-B", os.path.join(docs, "draw_figures.py"), "--diagrams", "-", "-", drawn], check=True)
        for name in sorted(os.listdir(drawn)):
            path = os.path.join(committed, name)
            with open(os.path.join(drawn, name), "rb") as file:
                expected = file.read()
            if not os.path.exists(path) or open(path, "rb").read() != expected:
                problems.append(f"{name} is not what docs/draw_figures.py draws")
    pages = "".join(open(os.path.join(docs, p), encoding="utf-8").read() for p in os.listdir(docs) if p.endswith(".md"))
    for name in sorted(os.listdir(committed)):
        if os.path.getsize(os.path.join(committed, name)) > LARGEST:
            problems.append(f"{name} has more than {LARGEST} bytes")
        if f"pictures/{name})" not in pages:
            problems.append(f"{name} is shown by no page")
    print("\n".join(problems) or "pictures are as drawn")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
