"""What a character has besides positions. The same classes describe a loaded face and a rig that is baked; docs/characters.md
explains them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Optional, Sequence, Tuple, Union

from ._arrays import ArrayLike, Floats, Indices

# Words in the order of the numbers that facebaker_character.h gives them.
SLOTS = ("base_colour", "metallic_roughness", "normal", "occlusion", "emissive")
WRAPS = ("repeat", "clamp", "mirror")
ALPHA_MODES = ("opaque", "mask", "blend")


class _NameAndRange(NamedTuple):
    name: str
    group: str
    minimum: float
    maximum: float
    rest: float


class Control(_NameAndRange):
    """A control of a rig. As a tuple it is name, group, minimum, maximum and rest.

    name: unique. group: the control group it belongs to ("brows"), may be empty. minimum, maximum: its range.
    rest: its value in the rest pose. And what it means, where that is known: unit of its values ("degrees"); arkit, its
    name among the face blendshapes of ARKit; facs, its action unit; mirror, the name of the control that does the same
    on the other side, and names this one."""

    unit: str = ""
    arkit: str = ""
    facs: str = ""
    mirror: str = ""

    def __new__(
        cls,
        name: str,
        group: str = "",
        minimum: float = 0.0,
        maximum: float = 1.0,
        rest: float = 0.0,
        *,
        unit: str = "",
        arkit: str = "",
        facs: str = "",
        mirror: str = "",
    ) -> "Control":
        control = super().__new__(cls, name, group, minimum, maximum, rest)
        control.unit, control.arkit, control.facs, control.mirror = unit, arkit, facs, mirror
        return control


@dataclass(frozen=True)
class MaterialRun:
    """Consecutive polygons of a mesh that have one material: an index of materials, or None."""

    polygons: int
    material: Optional[int] = None


@dataclass(frozen=True)
class Mesh:
    """One of the meshes of a character, which share one pool of vertices and polygons: those of a mesh follow those of
    the mesh before it. The numbers from first_vertex on are filled in a loaded face, and not read from a rig."""

    name: str
    vertices: int
    polygons: int
    materials: Tuple[MaterialRun, ...] = ()
    first_vertex: int = 0
    first_polygon: int = 0
    first_corner: int = 0
    corners: int = 0

    @property
    def vertex_slice(self) -> slice:
        """Its part of an array of vertices, such as positions."""
        return slice(self.first_vertex, self.first_vertex + self.vertices)


@dataclass(frozen=True)
class Texture:
    """slot: "base_colour", "metallic_roughness", "normal", "occlusion" or "emissive". image: an index of images. wrap_u,
    wrap_v: "repeat", "clamp" or "mirror". scale: of a normal texture; strength of an occlusion texture."""

    slot: str
    image: int
    wrap_u: str = "repeat"
    wrap_v: str = "repeat"
    scale: float = 1.0


@dataclass(frozen=True)
class Material:
    """With the meaning that glTF 2.0 gives to these fields; colours are linear. alpha_mode: "opaque", "mask", "blend"."""

    name: str = ""
    base_colour: Tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    metallic: float = 1.0
    roughness: float = 1.0
    emissive: Tuple[float, ...] = (0.0, 0.0, 0.0)
    alpha_mode: str = "opaque"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    textures: Tuple[Texture, ...] = ()


@dataclass(frozen=True)
class Image:
    """A picture file as it is. media_type: "image/png", "image/jpeg", ..."""

    name: str
    media_type: str
    data: bytes

    def __repr__(self) -> str:
        return f"Image({self.name!r}, {self.media_type!r}, {len(self.data)} bytes)"


@dataclass(frozen=True, eq=False)
class Socket:
    """A named frame that follows the surface. vertices: indices of at least 3, not on one line. weights: one a vertex,
    above 0; None: all 1. frame: (3, 4), the upper rows of a 4 x 4 matrix, at rest; None: axes of space, at the centre
    of the vertices."""

    name: str
    vertices: Union[Sequence[int], Indices]
    weights: Optional[ArrayLike] = None
    frame: Optional[ArrayLike] = None


@dataclass(frozen=True)
class Channel:
    """A named number that a rig gives with each pose, within its range: the weight of a wrinkle map, the turn of an
    eye."""

    name: str
    minimum: float = 0.0
    maximum: float = 1.0
    rest: float = 0.0
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the skeleton that carries the face; after its parent. parent: an index of joints, or None. rest: (3, 4),
    a frame in its parent; None: at its parent's. inverse_bind: (3, 4), from the space of positions to the joint's; None:
    the inverse of where the joint is at rest. numbers: of a skinned rig, how the controls move it, some of rotate_x, move_x,
    scale_x and those of y and z; it then becomes a DrivenJoint. Without any it is a host's, unless it is below one that has
    some."""

    name: str
    parent: Optional[int] = None
    rest: Optional[ArrayLike] = None
    inverse_bind: Optional[ArrayLike] = None
    numbers: Tuple[str, ...] = ()


# How a joint may move within its parent, by bit; a bake finds pivots, which joints of a rig do not name.
NUMBERS = tuple(f"{kind}_{axis}" for kind in ("rotate", "move", "scale", "pivot") for axis in "xyz")
RIG_NUMBERS = NUMBERS[:9]


class DrivenJoint(NamedTuple):
    """A joint that the controls of a face move. parent: an index of driven joints, or None. numbers: how it moves within its
    parent, some of rotate_x, move_x, scale_x, pivot_x (where the point is that it turns about) and those of y and z. rest:
    (3, 4), its frame at rest, in the space of positions. outer_rotations: how many rotations it turns by beside its first,
    each after those before it."""

    name: str
    parent: Optional[int]
    numbers: Tuple[str, ...]
    rest: Any
    outer_rotations: int = 0


class Skin(NamedTuple):
    """How vertices follow joints. joints: (vertices, influences), indices of joints. weights: of the same shape; those of
    a vertex sum to 1, or are all 0 in a mesh that follows no joint; of a rig whose joints are all driven, to at most 1.
    Positions of a character with a skin are those before skinning."""

    joints: Any
    weights: Any


@dataclass(frozen=True, eq=False)
class ExactPose:
    """A pose that comes out as the rig gave it. name: "CLIP:FRAME". controls: (controls,), its values."""

    name: str
    controls: Floats


@dataclass(frozen=True, eq=False)
class Level:
    """A level of detail; level 0 is the whole. vertices: how many it has, the first in vertex_order. polygon_sizes,
    polygon_corners, uv_corners: as those of the face, with its vertex indices. meshes: with the level's polygons.
    coefficients: how many move its vertices."""

    vertices: int
    polygon_sizes: Indices
    polygon_corners: Indices
    uv_corners: Indices
    meshes: Tuple[Mesh, ...]
    coefficients: int


About = Dict[str, Any]
