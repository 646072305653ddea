/** Without case and what is neither letter nor digit, "left" and "right" at the end being as good as "l" and "r". */
function plainName(name: string): string {
  const plain = name.toLowerCase().replace(/[^a-z0-9]/g, "");
  return plain.replace(/^(.+)left$/, "$1l").replace(/^(.+)right$/, "$1r");
}

/**
 * Which of several things each name means, -1 where none. `things`: the names of each, those that count first in front.
 * A name is matched exactly if it can be, else by its plain form, as the command line tool does it.
 */
export function matchNames(names: readonly string[], things: readonly (readonly string[])[]): number[] {
  const exact = new Map<string, number>();
  const plain = new Map<string, number>();
  const most = Math.max(0, ...things.map((own) => own.length));
  for (let rank = 0; rank < most; ++rank)
    things.forEach((own, index) => {
      const name = own[rank];
      if (!name) return;
      if (!exact.has(name)) exact.set(name, index);
      const form = plainName(name);
      if (form !== "" && !plain.has(form)) plain.set(form, index);
    });
  return names.map((name) => exact.get(name) ?? plain.get(plainName(name)) ?? -1);
}
