// Equations, which mkdocs leaves between \( \) or \[ \].
document.addEventListener("DOMContentLoaded", () => {
  for (const place of document.querySelectorAll(".arithmatex")) {
    const source = place.textContent.trim();
    const settings = { displayMode: source.startsWith("\\["), throwOnError: false };
    katex.render(source.slice(2, -2), place, settings);
  }
});
// Browsers let a page that was opened as a file read no index, so there is no search then.
if (location.protocol === "file:") {
  document.addEventListener("DOMContentLoaded", () => {
    for (const part of document.querySelectorAll(".md-search, [for=__search]")) part.remove();
  });
}
