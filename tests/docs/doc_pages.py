"""Reads the Markdown pages of this project: fenced blocks with the directives before them, links and paths."""
import os
import re

LANGUAGES = ("sh", "c", "cpp", "csharp", "html", "js", "jsx", "ts", "gdscript", "python", "cmake", "json", "text", "math", "")
FENCE = re.compile(r"^```(\w*)\s*$")
DIRECTIVE = re.compile(r"^<!--\s*(skip|file|replace|exact)\b:?\s*(.*?)\s*-->$")


class PageError(Exception):
    pass


class Block:
    """A fenced block: its language, text and line, and the directives in the HTML comments right before it."""

    def __init__(self, page, line, language, directives):
        self.page, self.line, self.language = page, line, language
        self.text = ""
        self.skip = self.file = None
        self.exact = False
        self.replacements = []
        for name, value in directives:
            if name == "replace":
                pair = re.fullmatch(r'"(.+?)"\s+with\s+"(.*?)"', value)
                if not pair:
                    raise PageError(f"{self}: a replacement is written: replace \"this\" with \"that\"")
                self.replacements.append(pair.groups())
            elif name == "exact":
                self.exact = True
            elif not value:
                raise PageError(f"{self}: {name}: needs a value")
            else:
                setattr(self, name, value)

    def __str__(self):
        return f"{self.page}:{self.line}"

    @property
    def code(self):
        """The text with the replacements made that keep the test short."""
        text = self.text
        for old, new in self.replacements:
            if old not in text:
                raise PageError(f"{self}: \"{old}\" is not in the block")
            text = text.replace(old, new)
        return text


def read_blocks(root, page):
    """The blocks of a page, in order."""
    blocks, directives, current = [], [], None
    with open(os.path.join(root, page), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            line = line.rstrip("\n")
            if current:
                if line == "```":
                    blocks.append(current)
                    current, directives = None, []
                else:
                    current.text += line + "\n"
                continue
            fence, directive = FENCE.match(line), DIRECTIVE.match(line)
            if fence:
                if fence[1] not in LANGUAGES:
                    raise PageError(f"{page}:{number}: the language \"{fence[1]}\" is not one of {', '.join(LANGUAGES)}")
                current = Block(page, number, fence[1], directives)
            elif directive:
                directives.append(directive.groups())
            elif line.strip() and directives:
                raise PageError(f"{page}:{number}: no block follows \"<!-- {directives[-1][0]} ... -->\"")
    if current:
        raise PageError(f"{current}: the block does not end")
    return blocks


def without_blocks(text):
    return re.sub(r"^```.*?^```$", "", text, flags=re.S | re.M)


def anchors_of(text):
    """The anchors that headings get on GitHub."""
    anchors = set()
    for heading in re.findall(r"^#+\s+(.*)$", without_blocks(text), flags=re.M):
        anchors.add(re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-"))
    return anchors


def links_of(text):
    return re.findall(r"\]\(([^)\s]+)\)", without_blocks(text)) + re.findall(r'<img[^>]*src="([^"]+)"', text)


SOURCE_SUFFIXES = (".h", ".hpp", ".c", ".cpp", ".inl", ".py", ".sh", ".md", ".map", ".cmake", ".mjs")


def paths_of(text, folders):
    """Words in backticks that name a file or folder of the tree: those that begin with one of its folders, and names of
    source files. Yields a path each, with braces expanded; placeholders in capitals are left out."""
    for code in re.findall(r"`([^`\n]+)`", without_blocks(text)):
        for word in code.split():
            word = word.rstrip(".,;:")
            inside = "/" in word and word.split("/")[0] in folders
            if not inside and not (word.endswith(SOURCE_SUFFIXES) and re.fullmatch(r"[\w{][\w./{},-]*", word)):
                continue
            if re.search(r"\b[A-Z]{3,}\b", word.replace("_", " ")) and not word.endswith(".md") or "<" in word:
                continue
            braces = re.search(r"\{([^}]*)\}", word)
            for choice in braces[1].split(",") if braces else [None]:
                yield word if choice is None else word.replace(braces[0], choice)
