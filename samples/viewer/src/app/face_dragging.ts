import type { Solver } from "facebaker/solver";
import { PointDrag, type Ray } from "../pose/point_drag";
import { pickSurface, positionOf, type SurfacePoint } from "../pose/surface_points";
import { ViewRays } from "../scene/view_rays";
import type { FaceSource, ShownFace } from "./open_faces";
import { Signal } from "./signal";
import type { Viewer } from "./viewer";

interface Held {
  drag: PointDrag;
  point: SurfacePoint;
  /** Where the pointer is, in pixels of the page. */
  x: number;
  y: number;
  /** The pose does not have it there yet. */
  asked: boolean;
  before: Float32Array;
}

async function loadSolverOf(source: FaceSource): Promise<Solver> {
  const { loadSolver } = await import("facebaker/solver");
  return loadSolver(typeof source === "string" ? source : await source.arrayBuffer());
}

/**
 * Points of the first face that are dragged, while the controls follow. The solver is loaded when it is first switched on; it
 * solves once for each picture, for where the pointer is then.
 */
export class FaceDragging {
  /** Another state: on or off, loading, holding a point. */
  readonly changed = new Signal();
  /** Milliseconds that solving took for the last picture. */
  milliseconds = 0;
  /** Whether only controls of `openControls` follow. */
  openOnly = false;
  /** One a control, 1: its group is open. */
  openControls: () => Uint8Array = () => new Uint8Array(0);
  readonly rays: ViewRays;
  #on = false;
  #solver: Solver | null = null;
  #loadedFor: ShownFace | null = null; // or is loading
  #held: Held | null = null;

  constructor(readonly viewer: Viewer) {
    this.rays = new ViewRays(viewer.stage.canvas, viewer.stage.camera);
    viewer.posing.subscribe(() => this.#solve());
    viewer.started.subscribe(() => {
      this.#solver?.dispose();
      this.#solver = this.#loadedFor = this.#held = null;
      if (this.#on) void this.#load();
    });
  }

  get on(): boolean {
    return this.#on;
  }
  set on(on: boolean) {
    this.release();
    this.#on = on && this.viewer.first !== null;
    if (this.#on) void this.#load();
    this.changed.emit();
  }

  get loading(): boolean {
    return this.#on && !this.#solver;
  }

  /** How many controls follow the point that is held; null where none is. */
  get following(): number | null {
    return this.#held?.drag.moving ?? null;
  }

  /** Where the held point is seen, from the left and from the top of the picture; null where none is held. */
  get place(): { x: number; y: number } | null {
    const shown = this.viewer.first;
    if (!this.#held || !shown) return null;
    const positions = shown.face.evaluateInPlace(this.viewer.pose.values);
    return this.rays.placeOf(positionOf(this.#held.point, positions), shown.object.toScene);
  }

  /** Takes hold of what is seen at a place; returns whether that is a point of the face. Fails where no control moves it. */
  hold(x: number, y: number): boolean {
    const { first: shown, pose } = this.viewer;
    if (!this.#on || !this.#solver || !shown) return false;
    this.viewer.stage.halt();
    const ray = this.#rayAt(x, y, shown);
    const point = pickSurface(shown.face, shown.face.evaluateInPlace(pose.values), ray.origin, ray.direction);
    if (!point) return false;
    const allowed = this.openOnly ? this.openControls() : new Uint8Array(pose.values.length).fill(1);
    const drag = new PointDrag(shown.face, this.#solver, pose, point, ray, allowed);
    if (drag.moving === 0)
      throw new Error(this.openOnly ? "No control of the open groups moves this point." : "No control moves this point.");
    pose.endStep();
    this.#held = { drag, point, x, y, asked: false, before: pose.values.slice() };
    this.changed.emit();
    this.viewer.stage.draw();
    return true;
  }

  /** Drags what is held to a place, before the next picture. */
  moveTo(x: number, y: number): void {
    if (!this.#held) return;
    Object.assign(this.#held, { x, y, asked: true });
    this.viewer.stage.draw();
  }

  moveBy(x: number, y: number): void {
    if (this.#held) this.moveTo(this.#held.x + x, this.#held.y + y);
  }

  /** Lets go: the drag is one step of the history. */
  release(): void {
    if (!this.#held) return;
    this.#solve();
    this.#held = null;
    this.viewer.pose.endStep();
    this.changed.emit();
    this.viewer.stage.draw();
  }

  /** Lets go, with the pose as it was. */
  cancel(): void {
    if (!this.#held) return;
    this.viewer.pose.move(this.#held.before);
    this.#held.asked = false;
    this.release();
  }

  #rayAt(x: number, y: number, shown: ShownFace): Ray {
    return this.rays.rayAt(x, y, shown.object.toScene);
  }

  #solve(): void {
    const { first: shown, pose } = this.viewer;
    if (!this.#held?.asked || !shown) return;
    this.#held.asked = false;
    const start = performance.now();
    pose.move(this.#held.drag.solveFor(this.#rayAt(this.#held.x, this.#held.y, shown)));
    this.milliseconds = performance.now() - start;
  }

  async #load(): Promise<void> {
    const shown = this.viewer.first;
    if (!shown || this.#loadedFor === shown) return;
    this.#loadedFor = shown;
    try {
      const solver = await loadSolverOf(shown.source);
      if (this.#loadedFor !== shown) return solver.dispose(); // another face was opened in the meantime
      this.#solver = solver;
    } catch (error) {
      if (this.#loadedFor !== shown) return;
      this.#loadedFor = null;
      this.#on = false;
      this.viewer.failed(`Points cannot be dragged: ${error instanceof Error ? error.message : String(error)}`);
    }
    this.changed.emit();
  }
}
