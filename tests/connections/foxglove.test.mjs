// Foxglove's own client beside the fixes in a file: node --test tests/connections/foxglove.test.mjs
// ROOMFIX is the program.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { listen } from './foxglove_client.mjs';

const require = createRequire(fileURLToPath(new URL('../../web/package.json', import.meta.url)));
const WebSocket = require('ws');

const program = process.env.ROOMFIX;
let folder;

before(() => {
  assert.ok(program, 'set ROOMFIX to the roomfix program');
  folder = mkdtempSync(join(tmpdir(), 'roomfix-test-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** The recorded drive of examples/labyrinth; gives the run and the port that its server has. */
async function run(t, name, outputs, ...options) {
  const session = join(folder, name);
  cpSync(fileURLToPath(new URL('../../examples/labyrinth', import.meta.url)), session, { recursive: true });
  const site = join(session, 'site.yaml');
  writeFileSync(site, readFileSync(site, 'utf8') + outputs);
  const fixes = join(session, 'fixes.jsonl');
  const process = spawn(program, ['run', site, '--no-page', '--fixes', fixes, ...options], { stdio: ['ignore', 'ignore', 'pipe'] });
  t.after(() => process.kill('SIGKILL'));
  const ended = new Promise((resolve) => process.on('exit', resolve));
  const port = await new Promise((resolve, reject) => {
    let said = '';
    process.stderr.on('data', (text) => {
      said += text;
      const found = said.match(/Foxglove at port (\d+)/);
      if (found) resolve(Number(found[1]));
    });
    process.on('exit', () => reject(new Error(`the run ended: ${said}`)));
  });
  return { process, port, ended, fixes: () => readFileSync(fixes, 'utf8').trim().split('\n').map((line) => JSON.parse(line)) };
}

async function until(holds, what) {
  for (let i = 0; i < 1500; ++i) {
    if (holds()) return;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  assert.fail(`waited in vain until ${what}`);
}

test('poses, map and transforms come as they are in the file', async (t) => {
  const running = await run(t, 'poses', 'outputs: {foxglove: {port: 0}}\nzones: {start: [[0, 0], [1, 0], [1, 1]]}\n', '--speed', '4');
  const { client, info, channels, messages } = await listen(`ws://127.0.0.1:${running.port}`);
  assert.equal(info.name, 'labyrinth');
  await until(() => messages.filter((m) => m.topic === '/r/pose').length > 20, 'poses come');
  assert.equal(channels.get('/r/pose').schemaName, 'foxglove.PoseInFrame');
  for (const channel of channels.values()) assert.equal(JSON.parse(channel.schema).type, 'object');
  const map = messages.find((m) => m.topic === '/map').data.entities[0];
  assert.equal(map.texts.filter((text) => text.text.startsWith('b10')).length, 4);
  assert.equal(map.lines.at(-1).points.length, 3);
  const robots = messages.filter((m) => m.topic === '/robots').at(-1).data;
  assert.equal(robots.entities[0].id, 'r');
  assert.equal(robots.entities[0].cylinders.length, 1);
  client.close();
  await running.ended;
  const fixes = running.fixes().filter((fix) => fix.status !== 'none');
  const poses = messages.filter((m) => m.topic === '/r/pose');
  for (const { data, time } of poses) {
    const at = Number(BigInt(data.timestamp.sec) * 1000000000n + BigInt(data.timestamp.nsec));
    assert.equal(Number(time), at);
    const yaw = 2 * Math.atan2(data.pose.orientation.z, data.pose.orientation.w);
    const same = (f) =>
      Math.abs(f.time * 1e9 - at) < 1000 && Math.hypot(data.pose.position.x - f.x, data.pose.position.y - f.y) < 3e-6 && Math.abs(Math.sin(yaw - (f.yaw ?? 0))) < 3e-6;
    assert.ok(fixes.some(same), `there is this fix at ${at}`); // there may be several of one time
  }
});

test('a client that says nonsense is told so, and others do not notice', async (t) => {
  const running = await run(t, 'nonsense', 'outputs: {foxglove: {port: 0}}\n', '--speed', '2');
  const address = `ws://127.0.0.1:${running.port}`;
  const good = await listen(address);
  const bad = new WebSocket(address, ['foxglove.websocket.v1']);
  const answers = [];
  bad.on('message', (data, binary) => !binary && answers.push(JSON.parse(data.toString())));
  await new Promise((resolve) => bad.on('open', resolve));
  const nonsense = ['', '[]', '{', '{"op": 5}', '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1},{"id":1,"channelId":999},7]}', '{"op":"subscribe","subscriptions":5}',
                    '{"op":"unsubscribe","subscriptionIds":{"a":1}}', '{"op":"publish"}'];
  for (const text of nonsense) bad.send(text);
  bad.send(Buffer.from([1, 2, 3]));
  await until(() => answers.filter((a) => a.op === 'status' && a.level === 2).length >= 7, 'the server complains');
  const flood = new WebSocket(address, ['foxglove.websocket.v1']);
  await new Promise((resolve) => flood.on('open', resolve));
  flood.on('error', () => {});
  const closed = new Promise((resolve) => flood.on('close', resolve));
  flood.send('x'.repeat(100000));
  await closed;
  const before = good.messages.length;
  await until(() => good.messages.length > before + 5, 'the good client gets more');
  good.client.close();
  bad.close();
});

test('who has no token is not let in', async (t) => {
  writeFileSync(join(folder, 'token'), 'open sesame\n');
  const running = await run(t, 'guarded', `outputs: {foxglove: {port: 0, token: {file: ${join(folder, 'token')}}}}\n`, '--speed', '2');
  const address = `ws://127.0.0.1:${running.port}`;
  await assert.rejects(listen(address));
  await assert.rejects(listen(`${address}/?token=open`));
  const { client, info } = await listen(`${address}/?token=open%20sesame`);
  assert.equal(info.name, 'labyrinth');
  client.close();
});
