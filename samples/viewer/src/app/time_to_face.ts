import type { Viewer } from "./viewer";

/** When the first face was on the screen, in milliseconds since the page's start: when the browser asked for the picture
 * after it. */
export class TimeToFace {
  milliseconds: number | null = null;
  #drawn = false;

  constructor(viewer: Viewer) {
    viewer.stage.afterDraw = () => {
      if (this.#drawn || viewer.first === null) return;
      this.#drawn = true;
      requestAnimationFrame(() => {
        this.milliseconds = performance.now();
      });
    };
  }
}
