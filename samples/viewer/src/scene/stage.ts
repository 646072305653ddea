import {
  AmbientLight,
  type Box3,
  BufferAttribute,
  BufferGeometry,
  DirectionalLight,
  Group,
  HemisphereLight,
  Mesh,
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  SRGBColorSpace,
  Spherical,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const TURN = Math.PI / 24; // a key press
const ZOOM = 1.1;
const MARGIN = 1.5; // of a framed part, for what is around it and for the bars over the picture

/**
 * The picture: camera, light, and what turns them. Lengths are diagonals of the first face. Draws when asked to, and
 * while somebody turns it.
 */
export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(28, 1, 0.01, 50);
  readonly renderer: WebGLRenderer;
  /** What is looked at; scaled, moved and turned to fit. */
  readonly faces = new Group();
  /** Called before a picture is drawn. */
  beforeDraw: (now: number) => void = () => {};
  /** Called once a picture is on the screen. */
  afterDraw: () => void = () => {};
  /** Called when the browser has lost the graphics card (true), and when it has it again. */
  contextChanged: (lost: boolean) => void = () => {};
  readonly #orbit: OrbitControls;
  #width = 1; // of what is looked at
  #height = 1;
  #angle = 0.32; // from the front, at the start
  #asked = false;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.#light();
    this.scene.add(this.faces, this.camera);
    this.#orbit = new OrbitControls(this.camera, canvas);
    this.#orbit.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.#orbit.dampingFactor = 0.12;
    this.#orbit.minDistance = 0.03;
    this.#orbit.maxDistance = 12;
    this.#orbit.addEventListener("change", () => this.draw());
    // The renderer has listened before: it keeps the context from being given up, and makes everything anew.
    canvas.addEventListener("webglcontextlost", () => this.contextChanged(true));
    canvas.addEventListener("webglcontextrestored", () => {
      this.contextChanged(false);
      this.draw();
    });
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
    this.home();
    this.#warmUp();
  }

  /** Has the graphics driver make the program that most faces are drawn with, while they are loading: it takes as long as
   * a picture. */
  #warmUp(): void {
    const geometry = new BufferGeometry();
    for (const name of ["position", "normal"]) geometry.setAttribute(name, new BufferAttribute(new Float32Array(9), 3));
    this.renderer.compile(new Mesh(geometry, new MeshStandardMaterial()), this.camera, this.scene);
  }

  /** A key, a soft fill from the sky, and a light behind that draws the outline; all move with the camera. */
  #light(): void {
    const key = new DirectionalLight(0xfff1e2, 2.1);
    key.position.set(-1.2, 1.4, 1.6);
    const fill = new DirectionalLight(0xcfdcff, 0.55);
    fill.position.set(1.8, 0.1, 1.2);
    const rim = new DirectionalLight(0xdfe8ff, 1.5);
    rim.position.set(1.1, 1.2, -2);
    this.camera.add(key, fill, rim);
    this.scene.add(new HemisphereLight(0xdfe6f5, 0x6b5a50, 0.95), new AmbientLight(0xffffff, 0.12));
  }

  /** Draws soon, once however often it is asked for. */
  draw(): void {
    if (this.#asked || this.renderer.xr.isPresenting) return;
    this.#asked = true;
    requestAnimationFrame((now) => {
      this.#asked = false;
      this.drawNow(now);
    });
  }

  drawNow(now: number): void {
    this.beforeDraw(now);
    if (!this.renderer.xr.isPresenting) this.#orbit.update();
    this.renderer.render(this.scene, this.camera);
    this.afterDraw();
  }

  /** How much is to be seen, in diagonals, and from which side home() looks at it, in radians. */
  setScene(width: number, height: number, angle: number): void {
    this.#width = width;
    this.#height = height;
    this.#angle = angle;
  }

  /** The camera as at the start: all faces, from a little to the side. */
  home(): void {
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const room = Math.max(0.5, 0.62 * this.#height, this.#width / 2 / Math.max(this.camera.aspect, 0.2));
    this.camera.position.setFromSpherical(new Spherical((room * 0.92) / half, Math.PI / 2 - 0.06, this.#angle));
    this.#orbit.target.set(0, 0, 0);
    this.draw();
  }

  /** Looks at a box from the front, so that it fills most of the picture. */
  frame(box: Box3): void {
    const size = box.getSize(new Vector3());
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const room = (MARGIN * Math.max(size.y, size.x / Math.max(this.camera.aspect, 0.2))) / 2;
    const target = box.getCenter(this.#orbit.target);
    this.camera.position.set(target.x, target.y, target.z + Math.max(room / half + size.z / 2, this.#orbit.minDistance));
    this.draw();
  }

  /** Ends a turn that goes on by itself after the pointer has let go. */
  halt(): void {
    const { view } = this;
    const damped = this.#orbit.enableDamping;
    this.#orbit.enableDamping = false; // forgets what is left of it
    this.#orbit.update();
    this.#orbit.enableDamping = damped;
    this.view = view;
  }

  turn(right: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.#orbit.target);
    const angles = new Spherical().setFromVector3(offset);
    angles.theta += right * TURN;
    angles.phi = Math.min(Math.max(angles.phi - up * TURN, 0.05), Math.PI - 0.05);
    this.camera.position.copy(this.#orbit.target).add(new Vector3().setFromSpherical(angles));
    this.draw();
  }

  /** From the front, a side, above: angles in degrees. */
  lookFrom(right: number, up: number): void {
    const distance = this.camera.position.distanceTo(this.#orbit.target);
    const angles = new Spherical(distance, Math.PI / 2 - (up * Math.PI) / 180, (right * Math.PI) / 180);
    this.camera.position.copy(this.#orbit.target).add(new Vector3().setFromSpherical(angles));
    this.draw();
  }

  zoom(steps: number): void {
    const offset = this.camera.position.clone().sub(this.#orbit.target).multiplyScalar(ZOOM ** -steps);
    offset.clampLength(this.#orbit.minDistance, this.#orbit.maxDistance);
    this.camera.position.copy(this.#orbit.target).add(offset);
    this.draw();
  }

  /** Position and target of the camera, six numbers. */
  get view(): number[] {
    return [...this.camera.position.toArray(), ...this.#orbit.target.toArray()];
  }
  set view(numbers: readonly number[]) {
    this.camera.position.fromArray(numbers, 0);
    this.#orbit.target.fromArray(numbers, 3);
    this.draw();
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}
