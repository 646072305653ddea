import { metresPerUnit } from "facebaker";
import type { Stage } from "./stage";

const EYE_HEIGHT = 1.5;
const DISTANCE = 0.7;

/** Shows the button where there is a headset, which then shows the face in its true size, at arm's length. */
export async function offerHeadset(button: HTMLButtonElement, stage: Stage, size: () => { units: string; diagonal: number }): Promise<void> {
  const supported = await navigator.xr?.isSessionSupported("immersive-vr").catch(() => false);
  if (!supported || !navigator.xr) return;
  const xr = navigator.xr;
  let session: XRSession | null = null;
  button.hidden = false;
  button.addEventListener("click", async () => {
    if (session) return void session.end();
    session = await xr.requestSession("immersive-vr", { optionalFeatures: ["local-floor"] });
    const { renderer, faces } = stage;
    const { units, diagonal } = size();
    faces.scale.setScalar(diagonal * (metresPerUnit(units) ?? 0.3 / diagonal));
    faces.position.set(0, EYE_HEIGHT, -DISTANCE);
    session.addEventListener("end", () => {
      session = null;
      renderer.setAnimationLoop(null);
      renderer.xr.enabled = false;
      faces.scale.setScalar(1);
      faces.position.set(0, 0, 0);
      button.textContent = "Enter VR";
      stage.draw();
    });
    button.textContent = "Leave VR";
    renderer.xr.enabled = true;
    renderer.xr.setReferenceSpaceType("local-floor");
    await renderer.xr.setSession(session);
    renderer.setAnimationLoop((now) => stage.drawNow(now));
  });
}
