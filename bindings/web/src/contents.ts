// What a face has, as plain objects: copies, which live longer than the face. facebaker.h and facebaker_character.h say
// what the fields mean.

/** No control, no material, no joint: where one could be. */
export const NONE = -1;

export interface Control {
  readonly name: string;
  readonly group: string;
  readonly index: number;
  readonly minimum: number;
  readonly maximum: number;
  /** The value in the rest pose. */
  readonly neutral: number;
  /** The control that does the same on the other side, or -1. */
  readonly mirror: number;
  /** Its name among the face blendshapes of ARKit, or "". */
  readonly arkit: string;
  /** Its action unit in the Facial Action Coding System, or "". */
  readonly facs: string;
  /** Of its values, such as "degrees", or "". */
  readonly unit: string;
}

/** Consecutive polygons of one material. */
export interface MaterialRun {
  readonly polygonCount: number;
  /** Index of a material, or -1. */
  readonly material: number;
}

/** A mesh of the character. All meshes share one pool of vertices, whose indices its polygons have. */
export interface Mesh {
  readonly name: string;
  readonly index: number;
  readonly firstVertex: number;
  readonly vertexCount: number;
  /** The material of its first polygons, or -1. */
  readonly material: number;
  readonly runs: readonly MaterialRun[];
  /** Corners of each of its polygons. */
  readonly polygonSizes: Uint32Array;
  /** Vertices of the corners, polygon after polygon. */
  readonly polygonCorners: Uint32Array;
  /** For each corner the index of its pair in `uvs` of the face; null without texture coordinates. */
  readonly uvCorners: Uint32Array | null;
  /** The polygons cut into triangles, fans of their first corners: three vertices each. */
  readonly triangles: Uint32Array;
}

export type TextureSlot = "baseColour" | "metallicRoughness" | "normal" | "occlusion" | "emissive";
export type Wrap = "repeat" | "clamp" | "mirror";

export interface Texture {
  readonly slot: TextureSlot;
  /** Index of an image. */
  readonly image: number;
  readonly wrapU: Wrap;
  readonly wrapV: Wrap;
  readonly scale: number;
}

/** With the meaning that glTF 2.0 gives to these fields. */
export interface Material {
  readonly name: string;
  readonly alphaMode: "opaque" | "mask" | "blend";
  readonly alphaCutoff: number;
  /** Linear red, green and blue, alpha. */
  readonly baseColour: readonly number[];
  readonly metallic: number;
  readonly roughness: number;
  readonly emissive: readonly number[];
  readonly doubleSided: boolean;
  readonly textures: readonly Texture[];
}

export interface Image {
  readonly name: string;
  /** "image/png", "image/jpeg", ... */
  readonly mediaType: string;
  /** The file. */
  readonly bytes: Uint8Array;
}

export interface Socket {
  readonly name: string;
  readonly vertices: Uint32Array;
  readonly weights: Float32Array;
  /** At rest: the upper three rows of a 4 x 4 matrix, row after row. */
  readonly frame: readonly number[];
}

export interface Channel {
  readonly name: string;
  readonly unit: string;
  readonly minimum: number;
  readonly maximum: number;
  readonly rest: number;
}

export interface ExactPose {
  readonly name: string;
  readonly controls: Float32Array;
}

export interface Joint {
  readonly name: string;
  /** Index of its parent, or -1. */
  readonly parent: number;
  /** At rest, in its parent: the upper three rows of a 4 x 4 matrix, row after row. */
  readonly rest: readonly number[];
  readonly inverseBind: readonly number[];
}

export interface Skin {
  /** Influences of each vertex in the two arrays. */
  readonly influences: number;
  readonly joints: Uint16Array;
  readonly weights: Float32Array;
}

/** A way in which a driven joint moves, along an axis of its own frame at rest. Its pivot is the point that it turns
 * about. */
export type JointNumber =
  "rotateX" | "rotateY" | "rotateZ" | "moveX" | "moveY" | "moveZ" | "scaleX" | "scaleY" | "scaleZ" |
  "pivotX" | "pivotY" | "pivotZ";

/** A joint that the controls move, such as that of a jaw. It is a part of the face, inside of the skeleton of `joints`;
 * where it is in a pose, `joints` of Outputs gives. */
export interface DrivenJoint {
  readonly name: string;
  /** Index of its parent among these, less than its own, or -1. */
  readonly parent: number;
  /** How controls move it within its parent; none: with that only. */
  readonly numbers: readonly JointNumber[];
  /** How many rotations it turns by beside its first, each after those before it. */
  readonly outerRotations: number;
  /** Its frame at rest, in the space of positions, not of its parent: the upper three rows of a 4 x 4 matrix, row after
   * row. */
  readonly rest: readonly number[];
}

/** A level of detail. Level 0 is the whole. */
export interface Level {
  /** The first so many in baked order (`vertexOrder`). */
  readonly vertexCount: number;
  readonly coefficientCount: number;
  readonly meshes: readonly Mesh[];
}

/** The regions that expected errors are given for; none, and an empty array, if the face has none. */
export interface Regions {
  readonly names: readonly string[];
  /** The region of each vertex. */
  readonly ofVertex: Uint32Array;
}

/** What there is to know of a face without posing it. */
export interface FaceContents {
  readonly name: string;
  readonly units: string;
  readonly upAxis: "y" | "z";
  /** Of the rest mesh's bounding box, in `units`. */
  readonly diagonal: number;
  readonly vertexCount: number;
  readonly controlCount: number;
  readonly coefficientCount: number;
  readonly controls: readonly Control[];
  readonly meshes: readonly Mesh[];
  /** Pairs of texture coordinates, v pointing up; null without any. */
  readonly uvs: Float32Array | null;
  /** -1 where the texture is mirrored, 1 elsewhere, a vertex; null without texture coordinates. */
  readonly tangentSigns: Float32Array | null;
  readonly materials: readonly Material[];
  readonly images: readonly Image[];
  readonly sockets: readonly Socket[];
  readonly channels: readonly Channel[];
  readonly exactPoses: readonly ExactPose[];
  readonly joints: readonly Joint[];
  readonly skin: Skin | null;
  readonly drivenJoints: readonly DrivenJoint[];
  /** What follows the driven joints. The weights of a vertex sum to at most 1: what is missing stays with what does not
   * move. Those that are 0 come last. Null without driven joints. */
  readonly drivenSkin: Skin | null;
  readonly levels: readonly Level[];
  readonly regions: Regions;
  /** The parts of the face that have a network of their own. */
  readonly networkRegions: readonly string[];
  /** The source index of each vertex in baked order; null if that is the source's order. */
  readonly vertexOrder: Uint32Array | null;
  /** JSON, as stored; "" if there is none. */
  readonly provenance: string;
  /** JSON, as stored; "" if there is none. */
  readonly about: string;
  /** A square PNG file; null if there is none. */
  readonly thumbnail: Uint8Array | null;
  /** "wasm-simd" or "scalar". */
  readonly instructionSet: string;
  /** Bytes of memory that the face takes to evaluate poses. */
  readonly runtimeBytes: number;
  readonly restControls: Float32Array;
  readonly restPositions: Float32Array;
}
