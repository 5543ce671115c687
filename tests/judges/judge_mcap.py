#!/usr/bin/env python3
"""Judges a Groundwave recording with independent MCAP and protobuf libraries.

    judge_mcap.py RECORDING.mcap [--raw TEE [--killed]] [--jsonl DECODED]
    judge_mcap.py RECORDING.mcap --unfinished --raw TEE

Every checksum must hold. Reading by the index, reading from the front and the statistics must agree.
The bytes of /raw/rx must be those of the raw capture (of a killed one, its beginning but for the last
read: the raw file is written first), every pose must be where the line before it says, and the fields of /telemetry those of
`groundwave export --to jsonl`. Of a recording that was killed and not recovered, --unfinished reads what a plain reader
finds. Prints a summary, or fails at the first error.
"""

import argparse
import collections
import json
import math
import pathlib

from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Channel, Message, Schema
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

TOPICS = json.loads((pathlib.Path(__file__).parent / "topics.json").read_text())

M_PER_IN = 0.0254

# Maximum size of a read of the station.
READ_BYTES = 4096


def check(holds, complaint):
    if not holds:
        raise SystemExit(f"wrong: {complaint}")


def plain(message):
    """A telemetry message in the form of the JSON lines."""
    record = {}
    for field, value in message.ListFields():
        if field.enum_type is not None:
            names = [v.name for v in field.enum_type.values]
            # LAYER_STATE_OFF -> off: the prefix is the type's own name.
            prefix = "".join("_" + c if c.isupper() else c for c in field.enum_type.name)
            prefix = prefix.lstrip("_").upper() + "_"
            check(all(n.startswith(prefix) for n in names), f"names of {field.enum_type.name}")
            word = field.enum_type.values_by_number[value].name.removeprefix(prefix)
            value = word if field.name == "line_type" else word.lower()
        record[field.name] = value
    return record


def judge_unfinished(path, raw_path):
    """Reads an unfinished recording from its beginning to its end."""
    schemas, channels, received, count = {}, {}, bytearray(), 0
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    count += 1
                    channel = channels[record.channel_id]
                    schema = schemas[channel.schema_id]
                    decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
                    content = decode(record.data)
                    if channel.topic == "/raw/rx":
                        check(content.stream_offset == len(received), "bytes are missing")
                        received += content.data
        except EndOfFile:
            pass
    with open(raw_path, "rb") as file:
        raw = file.read()
    check(len(received) > 0, "nothing was received")
    # The recording gets each read first, and each file has a thread of its own: either may lack the last read.
    check(abs(len(raw) - len(received)) <= READ_BYTES, f"{len(raw) - len(received)} bytes lost")
    check(raw.startswith(received) or received.startswith(raw), "/raw/rx differs from the raw capture")
    print(f"{count} messages, {len(received)} bytes received in a recording that nobody finished")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--raw", help="the raw capture of the same session")
    parser.add_argument("--killed", action="store_true", help="the session was killed and recovered")
    parser.add_argument("--jsonl", help="the recording as JSON lines")
    parser.add_argument("--unfinished", action="store_true", help="the session was killed")
    arguments = parser.parse_args()
    if arguments.unfinished:
        return judge_unfinished(arguments.recording, arguments.raw)

    with open(arguments.recording, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        check(reader.get_header().profile == "", "the profile is not empty")
        summary = reader.get_summary()
        check(summary is not None, "there is no summary")
        topics = {c.topic: summary.schemas[c.schema_id] for c in summary.channels.values()}
        check({t: s.name for t, s in topics.items()} == TOPICS, f"topics are {topics}")
        check(all(s.encoding == "protobuf" for s in topics.values()), "a schema is not protobuf")
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        check({"link", "start", "software_version"} <= metadata["session"].keys(), f"{metadata}")

        indexed = collections.Counter()
        received, telemetry, last_time, poses = bytearray(), [], 0, 0
        for _, channel, message, content in reader.iter_decoded_messages(log_time_order=True):
            check(message.sequence == indexed[channel.topic], f"sequence on {channel.topic}")
            indexed[channel.topic] += 1
            check(message.log_time >= last_time, "log times go back")
            last_time = message.log_time
            if channel.topic == "/raw/rx":
                check(content.stream_offset == len(received), f"bytes missing at {len(received)}")
                received += content.data
            elif channel.topic == "/telemetry":
                telemetry.append(plain(content))
            elif channel.topic == "/pose":
                poses += 1
                said = math.hypot(telemetry[-1]["x_in"], telemetry[-1]["y_in"]) * M_PER_IN
                place = math.hypot(content.pose.position.x, content.pose.position.y)
                check(abs(said - place) < 1e-6, f"pose {poses} is {place} m off, line {said} m")

    with open(arguments.recording, "rb") as file:
        streamed = collections.Counter()
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Message):
                streamed[summary.channels[record.channel_id].topic] += 1
    counted = collections.Counter(
        {
            summary.channels[channel].topic: count
            for channel, count in summary.statistics.channel_message_counts.items()
        }
    )
    check(indexed == streamed == counted, f"indexed {indexed}, streamed {streamed}, counted {counted}")
    check(poses == sum(line["line_type"] == "A" for line in telemetry), f"{poses} poses")
    check(summary.statistics.message_count == sum(indexed.values()), "the statistics do not add up")

    if arguments.raw:
        with open(arguments.raw, "rb") as file:
            raw = file.read()
        if arguments.killed:
            check(abs(len(raw) - len(received)) <= READ_BYTES, f"{len(raw) - len(received)} bytes lost")
            raw, received = raw[: len(received)], received[: len(raw)]
        check(received == raw, "/raw/rx differs from the raw capture")
    if arguments.jsonl:
        with open(arguments.jsonl, encoding="ascii") as file:
            records = [json.loads(line) for line in file]
        # Commands, marks and outages are records, too.
        decoded = [record for record in records if "event" not in record]
        for record in decoded:
            del record["at_s"]
        check(len(telemetry) == len(decoded), f"{len(telemetry)} lines, decoded {len(decoded)}")
        for number, (ours, theirs) in enumerate(zip(decoded, telemetry)):
            check(ours == theirs, f"line {number}: {ours} differs from {theirs}")

    for name, table in sorted(metadata.items()):
        print(f"{name}: " + ", ".join(f"{key} {value}" for key, value in sorted(table.items())))
    for topic, count in sorted(indexed.items()):
        print(f"{topic}: {count} messages")
    print(f"{len(received)} bytes received; every checksum holds, index, stream and statistics agree")


if __name__ == "__main__":
    main()
