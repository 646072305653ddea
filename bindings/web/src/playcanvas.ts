/** A face in a scene of PlayCanvas. */
import {
  BoundingBox, BUFFER_DYNAMIC, BUFFER_STATIC, Entity, IndexBuffer, INDEXFORMAT_UINT16, INDEXFORMAT_UINT32, Mesh, MeshInstance,
  PRIMITIVE_TRIANGLES, SEMANTIC_BLENDINDICES, SEMANTIC_BLENDWEIGHT, SEMANTIC_NORMAL, SEMANTIC_POSITION, SEMANTIC_TEXCOORD0, TYPE_FLOAT32,
  Vec3, VertexBuffer, VertexFormat, type AppBase, type GraphicsDevice, type GraphNode, type StandardMaterial,
} from "playcanvas";
import type { Face } from "./face.js";
import { PlayCanvasMaterials } from "./playcanvas_materials.js";
import { PlayCanvasSkin } from "./playcanvas_skin.js";
import { influenceCount, PosedFace, strongestInfluences, type FaceOptions, type Influences } from "./posed_face.js";
import { scatter, type RenderMesh } from "./render_mesh.js";
import { metresPerUnit, scaleToMetres } from "./units.js";

// A mesh of the character: its buffer has all positions, then all normals, then what stays.
interface Part {
  readonly render: RenderMesh;
  readonly buffer: VertexBuffer;
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** One a material. */
  readonly meshes: readonly Mesh[];
}

/** An entity with a child for each mesh of the character, on the archive's skin where it has one. Buffers are filled in
 * place, nothing is allocated. */
export class FaceBakerEntity extends Entity {
  /** By material of the face; the last one is for polygons without material. */
  readonly materials: readonly StandardMaterial[];
  /** By joint of the face; none without a skin. They are at rest until the page turns them. */
  readonly bones: readonly Entity[];
  /** Metres of the unit that positions are in; null where the archive's is not known. */
  readonly metresPerUnit: number | null;
  /** When all pictures are decoded; those that cannot be are left out. */
  readonly ready: Promise<void>;
  private readonly posed: PosedFace;
  private readonly parts: readonly Part[];
  private readonly materialSet: PlayCanvasMaterials;
  private readonly skin: PlayCanvasSkin | null;
  private readonly space: Entity; // of positions
  private readonly aabb = new BoundingBox();
  private readonly minimum = new Vec3();
  private readonly maximum = new Vec3();

  /** `app` needs its render component, as every Application has it. Add the entity to its scene. */
  constructor(face: Face, app: AppBase, options: FaceOptions = {}) {
    super(face.name, app);
    this.posed = new PosedFace(face, options);
    this.metresPerUnit = metresPerUnit(face.units);
    this.space = new Entity("space of positions", app);
    if (options.metres) this.space.setLocalScale(Vec3.ONE.clone().mulScalar(scaleToMetres(face.units)));
    if (face.upAxis === "z") this.space.setLocalEulerAngles(-90, 0, 0);
    this.addChild(this.space);
    this.materialSet = new PlayCanvasMaterials(face, app.graphicsDevice);
    this.materials = this.materialSet.all;
    this.ready = this.materialSet.ready;
    this.skin = (options.skin ?? true) && face.skin ? new PlayCanvasSkin(face, app, this.space) : null;
    this.bones = this.skin?.bones ?? [];
    this.parts = this.posed.meshes.map((render, index) => this.makePart(render, face.meshes[index]!.name, app));
    this.fill();
  }

  private makePart(render: RenderMesh, name: string, app: AppBase): Part {
    const influences = this.skin ? strongestInfluences(this.posed.face.skin!, render) : null;
    const buffer = makeBuffer(app.graphicsDevice, render, influences);
    const [positions, normals] = streams(buffer, render.vertexCount) as [Float32Array, Float32Array];
    const meshes: Mesh[] = [];
    const meshInstances = render.groups.map(({ start, count, material }) => {
      const mesh = new Mesh(app.graphicsDevice), indices = narrow(render.indices.subarray(start, start + count), render.vertexCount);
      mesh.vertexBuffer = buffer;
      mesh.indexBuffer[0] = new IndexBuffer(
        app.graphicsDevice, indices instanceof Uint16Array ? INDEXFORMAT_UINT16 : INDEXFORMAT_UINT32, count, BUFFER_STATIC, indices);
      Object.assign(mesh.primitive[0]!, { type: PRIMITIVE_TRIANGLES, base: 0, count, indexed: true });
      const instance = new MeshInstance(mesh, this.materialSet.at(material));
      if (influences) this.skin!.carry(mesh, instance);
      meshes.push(mesh);
      return instance;
    });
    const child = new Entity(name, app);
    if (!child.addComponent("render", { meshInstances }))
      throw new Error("facebaker: this application of PlayCanvas has no RenderComponentSystem");
    this.space.addChild(child);
    return { render, buffer, positions, normals, meshes };
  }

  /** Poses the face. `lod`: between its level of detail and the next one, 0 to 1, positions slide continuously. */
  update(controls: Float32Array, lod = 0): void {
    this.posed.pose(controls, lod);
    this.fill();
  }

  private fill(): void {
    const { posed: { bounds }, minimum, maximum } = this;
    minimum.set(bounds[0]!, bounds[1]!, bounds[2]!);
    maximum.set(bounds[3]!, bounds[4]!, bounds[5]!);
    this.aabb.setMinMax(minimum, maximum);
    for (const { render, buffer, positions, normals, meshes } of this.parts) {
      scatter(render, this.posed.positions, positions);
      scatter(render, this.posed.normals, normals);
      buffer.unlock(0, positions.byteLength + normals.byteLength);
      for (const mesh of meshes) mesh.aabb = this.aabb;
    }
  }

  /** Puts the face on a body: joints follow the nodes below `root`, such as the bones of a character, that have their
   * names, by how these move from where they are now. Place the face first. Gives the names of joints without one, which
   * stay with this entity. */
  followBones(root: GraphNode): string[] {
    return this.skin?.follow(root) ?? [];
  }

  /** Frees its meshes, materials, textures and bones, and takes it out of the scene. The face stays. */
  override destroy(): void {
    super.destroy();
    this.skin?.destroy();
    this.materialSet.destroy();
  }
}

const narrow = (indices: Uint32Array, vertexCount: number) => vertexCount < 65536 ? Uint16Array.from(indices) : indices.slice();

// Streams one after the other, so that those that move are sent alone.
function makeBuffer(device: GraphicsDevice, render: RenderMesh, influences: Influences | null): VertexBuffer {
  const stream = (semantic: string, components: number) => ({ semantic, components, type: TYPE_FLOAT32 });
  const format = new VertexFormat(device, [
    stream(SEMANTIC_POSITION, 3), stream(SEMANTIC_NORMAL, 3),
    ...(render.uvs ? [stream(SEMANTIC_TEXCOORD0, 2)] : []),
    ...(influences ? [stream(SEMANTIC_BLENDINDICES, influenceCount), stream(SEMANTIC_BLENDWEIGHT, influenceCount)] : []),
  ], render.vertexCount);
  const buffer = new VertexBuffer(device, format, render.vertexCount, { usage: BUFFER_DYNAMIC });
  const uvs = render.uvs?.map((value, i) => i % 2 === 0 ? value : 1 - value); // v points down
  const still = [uvs, influences?.joints, influences?.weights].filter((values) => !!values);
  streams(buffer, render.vertexCount).slice(2).forEach((to, index) => to.set(still[index]!));
  buffer.unlock();
  return buffer;
}

function streams(buffer: VertexBuffer, vertexCount: number): Float32Array[] {
  return buffer.getFormat().elements.map(({ offset, numComponents }) =>
    new Float32Array(buffer.lock() as ArrayBuffer, offset as number, numComponents * vertexCount));
}
