import { Matrix4, type PerspectiveCamera, Vector2, Vector3 } from "three";
import type { Ray } from "../pose/point_drag";

/** What the eye sees at a place of the picture, in pixels of the page, and where it sees points; in the space of one face. */
export class ViewRays {
  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly camera: PerspectiveCamera,
  ) {}

  /** The ray through a place. `toScene`: from the face's space. */
  rayAt(x: number, y: number, toScene: Matrix4): Ray {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const place = new Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    this.camera.updateMatrixWorld();
    const toFace = toScene.clone().invert();
    const origin = new Vector3().setFromMatrixPosition(this.camera.matrixWorld).applyMatrix4(toFace);
    const through = new Vector3(place.x, place.y, 0.5).unproject(this.camera).applyMatrix4(toFace);
    return { origin: origin.toArray(), direction: through.sub(origin).normalize().toArray() };
  }

  /** Where a point of the face is seen, from the left and from the top of the picture. */
  placeOf(point: readonly [number, number, number], toScene: Matrix4): { x: number; y: number } {
    this.camera.updateMatrixWorld();
    const seen = new Vector3(...point).applyMatrix4(toScene).project(this.camera);
    return { x: ((seen.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - seen.y) / 2) * this.canvas.clientHeight };
  }
}
