// Materials of a face as three.js has them.
import {
  ClampToEdgeWrapping, DoubleSide, FrontSide, MirroredRepeatWrapping, RepeatWrapping, SRGBColorSpace,
  TextureLoader, Vector2, type MeshStandardMaterial, type MeshStandardMaterialParameters, type Side, type Texture as ThreeTexture, type Wrapping,
} from "three";
import type { FaceContents, Image, Material, Texture, Wrap } from "./contents.js";

/** Makes a texture of a picture file; null: the material goes without. `arrived` is to be called once, later than the
 * return: when the texture has its picture, or with the reason why it never will. */
export type LoadTexture = (image: Image, arrived: (problem?: string) => void) => ThreeTexture | null;

const wraps: Record<Wrap, Wrapping> = {
  repeat: RepeatWrapping, clamp: ClampToEdgeWrapping, mirror: MirroredRepeatWrapping,
};

/** PNG, JPEG, WebP: whatever the browser decodes itself. */
export function loadImage(image: Image, arrived: (problem?: string) => void): ThreeTexture | null {
  if (typeof document === "undefined" || image.mediaType === "image/ktx2") return null;
  const address = URL.createObjectURL(new Blob([image.bytes as Uint8Array<ArrayBuffer>], { type: image.mediaType }));
  const done = (problem?: string) => {
    URL.revokeObjectURL(address);
    arrived(problem);
  };
  const texture = new TextureLoader().load(address, () => done(), undefined, () => done("it cannot be decoded"));
  texture.name = image.name;
  return texture;
}

const maps = ["map", "metalnessMap", "roughnessMap", "normalMap", "aoMap", "emissiveMap"] as const;

// A texture without picture is black and transparent.
function takeAway(texture: ThreeTexture, material: MeshStandardMaterial): void {
  for (const map of maps)
    if (material[map] === texture) {
      material[map] = null;
      material.needsUpdate = true;
    }
}

/** The materials of a face, with one more, for polygons without material, behind them. */
export class MaterialSet {
  readonly all: MeshStandardMaterial[];
  private readonly textures: ThreeTexture[] = [];

  /** `arrived`: called when a texture has its picture, or has turned out to have none and is taken away. */
  constructor(private readonly face: Pick<FaceContents, "materials" | "images">, private readonly load: LoadTexture,
              private readonly arrived: (texture: ThreeTexture) => void,
              private readonly Material: new (parameters: MeshStandardMaterialParameters) => MeshStandardMaterial) {
    this.all = face.materials.map((material) => this.make(material));
    this.all.push(new Material({ color: 0xb8b8b8, roughness: 0.6, metalness: 0 }));
  }

  /** By index; -1 is the one for polygons without material. */
  at(index: number): MeshStandardMaterial {
    return this.all[index < 0 ? this.all.length - 1 : index]!;
  }

  dispose(): void {
    for (const texture of this.textures) texture.dispose();
    for (const material of this.all) material.dispose();
  }

  private texture(from: Texture, colour: boolean): ThreeTexture | null {
    const image = this.face.images[from.image];
    const texture = image ? this.load(image, (problem) => this.receive(texture, image, problem)) : null;
    if (!texture) return null;
    texture.wrapS = wraps[from.wrapU];
    texture.wrapT = wraps[from.wrapV];
    if (colour) texture.colorSpace = SRGBColorSpace;
    this.textures.push(texture);
    return texture;
  }

  private receive(texture: ThreeTexture | null, image: Image, problem: string | undefined): void {
    if (!texture) return;
    if (problem !== undefined) {
      console.warn(`facebaker: picture "${image.name}" is left out: ${problem}`);
      for (const material of this.all) takeAway(texture, material);
    }
    this.arrived(texture);
  }

  private make(from: Material): MeshStandardMaterial {
    const material = new this.Material({
      name: from.name, metalness: from.metallic, roughness: from.roughness,
      side: (from.doubleSided ? DoubleSide : FrontSide) as Side, transparent: from.alphaMode === "blend",
      alphaTest: from.alphaMode === "mask" ? from.alphaCutoff : 0,
      opacity: from.alphaMode === "opaque" ? 1 : from.baseColour[3]!,
    });
    material.color.setRGB(from.baseColour[0]!, from.baseColour[1]!, from.baseColour[2]!);
    material.emissive.setRGB(from.emissive[0]!, from.emissive[1]!, from.emissive[2]!);
    for (const texture of from.textures) this.add(texture, material);
    return material;
  }

  private add(from: Texture, material: MeshStandardMaterial): void {
    const texture = this.texture(from, from.slot === "baseColour" || from.slot === "emissive");
    if (!texture) return;
    switch (from.slot) {
      case "baseColour":
        material.map = texture;
        break;
      case "metallicRoughness":
        material.metalnessMap = material.roughnessMap = texture;
        break;
      case "normal":
        material.normalMap = texture;
        material.normalScale = new Vector2(from.scale, from.scale);
        break;
      case "occlusion":
        material.aoMap = texture;
        material.aoMapIntensity = from.scale;
        break;
      case "emissive":
        material.emissiveMap = texture;
        break;
    }
  }
}
