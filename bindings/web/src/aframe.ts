/** A face in a scene of A-Frame: registers the component `facebaker`. A-Frame has to be there before it, and "three" has
 * to be the three.js of A-Frame. */
import type { Group } from "three";
import type { Face } from "./face.js";
import { load } from "./load.js";
import { FaceBakerMesh } from "./three.js";

/** What of an element of A-Frame is used here. */
interface EntityElement {
  setObject3D(name: string, object: Group): void;
  removeObject3D(name: string): void;
  emit(event: string, detail: object, bubbles: boolean): void;
}

interface FaceBakerData {
  /** Where the archive is. */
  src: string;
  /** Whether the face is scaled to metres, which A-Frame counts in. */
  metres: boolean;
  skin: boolean;
  level: number;
}

/** What the event "model-loaded" of the element has in `detail`. */
export interface LoadedFace {
  readonly format: "fbk";
  readonly model: FaceBakerMesh;
  readonly face: Face;
  /** To be written to: the next frame that is drawn has the face in this pose. */
  readonly controls: Float32Array;
}

/** The component, `element.components.facebaker`. The members are null until "model-loaded". */
export interface FaceBakerComponent {
  readonly el: EntityElement;
  readonly data: FaceBakerData;
  loaded: LoadedFace | null;
  /** The controls that are shown. */
  shown: Float32Array;
  loading: AbortController | null;
}

const component = {
  schema: {
    src: { type: "asset" }, metres: { default: true }, skin: { default: true }, level: { default: 0 },
  },

  init(this: FaceBakerComponent): void {
    this.loaded = this.loading = null;
  },

  update(this: FaceBakerComponent): void {
    unload(this);
    if (this.data.src) void show(this, this.loading = new AbortController());
  },

  tick(this: FaceBakerComponent): void {
    if (!this.loaded || sameNumbers(this.loaded.controls, this.shown)) return;
    this.shown.set(this.loaded.controls);
    this.loaded.model.update(this.shown);
  },

  remove(this: FaceBakerComponent): void {
    unload(this);
  },
};

function sameNumbers(a: Float32Array, b: Float32Array): boolean {
  for (let i = 0; i < a.length; ++i) if (a[i] !== b[i]) return false;
  return true;
}

async function show(to: FaceBakerComponent, { signal }: AbortController): Promise<void> {
  const { src, metres, skin, level } = to.data;
  let face: Face | null = null;
  try {
    face = await load(src, { signal });
    signal.throwIfAborted();
    const model = new FaceBakerMesh(face, { metres, skin, level }), controls = face.createPose();
    to.loaded = { format: "fbk", model, face, controls };
    to.shown = controls.slice();
    to.el.setObject3D("mesh", model);
    to.el.emit("model-loaded", to.loaded, false);
  } catch (error) {
    if (!to.loaded || to.loaded.face !== face) face?.dispose();
    if (signal.aborted) return;
    const message = error instanceof Error ? error.message : String(error);
    console.error(`facebaker: ${message.startsWith(src) ? message : `${src}: ${message}`}`);
    to.el.emit("model-error", { format: "fbk", src, error }, false);
  }
}

function unload(from: FaceBakerComponent): void {
  from.loading?.abort();
  from.loading = null;
  if (!from.loaded) return;
  from.el.removeObject3D("mesh");
  from.loaded.model.dispose();
  from.loaded.face.dispose();
  from.loaded = null;
}

const { AFRAME } = globalThis as { AFRAME?: { registerComponent(name: string, definition: object): void } };
if (!AFRAME) throw new Error("facebaker/aframe: A-Frame is not there yet; import it before");
AFRAME.registerComponent("facebaker", component);
