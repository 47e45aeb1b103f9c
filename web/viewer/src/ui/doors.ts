// How volumes come in: dropped, chosen, or named by an address.
import { safeUrl } from "../store/permalink.js";
import { byId, button, element, shownText } from "./dom.js";

/** open  is told of a source, and how many files came with it */
export function listenToDoors(open: (source: string | File, others?: number) => void): {
  choose: () => void;
} {
  const input = byId<HTMLInputElement>("file");
  const choose = (): void => {
    input.value = "";
    input.click();
  };
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    if (file) open(file);
  });
  byId("choose").addEventListener("click", choose);
  byId("url-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const text = byId<HTMLInputElement>("url").value;
    open(new URL(text, document.baseURI).href);
  });
  const over = (event: DragEvent): void => {
    event.preventDefault();
    document.body.classList.add("dropping");
  };
  document.addEventListener("dragenter", over);
  document.addEventListener("dragover", over);
  document.addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    const [file, ...others] = event.dataTransfer?.files ?? [];
    if (file) open(file, others.length);
  });
  return { choose };
}

/** What messages call a source: the name of a file, the last part of an address. */
export function nameOf(source: string | File): string {
  if (typeof source !== "string") return source.name;
  const last = /([^/]+)\/?([?#].*)?$/s.exec(source)?.[1] ?? source;
  try {
    return decodeURIComponent(last);
  } catch {
    return last;
  }
}

export interface Listed {
  readonly title: string;
  readonly url: string;
}

/** The volumes that lie beside the page, as `octavo publish` and `octavo serve` list them. */
export async function listedFiles(): Promise<Listed[]> {
  try {
    const answer = await fetch("files.json", { cache: "no-cache" });
    const list: unknown = answer.ok ? await answer.json() : [];
    if (!Array.isArray(list)) return [];
    return list.flatMap((row: { title?: unknown; url?: unknown }) => {
      const url = typeof row?.url === "string" ? safeUrl(row.url, document.baseURI) : undefined;
      return url && typeof row.title === "string" ? [{ title: row.title, url }] : [];
    });
  } catch {
    return []; // A page without a list is one for files of this machine and addresses.
  }
}

export function showList(listed: readonly Listed[], open: (url: string) => void): void {
  byId("listed").replaceChildren(
    ...listed.map(({ title, url }) =>
      element(
        "li",
        {},
        button(shownText(title, 80), url, () => open(url)),
      ),
    ),
  );
}
