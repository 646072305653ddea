import { openFace } from "./app/open_faces";
import { TimeToFace } from "./app/time_to_face";
import { clipsBeside, readViewList } from "./app/view_list";
import { Viewer } from "./app/viewer";
import { Stage } from "./scene/stage";
import { offerHeadset } from "./scene/vr_button";
import { startAboutPanel } from "./ui/about_panel";
import { startClipsPanel } from "./ui/clips_panel";
import { byId } from "./ui/dom";
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
  const names = viewer.faces.map(({ face, name }) => face.name || name);
  byId("title").textContent = names.join(" and ");
  document.title = `${names.join(" and ")} · FaceBaker viewer`;
});

function showProgress(loaded: number, total: number): void {
  byId<HTMLProgressElement>("loading-bar").value = total > 0 ? loaded / total : 0;
}

async function start(): Promise<void> {
  const loading = byId("loading");
  loading.hidden = false;
  try {
    const asked = new URLSearchParams(location.search).get("face");
    const list = asked ? { faces: [{ name: asked.split("/").at(-1) ?? asked, url: asked }] } : await readViewList();
    for (const [i, { name, url }] of list.faces.entries())
      viewer.show(await openFace(new URL(url, location.href).href, name, i > 0 ? viewer.first!.face : null, showProgress), i > 0);
    if (!viewer.first) return;
    readAddress(viewer);
    viewer.addClips(await clipsBeside(list, viewer.first.face));
    if (viewer.truth) viewer.truth.live = "beside" in list && list.beside?.live === true;
    viewer.modeChanged.emit();
  } finally {
    loading.hidden = true;
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
