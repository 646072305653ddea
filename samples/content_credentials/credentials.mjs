// Content credentials (C2PA) of a face, in a file beside it: no byte of the archive changes.
//   node credentials.mjs sign FACE.fbk --key KEY.pem --certificate CHAIN.pem [--out FACE.fbk.c2pa]
//   node credentials.mjs verify FACE.fbk --trust ROOT.pem [--manifest FACE.fbk.c2pa]
// The tool `facebaker` is found by PATH, or where FACEBAKER says. Nothing is fetched: there is no time stamp of an authority.

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { Builder, LocalSigner, Reader } from '@contentauth/c2pa-node';

import { assertionsOf } from './rights_assertions.mjs';

const MEDIA_TYPE = 'application/x-facebaker';
const TOOL = process.env.FACEBAKER ?? 'facebaker';

function facebaker(...command) {
  return execFileSync(TOOL, command, { encoding: 'utf8', maxBuffer: 1 << 28 });
}

function sign(face, options) {
  facebaker('verify', face); // what is damaged is not vouched for
  const { name, about = {} } = JSON.parse(facebaker('inspect', '--json', face));
  const builder = Builder.withJson({
    claim_generator_info: [{ name: 'FaceBaker', version: facebaker('--version').trim().split(' ').pop() }],
    title: about.name ?? name,
    format: MEDIA_TYPE,
    assertions: assertionsOf(about.rights ?? {}),
  });
  builder.setNoEmbed(true);
  const signer = LocalSigner.newSigner(readFileSync(options.certificate), readFileSync(options.key), 'es256');
  const manifest = builder.sign(signer, { buffer: readFileSync(face), mimeType: MEDIA_TYPE }, { buffer: null });
  const out = options.out ?? face + '.c2pa';
  writeFileSync(out, manifest, { flag: 'wx' });
  console.log(`${out}: credentials of ${face}, ${manifest.length} bytes`);
}

/** What is wrong by C2PA's codes, a line each; empty if bytes and signature are right and the signer is trusted. */
function failuresOf(store) {
  const failures = store.validation_results?.activeManifest?.failure ?? [];
  const lines = failures.map((one) => `${one.code}: ${one.explanation}`);
  if (lines.length === 0 && store.validation_state !== 'Trusted') lines.push(`the state is ${store.validation_state}, not Trusted`);
  return lines;
}

async function verify(face, options) {
  const settings = {
    trust: { trust_anchors: readFileSync(options.trust, 'utf8') },
    verify: { verify_trust: true, remote_manifest_fetch: false },
  };
  const asset = { buffer: readFileSync(face), mimeType: MEDIA_TYPE };
  const path = options.manifest ?? face + '.c2pa';
  const manifestData = readFileSync(path);
  const reader = await Reader.fromManifestDataAndAsset(manifestData, asset, settings).catch((error) => {
    throw new Error(`${path}: no credentials that can be read: ${error.message}`);
  });
  const store = reader.json();
  const failures = failuresOf(store);
  if (failures.length > 0) throw new Error(`${face}: its credentials do not hold\n  ${failures.join('\n  ')}`);
  const manifest = store.manifests[store.active_manifest];
  console.log(`${face}: as it was signed by ${manifest.signature_info.common_name} (${manifest.signature_info.issuer})`);
  for (const assertion of manifest.assertions) {
    for (const action of assertion.data.actions ?? []) console.log(`  ${action.action}: ${action.digitalSourceType}`);
    for (const [name, entry] of Object.entries(assertion.data.entries ?? {}))
      console.log(`  ${name}: ${entry.use}${entry.constraint_info ? `, ${entry.constraint_info}` : ''}`);
  }
}

async function main() {
  const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: Object.fromEntries(['key', 'certificate', 'out', 'trust', 'manifest'].map((name) => [name, { type: 'string' }])),
  });
  const [command, face] = positionals;
  const needed = { sign: ['key', 'certificate'], verify: ['trust'] }[command];
  if (!needed || positionals.length !== 2) throw new Error('usage: credentials.mjs sign|verify FACE.fbk [options]');
  for (const name of needed) if (!values[name]) throw new Error(`${command} needs --${name}`);
  await { sign, verify }[command](face, values);
}

main().catch((error) => {
  console.error(error.message);
  process.exitCode = 1;
});
