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

  clear(): void {
    this.bar.hidden = true;
    this.bar.replaceChildren();
  }
}
