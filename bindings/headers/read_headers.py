"""Reads the public C headers: constants, structs, callbacks and functions, for the generators of bindings.

The headers are the only description of the C interface; what is not understood in one is an error. Standard library only."""

from __future__ import annotations

import pathlib
import re
from typing import Dict, Iterator, List, NamedTuple, Optional, Sequence, Union

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "capi" / "include" / "facebaker"
RUNTIME_HEADERS = ("facebaker.h", "facebaker_character.h", "facebaker_solve.h")  # of libfacebaker
HEADERS = RUNTIME_HEADERS + (  # all, each after those that it includes
    "facebaker_rig.h", "facebaker_source.h", "facebaker_archive.h", "facebaker_bag.h", "facebaker_export.h",
    "facebaker_sign.h",
    "facebaker_bake.h",
)  # fmt: skip
# Bytes of the scalar types; size_t has those of a pointer.
SCALARS: Dict[str, int] = {
    "int8_t": 1, "uint8_t": 1, "int16_t": 2, "uint16_t": 2, "int32_t": 4, "uint32_t": 4, "int64_t": 8, "uint64_t": 8,
    "float": 4, "double": 8, "char": 1,
}  # fmt: skip


class HeaderError(ValueError):
    """Something in a header that is not understood, or that a generator cannot write in its language."""


class Field(NamedTuple):
    """A member of a struct, a parameter or a result."""

    type: str  # in C, as in "const float*"; "" of a pointer to a function
    name: str
    length: int = 0  # of an array; 0: none
    function: Optional["Function"] = None  # what it points to

    @property
    def base(self) -> str:
        """The type without const and stars."""
        return self.type.replace("const", "").replace("*", "").strip()

    @property
    def stars(self) -> int:
        return self.type.count("*")


class Function(NamedTuple):
    """A function, or the type of a pointer to one."""

    name: str
    result: Field
    parameters: List[Field]


class Struct(NamedTuple):
    name: str
    fields: List[Field]


class Constant(NamedTuple):
    name: str
    value: str  # as in C: "-1", "0xffffffffu"

    @property
    def number(self) -> int:
        return int(self.value.rstrip("u"), 0)


class Interface(NamedTuple):
    """What headers declare, in their order."""

    constants: List[Constant]
    aliases: Dict[str, str]  # types that are another name of a scalar
    handles: List[str]  # structs without members
    types: List[Union[Struct, Function]]  # structs and callbacks
    functions: List[Function]

    @property
    def structs(self) -> Dict[str, Struct]:
        return {one.name: one for one in self.types if isinstance(one, Struct)}

    @property
    def callbacks(self) -> Dict[str, Function]:
        return {one.name: one for one in self.types if isinstance(one, Function)}

    def scalar(self, field: Field) -> str:
        """The scalar type of a field; "" if its base is none."""
        base = self.aliases.get(field.base, field.base)
        return base if base in SCALARS or base in ("size_t", "void") else ""


_TYPE = r"(?:const )?(?:struct )?\w+(?: ?\*(?: ?const\b)?)*"
# Declarations that stand alone, by kind. Inline functions have no braces within their own.
_DECLARATION = re.compile(
    r"typedef struct (?P<struct>\w+) \{ (?P<members>[^{}]*)\} (?P<again>\w+); ?"
    r"|typedef struct (?P<handle>\w+) (?P=handle); ?"
    r"|typedef (?P<scalar>\w+) (?P<alias>\w+); ?"
    rf"|typedef (?P<returned>{_TYPE}) ?\(\*(?P<callback>\w+)\)\((?P<taken>[^()]*)\); ?"
    rf"|FB_API (?P<result>{_TYPE}) ?\b(?P<function>fb_\w+)\((?P<parameters>[^()]*)\); ?"
    r"|(?P<ignored>static inline void fb_\w+\([^()]*\) \{[^{}]*\}|struct \w+;) ?"
)
_DIRECTIVE = re.compile(r"^ *# ?(?:include|define|if|ifdef|ifndef|elif|else|endif)\b.*$", flags=re.M)
_DEFINITION = re.compile(r"^ *# ?define (\w+)(.*)$", flags=re.M)


def read_headers(folder: pathlib.Path = FOLDER, names: Sequence[str] = HEADERS) -> Interface:
    """Raises HeaderError on what is not understood, OSError on a header that cannot be read."""
    text = "\n".join((folder / name).read_text(encoding="utf-8") for name in names)
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S).replace("\\\n", " ")
    text = re.sub(r"^# ?ifdef __cplusplus$.*?^# ?endif", "", text, flags=re.S | re.M)
    constants = list(_read_constants(text))
    read = Interface(constants, {}, [], [], [])
    _read_declarations(_DIRECTIVE.sub("", text), read)
    _check_types(read)
    return read


def _read_constants(text: str) -> Iterator[Constant]:
    """Macros that are numbers; others are known by their names, or empty."""
    for name, value in _DEFINITION.findall(text):
        number = re.fullmatch(r" *\(?(-?(?:0x[0-9a-fA-F]+|\d+)u?)\)? *", value)
        if number:
            yield Constant(name, number[1])
        elif name not in ("FB_API", "FB_RIG_OPEN_SYMBOL") and value.strip():
            raise HeaderError(f'cannot read the macro "{name}{value}"')


def _read_declarations(text: str, read: Interface) -> None:
    text = " ".join(text.split())
    numbers = {constant.name: constant.number for constant in read.constants}
    at = 0
    while at < len(text):
        found = _DECLARATION.match(text, at)
        if not found:
            raise HeaderError(f'cannot read "{text[at : at + 80]}"')
        at = found.end()
        if found["struct"]:
            if found["struct"] != found["again"]:
                raise HeaderError(f"struct {found['struct']} is called {found['again']}, too")
            members = [member.strip() for member in found["members"].split(";") if member.strip()]
            read.types.append(Struct(found["struct"], [_read_field(member, numbers) for member in members]))
        elif found["handle"]:
            read.handles.append(found["handle"])
        elif found["alias"]:
            read.aliases[found["alias"]] = found["scalar"]
        elif found["callback"]:
            read.types.append(_read_function(found["callback"], found["returned"], found["taken"], numbers))
        elif found["function"]:
            read.functions.append(_read_function(found["function"], found["result"], found["parameters"], numbers))


def _read_function(name: str, result: str, parameters: str, numbers: Dict[str, int]) -> Function:
    parts = [part.strip() for part in parameters.split(",")]
    fields = [] if parts in ([""], ["void"]) else [_read_field(part, numbers) for part in parts]
    return Function(name, Field(_plain(result), ""), fields)


def _read_field(text: str, numbers: Dict[str, int]) -> Field:
    """Such as `const float* values`, `float rest[FB_FRAME_FLOATS]` or `void (*release)(void* memory)`."""
    function = re.fullmatch(rf"({_TYPE}) ?\(\*(\w+)\)\(([^()]*)\)", text)
    if function:
        return Field("", function[2], 0, _read_function(function[2], function[1], function[3], numbers))
    plain = re.fullmatch(rf"({_TYPE}) ?\b(\w+)(?:\[(\w+)\])?", text)
    if not plain or (plain[3] and not plain[3].isdigit() and plain[3] not in numbers):
        raise HeaderError(f'cannot read the declaration "{text}"')
    length = int(numbers.get(plain[3], plain[3])) if plain[3] else 0
    return Field(_plain(plain[1]), plain[2], length)


def _plain(c_type: str) -> str:
    return c_type.replace("struct ", "").replace(" *", "*").strip()


def _check_types(read: Interface) -> None:
    """Every type is declared, before it is used."""
    known = {*SCALARS, *read.aliases, *read.handles, "size_t", "void"}
    for alias, scalar in read.aliases.items():
        if scalar not in SCALARS:
            raise HeaderError(f'{alias}: the type "{scalar}" is not known')
    for one in [*read.types, *read.functions]:
        for field in _fields_of(one):
            if field.base not in known:
                raise HeaderError(f'{one.name}: the type "{field.type}" is not known')
        known.add(one.name)


def _fields_of(one: Union[Struct, Function]) -> Iterator[Field]:
    """Members, or result and parameters; of a pointer to a function those of the function."""
    for field in one.fields if isinstance(one, Struct) else [one.result, *one.parameters]:
        if field.function:
            yield from _fields_of(field.function)
        else:
            yield field
