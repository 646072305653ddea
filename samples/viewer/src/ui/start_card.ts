import { element } from "./dom";
import { bytesText } from "./number_text";

/** What stands where the picture is not. */
interface Card {
  heading: string;
  /** What is wrong, or what to do; the first is told at once where `alert`. */
  words: (string | HTMLElement)[];
  alert?: boolean;
  button?: { label: string; action: () => void };
}

function elementsOf({ heading, words, alert, button }: Card): HTMLElement[] {
  const made: HTMLElement[] = [
    element("h2", {}, heading),
    ...words.map((text, i) => element("p", { role: alert && i === 0 ? "alert" : undefined }, text)),
  ];
  if (button) {
    const pressed = element("button", { type: "button", class: "primary" }, button.label);
    pressed.addEventListener("click", button.action);
    made.push(pressed);
  }
  return made;
}

/** The card in the middle of the picture, there while there is no picture: says what happens, or what to do. */
export class StartCard {
  readonly #title = element("p", { class: "title", role: "status" });
  readonly #amount = element("p");
  readonly #bar = element("progress", { max: 1, "aria-label": "Loading" });
  #shown: HTMLElement[] = [];
  #lost: HTMLElement[] | null = null; // in place of the above

  constructor(
    readonly place: HTMLElement,
    readonly open: () => void,
  ) {}

  hide(): void {
    this.#put([]);
  }

  loading(name: string): void {
    this.#title.textContent = `Loading ${name}…`;
    this.#amount.textContent = "";
    this.#bar.value = 0;
    this.#put([this.#title, this.#amount, this.#bar]);
  }

  /** How much of what is loading is there, in bytes; nothing where something else is said now. */
  progress(name: string, loaded: number, total: number): void {
    if (this.#shown[0] !== this.#title) return;
    const title = `Loading ${name}…`;
    if (this.#title.textContent !== title) this.#title.textContent = title;
    this.#amount.textContent = `${bytesText(loaded)} of ${bytesText(total)}`;
    this.#bar.value = loaded / Math.max(total, 1);
  }

  welcome(): void {
    this.#putCard({
      heading: "Drop a face here",
      words: [
        element("span", {}, "An archive that ", element("code", {}, "facebaker bake"), " wrote (.fbk). It stays on this machine."),
      ],
      button: { label: "Open a file…", action: this.open },
    });
  }

  /** A face could not be loaded, and there is no other. */
  refused(reason: string): void {
    this.#putCard({
      heading: "This face cannot be shown",
      words: [reason, "Open another file, or drop one here."],
      alert: true,
      button: { label: "Open a file…", action: this.open },
    });
  }

  noWebGl(): void {
    this.#putCard({
      heading: "There is no WebGL 2 here",
      words: [
        "It draws the picture, and this browser does not have it, or has it switched off.",
        "Turn on hardware acceleration in the browser's settings, or open this page in another browser.",
      ],
      alert: true,
    });
  }

  /** The browser has lost the graphics card, or has it again. `reload` opens the page as it is now. */
  setLost(lost: boolean, reload: () => void): void {
    this.#lost = lost
      ? elementsOf({
          heading: "The picture is gone for now",
          words: [
            "The browser has lost the graphics card. The pose is kept.",
            "The picture comes back as soon as the browser has the card again. If it does not, reload the page.",
          ],
          alert: true,
          button: { label: "Reload with this pose", action: reload },
        })
      : null;
    this.#show();
  }

  #putCard(card: Card): void {
    this.#put(elementsOf(card));
  }

  #put(elements: HTMLElement[]): void {
    this.#shown = elements;
    this.#show();
  }

  #show(): void {
    const shown = this.#lost ?? this.#shown;
    this.place.hidden = shown.length === 0;
    this.place.replaceChildren(...shown);
  }
}
