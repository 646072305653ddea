// Materials of a face as PlayCanvas has them.
import {
  ADDRESS_CLAMP_TO_EDGE, ADDRESS_MIRRORED_REPEAT, ADDRESS_REPEAT, BLEND_NONE, BLEND_NORMAL, CULLFACE_BACK, CULLFACE_NONE,
  SPECOCC_AO, StandardMaterial, Texture as PlayCanvasTexture, type Color, type GraphicsDevice,
} from "playcanvas";
import type { FaceContents, Material, Texture, Wrap } from "./contents.js";
import { decodePicture, isColour, plainMaterial } from "./posed_face.js";

const wraps: Record<Wrap, number> = { repeat: ADDRESS_REPEAT, clamp: ADDRESS_CLAMP_TO_EDGE, mirror: ADDRESS_MIRRORED_REPEAT };

// PlayCanvas has colours as pictures have them.
const setLinear = (colour: Color, [red, green, blue]: readonly number[]): void => {
  colour.set(red!, green!, blue!).gamma();
};

// As glTF has it: what is metal says a number, and so does how rough it is.
function makeMaterial(name: string, colour: readonly number[], metallic: number, roughness: number): StandardMaterial {
  const material = new StandardMaterial();
  material.name = name;
  material.useMetalness = true;
  material.metalness = metallic;
  material.glossInvert = true;
  material.gloss = roughness;
  material.specular.set(1, 1, 1);
  material.occludeSpecular = SPECOCC_AO;
  setLinear(material.diffuse, colour);
  return material;
}

/** The materials of a face, with one more, for polygons without material, behind them. */
export class PlayCanvasMaterials {
  readonly all: readonly StandardMaterial[];
  readonly ready: Promise<void>;
  private readonly textures: PlayCanvasTexture[] = [];
  private destroyed = false;

  constructor(private readonly face: Pick<FaceContents, "materials" | "images">, private readonly device: GraphicsDevice) {
    const loading: Promise<void>[] = [], { colour, roughness } = plainMaterial;
    this.all = [...face.materials.map((material) => this.make(material, loading)),
                makeMaterial("without material", colour, 0, roughness)];
    for (const material of this.all) material.update();
    this.ready = Promise.all(loading).then(() => undefined);
  }

  /** By index; -1 is the one for polygons without material. */
  at(index: number): StandardMaterial {
    return this.all[index < 0 ? this.all.length - 1 : index]!;
  }

  destroy(): void {
    this.destroyed = true;
    for (const material of this.all) material.destroy();
    for (const texture of this.textures) texture.destroy();
  }

  private make(from: Material, loading: Promise<void>[]): StandardMaterial {
    const material = makeMaterial(from.name, from.baseColour, from.metallic, from.roughness);
    setLinear(material.emissive, from.emissive);
    material.cull = from.doubleSided ? CULLFACE_NONE : CULLFACE_BACK;
    material.twoSidedLighting = from.doubleSided;
    material.blendType = from.alphaMode === "blend" ? BLEND_NORMAL : BLEND_NONE;
    material.depthWrite = from.alphaMode !== "blend";
    if (from.alphaMode === "mask") material.alphaTest = from.alphaCutoff;
    if (from.alphaMode !== "opaque") material.opacity = from.baseColour[3]!;
    for (const texture of from.textures) loading.push(this.load(texture, from, material));
    return material;
  }

  private async load(from: Texture, of: Material, material: StandardMaterial): Promise<void> {
    const image = this.face.images[from.image], picture = image && await decodePicture(image);
    if (!picture || this.destroyed) return;
    const texture = new PlayCanvasTexture(this.device, {
      name: `${of.name}: ${from.slot}`, width: picture.naturalWidth, height: picture.naturalHeight, srgb: isColour(from.slot),
      addressU: wraps[from.wrapU], addressV: wraps[from.wrapV] });
    texture.setSource(picture);
    this.textures.push(texture);
    this.add(texture, from, of, material);
    material.update();
  }

  private add(texture: PlayCanvasTexture, from: Texture, of: Material, material: StandardMaterial): void {
    switch (from.slot) {
      case "baseColour":
        material.diffuseMap = texture;
        if (of.alphaMode === "opaque") break;
        material.opacityMap = texture;
        material.opacityMapChannel = "a";
        break;
      case "metallicRoughness":
        material.metalnessMap = material.glossMap = texture;
        material.metalnessMapChannel = "b";
        material.glossMapChannel = "g";
        break;
      case "normal":
        material.normalMap = texture;
        material.bumpiness = from.scale;
        break;
      case "occlusion":
        material.aoMap = texture;
        material.aoMapChannel = "r";
        material.aoIntensity = from.scale;
        break;
      case "emissive":
        material.emissiveMap = texture;
        break;
    }
  }
}
