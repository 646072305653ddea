import { byId } from "./dom";

/** Tells the style sheet how high the bars over the picture are that grow and go, as lengths --player-height and
 * --legend-height with their margin, so that the picture and other bars stay clear of them. */
export function watchBarHeights(): void {
  const view = byId("view");
  for (const id of ["player", "legend"]) {
    const bar = byId(id);
    const property = `--${id}-height`;
    new ResizeObserver(() => {
      const { height } = bar.getBoundingClientRect();
      view.style.setProperty(property, height > 0 ? `calc(${height}px + var(--bar-margin))` : "0px");
    }).observe(bar);
  }
}
