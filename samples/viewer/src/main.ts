import { takeToken } from "./app/access_token";
import { type LoadedFace, loadFace, prepareFace } from "./app/open_faces";
import { TimeToFace } from "./app/time_to_face";
import { clipsBeside, readViewList, type ViewList } from "./app/view_list";
import { Viewer } from "./app/viewer";
import { Stage } from "./scene/stage";
import { offerHeadset } from "./scene/vr_button";
import { startAboutPanel } from "./ui/about_panel";
import { startClipsPanel } from "./ui/clips_panel";
import { byId, element } from "./ui/dom";
import { startFileDialogs } from "./ui/file_dialogs";
import { startKeys } from "./ui/keys";
import { startLegend } from "./ui/legend";
import { tell, telling } from "./ui/messages";
import { startModeBar } from "./ui/mode_bar";
import { startPlayerBar } from "./ui/player_bar";
import { PosePanel } from "./ui/pose_panel";
import { readAddress, sharePose } from "./ui/share";
import { startStats } from "./ui/stats";
import { startTabs } from "./ui/tabs";
import { startTheme } from "./ui/theme";

/** What is loading, from before there is a picture to show it in. */
interface Opening {
  list: ViewList;
  faces: Promise<LoadedFace>[];
}

function showProgress(loaded: number, total: number): void {
  byId<HTMLProgressElement>("loading-bar").value = total > 0 ? loaded / total : 0;
}

async function beginLoading(): Promise<Opening> {
  const asked = new URLSearchParams(location.search).get("face");
  const list = asked ? { faces: [{ name: asked.split("/").at(-1) ?? asked, url: asked }] } : await readViewList();
  const faces = list.faces.map(({ name, url }) => loadFace(new URL(url, location.href).href, name, showProgress));
  for (const face of faces) face.catch(() => undefined); // told when it is to be shown
  return { list, faces };
}

byId("loading").hidden = false;
takeToken();
const opening = beginLoading();
// The archive and the module are on their way while the picture is made.
await opening.catch(() => undefined);
const stage = new Stage(byId<HTMLCanvasElement>("canvas"));
const viewer = new Viewer(stage, (reason) => tell(reason, "error"));
const timing = new TimeToFace(viewer);

function startPanels(): void {
  const panel = new PosePanel(viewer);
  const files = startFileDialogs(viewer);
  const showTab = startTabs(byId("tabs"));
  const share = (): void => void sharePose(viewer);
  startModeBar(viewer);
  startLegend(viewer);
  startStats(viewer);
  startPlayerBar(viewer);
  startAboutPanel(viewer);
  startClipsPanel(viewer, files.open, files.openFolder);
  startKeys(viewer, {
    open: files.open,
    share,
    search: () => {
      showTab("pose");
      panel.focusSearch();
    },
  });
  startTheme(byId<HTMLButtonElement>("theme"), () => stage.draw());
  byId("open").addEventListener("click", files.open);
  byId("open-first").addEventListener("click", files.open);
  byId("share").addEventListener("click", share);
  byId("home").addEventListener("click", () => stage.home());
  for (const button of document.querySelectorAll<HTMLButtonElement>("#cameras button[data-right]"))
    button.addEventListener("click", () => stage.lookFrom(Number(button.dataset.right), Number(button.dataset.up)));
}

viewer.opened.subscribe(() => {
  byId("welcome").hidden = true;
  const two = viewer.faces.length > 1;
  const names = viewer.faces.map(({ face, name }) => (two ? name : face.name || name));
  byId("names").hidden = !two;
  byId("names").replaceChildren(...names.map((name) => element("span", {}, name)));
  byId("title").textContent = names.join(" and ");
  document.title = `${names.join(" and ")} · FaceBaker viewer`;
});

async function start(): Promise<void> {
  try {
    const { list, faces } = await opening;
    for (const [i, face] of faces.entries()) viewer.show(prepareFace(await face, i > 0 ? viewer.first!.face : null), i > 0);
    if (!viewer.first) return;
    readAddress(viewer);
    viewer.addClips(await clipsBeside(list, viewer.first.face));
    if (viewer.truth) viewer.truth.live = list.beside?.live === true;
    viewer.modeChanged.emit();
  } finally {
    byId("loading").hidden = true;
    byId("welcome").hidden = viewer.first !== null;
  }
}

startPanels();
addEventListener("hashchange", () => readAddress(viewer));
void telling(start).then(() => offerHeadset(byId<HTMLButtonElement>("headset"), stage, () => {
  const face = viewer.first?.face;
  return { units: face?.units ?? "m", diagonal: face?.diagonal ?? 1 };
}));

// For the console and for tests.
Object.assign(globalThis, { facebakerViewer: { viewer, timing } });
