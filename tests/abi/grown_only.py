#!/usr/bin/env python3
"""Whether a newer C interface only adds to an older one: functions, members at the ends of structs that begin with their
size, values of enumerations. Prints what it does besides.

    grown_only.py OLD.abi NEW.abi      dumps of abidw

abidiff says that something has changed, but not whether that is all."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as xml
from typing import Dict, List, Tuple

Member = Tuple[int, str, str]  # offset in bits, name, type


class Interface:
    """The exported functions and the structs of a dump, with types as text."""

    def __init__(self, file: str) -> None:
        root = xml.parse(file).getroot()
        self._types = {one.get("id", ""): one for one in root.iter() if one.get("id")}
        self.functions: Dict[str, str] = {}
        for one in root.iter("function-decl"):
            if one.get("elf-symbol-id"):
                self.functions[one.get("name", "")] = self._signature(one)
        self.structs: Dict[str, List[Member]] = {}
        for one in root.iter("class-decl"):
            if one.find("data-member") is not None:
                self.structs[one.get("name", "")] = [self._member(member) for member in one.iter("data-member")]
        self.aliases = {one.get("name", ""): self._type(one.get("type-id", "")) for one in root.iter("typedef-decl")}

    def _member(self, member: xml.Element) -> Member:
        variable = member.find("var-decl")
        assert variable is not None
        return (
            int(member.get("layout-offset-in-bits", "0")),
            variable.get("name", ""),
            self._type(variable.get("type-id", "")),
        )

    def _signature(self, function: xml.Element) -> str:
        result = function.find("return")
        parameters = [self._type(one.get("type-id", "")) for one in function.findall("parameter")]
        return f"{self._type(result.get('type-id', '')) if result is not None else 'void'}({', '.join(parameters)})"

    def _type(self, name: str) -> str:
        one = self._types.get(name)
        if one is None:
            return name  # such as an ellipsis
        inner = one.get("type-id", "")
        if one.tag == "pointer-type-def":
            return self._type(inner) + "*"
        if one.tag == "qualified-type-def":
            return ("const " if one.get("const") == "yes" else "volatile ") + self._type(inner)
        if one.tag == "array-type-def":
            return self._type(inner) + "[" + ", ".join(part.get("length", "") for part in one.findall("subrange")) + "]"
        if one.tag == "function-type":
            return self._signature(one)
        return one.get("name", one.tag) + ("" if one.tag != "type-decl" else f":{one.get('size-in-bits', '')}")


def offences(old: Interface, new: Interface) -> List[str]:
    found = []
    for name, signature in old.functions.items():
        if new.functions.get(name) != signature:
            found.append(f"{name}: was {signature}, is {new.functions.get(name, 'gone')}")
    for name, alias in old.aliases.items():
        if name in new.aliases and new.aliases[name] != alias:
            found.append(f"{name}: was {alias}, is {new.aliases[name]}")
    for name, members in old.structs.items():
        now = new.structs.get(name, [])
        changed = [f"{name}: was {was}, is {now[i] if i < len(now) else 'gone'}" for i, was in enumerate(members) if now[i : i + 1] != [was]]
        if not changed and len(now) > len(members) and members[0][1] != "struct_size":
            changed = [f"{name}: has grown, and does not begin with its size"]
        found += changed
    return found


def main(arguments: List[str]) -> int:
    old, new = Interface(arguments[0]), Interface(arguments[1])
    if not old.functions or not new.functions:
        print("a dump without functions")
        return 1
    found = offences(old, new)
    print("\n".join(found) or f"{len(old.functions)} functions and {len(old.structs)} structs are as they were, or have grown")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
