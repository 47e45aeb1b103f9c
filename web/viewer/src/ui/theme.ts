// Dark or light: as the system has it until somebody chooses.
const KEY = "octavo-theme";

function put(theme: string): void {
  document.documentElement.dataset["theme"] = theme;
}

export function startTheme(): void {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let chosen: string | null = null;
  try {
    chosen = localStorage.getItem(KEY);
  } catch {
    // Storage may be forbidden.
  }
  put(chosen === "dark" || chosen === "light" ? chosen : dark.matches ? "dark" : "light");
}

export function switchTheme(): void {
  const next = document.documentElement.dataset["theme"] === "dark" ? "light" : "dark";
  put(next);
  try {
    localStorage.setItem(KEY, next);
  } catch {
    // Then the choice lasts as long as the page.
  }
}
