import type { Control } from "facebaker";
import type { FaceDragging } from "../app/face_dragging";
import type { Viewer } from "../app/viewer";
import type { Pose } from "../pose/pose";
import { ControlRow } from "./control_row";
import { byId, element } from "./dom";
import { DragRow } from "./drag_row";
import { UndoButtons } from "./undo_buttons";

interface Group {
  body: HTMLElement;
  details: HTMLDetailsElement;
  count: HTMLElement;
  reset: HTMLButtonElement;
  rows: ControlRow[];
}

const OPEN_AT_FIRST = 24; // rows, of the groups that are open when a face is new

/** Controls by group, with search, undo, resets and the link between sides; and the exact poses as buttons. */
export class PosePanel {
  readonly #panel = byId("pose");
  readonly #search = element("input", { type: "search", id: "search", placeholder: "Search controls", "aria-label": "Search controls" });
  readonly #link = element("button", { type: "button", "aria-pressed": "false", title: "Move left and right together" }, "Mirror");
  readonly #random = element("button", { type: "button", title: "A few controls at random (X)" }, "Random");
  readonly #undo: UndoButtons;
  readonly #drag: DragRow;
  readonly #moved = element("span", { class: "grow", role: "status" });
  readonly #resetAll = element("button", { type: "button", title: "All controls to rest (R)" }, "Reset all");
  readonly #none = element("p", { class: "none", hidden: true }, "No control has this in its name.");
  #pose: Pose | null = null;
  #groups: Group[] = [];

  constructor(
    readonly viewer: Viewer,
    dragging: FaceDragging,
  ) {
    this.#undo = new UndoButtons(viewer);
    this.#drag = new DragRow(dragging);
    dragging.openControls = () => this.#openControls();
    this.#search.addEventListener("input", () => this.#filter());
    this.#random.addEventListener("click", () => this.#pose?.randomise());
    this.#resetAll.addEventListener("click", () => this.#pose?.reset());
    this.#link.addEventListener("click", () => this.toggleLink());
    viewer.opened.subscribe(() => {
      if (viewer.pose !== this.#pose) this.#build();
    });
  }

  /** Has left and right move together, or not any more. */
  toggleLink(): void {
    if (!this.#pose?.hasPairs) return;
    this.#pose.linked = !this.#pose.linked;
    this.#link.setAttribute("aria-pressed", String(this.#pose.linked));
  }

  focusSearch(): void {
    this.#search.focus();
    this.#search.select();
  }

  #build(): void {
    const pose = this.viewer.pose;
    this.#pose = pose;
    this.#search.value = "";
    this.#link.hidden = !pose.hasPairs;
    this.#link.setAttribute("aria-pressed", "false");
    const byGroup = new Map<string, Control[]>();
    for (const control of pose.controls) {
      const group = byGroup.get(control.group);
      if (group) group.push(control);
      else byGroup.set(control.group, [control]);
    }
    this.#groups = [...byGroup].map(([name, controls]) => this.#makeGroup(name || "controls", controls, pose));
    let rows = 0;
    for (const group of this.#groups) {
      group.details.open = rows === 0 || rows + group.rows.length <= OPEN_AT_FIRST;
      rows += group.rows.length;
    }
    this.#undo.follow();
    const find = element(
      "div",
      { class: "find" },
      element("div", { class: "row" }, this.#search, this.#undo.undo, this.#undo.redo),
      element("div", { class: "row" }, this.#moved, this.#link, this.#random, this.#resetAll),
      element("div", { class: "row" }, this.#drag.drag, this.#drag.openOnly),
      this.#drag.state,
    );
    this.#panel.replaceChildren(find, ...this.#exactPoses(pose), this.#none, ...this.#groups.map(({ details }) => details));
    pose.changed.subscribe(() => this.#show());
    this.#show();
  }

  /** One a control, 1: its group is open. */
  #openControls(): Uint8Array {
    const open = new Uint8Array(this.viewer.pose.values.length);
    for (const { details, rows } of this.#groups)
      if (details.open) for (const { control } of rows) open[control.index] = 1;
    return open;
  }

  #makeGroup(name: string, controls: readonly Control[], pose: Pose): Group {
    const rows = controls.map((control) => new ControlRow(control, pose));
    const count = element("span", { class: "count" });
    const reset = element("button", { type: "button", "aria-label": `Reset group ${name}` }, "Reset group");
    reset.addEventListener("click", () => pose.reset(controls.map((control) => control.index)));
    const body = element("div", { class: "group-body" }, reset, ...rows.map((row) => row.element));
    const details = element("details", { class: "group" }, element("summary", {}, name, count), body);
    details.addEventListener("toggle", () => this.#show());
    return { details, body, count, reset, rows };
  }

  #exactPoses(pose: Pose): HTMLElement[] {
    const exact = this.viewer.first?.face.exactPoses ?? [];
    if (exact.length === 0) return [];
    const buttons = exact.map(({ name, controls }) => {
      const button = element("button", { type: "button" }, name);
      button.addEventListener("click", () => pose.assign(controls));
      return button;
    });
    const title = element("h3", { title: "Poses that the face has exactly as the rig has them" }, "Exact poses");
    return [element("div", { class: "exact" }, title, element("div", { class: "chips" }, ...buttons))];
  }

  #filter(): void {
    const words = this.#search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let any = false;
    for (const group of this.#groups) {
      let found = 0;
      for (const row of group.rows) if (row.match(words)) ++found;
      group.details.hidden = found === 0;
      if (words.length > 0 && found > 0) group.details.open = true;
      any ||= found > 0;
    }
    this.#none.hidden = any;
    this.#show();
  }

  /** Only rows that can be seen are brought up to date. */
  #show(): void {
    const moved = this.#pose?.movedCount() ?? 0;
    this.#moved.textContent = moved === 0 ? "At rest" : `${moved} moved`;
    this.#resetAll.disabled = moved === 0;
    for (const { details, rows, count, reset } of this.#groups) {
      const off = rows.filter((row) => row.moved).length;
      count.textContent = off > 0 ? `${rows.length}, ${off} moved` : String(rows.length);
      reset.hidden = off === 0;
      if (details.open) for (const row of rows) row.show();
    }
  }
}
