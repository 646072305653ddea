import type { Capture, CaptureNews } from "../app/capture";
import { byId, element } from "./dom";

const SILENCE = 1; // seconds without a frame, after which it is told
const UPDATES = 4; // a second: figures that change faster cannot be read

const who = ({ source, subject }: CaptureNews): string => (subject ? `${source}, ${subject}` : source);

/** What is going on, without figures that change all the time. */
function stateOf({ news, failure, source, held }: Capture): string {
  const { address, port } = source;
  if (failure !== null) return `${source.source}: ${failure}`;
  if (!news) return source.source;
  if (news.calibrating) return `${who(news)}: ${news.calibrating}`;
  if (news.frame_age === null) {
    if (news.packet_age !== null) return `${who(news)}: sees no face yet`;
    const others = news.refused > 0 ? `; what came there is not of ${news.source}` : "";
    return `${news.source}: waits for packets on ${address}, UDP port ${port}${others}`;
  }
  if (held) return `${who(news)}: held`;
  if (news.frame_age <= SILENCE) return who(news);
  const silent = `for ${Math.floor(news.frame_age)} s; the last pose stays`;
  return news.packet_age !== null && news.packet_age <= SILENCE ? `${who(news)}: no face ${silent}` : `${who(news)}: no packets ${silent}`;
}

/** Says where facial capture comes from, how often, and what of it moves nothing; holds the pose by a button. */
export function startCaptureLine(capture: Capture): void {
  const line = byId("capture");
  const state = element("span", { role: "status" });
  const rate = element("span", { class: "rate" });
  const hold = element("button", { type: "button", "aria-pressed": "false", title: "Keep this pose, to edit it" }, "Hold");
  const summary = element("summary");
  const names = element("p");
  const unmatched = element("details", { hidden: true }, summary, names);
  line.replaceChildren(element("p", {}, state, rate, hold), unmatched);
  line.hidden = false;
  hold.addEventListener("click", () => {
    capture.held = !capture.held;
  });

  let rated = 0; // when the rate was shown
  capture.changed.subscribe(() => {
    const { news } = capture;
    const text = stateOf(capture);
    if (state.textContent !== text) state.textContent = text;
    hold.setAttribute("aria-pressed", String(capture.held));
    const now = performance.now();
    if (now - rated < 1000 / UPDATES) return;
    rated = now;
    rate.textContent = news && news.fps > 0 ? `${news.fps} frames a second` : "";
    unmatched.hidden = !news || news.frames === 0 || news.unmatched_count === 0;
    if (!news) return;
    summary.textContent = `${news.unmatched_count} of ${news.names} captured names have no control`;
    const more = news.unmatched_count - news.unmatched.length;
    names.textContent = news.unmatched.join(", ") + (more > 0 ? ` and ${more} more` : "");
  });
}
