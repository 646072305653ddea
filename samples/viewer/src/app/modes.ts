/** What of a face is shown. */
export type Mode = "shaded" | "wireframe" | "normals" | "regions" | "expected" | "error" | "difference";

export const MODES: readonly { mode: Mode; label: string; hint: string }[] = [
  { mode: "shaded", label: "Shaded", hint: "The face with its materials" },
  { mode: "wireframe", label: "Wireframe", hint: "The edges of its polygons" },
  { mode: "normals", label: "Normals", hint: "The direction of the surface as a colour" },
  { mode: "regions", label: "Regions", hint: "The regions that expected errors are given for" },
  { mode: "expected", label: "Expected error", hint: "How far vertices are expected to be from the rig, by region, as the bake found" },
  { mode: "error", label: "Error", hint: "How far each vertex is from where the rig has it" },
  { mode: "difference", label: "Difference", hint: "How far the same vertex of the two faces is apart" },
];

export const isMode = (text: string): text is Mode => MODES.some(({ mode }) => mode === text);
