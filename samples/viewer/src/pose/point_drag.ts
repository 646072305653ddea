import type { Face } from "facebaker";
import type { Solver } from "facebaker/solver";
import type { Pose } from "./pose";
import { mirrorPoint, positionOf, spreadVertices, type SurfacePoint } from "./surface_points";

type Position = [number, number, number];

// By these, the corner of the sample face's mouth that is pulled up by 0.018 diagonals is where the pointer is, within 1e-5
// of one, and 13 of 500 controls move; the chin opens the jaw, a brow is lifted by its own control (dragging.test.mjs).
const HELD_POINTS = 40; // of the rest of the face, spread over it
/** Weight of the point that is dragged, and of each held one as far away as HELD_REACH diagonals or more. */
const DRAGGED = 5;
const HELD = 0.02;
const HELD_REACH = 0.25;
/** Controls that move the point less than this share of what moves it most across the eye are left alone. */
const LEAST_GAIN = 0.3;
const NOISE = 1e-3; // of the diagonal
const NEARNESS = 1;
const SYMMETRY = 10;
const ITERATIONS = 10; // a picture; the next one goes on from there
const STILL = 1e-5; // of the diagonal, by the whole range of a control: it does not move the point

/** Held vertices of faces that were dragged before. */
const spread = new WeakMap<Face, number[]>();

function heldVertices(face: Face): number[] {
  let held = spread.get(face);
  if (!held) spread.set(face, (held = spreadVertices(face.restPositions, HELD_POINTS)));
  return held;
}

const along = (a: Position, b: Position): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** A ray of the face's space; the direction has the length 1. */
export interface Ray {
  origin: Position;
  direction: Position;
}

/** Two directions across another one. */
function across([x, y, z]: Position): [Position, Position] {
  const length = Math.hypot(x, z);
  const right: Position = length > 1e-3 ? [z / length, 0, -x / length] : [1, 0, 0];
  return [right, [y * right[2] - z * right[1], z * right[0] - x * right[2], x * right[1] - y * right[0]]];
}

/**
 * A point of the face that is held by somebody, and whose place controls follow. Only controls that move it much are moved,
 * and these no farther from where they were than it takes, while other points of the face weigh a little against being moved.
 */
export class PointDrag {
  /** How many controls move. */
  readonly moving: number;
  readonly #face: Face;
  readonly #start: Position;
  readonly #near: Float32Array;
  readonly #movable: Uint8Array;
  readonly #targets: Float32Array;
  readonly #weights: Float32Array;
  readonly #mirrored: Position | null;
  /** How much deeper the point goes, for each unit to the right and up of the eye. */
  #slope: readonly [number, number] = [0, 0];

  /**
   * Takes hold of a point that is seen along a ray. `allowed`: one a control, 0: it is not to be moved. Where sides of the pose
   * are linked, the point of the other side moves as well. The solver is the face's own, and follows other points after this.
   */
  constructor(
    face: Face,
    readonly solver: Solver,
    readonly pose: Pose,
    point: SurfacePoint,
    readonly ray: Ray,
    allowed: Uint8Array,
  ) {
    this.#face = face;
    const positions = face.evaluate(pose.values);
    const other = pose.linked ? mirrorPoint(face, point) : null;
    const held = heldVertices(face);
    const points = [point, ...(other ? [other] : [])];
    this.#start = positionOf(point, positions);
    this.#mirrored = other && positionOf(other, positions);
    this.#near = pose.values.slice();
    solver.follow({
      vertices: [...points.flatMap(({ vertices }) => vertices), ...held.flatMap((vertex) => [vertex, vertex, vertex])],
      weights: [...points.flatMap(({ weights }) => weights), ...held.flatMap(() => [1, 0, 0])],
    });
    this.#movable = this.#findMovable(allowed);
    this.moving = this.#movable.reduce((sum, movable) => sum + movable, 0);
    this.#targets = solver.values(pose.values);
    this.#weights = new Float32Array(solver.pointCount).fill(DRAGGED, 0, points.length);
    held.forEach((vertex, i) => {
      const away = [this.#start, this.#mirrored ?? this.#start].map((from) =>
        Math.hypot(...from.map((x, axis) => positions[3 * vertex + axis] - x)),
      );
      this.#weights[points.length + i] = HELD * Math.min(1, (Math.min(...away) / (HELD_REACH * face.diagonal)) ** 2);
    });
  }

  /** Which controls move the point much across the ray; and how deep it goes by them. */
  #findMovable(allowed: Uint8Array): Uint8Array {
    const { controls, partners, linked } = this.pose;
    const jacobian = this.solver.jacobian(this.pose.values);
    const [right, up] = across(this.ray.direction);
    /** How far the whole range of a control moves a point, the first or its mirror. */
    const moveOf = (index: number, point: number): Position => {
      const { minimum, maximum } = controls[index];
      return [0, 1, 2].map((axis) => (maximum - minimum) * jacobian[(3 * point + axis) * controls.length + index]) as Position;
    };
    const moves = controls.map((_, index) => {
      const by = moveOf(index, 0);
      return { right: along(by, right), up: along(by, up), deep: along(by, this.ray.direction) };
    });
    /** Whether a control without a partner moves both sides alike, as jaws that open do, and jaws that go sideways do not. */
    const evenly = (index: number): boolean => {
      const [x, y, z] = moveOf(index, 1);
      return along(moveOf(index, 0), [-x, y, z]) > 0;
    };
    const usable = (index: number): boolean =>
      allowed[index] === 1 && (!this.#mirrored || partners[index] >= 0 || evenly(index));
    const gains = moves.map((by, index) => (usable(index) ? Math.hypot(by.right, by.up) : 0));
    const least = Math.max(LEAST_GAIN * Math.max(...gains), STILL * this.#face.diagonal);
    const movable = Uint8Array.from(gains, (gain) => (gain >= least ? 1 : 0));
    this.#slope = slopeOf(moves.filter((_, index) => movable[index]));
    if (linked)
      for (const [index, partner] of partners.entries())
        if (partner >= 0 && gains[index] >= least && allowed[partner]) movable[partner] = 1;
    return movable;
  }

  /**
   * The controls that bring the point onto a ray, or as near to it as they can. How deep it goes is not asked for: as deep as it
   * goes where these controls move the least, as far as their derivatives at the start tell.
   */
  solveFor({ origin, direction }: Ray): Float32Array {
    const controls = this.pose.values.slice();
    const [right, up] = across(this.ray.direction);
    const facing = along(direction, this.ray.direction);
    const from = origin.map((x, axis) => x - this.#start[axis]) as Position;
    const at = (distance: number): Position => direction.map((x, axis) => from[axis] + distance * x) as Position;
    const distance = -along(from, this.ray.direction) / facing; // in the plane through the start
    const deeper = along(at(distance), right) * this.#slope[0] + along(at(distance), up) * this.#slope[1];
    const [x, y, z] = at(distance + deeper / facing);
    this.#targets.set(this.#start.map((value, axis) => value + [x, y, z][axis]));
    if (this.#mirrored) this.#targets.set([this.#mirrored[0] - x, this.#mirrored[1] + y, this.#mirrored[2] + z], 3);
    this.solver.solve(controls, {
      points: this.#targets,
      pointWeights: this.#weights,
      noise: NOISE * this.#face.diagonal,
      nearness: NEARNESS,
      near: this.#near,
      sparsity: 0,
      symmetry: this.pose.linked ? SYMMETRY : 0,
      movable: this.#movable,
      maxIterations: ITERATIONS,
    });
    if (this.pose.linked) this.#balance(controls);
    return controls;
  }

  /** Has left and right be alike, as much of each as the mean: faces and targets are never quite symmetric. */
  #balance(controls: Float32Array): void {
    const { pose } = this;
    for (const [index, partner] of pose.partners.entries()) {
      if (partner < index || !this.#movable[index] || !this.#movable[partner]) continue;
      controls[index] = (controls[index] + pose.mirrored(partner, index, controls[partner])) / 2;
      controls[partner] = pose.mirrored(index, partner, controls[index]);
    }
  }
}

/** By the shortest change of controls that moves a point across the eye: how deep it goes. */
function slopeOf(moves: readonly { right: number; up: number; deep: number }[]): [number, number] {
  const sum = (value: (by: { right: number; up: number; deep: number }) => number): number =>
    moves.reduce((all, by) => all + value(by), 0);
  const rr = sum((by) => by.right * by.right);
  const uu = sum((by) => by.up * by.up);
  const ru = sum((by) => by.right * by.up);
  const floor = 1e-3 * (rr + uu); // where they move it one way alone
  const determinant = (rr + floor) * (uu + floor) - ru * ru;
  if (determinant === 0) return [0, 0];
  const dr = sum((by) => by.deep * by.right);
  const du = sum((by) => by.deep * by.up);
  return [((uu + floor) * dr - ru * du) / determinant, ((rr + floor) * du - ru * dr) / determinant];
}
