// Copies what a loaded face has out of the module's memory.
import type { Channel, Control, DrivenJoint, ExactPose, FaceContents, Image, Joint, JointNumber, Level, Material, Mesh,
              Skin, Socket, Texture, TextureSlot, Wrap } from "./contents.js";
import type { Heap, StructValues } from "./heap.js";
import { fanTriangles } from "./polygons.js";

const slots: readonly TextureSlot[] = ["baseColour", "metallicRoughness", "normal", "occlusion", "emissive"];
const wraps: readonly Wrap[] = ["repeat", "clamp", "mirror"];
const alphaModes = ["opaque", "mask", "blend"] as const;
/** By bit. */
const jointNumbers: readonly JointNumber[] =
  ["rotateX", "rotateY", "rotateZ", "moveX", "moveY", "moveZ",
   "scaleX", "scaleY", "scaleZ", "pivotX", "pivotY", "pivotZ"];
const orNone = (index: number): number => (index === 0xffffffff ? -1 : index);

/** Reads the parts of one model, each when it is asked for. */
export class ContentsReader {
  constructor(private readonly heap: Heap, private readonly model: number) {}

  count(name: string): number {
    return this.heap.call(name, this.model);
  }
  text(name: string): string {
    return this.heap.text(this.heap.call(name, this.model));
  }
  floats(name: string, count: number): Float32Array {
    return this.heap.copyF32(this.heap.call(name, this.model), count);
  }
  numbers(name: string, count: number): Uint32Array {
    return this.heap.copyU32(this.heap.call(name, this.model), count);
  }
  number(name: string): number {
    return Number(this.heap.exports[name]!(this.model));
  }

  // Everything of a kind: fb_KIND_count, fb_KIND_at.
  private all<Item>(kind: string, make: (values: StructValues, index: number) => Item): Item[] {
    const struct = `fb_${kind}`;
    return Array.from({ length: this.count(`${struct}_count`) }, (_, index) =>
      make(this.heap.fill(struct, (to) => this.heap.check(`${struct}_at`, this.model, index, to)), index));
  }
  private texts(kind: string): string[] {
    return Array.from({ length: this.count(`fb_${kind}_count`) }, (_, index) =>
      this.heap.text(this.heap.call(`fb_${kind}_name`, this.model, index)));
  }
  // The structs of an array.
  private array(struct: string, address: number, count: number): StructValues[] {
    return Array.from({ length: count }, (_, i) => this.heap.read(struct, address + i * this.heap.size(struct)));
  }

  controls(): Control[] {
    return this.all("control", (c, index) => ({
      name: c.name, group: c.group, index, minimum: c.minimum, maximum: c.maximum, neutral: c.rest,
      mirror: orNone(c.mirror), arkit: c.arkit, facs: c.facs, unit: c.unit,
    }));
  }

  private mesh(m: StructValues, index: number, sizes: number, corners: number, uvCorners: number): Mesh {
    const polygonSizes = this.heap.copyU32(sizes && sizes + 4 * m.first_polygon, m.polygon_count);
    const polygonCorners = this.heap.copyU32(corners && corners + 4 * m.first_corner, m.corner_count);
    const runs = this.array("fb_material_run", m.runs, m.run_count).map((run) => ({
      polygonCount: run.polygon_count as number, material: orNone(run.material),
    }));
    return {
      name: m.name, index, firstVertex: m.first_vertex, vertexCount: m.vertex_count,
      material: runs[0]?.material ?? -1, runs, polygonSizes, polygonCorners,
      uvCorners: uvCorners ? this.heap.copyU32(uvCorners + 4 * m.first_corner, m.corner_count) : null,
      triangles: fanTriangles(polygonSizes, polygonCorners),
    };
  }
  meshes(): Mesh[] {
    const at = (name: string) => this.heap.call(name, this.model);
    const uvCorners = at("fb_uv_count") > 0 ? at("fb_uv_corners") : 0;
    return this.all("mesh", (m, index) =>
      this.mesh(m, index, at("fb_polygon_sizes"), at("fb_polygon_corners"), uvCorners));
  }
  levels(): Level[] {
    const meshes = this.count("fb_mesh_count");
    return this.all("level", (level) => ({
      vertexCount: level.vertex_count,
      coefficientCount: level.coefficient_count,
      meshes: this.array("fb_mesh", level.meshes, meshes).map((m, index) =>
        this.mesh(m, index, level.polygon_sizes, level.polygon_corners, level.uv_corners)),
    }));
  }
  uvs(): Float32Array | null {
    const count = this.count("fb_uv_count");
    return count > 0 ? this.floats("fb_uvs", 2 * count) : null;
  }
  tangentSigns(): Float32Array | null {
    return this.count("fb_uv_count") > 0 ? this.floats("fb_tangent_signs", this.count("fb_vertex_count")) : null;
  }

  private texture(t: StructValues): Texture {
    return { slot: slots[t.slot]!, image: t.image, wrapU: wraps[t.wrap_u]!, wrapV: wraps[t.wrap_v]!,
             scale: t.scale };
  }
  materials(): Material[] {
    return this.all("material", (m) => ({
      name: m.name, alphaMode: alphaModes[m.alpha_mode]!, alphaCutoff: m.alpha_cutoff,
      baseColour: m.base_colour, metallic: m.metallic, roughness: m.roughness, emissive: m.emissive,
      doubleSided: m["double_sided"] === 1,
      textures: this.array("fb_texture", m.textures, m.texture_count).map((t) => this.texture(t)),
    }));
  }
  images(): Image[] {
    return this.all("image", (i) => ({ name: i.name, mediaType: i.media_type,
                                       bytes: this.heap.copyU8(i.bytes, i.byte_count) }));
  }
  sockets(): Socket[] {
    return this.all("socket", (s) => ({ name: s.name, frame: s.frame,
                                        vertices: this.heap.copyU32(s.vertices, s.vertex_count),
                                        weights: this.heap.copyF32(s.weights, s.vertex_count) }));
  }
  channels(): Channel[] {
    return this.all("channel", (c) => ({ name: c.name, unit: c.unit, minimum: c.minimum,
                                         maximum: c.maximum, rest: c.rest }));
  }
  exactPoses(): ExactPose[] {
    return this.all("exact_pose", (p) => ({ name: p.name,
                                            controls: this.heap.copyF32(p.controls, p.control_count) }));
  }
  joints(): Joint[] {
    return this.all("joint", (j) => ({ name: j.name, parent: orNone(j.parent), rest: j.rest,
                                       inverseBind: j.inverse_bind }));
  }
  private skinOf(influences: number, joints: string, weights: string): Skin | null {
    if (influences === 0) return null;
    const count = influences * this.count("fb_vertex_count");
    return { influences, joints: this.heap.copyU16(this.heap.call(joints, this.model), count),
             weights: this.floats(weights, count) };
  }
  skin(): Skin | null {
    return this.skinOf(this.count("fb_skin_influences"), "fb_skin_joints", "fb_skin_weights");
  }
  drivenJoints(): DrivenJoint[] {
    return this.all("driven_joint", (j) => ({ name: j.name, parent: orNone(j.parent), rest: j.rest,
                                              outerRotations: j.outer_rotations,
                                              numbers: jointNumbers.filter((_, bit) => (j.numbers >>> bit) & 1) }));
  }
  drivenSkin(): Skin | null {
    return this.skinOf(this.count("fb_driven_influences"), "fb_driven_skin_joints", "fb_driven_skin_weights");
  }
  regions(): FaceContents["regions"] {
    const names = this.texts("error_region");
    return { names, ofVertex: this.numbers("fb_error_vertex_regions", names.length && this.count("fb_vertex_count")) };
  }
  networkRegions(): string[] {
    return this.texts("region");
  }
  vertexOrder(): Uint32Array | null {
    const order = this.numbers("fb_vertex_order", this.count("fb_vertex_count"));
    return order.length > 0 ? order : null;
  }
  thumbnail(): Uint8Array | null {
    const size = this.heap.allocate(8);
    const bytes = this.heap.copyU8(this.heap.call("fb_thumbnail", this.model, size), this.heap.u32[size >>> 2]!);
    this.heap.release(size);
    return bytes.length > 0 ? bytes : null;
  }
}
