import type { Viewer } from "./viewer";

/** When the first face was on the screen, in milliseconds since the page's start; performance.mark "face". */
export class TimeToFace {
  milliseconds: number | null = null;

  constructor(viewer: Viewer) {
    viewer.stage.afterDraw = () => {
      if (this.milliseconds !== null || viewer.first === null) return;
      this.milliseconds = performance.now();
      performance.mark("face");
    };
  }
}
