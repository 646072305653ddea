import { isMode } from "../app/modes";
import type { Viewer } from "../app/viewer";
import { applyLink, decodeLink, encodeLink } from "../pose/pose_link";
import { tell } from "./messages";

/** Puts pose, mode and camera into the address. */
export function putPoseIntoAddress(viewer: Viewer): void {
  const hash = encodeLink(viewer.pose, { mode: viewer.mode, camera: viewer.stage.view });
  history.replaceState(null, "", `${location.pathname}${location.search}${hash}`);
}

/** Puts them there and copies the address. */
export async function sharePose(viewer: Viewer): Promise<void> {
  putPoseIntoAddress(viewer);
  try {
    await navigator.clipboard.writeText(location.href);
    tell("The link to this pose is copied.");
  } catch {
    tell("The link to this pose is in the address bar.");
  }
}

/** Shows what the address asks for. */
export function readAddress(viewer: Viewer): void {
  const link = decodeLink(location.hash);
  if (location.hash.length < 2) return;
  const unknown = applyLink(link, viewer.pose);
  if (link.mode !== undefined && isMode(link.mode)) viewer.mode = link.mode;
  if (link.camera) viewer.stage.view = link.camera;
  if (unknown.length > 0) tell(`The link poses controls that this face does not have: ${unknown.slice(0, 3).join(", ")}.`);
}
