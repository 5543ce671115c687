// Judges the Foxglove server with the client and the protobuf reader that Lichtblick uses.
//
//     GROUNDWAVE=target/debug/groundwave node judge.mjs
//
// Starts a simulated robot and a station, subscribes to everything, decodes every message with the schema
// that came with it, sends a route and a mode and waits for their confirmation, and sends invalid calls. At the end,
// the received messages must equal the station's files: the bytes of its --tee, and the lines in it as `groundwave
// decode` reads them. Prints a summary, or fails at the first error.

import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";

import { protobufFromBinaryDescriptor } from "@mcap/support";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = protocol;
const GROUNDWAVE = process.env.GROUNDWAVE ?? "target/debug/groundwave";
const PATIENCE_MS = 40_000;
const SERVICE = "/groundwave/send";
const TOPICS = JSON.parse(readFileSync(new URL("topics.json", import.meta.url)));
// The subprotocols that Lichtblick offers, in its order.
const SUBPROTOCOLS = [FoxgloveClient.SUPPORTED_SUBPROTOCOL, "foxglove.sdk.v1"];

function check(holds, complaint) {
  if (!holds) throw new Error(`wrong: ${complaint}`);
}

/** Waits until `look` returns something. */
async function until(what, look) {
  const deadline = Date.now() + PATIENCE_MS;
  for (;;) {
    const found = look();
    if (found) return found;
    check(Date.now() < deadline, `never came: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

const processes = [];

function start(...args) {
  const process = spawn(GROUNDWAVE, args, { stdio: ["ignore", "pipe", "pipe"] });
  const lines = [];
  const errors = [];
  createInterface({ input: process.stdout }).on("line", (line) => lines.push(line));
  createInterface({ input: process.stderr }).on("line", (line) => errors.push(line));
  processes.push(process);
  return { process, lines, errors };
}

/** A client that keeps everything that comes, decoded. */
class Client {
  channels = new Map();
  services = new Map();
  messages = [];
  answers = new Map();
  #types = new Map();
  #topics = new Map();
  #calls = 0;

  constructor(url, wanted) {
    this.socket = new WebSocket(url, SUBPROTOCOLS);
    this.client = new FoxgloveClient({ ws: this.socket });
    this.client.on("error", (error) => (this.error = error));
    this.client.on("serverInfo", (info) => (this.info = info));
    this.client.on("advertise", (channels) => {
      for (const channel of channels) this.#take(channel, wanted);
    });
    this.client.on("advertiseServices", (services) => {
      for (const service of services) this.services.set(service.name, service);
    });
    this.client.on("serviceCallResponse", ({ callId, data }) =>
      this.answers.set(callId, JSON.parse(new TextDecoder().decode(data))),
    );
    this.client.on("serviceCallFailure", ({ callId, message }) =>
      this.answers.set(callId, { status: "call failed", text: message }),
    );
    this.client.on("message", ({ subscriptionId, timestamp, data }) => {
      const topic = this.#topics.get(subscriptionId);
      const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
      const type = this.#types.get(topic);
      // Decodes a message as Lichtblick does for its panels.
      const content = type.toObject(type.decode(bytes), { defaults: true, enums: String });
      this.messages.push({ topic, timestamp, content, type });
    });
  }

  #take(channel, wanted) {
    this.channels.set(channel.topic, channel);
    if (!wanted(channel.topic)) return;
    const root = protobufFromBinaryDescriptor(Buffer.from(channel.schema, "base64"));
    root.resolveAll();
    this.#types.set(channel.topic, root.lookupType(channel.schemaName));
    this.#topics.set(this.client.subscribe(channel.id), channel.topic);
  }

  on(topic) {
    return this.messages.filter((message) => message.topic === topic);
  }

  async call(request) {
    const callId = ++this.#calls;
    const text = typeof request === "string" ? request : JSON.stringify(request);
    const data = new DataView(new TextEncoder().encode(text).buffer);
    const serviceId = this.services.get(SERVICE).id;
    this.client.sendServiceCallRequest({ serviceId, callId, encoding: "json", data });
    return await until(`the answer to ${text}`, () => this.answers.get(callId));
  }
}

/** A telemetry message as the JSON lines have it. */
function plain({ content, type }) {
  const record = {};
  for (const field of type.fieldsArray) {
    let value = content[field.name];
    if (value === undefined || value === null) continue;
    if (field.resolvedType?.values) {
      // LAYER_STATE_OFF -> off: the prefix is the type's own name.
      const prefix = field.resolvedType.name.replace(/(?<!^)[A-Z]/g, "_$&").toUpperCase() + "_";
      check(value.startsWith(prefix), `${value} of ${field.resolvedType.name}`);
      value = value.slice(prefix.length);
      if (field.name !== "line_type") value = value.toLowerCase();
    }
    record[field.name] = value;
  }
  return record;
}

/** The bytes that came on a topic, checked for gaps, and where in the stream they begin. */
function stream(messages) {
  const first = Number(messages[0].content.stream_offset);
  const parts = [];
  let offset = first;
  for (const { content } of messages) {
    check(Number(content.stream_offset) === offset, `bytes missing at ${offset}`);
    parts.push(content.data);
    offset += content.data.length;
  }
  return { first, bytes: Buffer.concat(parts) };
}

async function refuses(url, subprotocols) {
  const socket = new WebSocket(url, subprotocols);
  return await new Promise((resolve) => {
    socket.on("error", () => resolve(true));
    socket.on("open", () => resolve(false));
  });
}

async function main(folder) {
  const tee = join(folder, "live.txt");
  const robot = start("sim", "--listen", "127.0.0.1:0", "--seed", "7");
  const link = await until("the robot's address", () => robot.lines[0]);
  const station = start("watch", link, "--headless", "--foxglove", "127.0.0.1:0", "--tee", tee);
  const url = await until("the station's address", () => {
    check(station.process.exitCode === null, station.errors.join("\n"));
    const said = station.lines.find((line) => line.includes("Foxglove at ws://"));
    return said && JSON.parse(said).text.slice("Foxglove at ".length);
  });
  check(url.startsWith("ws://127.0.0.1:"), url);
  check(await refuses(url, ["mqtt"]), "a client without the protocol was let in");

  // A client that subscribes and never reads again.
  const sleeper = new Client(url, () => true);
  await until("what the sleeper subscribed to", () => sleeper.on("/telemetry").length);
  sleeper.socket.pause();

  const client = new Client(url, () => true);
  await until("the service", () => client.services.has(SERVICE));
  check(client.socket.protocol === "foxglove.sdk.v1", `it speaks ${client.socket.protocol}`);
  check(client.info.name.includes(link), `it is called ${client.info.name}`);
  const topics = Object.fromEntries(
    [...client.channels].map(([topic, channel]) => [topic, channel.schemaName]),
  );
  for (const [topic, schema] of Object.entries(TOPICS)) {
    check(topics[topic] === schema, `${topic} is ${topics[topic]}`);
  }
  check(Object.keys(topics).length === Object.keys(TOPICS).length, `topics are ${Object.keys(topics)}`);
  const encodings = [...client.channels.values()].map((channel) => channel.encoding);
  check(encodings.every((encoding) => encoding === "protobuf"), `encodings are ${encodings}`);

  for (const rubbish of ["", "mode prowl", "{}", '{"do":"fly"}', '{"route":[[1,2,3]]}', '{"route":[{"x_in":0.5,"y_in":0}]}']) {
    const answer = await client.call(rubbish);
    check(answer.status === "failed" && answer.code === "not-understood", JSON.stringify(answer));
  }
  const route = [
    { x_in: 24, y_in: 12 },
    { x_in: -24, y_in: 36 },
    { x_in: 0, y_in: 48 },
  ];
  const list = await client.call({ route });
  check(list.status === "confirmed" && /^[0-9a-f]{8}$/.test(list.digest), JSON.stringify(list));
  const mode = await client.call({ do: "mode prowl" });
  check(mode.status === "confirmed" && mode.command === "mode prowl", JSON.stringify(mode));
  const preset = await client.call({ do: "preset reactive", timeout_ms: 40_000 });
  check(preset.status === "confirmed" && preset.command === "mode reactive", JSON.stringify(preset));
  const hurried = await client.call({ do: "mode wander", timeout_ms: 1 });
  check(hurried.status === "failed" && hurried.code === "timed-out", JSON.stringify(hurried));

  // More calls than may wait: calls above the limit are refused, and a STOP still gets through.
  const crowd = Array.from({ length: 60 }, () => client.call({ do: "mode prowl", timeout_ms: 5000 }));
  const stops = Array.from({ length: 12 }, () => client.call({ do: "stop" }));
  const stopped = await Promise.all(stops);
  check(stopped[0].status === "confirmed" && stopped[0].command === "stop", JSON.stringify(stopped[0]));
  const went = stopped.filter(({ status, command }) => command === "stop" && (status === "confirmed" || status === "queued"));
  check(went.length === stops.length, JSON.stringify(stopped));
  const crowded = await Promise.all(crowd);
  check(crowded.some(({ code }) => code === "busy"), "nobody was told that too many wait");
  check(crowded.every(({ status }) => status === "failed" || status === "confirmed"), JSON.stringify(crowded));

  // All clients get the same confirmation, and the robot's route is drawn.
  await until("the confirmation among the commands", () =>
    client.on("/uplink").some(({ content }) => content.list_digest === parseInt(list.digest, 16)),
  );
  const drawn = ({ content }) =>
    content.entities.some(({ id, spheres }) => id === "waypoints" && spheres.length >= route.length);
  await until("the waypoints", () => client.on("/markers").some(drawn));
  // A late subscriber gets the latest drawing at once.
  const late = new Client(url, (topic) => topic === "/markers");
  await until("the waypoints for who comes late", () => late.on("/markers").some(drawn));
  for (const topic of ["/tf", "/pose", "/path", "/sonar", "/log", "/raw/tx"]) {
    await until(`a message on ${topic}`, () => client.on(topic).length);
  }
  const tf = client.on("/tf")[0].content.transforms[0];
  check(tf.parent_frame_id === "odom" && tf.child_frame_id === "base_link", JSON.stringify(tf));

  await until("enough lines", () => client.on("/telemetry").length > 40);
  station.process.kill("SIGTERM");
  await until("the end of the station", () => station.process.exitCode !== null);
  check(station.process.exitCode === 0, `the station ended with ${station.process.exitCode}`);
  await until("the end of the connection", () => client.socket.readyState === WebSocket.CLOSED);
  check(client.error === undefined, client.error);

  const newest = {};
  for (const { topic, timestamp } of client.messages) {
    check(timestamp >= (newest[topic] ?? 0n), `times on ${topic} go back`);
    newest[topic] = timestamp;
  }
  const kept = readFileSync(tee);
  const { first, bytes } = stream(client.on("/raw/rx"));
  check(bytes.equals(kept.subarray(first, first + bytes.length)), "/raw/rx differs from the tee");
  // The last line may have been under way when the station ended.
  check(kept.length - first - bytes.length <= 160, `${kept.length - first - bytes.length} bytes less than the tee`);
  const decoded = execFileSync(GROUNDWAVE, ["export", tee, "--to", "jsonl", "-o", "-"], { encoding: "utf8" })
    .trim()
    .split("\n")
    .map((line) => JSON.parse(line));
  for (const record of decoded) delete record.at_s;
  const telemetry = client.on("/telemetry").map(plain);
  // The client connected later: its messages are a consecutive part of those lines.
  const same = (ours, theirs) => JSON.stringify(sorted(ours)) === JSON.stringify(sorted(theirs));
  const begin = decoded.findIndex((_, at) => telemetry.slice(0, 5).every((message, i) => decoded[at + i] && same(decoded[at + i], message)));
  check(begin >= 0, `no line says ${JSON.stringify(telemetry[0])}`);
  telemetry.forEach((message, i) => {
    check(same(decoded[begin + i], message), `line ${begin + i} is ${JSON.stringify(decoded[begin + i])}, came as ${JSON.stringify(message)}`);
  });
  sleeper.socket.terminate();
  const counts = Object.keys(TOPICS).map((topic) => `${topic} ${client.on(topic).length}`);
  console.log(`messages: ${counts.join(", ")}`);
  console.log(`${bytes.length} bytes and ${telemetry.length} lines came as they were kept; a route, a mode and a preset confirmed, invalid calls refused`);
}

function sorted(record) {
  return Object.fromEntries(Object.entries(record).sort(([a], [b]) => (a < b ? -1 : 1)));
}

const folder = mkdtempSync(join(tmpdir(), "groundwave-live-"));
try {
  await main(folder);
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  for (const child of processes) child.kill("SIGKILL");
  rmSync(folder, { recursive: true, force: true });
}
process.exit();
