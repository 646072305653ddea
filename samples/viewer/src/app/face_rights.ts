/** What the rights that an archive states come to on a day. The rule is TEXTS.md's, the words are those of `facebaker
 * inspect` (core/bake/rights): tests/fixtures/rights/cases.json holds both to the same. */
export interface FaceRights {
  expired: boolean;
  /** Clauses about what is not simply permitted, what ended first. */
  binding: string[];
}

type Permission = "unstated" | "allowed" | "constrained" | "not allowed"; // the later the stricter
const ORDER: Permission[] = ["unstated", "allowed", "constrained", "not allowed"];

const DAY = 86_400;
const YES_OR_NO = ["yes", "no"];
const PERMISSIONS = ["allowed", "notAllowed", "constrained"];
// IPTC's digital source types of 2024-10-23.
const SOURCE_TYPES = [
  "digitalCapture", "computationalCapture", "negativeFilm", "positiveFilm", "print", "minorHumanEdits", "humanEdits",
  "algorithmicallyEnhanced", "softwareImage", "digitalArt", "digitalCreation", "dataDrivenMedia", "trainedAlgorithmicMedia",
  "algorithmicMedia", "screenCapture", "virtualRecording", "composite", "compositeCapture", "compositeSynthetic",
  "compositeWithTrainedAlgorithmicMedia",
];
const TERMS: Record<string, string[] | undefined> = {
  suspendable: YES_OR_NO,
  digital_source_type: SOURCE_TYPES,
  ai_training: PERMISSIONS,
  ai_generative_training: PERMISSIONS,
  data_mining: PERMISSIONS,
};
const FIELDS = [
  "licence", "consent", "uses", "expires", "learning", "performer", "agreement", "territory", "suspendable", "consent_state",
  "recognisable", "digital_source_type", "ai_training", "ai_generative_training", "data_mining", "constraint_info",
] as const;
type Field = (typeof FIELDS)[number];

/** Of a text that is shown in one line. */
function shortened(text: string): string {
  return text.length <= 240 ? text : `${text.slice(0, 118)}...${text.slice(-118)}`;
}

function isTerm(field: Field, value: string): boolean {
  const terms = TERMS[field];
  if (!terms) return true;
  if (field !== "digital_source_type" || !/^https?:\/\//.test(value)) return terms.includes(value);
  const uri = /^https?:\/\/cv\.iptc\.org\/newscodes\/digitalsourcetype\/(.*)$/s.exec(value);
  return !uri || terms.includes(uri[1]!);
}

/** The fields that are there; clauses about what is not as it should be; null where nothing can be read. */
function read(about: string): { said: Partial<Record<Field, string>>; unread: string[] } | { unreadable: string } {
  let object: unknown;
  try {
    object = JSON.parse(about);
  } catch {
    object = null;
  }
  const isObject = (value: unknown): value is Record<string, unknown> =>
    typeof value === "object" && value !== null && !Array.isArray(value);
  if (!isObject(object)) return { unreadable: "what is said about the character is no JSON object" };
  const rights = object.rights ?? {};
  if (!isObject(rights))
    return { unreadable: `rights is no object, but ${shortened(typeof rights === "string" ? rights : JSON.stringify(rights))}` };
  const said: Partial<Record<Field, string>> = {};
  const unread: string[] = [];
  for (const field of FIELDS) {
    const given = rights[field];
    if (given === undefined || given === null) continue;
    const value = typeof given === "string" ? given : JSON.stringify(given);
    said[field] = value;
    if (typeof given !== "string") unread.push(`rights ${field} is no string, but ${shortened(value)}`);
    else if (value !== "" && !isTerm(field, value)) unread.push(`rights ${field} is "${shortened(value)}", which is none of its terms`);
  }
  return { said, unread };
}

/** Seconds since 1970 of the beginning of a day that the calendar has; NaN for other texts. */
function dayOf(text: string): number {
  const date = new Date(/^\d{4}-\d\d-\d\d$/.test(text) ? `${text}T00:00:00Z` : Number.NaN);
  return Number.isNaN(date.getTime()) || date.toISOString().slice(0, 10) !== text ? Number.NaN : date.getTime() / 1000;
}

/** The beginning of the last whole day, of UTC, of what lasts until then; NaN for what is no day and no time of one. */
function lastDayOf(text: string): number {
  const day = dayOf(text.slice(0, 10));
  if (text.length === 10) return day;
  const time = /^[Tt]([01]\d|2[0-3]):([0-5]\d):([0-5]\d|60)(?:\.\d+)?(?:[Zz]|([+-])([01]\d|2[0-3]):([0-5]\d))$/.exec(text.slice(10));
  if (!time) return Number.NaN;
  const [, hours, minutes, seconds, sign, ahead, aheadMinutes] = time;
  const offset = (sign === "-" ? -1 : 1) * (3600 * Number(ahead ?? 0) + 60 * Number(aheadMinutes ?? 0));
  const moment = day + 3600 * Number(hours) + 60 * Number(minutes) + Number(seconds) - offset;
  return DAY * (Math.floor((moment + 1) / DAY) - 1);
}

function stricter(...permissions: Permission[]): Permission {
  return ORDER[Math.max(...permissions.map((permission) => ORDER.indexOf(permission)))]!;
}

function learningOf({ learning }: Partial<Record<Field, string>>): Permission {
  if (!learning) return "unstated";
  if (learning === "allowed") return "allowed";
  const lower = learning.replace(/[A-Z]/g, (letter) => letter.toLowerCase());
  return lower === "forbidden" || lower === "notallowed" ? "not allowed" : "constrained";
}

/** Of a field of CAWG's terms: what is none of them is not allowed, nor what is constrained without a word on how. */
function permissionOf(value: string | undefined, info: string | undefined): Permission {
  if (!value) return "unstated";
  if (value === "allowed") return "allowed";
  return value === "constrained" && info ? "constrained" : "not allowed";
}

function permissionClause(what: string, permission: Permission, fields: Field[], said: Partial<Record<Field, string>>): string[] {
  if (permission !== "constrained" && permission !== "not allowed") return [];
  const info = said.constraint_info ? `, ${shortened(said.constraint_info)}` : ", without a word on how";
  const reasons = fields.flatMap((field) => {
    const value = said[field];
    return value && value !== "allowed" ? [`${field}: ${shortened(value)}${value === "constrained" ? info : ""}`] : [];
  });
  const why = reasons.length > 0 ? ` (${reasons.join("; ")})` : "";
  return [`${what} is ${permission === "constrained" ? "constrained" : "forbidden"}${why}`];
}

/** about: what the archive says about its character, a JSON object; "": nothing. on: a day of UTC, such as 2031-12-31. */
export function readRights(about: string, on: string): FaceRights {
  if (about === "") return { expired: false, binding: [] };
  const found = read(about);
  if ("unreadable" in found)
    return {
      expired: false,
      binding: [`${found.unreadable}; it is taken for the strictest`, "learning from it is forbidden", "mining it for data is forbidden"],
    };
  const { said, unread } = found;
  const binding: string[] = [];
  const last = lastDayOf(said.expires ?? "");
  const expired = dayOf(on) > last;
  const lastText = Number.isNaN(last) ? "" : new Date(1000 * last).toISOString().slice(0, 10);
  if (lastText) binding.push(`${expired ? "expired: the rights ended on" : "the rights end on"} ${lastText}`);
  else if (said.expires)
    binding.push(`the rights expire: "${shortened(said.expires)}", which is no date that can be checked (2031-12-31 is one)`);
  binding.push(...unread.map((clause) => `${clause}; it is taken for the strictest`));
  const info = said.constraint_info;
  const trainings: Field[] = ["learning", "ai_training", "ai_generative_training"];
  const learning = stricter(learningOf(said), permissionOf(said.ai_training, info), permissionOf(said.ai_generative_training, info));
  binding.push(...permissionClause("learning from it", learning, trainings, said));
  binding.push(...permissionClause("mining it for data", permissionOf(said.data_mining, info), ["data_mining"], said));
  if (said.uses) binding.push(`permitted uses: ${shortened(said.uses)}`);
  if (said.territory) binding.push(`territory: ${shortened(said.territory)}`);
  if (said.suspendable && said.suspendable !== "no")
    binding.push(
      `the consent can be suspended; ${said.consent_state ? `its state is asked at: ${shortened(said.consent_state)}` : "where its state is asked is not said"}`,
    );
  return { expired, binding };
}

/** Today, of UTC. */
export function today(): string {
  return new Date().toISOString().slice(0, 10);
}
