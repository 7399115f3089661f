// `roomfix export` read back by others' readers: node --test tests/export/export.test.mjs
// ROOMFIX is the program. The files' structure, checksums and index by @mcap/core, the messages by @foxglove/rosmsg2-serialization, which knows them only
// by the definitions in the file.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

const require = createRequire(fileURLToPath(new URL('../../web/package.json', import.meta.url)));
const { McapIndexedReader, McapStreamReader } = require('@mcap/core');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');
const { crc32 } = require('@foxglove/crc');

const program = process.env.ROOMFIX;
const examples = fileURLToPath(new URL('../../examples', import.meta.url));
let folder;

function call(...parameters) {
  const ended = spawnSync(program, parameters, { encoding: 'utf8' });
  return { code: ended.status, text: ended.stdout + ended.stderr };
}

function succeed(...parameters) {
  const outcome = call(...parameters);
  assert.equal(outcome.code, 0, outcome.text);
  return outcome.text;
}

before(() => {
  assert.ok(program, 'set ROOMFIX to the roomfix program');
  folder = mkdtempSync(join(tmpdir(), 'roomfix-export-'));
  cpSync(join(examples, 'labyrinth'), join(folder, 'drive'), { recursive: true });  // wheels and ranges
  succeed('simulate', 'li2014', '--duration', '0.3', '-o', join(folder, 'hall'));   // three cameras
  for (const session of ['drive', 'hall']) succeed('replay', join(folder, session), '--fixes', join(folder, session, 'fixes.jsonl'));
  succeed('export', join(folder, 'drive'), '--mcap', join(folder, 'drive.mcap'));
});

after(() => rmSync(folder, { recursive: true, force: true }));

/** Decimal seconds as nanoseconds, without loss. */
function nanoseconds(text) {
  const [whole, part = ''] = text.split('.');
  return BigInt(whole + part.padEnd(9, '0').slice(0, 9));
}

function csv(file) {
  const [names, ...lines] = readFileSync(file, 'utf8').trim().split('\n').map((line) => line.trim().split(','));
  return lines.map((fields) => Object.fromEntries(names.map((name, i) => [name, fields[i]])));
}

function fixesOf(session) {
  return readFileSync(join(folder, session, 'fixes.jsonl'), 'utf8').trim().split('\n').map((line) => {
    return { ...JSON.parse(line), stamp: nanoseconds(line.match(/"time": ([\d.]+)/)[1]) };
  }).filter((fix) => fix.status !== 'none');
}

const stampOf = (header) => BigInt(header.stamp.sec) * 1000000000n + BigInt(header.stamp.nanosec ?? header.stamp.nsec);
const yawOf = (q) => 2 * Math.atan2(q.z, q.w);
const near = (a, b, what) => assert.ok(Math.abs(a - b) < 1e-9, `${what}: ${a} is not ${b}`);

/** Every record from the beginning to the end; a wrong checksum of a chunk or an attachment throws. */
function readThrough(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true, includeChunks: true });
  reader.append(bytes);
  const records = [];
  for (let record; (record = reader.nextRecord());) records.push(record);
  assert.ok(reader.done(), 'the file ends before its end');
  return records;
}

/** By its index; a wrong checksum of the summary throws. Messages are decoded by the definitions in the file. */
async function readByIndex(bytes) {
  const readable = { size: async () => BigInt(bytes.length), read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)) };
  const reader = await McapIndexedReader.Initialize({ readable });
  const decoders = new Map();
  for (const [id, schema] of reader.schemasById) {
    assert.equal(schema.encoding, 'ros2msg');
    decoders.set(id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  const topics = {};
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    assert.equal(channel.messageEncoding, 'cdr');
    assert.match(channel.metadata.get('offered_qos_profiles'), /reliability: 1/);
    const topic = (topics[channel.topic] ??= { type: reader.schemasById.get(channel.schemaId).name, messages: [] });
    assert.equal(message.sequence, topic.messages.length);
    assert.equal(message.publishTime, message.logTime);
    assert.ok(message.logTime >= last, 'messages are in the order of their times');
    last = message.logTime;
    topic.messages.push({ time: message.logTime, value: decoders.get(channel.schemaId).readMessage(message.data) });
  }
  const attachments = [];
  for await (const attachment of reader.readAttachments({ validateCrcs: true })) attachments.push(attachment);
  return { reader, topics, attachments };
}

function checkStructure(bytes, { reader, topics }) {
  const records = readThrough(bytes);
  const of = (type) => records.filter((record) => record.type === type);
  assert.equal(of('Header')[0].profile, 'ros2');
  const [dataEnd] = of('DataEnd'), [footer] = of('Footer'), [statistics] = of('Statistics');
  assert.notEqual(dataEnd.dataSectionCrc, 0);
  assert.equal(dataEnd.dataSectionCrc, crc32(bytes.subarray(0, Number(footer.summaryStart) - 13)), 'checksum of the data');
  assert.notEqual(footer.summaryCrc, 0);
  assert.ok(of('Chunk').every((chunk) => chunk.uncompressedCrc !== 0));
  const counts = Object.values(topics).map((topic) => topic.messages.length);
  const messages = counts.reduce((a, b) => a + b, 0);
  assert.equal(of('Message').length, messages);
  assert.equal(Number(statistics.messageCount), messages);
  assert.equal(statistics.channelCount, counts.length);
  assert.equal(statistics.schemaCount, reader.schemasById.size);
  assert.equal(statistics.chunkCount, of('Chunk').length);
  assert.equal(of('ChunkIndex').length, of('Chunk').length);
  assert.equal(statistics.attachmentCount, 1);
  const times = Object.values(topics).flatMap((topic) => topic.messages.map((m) => m.time));
  assert.equal(statistics.messageStartTime, times.reduce((a, b) => (b < a ? b : a)));
  assert.equal(statistics.messageEndTime, times.reduce((a, b) => (b > a ? b : a)));
  for (const [id, channel] of reader.channelsById) {
    assert.equal(Number(statistics.channelMessageCounts.get(id)), topics[channel.topic].messages.length, channel.topic);
  }
  const offsets = of('SummaryOffset').map((record) => record.groupOpcode).sort((a, b) => a - b);
  assert.deepEqual(offsets, [3, 4, 8, 10, 11]);
}

/** Of a fix of a robot whose yaw is known. */
function checkPose({ time, value }, fix) {
  assert.equal(time, fix.stamp);
  assert.equal(stampOf(value.header), fix.stamp);
  assert.equal(value.header.frame_id, 'map');
  const { position, orientation } = value.pose.pose;
  assert.deepEqual([position.x, position.y, position.z], [fix.x, fix.y, 0]);
  const covariance = [...value.pose.covariance];
  assert.ok(covariance.every(Number.isFinite));
  for (let i = 0; i < 6; ++i) assert.ok(covariance[7 * i] > 0, 'no variance is 0');
  const axes = fix.yaw === null ? [0, 1] : [0, 1, 5];
  for (const [i, a] of axes.entries()) for (const [j, b] of axes.entries()) assert.equal(covariance[6 * a + b], fix.covariance[3 * i + j]);
  near(yawOf(orientation), fix.yaw ?? 0, 'yaw');
  if (fix.yaw === null) near(covariance[35], Math.PI ** 2 / 3, 'variance of a yaw that nobody knows');
}

function transformsOf(topics, parent, child) {
  return topics['/tf'].messages.map((m) => m.value.transforms[0]).filter((t) => t.header.frame_id === parent && t.child_frame_id === child);
}

test('a drive with wheels comes back whole', async () => {
  const bytes = readFileSync(join(folder, 'drive.mcap'));
  const read = await readByIndex(bytes);
  checkStructure(bytes, read);
  const { topics, attachments } = read;
  assert.ok(read.reader.chunkIndexes.length > 1, 'several chunks');
  assert.equal(attachments[0].name, 'site.yaml');
  assert.deepEqual(Buffer.from(attachments[0].data), readFileSync(join(folder, 'drive', 'site.yaml')));
  assert.deepEqual(Object.keys(topics).sort(), ['/r/odom', '/r/odometry', '/r/pose', '/r/truth', '/tf']);

  const fixes = fixesOf('drive');
  assert.equal(topics['/r/pose'].type, 'geometry_msgs/msg/PoseWithCovarianceStamped');
  assert.equal(topics['/r/pose'].messages.length, fixes.length);
  fixes.forEach((fix, i) => checkPose(topics['/r/pose'].messages[i], fix));

  const moving = fixes.filter((fix) => fix.velocity && fix.yaw !== null);
  assert.ok(moving.length > 0.5 * fixes.length, `${moving.length} of ${fixes.length} fixes have a velocity`);
  assert.equal(topics['/r/odometry'].messages.length, moving.length);
  moving.forEach((fix, i) => {
    const { value } = topics['/r/odometry'].messages[i], { linear, angular } = value.twist.twist;
    assert.deepEqual([value.header.frame_id, value.child_frame_id], ['map', 'base_link']);
    near(Math.sin(yawOf(value.pose.pose.orientation) - fix.yaw), 0, 'yaw');
    near(Math.cos(fix.yaw) * linear.x - Math.sin(fix.yaw) * linear.y, fix.velocity[0], 'velocity in x');
    near(Math.sin(fix.yaw) * linear.x + Math.cos(fix.yaw) * linear.y, fix.velocity[1], 'velocity in y');
    near(angular.z, fix.velocity[2], 'turning');
    for (let k = 0; k < 6; ++k) assert.ok(value.twist.covariance[7 * k] > 0);
  });

  const odometry = csv(join(folder, 'drive', 'odometry.csv'));
  assert.equal(topics['/r/odom'].type, 'nav_msgs/msg/Odometry');
  assert.equal(topics['/r/odom'].messages.length, odometry.length);
  odometry.forEach((line, i) => {
    const { value } = topics['/r/odom'].messages[i];
    assert.equal(stampOf(value.header), nanoseconds(line.time));
    assert.deepEqual([value.header.frame_id, value.child_frame_id], ['odom', 'base_link']);
    assert.equal(value.pose.pose.position.x, Number(line.x));
    near(Math.sin(yawOf(value.pose.pose.orientation) - Number(line.yaw)), 0, 'yaw');
    for (let k = 0; k < 6; ++k) assert.ok(value.pose.covariance[7 * k] > 0 && value.twist.covariance[7 * k] > 0);
  });

  const truth = csv(join(folder, 'drive', 'truth.csv'));  // has no yaw
  assert.equal(topics['/r/truth'].messages.length, truth.length);
  truth.forEach((line, i) => {
    assert.equal(topics['/r/truth'].messages[i].value.pose.pose.position.y, Number(line.y));
    near(topics['/r/truth'].messages[i].value.pose.covariance[35], Math.PI ** 2 / 3, 'variance of a yaw that nobody knows');
  });
});

test('map -> odom and odom -> base_link make a pose of a fix again', async () => {
  const { topics } = await readByIndex(readFileSync(join(folder, 'drive.mcap')));
  assert.equal(topics['/tf'].type, 'tf2_msgs/msg/TFMessage');
  const corrections = transformsOf(topics, 'map', 'odom'), wheels = transformsOf(topics, 'odom', 'base_link');
  const fixes = new Map(fixesOf('drive').filter((fix) => fix.yaw !== null).map((fix) => [fix.stamp, fix]));
  assert.equal(corrections.length, fixes.size);  // one at a time: tf2 takes no second one
  assert.equal(transformsOf(topics, 'map', 'r/base_link').length, 0);  // base_link has one parent only
  const moved = new Map(wheels.map((t) => [stampOf(t.header), t.transform]));
  let compared = 0;
  for (const { header, transform } of corrections) {
    const wheel = moved.get(stampOf(header)), fix = fixes.get(stampOf(header));
    assert.ok(fix);
    if (!wheel) continue;
    const yaw = yawOf(transform.rotation), { x, y } = wheel.translation;
    near(transform.translation.x + Math.cos(yaw) * x - Math.sin(yaw) * y, fix.x, 'x');
    near(transform.translation.y + Math.sin(yaw) * x + Math.cos(yaw) * y, fix.y, 'y');
    near(Math.sin(yaw + yawOf(wheel.rotation) - fix.yaw), 0, 'yaw');
    ++compared;
  }
  assert.ok(compared > 100, `${compared} compared`);
});

test('pictures are the bytes of their files, in a rosbag2 folder', async () => {
  const bag = join(folder, 'hall-bag');
  succeed('export', join(folder, 'hall'), '--bag', bag);
  assert.deepEqual(readdirSync(bag).sort(), ['hall-bag_0.mcap', 'metadata.yaml']);
  const bytes = readFileSync(join(bag, 'hall-bag_0.mcap'));
  const read = await readByIndex(bytes);
  checkStructure(bytes, read);
  const { topics } = read;
  for (const camera of ['hall1', 'hall2', 'hall3']) {
    const files = readdirSync(join(folder, 'hall', 'frames', camera)).sort();
    const pictures = topics[`/${camera}/image/compressed`], infos = topics[`/${camera}/camera_info`];
    assert.equal(pictures.type, 'sensor_msgs/msg/CompressedImage');
    assert.equal(pictures.messages.length, files.length);
    files.forEach((name, i) => {
      const { value } = pictures.messages[i];
      assert.equal(stampOf(value.header), BigInt(basename(name, '.jpg')));
      assert.equal(value.format, 'jpeg');
      assert.deepEqual(Buffer.from(value.data), readFileSync(join(folder, 'hall', 'frames', camera, name)));
      assert.equal(infos.messages[i].value.header.frame_id, value.header.frame_id);
      assert.equal(stampOf(infos.messages[i].value.header), stampOf(value.header));
    });
  }
  const info = topics['/hall1/camera_info'].messages[0].value;
  assert.deepEqual([info.width, info.height, info.distortion_model], [640, 480, 'plumb_bob']);
  assert.deepEqual([...info.k], [518.38, 0, 318, 0, 518.07, 239.5, 0, 0, 1]);
  assert.deepEqual([...info.d], [0.0895, -0.7064, -0.0034, 0.002, 1.3227]);
  assert.deepEqual([...info.p], [518.38, 0, 318, 0, 0, 518.07, 239.5, 0, 0, 0, 1, 0]);
  assert.equal(info.roi.do_rectify, false);

  const read_yaml = 'import json, sys, yaml; print(json.dumps(yaml.safe_load(open(sys.argv[1]))))';
  const yaml = spawnSync('/usr/bin/python3', ['-c', read_yaml, join(bag, 'metadata.yaml')], { encoding: 'utf8' });
  assert.equal(yaml.status, 0, yaml.stderr);
  const metadata = JSON.parse(yaml.stdout).rosbag2_bagfile_information;
  assert.equal(metadata.version, 4);
  assert.equal(metadata.storage_identifier, 'mcap');
  assert.deepEqual(metadata.relative_file_paths, ['hall-bag_0.mcap']);
  assert.equal(BigInt(metadata.starting_time.nanoseconds_since_epoch), read.reader.statistics.messageStartTime);
  assert.equal(BigInt(metadata.duration.nanoseconds), read.reader.statistics.messageEndTime - read.reader.statistics.messageStartTime);
  assert.equal(BigInt(metadata.message_count), read.reader.statistics.messageCount);
  for (const { topic_metadata: topic, message_count: count } of metadata.topics_with_message_count) {
    assert.deepEqual([topic.type, count], [topics[topic.name].type, topics[topic.name].messages.length]);
    assert.equal(topic.serialization_format, 'cdr');
    assert.match(topic.offered_qos_profiles, /^- history: 1\n  depth: 10\n/);
  }
  assert.equal(metadata.topics_with_message_count.length, Object.keys(topics).length);
});

test('a robot without odometry is in the map itself; ids become words of ROS', async () => {
  const session = join(folder, 'bare');
  mkdirSync(session);
  writeFileSync(join(session, 'site.yaml'), `roomfix: 1
site: {name: bare}
robots:
  2-fast: {shape: box, size: [0.5, 0.5, 0.5]}
  a-b: {shape: box, size: [0.5, 0.5, 0.5]}
  a_b: {shape: box, size: [0.5, 0.5, 0.5]}
`);
  const usual = { status: 'ok', x: 1.5, y: -2.25, yaw: 3, covariance: [0.01, 0.001, 0, 0.001, 0.02, 0, 0, 0, 0.03], sources: [] };
  const fix = (time, robot, more) => JSON.stringify({ time, robot, ...usual, ...more });
  const lines = [fix(1, '2-fast'), fix(1.5, 'a-b', { yaw: null }), fix(2, 'a_b'), fix(2.5, 'a_b', { covariance: [1, 2, 0, 2, 1, 0, 0, 0, 1] }),
                 fix(3, 'a_b', { covariance: Array(9).fill(0) }), fix(-4, 'a_b'), fix(3e9, 'a_b'),
                 '{"time": 5, "robot": "a-b", "status": "none", "reason": "lost"}', 'no JSON'];
  writeFileSync(join(folder, 'bare.jsonl'), lines.join('\n') + '\n');
  const said = succeed('export', session, '--fixes', join(folder, 'bare.jsonl'), '--mcap', join(folder, 'bare.mcap'));
  assert.match(said, /2 fixes have no covariance that can be one/);
  assert.match(said, /records are before 1970 or after 2038/);
  assert.match(said, /line 9/);
  const { topics } = await readByIndex(readFileSync(join(folder, 'bare.mcap')));
  assert.deepEqual(Object.keys(topics).sort(), ['/a_b/pose', '/a_b_2/pose', '/id_2_fast/pose', '/tf']);
  const read = lines.slice(0, 3).map((line) => ({ ...JSON.parse(line), stamp: nanoseconds(String(JSON.parse(line).time)) }));
  ['/id_2_fast/pose', '/a_b/pose', '/a_b_2/pose'].forEach((topic, i) => {
    assert.equal(topics[topic].messages.length, 1);
    checkPose(topics[topic].messages[0], read[i]);
  });
  const [{ transform }] = transformsOf(topics, 'map', 'id_2_fast/base_link');
  assert.deepEqual([transform.translation.x, transform.translation.y], [1.5, -2.25]);
  near(yawOf(transform.rotation), 3, 'yaw');
  assert.equal(topics['/tf'].messages.length, 2);  // nobody knows where the front of a-b is
});

test('what cannot be exported is said, with what to do', () => {
  const drive = join(folder, 'drive');
  const says = (code, words, ...parameters) => {
    const outcome = call('export', ...parameters);
    assert.equal(outcome.code, code, outcome.text);
    assert.match(outcome.text, words);
  };
  says(2, /cannot be read as a site file/, join(folder, 'nowhere'), '--mcap', join(folder, 'x.mcap'));
  says(2, /Exactly 1 option/, drive, '--mcap', join(folder, 'x.mcap'), '--bag', join(folder, 'x'));
  says(1, /does the folder exist/, drive, '--mcap', join(folder, 'nowhere', 'x.mcap'));
  says(1, /it exists already/, drive, '--bag', drive);
  assert.ok(existsSync(join(drive, 'site.yaml')), 'what was there is still there');
  if (existsSync('/dev/full')) says(1, /is the disk full/, drive, '--mcap', '/dev/full');
  assert.ok(!existsSync(join(folder, 'x.mcap')));

  cpSync(drive, join(folder, 'unfixed'), { recursive: true });
  rmSync(join(folder, 'unfixed', 'fixes.jsonl'));
  const cure = /\/r\/odom {2}nav_msgs[^]*fixes.jsonl does not exist: no poses are exported; 'roomfix replay/;
  says(0, cure, join(folder, 'unfixed'), '--mcap', join(folder, 'unfixed.mcap'));
});
