import { takeToken } from "./app/access_token";
import { Capture } from "./app/capture";
import { FaceDragging } from "./app/face_dragging";
import { readRights } from "./app/face_rights";
import { keepExpressions } from "./app/kept_expressions";
import { type LoadedFace, loadFace, prepareFace } from "./app/open_faces";
import { TimeToFace } from "./app/time_to_face";
import { clipsBeside, readViewList, type ViewList } from "./app/view_list";
import { Viewer } from "./app/viewer";
import { Stage } from "./scene/stage";
import { offerHeadset } from "./scene/vr_button";
import { startAboutPanel } from "./ui/about_panel";
import { watchBarHeights } from "./ui/bar_heights";
import { startCaptureLine } from "./ui/capture_line";
import { startClipsPanel } from "./ui/clips_panel";
import { byId } from "./ui/dom";
import { startDragInput } from "./ui/drag_input";
import { startExpressionsPanel } from "./ui/expressions_panel";
import { startFaceNames } from "./ui/face_names";
import { startFileDialogs } from "./ui/file_dialogs";
import { startKeyframesPanel } from "./ui/keyframes_panel";
import { startKeys, typing } from "./ui/keys";
import { startLegend } from "./ui/legend";
import { tell, telling } from "./ui/messages";
import { startModeBar } from "./ui/mode_bar";
import { startPlayerBar } from "./ui/player_bar";
import { startPoseClipboard } from "./ui/pose_clipboard";
import { PosePanel } from "./ui/pose_panel";
import { startRightsLine } from "./ui/rights_line";
import { putPoseIntoAddress, readAddress, sharePose } from "./ui/share";
import { StartCard } from "./ui/start_card";
import { startStats } from "./ui/stats";
import { startTabs } from "./ui/tabs";
import { startTheme } from "./ui/theme";

/** What is loading, from before there is a picture to show it in. */
interface Opening {
  list: ViewList;
  faces: Promise<LoadedFace>[];
}

const card = new StartCard(byId("start"), () => byId("files").click());

async function beginLoading(): Promise<Opening> {
  const asked = new URLSearchParams(location.search).get("face");
  const list = asked ? { faces: [{ name: asked.split("/").at(-1) ?? asked, url: asked }] } : await readViewList();
  const faces = list.faces.map(({ name, url }) =>
    loadFace(new URL(url, location.href).href, name, (loaded, total) => card.progress(name, loaded, total)),
  );
  for (const face of faces) face.catch(() => undefined); // told when it is to be shown
  return { list, faces };
}

function startPanels(viewer: Viewer, dragging: FaceDragging): void {
  const { stage } = viewer;
  const panel = new PosePanel(viewer, dragging);
  const files = startFileDialogs(viewer, card);
  const showTab = startTabs(byId("tabs"));
  const share = (): void => void sharePose(viewer);
  watchBarHeights();
  startFaceNames(viewer);
  startModeBar(viewer);
  startLegend(viewer);
  startStats(viewer);
  startPlayerBar(viewer);
  startAboutPanel(viewer);
  startRightsLine(viewer);
  startClipsPanel(viewer, files.open, files.openFolder);
  const addKeyframe = startKeyframesPanel(viewer);
  const nameExpression = startExpressionsPanel(viewer, files.open);
  keepExpressions(viewer);
  startPoseClipboard(viewer, typing);
  startDragInput(dragging);
  startKeys(viewer, {
    mirror: () => panel.toggleLink(),
    addKeyframe,
    drag: () => {
      showTab("pose");
      dragging.on = !dragging.on;
    },
    open: files.open,
    share,
    search: () => {
      showTab("pose");
      panel.focusSearch();
    },
    keepExpression: () => {
      showTab("expressions");
      nameExpression();
    },
  });
  byId("open").addEventListener("click", files.open);
  byId("share").addEventListener("click", share);
  byId("face-camera").addEventListener("click", () => viewer.lookAtMoving());
  byId("home").addEventListener("click", () => stage.home());
  for (const button of document.querySelectorAll<HTMLButtonElement>("#cameras button[data-right]"))
    button.addEventListener("click", () => stage.lookFrom(Number(button.dataset.right), Number(button.dataset.up)));
}

function startCapture(capture: Capture): void {
  startCaptureLine(capture);
  capture.start();
}

/** Shows what the page was opened for. */
async function showFirst(viewer: Viewer, opening: Promise<Opening>): Promise<void> {
  try {
    const { faces } = await opening;
    for (const [i, face] of faces.entries()) viewer.show(prepareFace(await face, i > 0 ? viewer.first!.face : null), i > 0);
    if (!viewer.first) card.welcome();
  } catch (error) {
    if (viewer.first) throw error;
    return card.refused(error instanceof Error ? error.message : String(error));
  }
  if (!viewer.first) return;
  const { list } = await opening;
  readAddress(viewer);
  viewer.addClips(await clipsBeside(list, viewer.first.face));
  if (viewer.truth) viewer.truth.live = list.beside?.live === true;
  viewer.modeChanged.emit();
  if (list.capture) startCapture(new Capture(viewer, list.capture));
}

/** The picture; null where the browser cannot draw it. */
function makeStage(): Stage | null {
  try {
    return new Stage(byId<HTMLCanvasElement>("canvas"));
  } catch {
    return null;
  }
}

async function main(): Promise<void> {
  card.loading("the face");
  takeToken();
  const opening = beginLoading();
  // The archive and the module are on their way while the picture is made.
  await opening.catch(() => undefined);
  const stage = makeStage();
  startTheme(byId<HTMLButtonElement>("theme"), () => stage?.draw());
  if (!stage) {
    for (const id of ["open", "share", "help"]) byId<HTMLButtonElement>(id).disabled = true;
    // Else the browser would leave the page for the file.
    for (const event of ["dragover", "drop"]) addEventListener(event, (dropped) => dropped.preventDefault());
    return card.noWebGl();
  }
  const viewer = new Viewer(stage, (reason) => tell(reason, "error"));
  const timing = new TimeToFace(viewer);
  stage.contextChanged = (lost) =>
    card.setLost(lost, () => {
      putPoseIntoAddress(viewer);
      location.reload();
    });
  viewer.opened.subscribe(() => card.hide());
  const dragging = new FaceDragging(viewer);
  startPanels(viewer, dragging);
  addEventListener("hashchange", () => readAddress(viewer));
  // For the console and for tests.
  Object.assign(globalThis, { facebakerViewer: { viewer, timing, dragging, readRights } });
  await telling(() => showFirst(viewer, opening));
  await offerHeadset(byId<HTMLButtonElement>("headset"), stage, () => {
    const face = viewer.first?.face;
    return { units: face?.units ?? "m", diagonal: face?.diagonal ?? 1 };
  });
}

void main();
