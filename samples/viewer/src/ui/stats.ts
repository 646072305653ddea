import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

/** Microseconds a pose, and how large the face is. */
export function startStats(viewer: Viewer): void {
  const stats = byId("stats");
  const time = element("b");
  const more = element("span", { class: "more" });
  stats.append(time, " a pose", more);
  stats.title = "Mean over the last poses: controls to positions, normals and what is drawn";
  viewer.drawn.subscribe(() => {
    const { first, times } = viewer;
    stats.hidden = first === null || times.microseconds === null;
    if (stats.hidden || !first) return;
    time.textContent = `${Math.round(times.microseconds ?? 0)} µs`;
    more.textContent = ` · ${first.face.vertexCount.toLocaleString("en")} vertices · ${first.face.controlCount} controls`;
  });
}
