// Equations, which mkdocs leaves between \( \) or \[ \].
document.addEventListener("DOMContentLoaded", () => {
  for (const place of document.querySelectorAll(".arithmatex")) {
    const source = place.textContent.trim();
    const settings = { displayMode: source.startsWith("\\["), throwOnError: false };
    katex.render(source.slice(2, -2), place, settings);
  }
});
// Code and pictures that are wider than the page can be scrolled by keys, too.
addEventListener("load", () => {
  for (const wide of document.querySelectorAll("pre > code, p:has(> img:only-child)"))
    if (wide.scrollWidth > wide.clientWidth) wide.tabIndex = 0;
});
// Browsers let a page that was opened as a file read no index, so there is no search then.
if (location.protocol === "file:") {
  document.addEventListener("DOMContentLoaded", () => {
    for (const part of document.querySelectorAll(".md-search, [for=__search]")) part.remove();
  });
}
