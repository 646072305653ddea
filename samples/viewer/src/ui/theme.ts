const KEY = "facebaker-theme";
type Theme = "light" | "dark";

const systemTheme = (): Theme => (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");

/** The system's theme until somebody chooses the other. */
export function startTheme(button: HTMLButtonElement, changed: () => void): void {
  let theme: Theme = systemTheme();
  try {
    const kept = localStorage.getItem(KEY);
    if (kept === "light" || kept === "dark") theme = kept;
  } catch {
    // storage may be forbidden
  }
  const show = (): void => {
    document.documentElement.dataset.theme = theme;
    button.setAttribute("aria-pressed", String(theme === "dark"));
    changed();
  };
  button.addEventListener("click", () => {
    theme = theme === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(KEY, theme);
    } catch {
      // the choice lasts as long as the page
    }
    show();
  });
  show();
}
