// Foxglove's own client, which subscribes to every channel and keeps what comes. As a program: node foxglove_client.mjs ADDRESS prints a line of JSON per message.
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const require = createRequire(fileURLToPath(new URL('../../web/package.json', import.meta.url)));
const { FoxgloveClient } = require('@foxglove/ws-protocol');
const WebSocket = require('ws');

export async function listen(address, heard = () => {}) {
  const client = new FoxgloveClient({ ws: new WebSocket(address, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const channels = new Map();
  const topics = new Map();
  const messages = [];
  const statuses = [];
  client.on('status', (status) => statuses.push(status));
  client.on('advertise', (told) => {
    for (const channel of told) {
      channels.set(channel.topic, channel);
      topics.set(client.subscribe(channel.id), channel.topic);
    }
  });
  client.on('message', ({ subscriptionId, timestamp, data }) => {
    const message = { topic: topics.get(subscriptionId), time: timestamp, data: JSON.parse(Buffer.from(data.buffer, data.byteOffset, data.byteLength).toString()) };
    messages.push(message);
    heard(message);
  });
  const info = await new Promise((resolve, reject) => {
    client.on('serverInfo', resolve);
    client.on('error', reject);
    client.on('close', () => reject(new Error('the connection was closed')));
  });
  return { client, info, channels, messages, statuses };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  await listen(process.argv[2], ({ topic, time, data }) => {
    if (topic.endsWith('/pose')) console.log(JSON.stringify({ topic, time: Number(time) / 1e9, pose: data.pose }));
  });
}
