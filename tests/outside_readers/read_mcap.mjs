// SPDX-FileCopyrightText: 2026 the hullrecon authors
// SPDX-License-Identifier: Apache-2.0
// Reads an MCAP as Foxglove does, by its index and with every checksum, and prints for each topic its schema and number of messages; with a second argument
// it prints Foxglove's own JSON Schema of that name instead.
import { open } from "node:fs/promises";
import { readFileSync } from "node:fs";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import schemas from "@foxglove/schemas/jsonschema.js";

if (process.argv[3]) {
  console.log(JSON.stringify(schemas[process.argv[3]]));
  process.exit(0);
}
const decompressHandlers = { zstd: (buffer) => decompress(buffer) };
const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const buffer = new Uint8Array(Number(size));
    await file.read(buffer, 0, Number(size), Number(offset));
    return buffer;
  },
};
const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const topics = {};
for await (const message of indexed.readMessages({ validateCrcs: true })) {
  const channel = indexed.channelsById.get(message.channelId);
  topics[channel.topic] ??= { schema: indexed.schemasById.get(channel.schemaId).name, messages: 0 };
  topics[channel.topic].messages += 1;
  JSON.parse(new TextDecoder().decode(message.data));
}
const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
stream.append(readFileSync(process.argv[2]));
const records = {};
for (let record; (record = stream.nextRecord()); ) records[record.type] = (records[record.type] ?? 0) + 1;
console.log(JSON.stringify({ topics, records, isDone: stream.done() }));
