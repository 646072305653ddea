import type { ExpectedError } from "facebaker";
import { Box3 } from "three";
import type { Clip } from "../clips/clip";
import { KeyframeList } from "../clips/keyframes";
import { Player } from "../clips/player";
import { ExpressionList } from "../pose/expressions";
import { Pose } from "../pose/pose";
import { colourParts, colourValues, roundScale } from "../scene/colour_scale";
import { FaceObject, type Look } from "../scene/face_object";
import type { Stage } from "../scene/stage";
import { ErrorCurve } from "./error_curve";
import type { Mode } from "./modes";
import { closeFace, followedControls, type ShownFace } from "./open_faces";
import { PoseTimes } from "./pose_times";
import { Signal } from "./signal";
import { TruePositions } from "./true_positions";
import { measureErrors, type VertexErrors } from "./vertex_errors";

const GAP = 0.12; // between two faces, in diagonals
const SIDE = 0.32; // radians from the front, from where one face is seen at first
const SMALL_PART = 0.5; // of the diagonal

const LOOKS: Record<Mode, Look> = {
  shaded: "shaded",
  wireframe: "wireframe",
  normals: "normals",
  regions: "colours",
  expected: "colours",
  error: "colours",
  difference: "colours",
};

/** The least end of the colour scale where none is chosen, of the diagonal: 0.04 mm of a head. */
const LEAST_SCALE = 1e-4;

/** What is on the screen: one or two faces in a pose, looked at in a mode. Panels listen to its signals. */
export class Viewer {
  /** The first face is another one, with a pose of its own; told at once, before panels are made. */
  readonly started = new Signal();
  /** Other faces. */
  readonly opened = new Signal();
  /** Another pose, mode or scale was drawn: figures are other ones. */
  readonly drawn = new Signal();
  /** A picture is about to be drawn: the last moment to change the pose that it shows. */
  readonly posing = new Signal();
  /** Another mode, or modes that can be chosen. */
  readonly modeChanged = new Signal();
  /** Another list of clips. */
  readonly clipsChanged = new Signal();
  readonly expressions = new ExpressionList();
  readonly keyframes = new KeyframeList();
  readonly player = new Player();
  /** Errors of the clip's frames, where its true positions are known. */
  readonly curve = new ErrorCurve();
  readonly times = new PoseTimes();

  faces: ShownFace[] = [];
  pose = new Pose([]);
  clips: Clip[] = [];
  truth: TruePositions | null = null;
  /** Largest value of the colour scale, as a fraction of the diagonal; null: of the pose shown. */
  scale: number | null = null;
  /** Distances of what is shown, in the modes error and difference. */
  errors: VertexErrors | null = null;
  expected: ExpectedError | null = null;
  /** The rig itself as the last one in the row, posed by its true positions; not visible where these are not known. */
  trueRig: FaceObject | null = null;
  #mode: Mode = "shaded";
  #stale = false;
  #distances = new Float32Array(0);

  constructor(
    readonly stage: Stage,
    readonly failed: (reason: string) => void,
  ) {
    stage.beforeDraw = (now) => this.#beforeDraw(now);
    this.player.changed.subscribe(() => stage.draw());
    this.player.moved.subscribe(() => {
      const controls = this.player.controls();
      if (controls) this.pose.follow(controls);
    });
  }

  get first(): ShownFace | null {
    return this.faces[0] ?? null;
  }

  get mode(): Mode {
    return this.#mode;
  }
  set mode(mode: Mode) {
    this.#mode = this.whyNot(mode) === null ? mode : "shaded";
    for (const object of this.#objects()) object.look = LOOKS[this.#mode];
    this.refresh();
    this.modeChanged.emit();
  }

  /** Why a mode cannot be chosen now; null where it can. */
  whyNot(mode: Mode): string | null {
    const face = this.first?.face;
    if (!face) return "There is no face yet.";
    if ((mode === "regions" || mode === "expected") && face.regions.names.length === 0)
      return "This face has no expected errors: it was baked without poses held back.";
    if (mode === "error" && !this.truth?.known)
      return "There are no true positions: facebaker view FACE --beside SOURCE gives them, or a dataset folder.";
    if (mode === "difference" && (this.faces.length < 2 || this.faces[1].face.vertexCount !== face.vertexCount))
      return "This takes two faces with the same vertices.";
    return null;
  }

  /** Shows a face in place of all, or beside the first. */
  show(shown: ShownFace, beside: boolean): void {
    if (!beside) this.trueRigBeside = false;
    const closed = beside ? this.faces.splice(1) : this.faces.splice(0);
    for (const old of closed) closeFace(old);
    this.faces.push(shown);
    if (this.faces.length === 1) this.#start(shown);
    shown.object.changed = () => this.stage.draw();
    this.stage.faces.add(shown.object);
    this.#arrange();
    this.mode = this.#mode;
    this.#lookFirst();
    // Panels take longer to make than the picture, which comes first.
    requestAnimationFrame(() =>
      setTimeout(() => {
        this.opened.emit();
        this.clipsChanged.emit();
      }),
    );
  }

  /** Takes the second face away. */
  removeSecond(): void {
    for (const old of this.faces.splice(1)) closeFace(old);
    this.#arrange();
    this.mode = this.#mode;
    this.#lookFirst();
    this.opened.emit();
  }

  get trueRigBeside(): boolean {
    return this.trueRig !== null;
  }
  set trueRigBeside(beside: boolean) {
    if (beside === this.trueRigBeside || (beside && !this.truth?.known)) return;
    if (this.trueRig) {
      this.trueRig.removeFromParent();
      this.trueRig.dispose();
      this.trueRig = null;
    } else if (this.first) {
      this.trueRig = new FaceObject(this.first.face);
      this.trueRig.changed = () => this.stage.draw();
      this.trueRig.visible = false;
      this.stage.faces.add(this.trueRig);
    }
    this.#arrange();
    this.mode = this.#mode;
    this.#lookFirst();
  }

  /** Looks from the front at what moves of the faces; at the whole where nothing does. */
  lookAtMoving(): void {
    const box = this.#movingBox();
    if (box) this.stage.frame(box);
    else this.stage.home();
  }

  addClips(clips: readonly Clip[]): void {
    this.clips.push(...clips);
    this.clipsChanged.emit();
  }

  /** Opens a clip at its first frame; null: none. */
  openClip(clip: Clip | null): void {
    this.curve.open(clip);
    this.truth?.open(clip);
    if (!this.truth?.known) this.trueRigBeside = false;
    this.player.open(clip);
    this.mode = this.#mode;
    this.clipsChanged.emit();
  }

  /** Goes to the frame of the clip with the next smaller error, from the worst one on. */
  seekNextWorst(): void {
    const frame = this.curve.nextWorst(this.player.frame);
    if (frame !== null) this.player.seek(frame);
  }

  setScale(scale: number | null): void {
    this.scale = scale;
    this.refresh();
  }

  /** The end of the colour scale, in the rig's unit. */
  get scaleEnd(): number {
    const diagonal = this.first?.face.diagonal ?? 1;
    if (this.scale !== null) return this.scale * diagonal;
    const largest = this.#mode === "expected" ? Math.max(0, ...(this.expected?.regions ?? [])) : (this.errors?.max ?? 0);
    return roundScale(Math.max(largest / diagonal, LEAST_SCALE)) * diagonal;
  }

  /** Poses and draws again soon. */
  refresh(): void {
    this.#stale = true;
    this.stage.draw();
  }

  #start(shown: ShownFace): void {
    this.pose = new Pose(shown.face.controls);
    this.pose.changed.subscribe(() => this.refresh());
    this.pose.edited.subscribe(() => this.player.pause());
    this.clips = [];
    this.keyframes.replace([]);
    this.truth = new TruePositions(shown.face.vertexCount, {
      ready: () => {
        this.modeChanged.emit();
        this.refresh();
      },
      clipRead: (clip, points) =>
        void this.curve.measure(shown.face, clip, points).catch((error: unknown) => this.failed(String(error))),
      failed: (reason) => {
        this.curve.giveUp();
        this.failed(reason);
      },
    });
    this.#distances = new Float32Array(shown.face.vertexCount);
    this.times.clear();
    this.curve.open(null);
    this.player.open(null);
    this.started.emit();
  }

  /** What is drawn, from left to right. */
  #objects(): FaceObject[] {
    const objects = this.faces.map(({ object }) => object);
    return this.trueRig ? [...objects, this.trueRig] : objects;
  }

  #movingBox(): Box3 | null {
    const box = new Box3();
    for (const object of this.#objects()) if (object.moving) box.union(object.moving.clone().translate(object.position));
    return box.isEmpty() ? null : box;
  }

  /** As a face is seen at first: what moves, where that is small, such as the head of a body. */
  #lookFirst(): void {
    const moving = this.first?.object.moving;
    if (moving && moving.min.distanceTo(moving.max) < SMALL_PART) this.lookAtMoving();
    else this.stage.home();
  }

  #arrange(): void {
    const objects = this.#objects();
    const widths = objects.map((object) => object.width);
    const all = widths.reduce((sum, width) => sum + width, GAP * (widths.length - 1));
    let left = -all / 2;
    objects.forEach((object, i) => {
      object.position.x = left + widths[i] / 2;
      left += widths[i] + GAP;
    });
    // Two faces are seen alike only from the front.
    this.stage.setScene(all * 1.25, Math.max(...objects.map((object) => object.height)), objects.length > 1 ? 0 : SIDE);
  }

  #beforeDraw(now: number): void {
    this.player.advance(now);
    this.posing.emit();
    if (this.player.playing) this.stage.draw();
    if (!this.#stale || this.faces.length === 0) return;
    this.#stale = false;
    this.faces.forEach((shown, i) => {
      const controls = i === 0 ? this.pose.values : followedControls(shown, this.pose.values);
      const milliseconds = shown.object.pose(controls);
      if (i === 0) this.times.add(milliseconds);
    });
    this.#poseTrueRig();
    this.#colour();
    this.drawn.emit();
  }

  /** Of a live rig it stays as it was until the answer is there. */
  #poseTrueRig(): void {
    if (!this.trueRig) return;
    const positions = this.truePositions();
    if (positions) this.trueRig.showPositions(positions);
    if (positions || !this.truth?.live) this.trueRig.visible = positions !== null;
  }

  #colour(): void {
    this.errors = null;
    this.expected = null;
    if (LOOKS[this.#mode] !== "colours") return;
    this.faces.forEach((shown, i) => {
      const { face, object } = shown;
      const { colours } = object.analysis;
      if (this.#mode === "regions" || this.#mode === "expected") {
        if (face.regions.names.length === 0) colours.fill(0.7);
        else if (this.#mode === "regions") colourParts(face.regions.ofVertex, colours);
        else this.#colourExpected(shown, i, colours);
      } else if (i === 0) {
        this.#colourErrors(shown, colours);
      } else {
        colours.fill(0.7);
      }
      object.analysis.touch();
    });
  }

  #colourExpected({ face, follows }: ShownFace, index: number, colours: Float32Array): void {
    const controls = index === 0 ? this.pose.values : Float32Array.from(follows, (from) => this.pose.values[from] ?? 0);
    const expected = face.expectedError(controls);
    if (index === 0) this.expected = expected;
    colourValues(Array.from(face.regions.ofVertex, (region) => expected.regions[region]), this.scaleEnd, colours);
  }

  #colourErrors({ object }: ShownFace, colours: Float32Array): void {
    const truth = this.#mode === "difference" ? this.faces[1].object.analysis.positions : this.truePositions();
    if (!truth) return void colours.fill(0.7);
    this.errors = measureErrors(object.analysis.positions, truth, this.#distances);
    colourValues(this.errors.distances, this.scaleEnd, colours);
    const frame = this.#frameShown();
    if (this.#mode === "error" && frame !== null) this.curve.note(frame, this.errors.max);
  }

  /** Where the vertices truly are in this pose; null where that is not known (yet). */
  truePositions(): Float32Array | null {
    return this.truth?.at(this.pose.values, this.#frameShown()) ?? null;
  }

  /** The frame of the clip whose pose is shown; null where it is another pose. */
  #frameShown(): number | null {
    const controls = this.player.controls();
    if (!controls) return null;
    return controls.every((value, i) => value === this.pose.values[i] || this.#clamped(value, i)) ? this.player.frame : null;
  }

  #clamped(value: number, index: number): boolean {
    const { minimum, maximum } = this.pose.controls[index];
    return this.pose.values[index] === Math.min(Math.max(value, minimum), maximum);
  }
}
