"""Breaks text into lines of a width. Without Blender."""

from __future__ import annotations

from typing import Callable, List

Measure = Callable[[str], float]  # the width of a text


def wrapped(text: str, width: float, measure: Measure) -> List[str]:
    """The text in lines that are at most so wide, none of it left out. It is broken at spaces and at its own ends of lines;
    a word that is wider than a line, such as a path, is broken within."""
    lines: List[str] = []
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}" if line else word
            if measure(longer) <= width:
                line = longer
                continue
            if line:
                lines.append(line)
            *whole, line = _pieces(word, width, measure)
            lines += whole
        if line:
            lines.append(line)
    return lines


def _pieces(word: str, width: float, measure: Measure) -> List[str]:
    """A word in pieces that fit; each has one character at least. A piece ends behind a slash or the like if there is one
    in its second half."""
    pieces = []
    while measure(word) > width and len(word) > 1:
        end = 1
        while end < len(word) - 1 and measure(word[: end + 1]) <= width:
            end += 1
        breaks = [place + 1 for place in range(end // 2, end) if word[place] in "/\\_-.,:"]
        end = breaks[-1] if breaks else end
        pieces.append(word[:end])
        word = word[end:]
    return [*pieces, word]
