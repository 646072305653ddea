import { byId, element } from "./dom";

const SECONDS = 8;

/** Says something over the picture: an error stays until it is closed. Returns the message. */
export function tell(text: string, kind: "note" | "error" = "note"): HTMLElement {
  const list = byId("messages");
  const close = element("button", { type: "button", class: "plain", "aria-label": "Close this message" }, "×");
  const message = element("div", { class: kind, role: kind === "error" ? "alert" : "status" }, element("span", {}, text), close);
  close.addEventListener("click", () => message.remove());
  if (kind === "note") setTimeout(() => message.remove(), SECONDS * 1000);
  list.append(message);
  while (list.children.length > 4) list.firstElementChild?.remove();
  return message;
}

/** Runs something and says what went wrong with it. */
export async function telling(work: () => unknown): Promise<void> {
  try {
    await work();
  } catch (error) {
    tell(error instanceof Error ? error.message : String(error), "error");
  }
}
