import { MODES } from "../app/modes";
import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

export interface KeyActions {
  open(): void;
  share(): void;
  search(): void;
  keepExpression(): void;
  addKeyframe(): void;
  drag(): void;
  mirror(): void;
}

const HELP: readonly (readonly [string, string])[] = [
  ["Drag", "turn the face; with two fingers or the right button move it, pinch or wheel to zoom"],
  ["← → ↑ ↓", "turn the face, where it has the focus"],
  ["+ −", "zoom"],
  ["F", "look from the front at what the controls move"],
  ["Home", "fit the face into the picture"],
  ["1 … 7", "what is shown: shaded, wireframe, normals, ..."],
  ["T", "the true rig beside the face, where it is known"],
  ["Space", "play the clip, or pause it"],
  [", .", "the frame before, the next one"],
  ["L", "begin the clip again at its end, or not"],
  ["W", "the worst frame of the clip, then the next worst"],
  ["Ctrl+Z", "undo what was done to the pose; with Shift redo it"],
  ["Ctrl+C", "copy the values of the pose as text"],
  ["Ctrl+V", "pose the face by such a text"],
  ["R", "all controls to rest"],
  ["X", "a random pose"],
  ["D", "drag points of the face, or turn it"],
  ["M", "left and right together, or not"],
  ["E", "keep the pose as an expression"],
  ["K", "add the pose to the keyframes"],
  ["/", "search controls"],
  ["O", "open files"],
  ["C", "copy a link to the pose"],
];

/** Whether a key means text there. */
export function typing(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return target.type !== "range";
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}

/** Whether Space presses what has the focus: not a button that has it because it was clicked. */
function watchPressable(): (target: EventTarget | null) => boolean {
  let clicked: EventTarget | null = null;
  document.addEventListener("focusin", () => {
    clicked = null;
  });
  document.addEventListener("click", (event) => {
    if (event.detail > 0) clicked = document.activeElement; // keys click without a count
  });
  return (target) => target instanceof HTMLElement && target.matches("button, summary") && target !== clicked;
}

/** Undoes or redoes where that is what the keys mean; returns whether. In a text Ctrl+Z is the text's own. */
function undoes(event: KeyboardEvent, { pose }: Viewer): boolean {
  const key = event.key.toLowerCase();
  const text = typing(event.target) && (event.target as HTMLInputElement).type !== "number";
  if (!(event.ctrlKey || event.metaKey) || event.altKey || text || (key !== "z" && key !== "y")) return false;
  if (key === "y" || event.shiftKey) pose.redo();
  else pose.undo();
  return true;
}

function startHelp(): () => void {
  const dialog = byId<HTMLDialogElement>("keys");
  const list = element("dl");
  for (const [keys, words] of HELP) list.append(element("dt", {}, element("kbd", {}, keys)), element("dd", {}, words));
  const close = element("button", { type: "button", class: "primary" }, "Close");
  close.addEventListener("click", () => dialog.close());
  dialog.append(element("h2", { id: "keys-title" }, "Keys and mouse"), list, close);
  byId("help").addEventListener("click", () => dialog.showModal());
  return () => dialog.showModal();
}

export function startKeys(viewer: Viewer, actions: KeyActions): void {
  const help = startHelp();
  const pressable = watchPressable();
  const { stage, player } = viewer;
  const turns: Record<string, () => void> = {
    ArrowLeft: () => stage.turn(-1, 0),
    ArrowRight: () => stage.turn(1, 0),
    ArrowUp: () => stage.turn(0, 1),
    ArrowDown: () => stage.turn(0, -1),
    "+": () => stage.zoom(1),
    "=": () => stage.zoom(1),
    "-": () => stage.zoom(-1),
    Home: () => stage.home(),
  };
  stage.canvas.addEventListener("keydown", (event) => {
    const turn = turns[event.key];
    if (!turn || event.ctrlKey || event.metaKey || event.altKey) return;
    turn();
    event.preventDefault();
  });
  const keys: Record<string, () => void> = {
    " ": () => player.toggle(),
    ",": () => player.seek(player.frame - 1),
    ".": () => player.seek(player.frame + 1),
    "/": actions.search,
    "?": help,
    l: () => {
      player.loop = !player.loop;
    },
    w: () => viewer.seekNextWorst(),
    t: () => {
      viewer.trueRigBeside = !viewer.trueRigBeside;
    },
    f: () => viewer.lookAtMoving(),
    x: () => viewer.pose.randomise(),
    r: () => viewer.pose.reset(),
    o: actions.open,
    c: actions.share,
    e: actions.keepExpression,
    d: actions.drag,
    k: actions.addKeyframe,
    m: actions.mirror,
  };
  document.addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]")) return;
    if (undoes(event, viewer)) return void event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    if (event.key === " " && pressable(event.target)) return;
    const digit = MODES[Number(event.key) - 1];
    if (digit && viewer.whyNot(digit.mode) === null) viewer.mode = digit.mode;
    const action = keys[event.key];
    if (!action) return;
    action();
    event.preventDefault();
  });
  // Firefox presses a button when Space comes up.
  document.addEventListener("keyup", (event) => {
    if (event.key === " " && event.target instanceof HTMLButtonElement && !pressable(event.target)) event.preventDefault();
  });
}
