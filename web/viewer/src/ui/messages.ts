// What goes wrong, said where it is seen and read out, with what can be done about it.
import { button, byId, element, shownText } from "./dom.js";

export interface Remedy {
  readonly text: string;
  readonly act: () => void;
}

export class Messages {
  private readonly bar = byId("message");

  show(text: string, kind: "error" | "note", remedy?: Remedy): void {
    this.bar.replaceChildren(element("span", {}, shownText(text, 400)));
    this.bar.className = kind;
    if (remedy) {
      this.bar.append(
        button(remedy.text, remedy.text, () => {
          this.clear();
          remedy.act();
        }),
      );
    }
    this.bar.append(button("✕", "Close this message", () => this.clear()));
    this.bar.hidden = false;
  }

  /** Says something more, beside what went wrong before. */
  add(text: string): void {
    if (this.bar.hidden) this.show(text, "error");
    else this.bar.prepend(element("span", {}, shownText(text, 400)));
  }

  /** Says nothing any more; of a text nothing where another took its place. */
  clear(text = this.bar.firstChild?.textContent): void {
    if (text !== this.bar.firstChild?.textContent) return;
    this.bar.hidden = true;
    this.bar.replaceChildren();
  }
}
