// Prints topic -> [schema, number of messages, numbers in the last message] of a log, decoded with the schemas in the file alone.
import { open } from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const readable = new FileHandleReadable(await open(process.argv[2]));
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
const decoders = new Map();
for (const [id, schema] of reader.schemasById) {
  if (schema.encoding === "protobuf") {
    const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
    const type = root.lookupType(schema.name);
    decoders.set(id, (data) => type.decode(data));
  } else {
    const messages = new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
    decoders.set(id, (data) => messages.readMessage(data));
  }
}
const found = {};
for await (const message of reader.readMessages()) {
  const { topic, schemaId } = reader.channelsById.get(message.channelId);
  const content = decoders.get(schemaId)(message.data);
  const [schema, count] = found[topic] ?? [reader.schemasById.get(schemaId).name, 0];
  const numbers = content.fields ? content.data.length / content.point_stride : (content.values ?? content.data).length;
  found[topic] = [schema, count + 1, numbers];
}
console.log(JSON.stringify(found));
