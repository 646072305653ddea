import assert from 'node:assert/strict';
import test from 'node:test';

import { assertionsOf, digitalSourceType, trainingEntries } from './rights_assertions.mjs';

const uses = (rights) => Object.fromEntries(Object.entries(trainingEntries(rights)).map(([name, entry]) => [name, entry.use]));

test('a source type is a bare term or its address', () => {
  const address = 'http://cv.iptc.org/newscodes/digitalsourcetype/digitalCapture';
  assert.equal(digitalSourceType({ digital_source_type: 'digitalCapture' }), address);
  assert.equal(digitalSourceType({ digital_source_type: address }), address);
  assert.equal(digitalSourceType({ digital_source_type: address.replace('http', 'https') }), address);
  assert.equal(digitalSourceType({ digital_source_type: 'https://example.org/scanned' }), 'https://example.org/scanned');
  assert.throws(() => digitalSourceType({}), /digital_source_type/);
  assert.throws(() => digitalSourceType({ digital_source_type: 'a photo of somebody' }), /a photo of somebody/);
});

test('of learning and the other fields the stricter holds', () => {
  const forbidden = { 'cawg.ai_training': 'notAllowed', 'cawg.ai_generative_training': 'notAllowed' };
  assert.deepEqual(uses({ learning: 'forbidden', ai_training: 'allowed', ai_generative_training: 'allowed' }), forbidden);
  assert.deepEqual(uses({ learning: 'allowed', ai_training: 'notAllowed' }),
    { 'cawg.ai_training': 'notAllowed', 'cawg.ai_generative_training': 'allowed' });
  assert.deepEqual(uses({ data_mining: 'allowed' }), { 'cawg.data_mining': 'allowed' });
  assert.deepEqual(uses({}), {});
  assert.throws(() => uses({ ai_training: 'perhaps' }), /ai_training is 'perhaps'/);
});

test('constraints are given with their words', () => {
  assert.deepEqual(trainingEntries({ learning: 'for lip sync alone' })['cawg.ai_training'],
    { use: 'constrained', constraint_info: 'for lip sync alone' });
  assert.deepEqual(trainingEntries({ data_mining: 'constrained', constraint_info: 'counts' })['cawg.data_mining'],
    { use: 'constrained', constraint_info: 'counts' });
  assert.deepEqual(uses({ data_mining: 'constrained' }), { 'cawg.data_mining': 'notAllowed' });
});

test('rights that say nothing of training make no assertion of it', () => {
  const labels = assertionsOf({ digital_source_type: 'digitalCreation' }).map((one) => one.label);
  assert.deepEqual(labels, ['c2pa.actions.v2']);
});
