"""What a bake came to, in lines for people. Without Blender."""

from __future__ import annotations

from typing import Any, Dict, List


def result_lines(document: Dict[str, Any]) -> List[str]:
    """Of the JSON document that `facebaker bake` prints: its verdict first, which says how far the face is off, in
    millimetres; then its size and what it took."""
    verdict = [str(document["verdict"])] if document.get("verdict") else []
    reused = document.get("reused", 0)
    return [
        *verdict,
        f"{_size_text(document.get('bytes', 0))}, trained on {document.get('poses', 0):,} poses",
        f"The rig was evaluated {document.get('rig_calls', 0):,} times",
        *([f"{reused:,} answers of the rig were taken over"] if reused else []),
    ]


def warnings_of(document: Dict[str, Any]) -> List[str]:
    """What the bake warned of, in sentences."""
    return [f"{warning[:1].upper()}{warning[1:]}." for warning in map(str, document.get("warnings", ()))]


def _size_text(size: int) -> str:
    return f"{size / 1e6:.2f} MB" if size >= 1_000_000 else f"{size / 1e3:.0f} kB"
