import { readExpressions, writeExpressions } from "../pose/expression_file";
import type { Expression } from "../pose/expressions";
import type { Viewer } from "./viewer";

/** What was kept under a key; none where storage is forbidden, or has those of another face of this name. */
function readKept(key: string, viewer: Viewer): Expression[] {
  try {
    const text = localStorage.getItem(key);
    return text ? readExpressions(text, key, viewer.pose.controls).expressions : [];
  } catch {
    return [];
  }
}

/** Has the browser keep the expressions of each face by its name, where it keeps anything. */
export function keepExpressions(viewer: Viewer): void {
  const { expressions } = viewer;
  let key: string | null = null; // null: nothing is to be written
  viewer.started.subscribe(() => {
    const { first } = viewer;
    key = null;
    const opened = `facebaker-expressions:${first?.face.name || first?.name}`;
    expressions.replace(readKept(opened, viewer));
    key = opened;
  });
  expressions.changed.subscribe(() => {
    if (key === null) return;
    try {
      if (expressions.all.length > 0) localStorage.setItem(key, writeExpressions(expressions.all, viewer.pose.controls));
      else localStorage.removeItem(key);
    } catch {
      // they last as long as the page
    }
  });
}
