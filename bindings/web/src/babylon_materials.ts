// Materials of a face as Babylon.js has them.
import { PBRMaterial } from "@babylonjs/core/Materials/PBR/pbrMaterial.js";
import { Material as BabylonMaterial } from "@babylonjs/core/Materials/material.js";
import { Texture as BabylonTexture } from "@babylonjs/core/Materials/Textures/texture.js";
import { Color3 } from "@babylonjs/core/Maths/math.color.js";
import type { Scene } from "@babylonjs/core/scene.js";
import type { FaceContents, Material, Texture, Wrap } from "./contents.js";
import { decodePicture, isColour, plainMaterial } from "./posed_face.js";

const wraps: Record<Wrap, number> = {
  repeat: BabylonTexture.WRAP_ADDRESSMODE, clamp: BabylonTexture.CLAMP_ADDRESSMODE, mirror: BabylonTexture.MIRROR_ADDRESSMODE,
};

const transparency: Record<Material["alphaMode"], number> = {
  opaque: BabylonMaterial.MATERIAL_OPAQUE, mask: BabylonMaterial.MATERIAL_ALPHATEST, blend: BabylonMaterial.MATERIAL_ALPHABLEND,
};

/** The materials of a face, with one more, for polygons without material, behind them. */
export class BabylonMaterials {
  readonly all: readonly PBRMaterial[];
  readonly ready: Promise<void>;
  private readonly pictures = new Map<number, Promise<HTMLImageElement | null>>();
  private readonly textures: BabylonTexture[] = [];
  private disposed = false;

  constructor(private readonly face: Pick<FaceContents, "materials" | "images">, private readonly scene: Scene) {
    const loading: Promise<void>[] = [];
    const plain = new PBRMaterial("without material", scene);
    plain.albedoColor = Color3.FromArray(plainMaterial.colour);
    plain.roughness = plainMaterial.roughness;
    plain.metallic = 0;
    this.all = [...face.materials.map((material) => this.make(material, loading)), plain];
    this.ready = Promise.all(loading).then(() => undefined);
  }

  /** By index; -1 is the one for polygons without material. */
  at(index: number): PBRMaterial {
    return this.all[index < 0 ? this.all.length - 1 : index]!;
  }

  dispose(): void {
    this.disposed = true;
    for (const texture of this.textures) texture.dispose();
    for (const material of this.all) material.dispose();
  }

  private make(from: Material, loading: Promise<void>[]): PBRMaterial {
    const material = new PBRMaterial(from.name, this.scene);
    material.albedoColor = Color3.FromArray(from.baseColour);
    material.emissiveColor = Color3.FromArray(from.emissive);
    material.metallic = from.metallic;
    material.roughness = from.roughness;
    material.backFaceCulling = !from.doubleSided;
    material.twoSidedLighting = from.doubleSided;
    material.transparencyMode = transparency[from.alphaMode];
    material.alphaCutOff = from.alphaCutoff;
    if (from.alphaMode !== "opaque") material.alpha = from.baseColour[3]!;
    for (const texture of from.textures) loading.push(this.load(texture, from, material));
    return material;
  }

  private picture(index: number): Promise<HTMLImageElement | null> {
    const image = this.face.images[index];
    let picture = this.pictures.get(index);
    if (!picture) this.pictures.set(index, picture = image ? decodePicture(image) : Promise.resolve(null));
    return picture;
  }

  private async load(from: Texture, of: Material, material: PBRMaterial): Promise<void> {
    const picture = await this.picture(from.image);
    if (!picture || this.disposed) return;
    await new Promise<void>((loaded) => {
      const texture = new BabylonTexture(`${of.name}: ${from.slot}`, this.scene, {
        buffer: picture, useSRGBBuffer: isColour(from.slot), onLoad: () => loaded(), onError: () => loaded() });
      texture.wrapU = wraps[from.wrapU];
      texture.wrapV = wraps[from.wrapV];
      this.textures.push(texture);
      this.add(texture, from, of, material);
    });
  }

  private add(texture: BabylonTexture, from: Texture, of: Material, material: PBRMaterial): void {
    switch (from.slot) {
      case "baseColour":
        texture.hasAlpha = of.alphaMode !== "opaque";
        material.useAlphaFromAlbedoTexture = texture.hasAlpha;
        material.albedoTexture = texture;
        break;
      case "metallicRoughness":
        material.useMetallnessFromMetallicTextureBlue = true;
        material.useRoughnessFromMetallicTextureGreen = true;
        material.useRoughnessFromMetallicTextureAlpha = false;
        material.metallicTexture = texture;
        break;
      case "normal":
        texture.level = from.scale;
        material.invertNormalMapX = material.invertNormalMapY = !this.scene.useRightHandedSystem;
        material.bumpTexture = texture;
        break;
      case "occlusion":
        material.useAmbientInGrayScale = true;
        material.ambientTextureStrength = from.scale;
        material.ambientTexture = texture;
        break;
      case "emissive":
        material.emissiveTexture = texture;
        break;
    }
  }
}
