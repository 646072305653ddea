// What the rights of a face (`rights` of its `about`) say in the terms of C2PA: the digital source type of IPTC, and what may be
// learned or mined, as CAWG's training and data mining assertion has it.

const SOURCE_TYPES = 'http://cv.iptc.org/newscodes/digitalsourcetype/';
const USES = ['allowed', 'notAllowed', 'constrained'];

/** The digital source type as an address; rights may have IPTC's bare term, such as digitalCapture, or any address. */
export function digitalSourceType(rights) {
  const type = rights.digital_source_type;
  if (!type) throw new Error("the face's rights have no digital_source_type, such as digitalCapture or digitalCreation");
  if (/^[A-Za-z]+$/.test(type)) return SOURCE_TYPES + type;
  if (!URL.canParse(type)) throw new Error(`digital_source_type is '${type}', expected a term of IPTC or an address`);
  return type.replace('https://cv.iptc.org/', 'http://cv.iptc.org/'); // the vocabulary is named with http
}

/** Of two uses the stricter; undefined is no word on it. */
function stricter(a, b) {
  const order = [undefined, 'allowed', 'constrained', 'notAllowed'];
  return order[Math.max(order.indexOf(a), order.indexOf(b))];
}

function useOf(rights, field) {
  const use = rights[field];
  if (use === 'constrained' && !rights.constraint_info) return 'notAllowed'; // as CAWG has it
  if (use !== undefined && !USES.includes(use)) throw new Error(`${field} is '${use}', expected one of ${USES.join(', ')}`);
  return use;
}

/** What `learning` says in CAWG's terms: it may have words instead of allowed or forbidden, and binds with them. */
function useOfLearning(learning) {
  if (learning === undefined) return undefined;
  if (/^(forbidden|notallowed)$/i.test(learning)) return 'notAllowed';
  return learning === 'allowed' ? 'allowed' : 'constrained';
}

/** Entries of cawg.training-mining. Where `learning` and others disagree the stricter holds. */
export function trainingEntries(rights) {
  const learning = useOfLearning(rights.learning);
  const uses = {
    'cawg.data_mining': useOf(rights, 'data_mining'),
    'cawg.ai_training': stricter(useOf(rights, 'ai_training'), learning),
    'cawg.ai_generative_training': stricter(useOf(rights, 'ai_generative_training'), learning),
  };
  const words = rights.constraint_info ?? (learning === 'constrained' ? rights.learning : undefined);
  const entries = {};
  for (const [name, use] of Object.entries(uses)) {
    if (use === undefined) continue;
    entries[name] = use === 'constrained' && words ? { use, constraint_info: words } : { use };
  }
  return entries;
}

/** All assertions for a face with these rights. */
export function assertionsOf(rights) {
  const created = { action: 'c2pa.created', digitalSourceType: digitalSourceType(rights) };
  const assertions = [{ label: 'c2pa.actions.v2', data: { actions: [created] } }];
  const entries = trainingEntries(rights);
  if (Object.keys(entries).length > 0) assertions.push({ label: 'cawg.training-mining', data: { entries } });
  return assertions;
}
