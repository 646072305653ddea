import type { Viewer } from "../app/viewer";
import type { Expression } from "../pose/expressions";
import { writeExpressions } from "../pose/expression_file";
import { byId, element } from "./dom";
import { download } from "./download";
import { telling } from "./messages";
import { askForValues, copyValues } from "./pose_clipboard";

const HINT =
  "The file is a table (.csv), a row for each expression. facebaker bake --exact FILE.csv makes these poses exact, and " +
  "--poses-like FILE.csv trains near them. Values that are copied are options of facebaker pose.";

function makeButton(label: string, action: () => void, attributes: Record<string, string> = {}): HTMLButtonElement {
  const button = element("button", { type: "button", ...attributes }, label);
  button.addEventListener("click", action);
  return button;
}

function makeRow(viewer: Viewer, expression: Expression): HTMLElement {
  const { name, values } = expression;
  const moved = values.reduce((count, value, i) => count + (value === viewer.pose.rest[i] ? 0 : 1), 0);
  const show = element(
    "button",
    { type: "button", class: "show", title: "Pose the face so" },
    element("span", { class: "title" }, name),
    element("span", { class: "where" }, `${moved} ${moved === 1 ? "control" : "controls"}`),
  );
  show.addEventListener("click", () => viewer.pose.assign(values));
  return element(
    "li",
    {},
    show,
    makeButton("Copy", () => void copyValues(viewer, values), {
      "aria-label": `Copy the values of ${name}`,
      title: "Copy its values",
    }),
    makeButton("×", () => viewer.expressions.remove(expression), {
      "aria-label": `Remove ${name}`,
      title: "Remove",
      class: "plain",
    }),
  );
}

/** Poses with names: keeping them, a file of them, and values as text. Returns what brings the field of the name to
 * the eye. */
export function startExpressionsPanel(viewer: Viewer, open: () => void): () => void {
  const { expressions } = viewer;
  const panel = byId("expressions");
  const asked = "Name of this pose";
  const name = element("input", { type: "text", placeholder: asked, "aria-label": asked, maxlength: 80, autocomplete: "off" });
  const keep = element("button", { type: "submit", class: "primary" }, "Keep");
  const form = element("form", { class: "keep" }, name, keep);
  const list = element("ul", { class: "expressions", "aria-label": "Expressions" });
  const none = element("p", { class: "none" }, "No expressions yet.");
  const save = makeButton("Save as a file", () =>
    void telling(() => {
      const { first, pose } = viewer;
      download(`${first?.face.name || "face"}.expressions.csv`, writeExpressions(expressions.all, pose.controls), "text/csv");
    }),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (!viewer.first) return;
    expressions.keep(name.value, viewer.pose.values);
    name.value = "";
  });
  panel.replaceChildren(
    form,
    none,
    list,
    element("div", { class: "row" }, makeButton("Open a file…", open), save),
    element("h2", {}, "Values as text"),
    element(
      "div",
      { class: "row" },
      makeButton("Copy values", () => void copyValues(viewer, viewer.pose.values), { title: "Copy the pose's values (Ctrl+C)" }),
      makeButton("Paste values…", () => askForValues(viewer), { title: "Pose the face by a text (Ctrl+V)" }),
    ),
    element("p", { class: "hint" }, HINT),
  );
  const show = (): void => {
    list.replaceChildren(...expressions.all.map((expression) => makeRow(viewer, expression)));
    list.hidden = save.disabled = expressions.all.length === 0;
    none.hidden = expressions.all.length > 0;
    keep.disabled = viewer.first === null;
  };
  expressions.changed.subscribe(show);
  viewer.opened.subscribe(show);
  show();
  return () => name.focus();
}
