// Judges recordings with @mcap/core, which is the strictest reader of indexes. Reading by index and from the front
// must give the same messages, as many as the statistics declare, and the bytes of /raw/rx must have no gap.
//
//     node judge.mjs RECORDING.mcap [RAW]

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

const [recording, raw] = process.argv.slice(2);
const bytes = new Uint8Array(readFileSync(recording));

function check(holds, complaint) {
  if (!holds) {
    console.error(`wrong: ${recording}: ${complaint}`);
    process.exit(1);
  }
}

/** Messages by topic: how many, and what they say. */
class Found {
  topics = new Map();
  received = [];
  length = 0n;

  take(topic, message) {
    let found = this.topics.get(topic);
    if (found === undefined) {
      found = { count: 0, hash: createHash("sha256") };
      this.topics.set(topic, found);
    }
    check(message.sequence === found.count, `${topic}: message ${found.count} is ${message.sequence}`);
    found.count += 1;
    found.hash.update(message.data).update(String([message.logTime, message.publishTime]));
    if (topic === "/raw/rx") {
      const { offset, data } = rawBytes(message.data);
      check(offset === this.length, `bytes missing at ${this.length}`);
      this.length += BigInt(data.length);
      this.received.push(data);
    }
  }

  summary() {
    const topics = [...this.topics].sort(([a], [b]) => (a < b ? -1 : 1));
    return topics.map(([topic, { count, hash }]) => [topic, count, hash.digest("hex")]);
  }
}

/** `RawBytes` of protobuf: field 1 a varint, field 2 bytes. */
function rawBytes(message) {
  let at = 0;
  const varint = () => {
    let value = 0n;
    for (let shift = 0n; ; shift += 7n) {
      const byte = message[at++];
      value |= BigInt(byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
  };
  let offset = 0n;
  let data = new Uint8Array();
  while (at < message.length) {
    const tag = varint();
    check(tag === 0x08n || tag === 0x12n, `RawBytes has a field ${tag}`);
    const value = varint();
    if (tag === 0x08n) {
      offset = value;
    } else {
      data = message.subarray(at, at + Number(value));
      at += Number(value);
    }
  }
  return { offset, data };
}

const decompressHandlers = await loadDecompressHandlers();
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => bytes.slice(Number(offset), Number(offset + size)),
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const indexed = new Found();
for await (const message of reader.readMessages()) {
  indexed.take(reader.channelsById.get(message.channelId).topic, message);
}

const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
const streamed = new Found();
const channels = new Map();
for (let at = 0; at < bytes.length; at += 1 << 20) {
  stream.append(bytes.subarray(at, at + (1 << 20)));
  for (let record; (record = stream.nextRecord()) !== undefined; ) {
    if (record.type === "Channel") channels.set(record.id, record.topic);
    if (record.type === "Message") streamed.take(channels.get(record.channelId), record);
  }
}
check(stream.done(), "the stream does not end");

const [byIndex, byStream] = [indexed.summary(), streamed.summary()];
check(JSON.stringify(byIndex) === JSON.stringify(byStream), `${byIndex} differs from ${byStream}`);
for (const [topic, count] of byIndex) {
  const channel = [...reader.channelsById.values()].find((c) => c.topic === topic);
  const counted = reader.statistics.channelMessageCounts.get(channel.id);
  check(counted === BigInt(count), `${topic}: ${count} messages, counted ${counted}`);
}
const total = byIndex.reduce((sum, [, count]) => sum + count, 0);
check(reader.statistics.messageCount === BigInt(total), "the statistics do not add up");
if (raw !== undefined) {
  // Of a killed recording either file may lack the last read; judge_mcap.py compares the lengths.
  const received = Buffer.concat(indexed.received);
  const text = readFileSync(raw);
  check(received.subarray(0, text.length).equals(text.subarray(0, received.length)), `${raw} differs`);
}
console.log(`${total} messages of ${byIndex.length} topics: index, stream and statistics agree`);
// Node has once waited here for a thread of its own without end.
process.exit();
