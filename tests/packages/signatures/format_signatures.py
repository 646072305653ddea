"""The signatures by which others know archives, read from the files of packager/desktop: those of DROID and siegfried, those of
fido, the magic of file(1) and that of desktops. Whatever a file says that is not understood here is an error."""

import dataclasses
import pathlib
import re
import xml.etree.ElementTree as ElementTree

DROID = "{http://www.nationalarchives.gov.uk/pronom/SignatureFile}"
MIME = "{http://www.freedesktop.org/standards/shared-mime-info}"


@dataclasses.dataclass
class Format:
    """What a file may be identified as; matches tells whether bytes have its signature."""

    puid: str
    name: str
    version: str
    media_type: str
    extensions: list
    overrules: list  # PUIDs of formats that are left out where this one matches, too
    matches: object


def identify(formats, data):
    """PUIDs of the formats that data has the signatures of, without those that another one of them overrules."""
    found = [one for one in formats if one.matches(data)]
    overruled = {puid for one in found for puid in one.overrules}
    return [one.puid for one in found if one.puid not in overruled]


def attributes_of(element, required, optional=()):
    names = set(element.attrib)
    if not set(required) <= names <= set(required) | set(optional):
        raise ValueError(f"<{element.tag}> has the attributes {sorted(names)}, expected {sorted(required)}")
    return element.attrib


def children_of(element, namespace, names):
    """The children by name; any other name is an error."""
    found = {name: [] for name in names}
    for child in element:
        name = child.tag.removeprefix(namespace)
        if name not in found:
            raise ValueError(f"<{element.tag}> has a <{child.tag}>, expected one of {names}")
        found[name].append(child)
    return found


def one_of(element, namespace, name):
    (child,) = children_of(element, namespace, [name])[name]
    return child


def droid_bytes(signature):
    """The bytes that a file begins with by an InternalSignature: one sequence of plain bytes at its beginning."""
    sequence = one_of(signature, DROID, "ByteSequence")
    if attributes_of(sequence, ["Reference"])["Reference"] != "BOFoffset":
        raise ValueError(f"a signature is sought by {sequence.attrib}, expected BOFoffset")
    part = one_of(sequence, DROID, "SubSequence")
    if attributes_of(part, ["MinFragLength", "Position", "SubSeqMinOffset", "SubSeqMaxOffset"]) != {
            "MinFragLength": "0", "Position": "1", "SubSeqMinOffset": "0", "SubSeqMaxOffset": "0"}:
        raise ValueError(f"a signature is not at the beginning: {part.attrib}")
    return bytes.fromhex(one_of(part, DROID, "Sequence").text)


def beginning_with(beginnings):
    return lambda data: data.startswith(tuple(beginnings))


def droid_formats(path):
    """Formats of a DROID signature file, and the bytes of each of its signatures by PUID."""
    root = ElementTree.parse(path).getroot()
    attributes_of(root, ["Version", "DateCreated"])
    parts = children_of(root, DROID, ["InternalSignatureCollection", "FileFormatCollection"])
    (signatures,), (formats,) = parts.values()
    begins = {}
    for signature in children_of(signatures, DROID, ["InternalSignature"])["InternalSignature"]:
        number = attributes_of(signature, ["ID", "Specificity"])["ID"]
        if number in begins:
            raise ValueError(f"two signatures have the ID {number}")
        begins[number] = droid_bytes(signature)
    elements = children_of(formats, DROID, ["FileFormat"])["FileFormat"]
    puids = {one.get("ID"): one.get("PUID") for one in elements}
    if len(puids) != len(elements) or len(set(puids.values())) != len(elements):
        raise ValueError("two formats have the same ID or PUID")
    result, beginnings = [], {}
    for element in elements:
        values = attributes_of(element, ["ID", "Name", "PUID", "MIMEType"], ["Version"])
        fields = children_of(element, DROID, ["InternalSignatureID", "Extension", "HasPriorityOverFileFormatID"])
        beginnings[values["PUID"]] = [begins[one.text] for one in fields["InternalSignatureID"]]
        result.append(Format(values["PUID"], values["Name"], values.get("Version", ""), values["MIMEType"],
                             [one.text for one in fields["Extension"]],
                             [puids[one.text] for one in fields["HasPriorityOverFileFormatID"]],
                             beginning_with(beginnings[values["PUID"]])))
    return result, beginnings


def fido_formats(path):
    """Formats of a file that fido loads: regular expressions of bytes, as fido compiles them."""
    result = []
    for element in children_of(ElementTree.parse(path).getroot(), "", ["format"])["format"]:
        fields = children_of(element, "", ["puid", "mime", "name", "version", "extension", "has_priority_over", "signature"])
        texts = {name: [one.text for one in fields[name]] for name in fields}
        (signature,) = fields["signature"]
        (pattern,) = children_of(signature, "", ["name", "pattern"])["pattern"]
        position, regex = (one.text for one in pattern)
        if position != "BOF":
            raise ValueError(f"a pattern of {texts['puid']} is sought at {position}, expected BOF")
        result.append(Format(texts["puid"][0], texts["name"][0], "".join(texts["version"]), texts["mime"][0], texts["extension"],
                             texts["has_priority_over"], re.compile(regex.encode("latin-1")).search))  # as fido does
    return result


def unescaped(text):
    """Bytes of a string as in C, octal numbers and all, as both files of magic write it."""
    return text.encode("ascii").decode("unicode_escape").encode("latin-1")


def file_magic(path):
    """What a file of magic for file(1) says of archives: bytes, media type, extensions."""
    text = pathlib.Path(path).read_text(encoding="ascii")
    (begin,) = re.findall(r"^0\tstring\t(\S+)\t", text, flags=re.M)
    (media_type,) = re.findall(r"^!:mime\t(\S+)$", text, flags=re.M)
    (extensions,) = re.findall(r"^!:ext\t(\S+)$", text, flags=re.M)
    return unescaped(begin), media_type, extensions.split("/")


def desktop_magic(path):
    """The same of a file of shared-mime-info."""
    kind = one_of(ElementTree.parse(path).getroot(), MIME, "mime-type")
    fields = children_of(kind, MIME, ["comment", "magic", "glob"])
    match = one_of(fields["magic"][0], MIME, "match")
    if (match.get("type"), match.get("offset")) != ("string", "0"):
        raise ValueError(f"the magic of desktops is sought by {match.attrib}")
    return unescaped(match.get("value")), kind.get("type"), [one.get("pattern").removeprefix("*.") for one in fields["glob"]]
