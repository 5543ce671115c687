"""Check `groundwave_wire.py` against every vector and every capture.

Vectors are looked for in `vectors` beside this file, else in `../vectors` (then captures in `../../captures`).
Prints one line a file and at last `N passed, N failed`; the exit status is 1 when anything failed or nothing was found.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any, Callable, Iterable

import groundwave_wire as wire

HERE = Path(__file__).resolve().parent
PLACES = [(HERE / "vectors", HERE / "captures"), (HERE.parent / "vectors", HERE.parent.parent / "captures")]
Vector = dict[str, Any]


def same(what: str, got: Any, expected: Any) -> None:
    """AssertionError unless both are equal; True is not 1, as in JSON."""
    if json.dumps(got, sort_keys=True) != json.dumps(expected, sort_keys=True):
        raise AssertionError(f"{what}: got {got!r}, expected {expected!r}")


def raw(text: str) -> bytes:
    """The bytes of a string in a vector."""
    return text.encode("latin-1")


def rest_known(vector: Vector, *names: str) -> None:
    """AssertionError if the vector has a key without a check."""
    unknown = set(vector) - set(names) - {"about"}
    if unknown:
        raise AssertionError(f"no check for {sorted(unknown)}")


def check_checksum(vector: Vector) -> None:
    """`init` and `text` give `remainder` and `characters`."""
    rest_known(vector, "init", "text", "remainder", "characters")
    remainder = wire.crc24(int(vector["init"], 16), raw(vector["text"]))
    same("remainder", f"{remainder:06x}", vector["remainder"])
    same("characters", wire.to_six(remainder, 4).decode(), vector["characters"])
    same("read back", wire.from_six(raw(vector["characters"])), remainder)


def check_digest(vector: Vector) -> None:
    """`waypoints` have the `digest`."""
    rest_known(vector, "waypoints", "digest")
    same("digest", wire.list_digest(vector["waypoints"]), vector["digest"])


def check_line(vector: Vector) -> None:
    """`line` decodes to `fields`, or is refused with `error` and its `column`."""
    rest_known(vector, "line", "fields", "error", "column")
    ended = list(wire.StreamDecoder().feed(raw(vector["line"])))
    same("line feeds", len(ended), 1)
    _, result = ended[0]
    if isinstance(result, wire.FieldError):
        got: Vector = {"error": "field", "column": result.column}
    else:
        got = {"error": result} if isinstance(result, str) else {"fields": result}
    same("line", got, {name: vector[name] for name in ("fields", "error", "column") if name in vector})
    if "fields" in vector:
        ack = vector["fields"]["ack"]
        at = 3 if vector["fields"]["type"] in "KG" else 69
        same("acknowledgement encoded", wire.encode_ack(ack).decode(), vector["line"][at:at + 5])


def check_stream(vector: Vector) -> None:
    """`bytes` hold `lines` and give `counters`, whole and byte by byte."""
    rest_known(vector, "bytes", "lines", "counters")
    data = bytes.fromhex(vector["bytes"])
    for size in (max(len(data), 1), 1, 7):
        decoder = wire.StreamDecoder()
        found = [line.decode("latin-1") for at in range(0, len(data), size)
                 for line, result in decoder.feed(data[at:at + size]) if isinstance(result, dict)]
        same("lines", found, vector["lines"])
        same("counters", decoder.counters, vector["counters"])


def encodings(message: Vector, robot: dict[str, int]) -> list[bytes]:
    """The frames that say a message: STOP has two."""
    choices = (False, True) if message["type"] == "X" else (False,)
    return [wire.encode_frame(message, **robot, to_all=to_all) for to_all in choices]


def encodes(message: Vector | None, frame: str, robot: dict[str, int]) -> None:
    """AssertionError unless the message encodes to the last frame in `frame`, byte for byte."""
    if message is None or message.get("order", "") is None:
        return                              # no message, or an order that cannot be encoded
    if message["type"] == "W" and message["first_block"] * wire.BLOCK + len(message["waypoints"]) > wire.LIST_MAX:
        return                              # readable, but must not be sent
    expected = "\n" + frame.split("\n")[-2] + "\n"
    got = [encoded.decode() for encoded in encodings(message, robot)]
    if expected not in got:
        raise AssertionError(f"encoded: got {got!r}, expected {expected!r}")


def check_frame(vector: Vector) -> None:
    """`frame` is heard as `message` or refused with `error`, and the message encodes to the frame."""
    names = ("robot_id", "boot", "session", "owner")
    rest_known(vector, "frame", "message", "error", "era", *names)
    robot = {name: vector[name] for name in names} | {"era": vector.get("era", 0)}
    messages, error = [], None
    for between in raw(vector["frame"]).split(b"\n")[:-1]:
        if between:
            error = None
            try:
                messages.append(wire.decode_frame(between, **robot))
            except wire.FrameError as refused:
                error = refused.reason
    same("verdict on the last frame", error, vector.get("error"))
    message = None if "error" in vector else vector["message"]
    same("messages", messages, [] if message is None else [message])
    encodes(message, vector["frame"], robot)


class Conversation:
    """A robot that lives through the steps of conversation.jsonl."""

    def __init__(self) -> None:
        self.farm: wire.Farm | None = None
        self.outcomes: list[int] = []

    def carry_out(self, order: Vector) -> int:
        """The outcome of an order in the robot's program: that of the vector, once."""
        if not self.outcomes:
            raise AssertionError(f"carried out, but should not have been: {order!r}")
        return self.outcomes.pop()

    def check(self, vector: Vector) -> None:
        """One step: a boot or a frame, then the state."""
        rest_known(vector, "boots", "robot_id", "frame", "outcome", "message", "action", "ack", "ack_characters",
                   "active_count", "active_digest")
        if "boots" in vector:
            self.farm = wire.Farm(vector["robot_id"], vector["boots"], self.carry_out)
        farm = self.farm
        if farm is None:
            raise AssertionError("the first step is no boot")
        if "frame" in vector:
            robot = {"robot_id": farm.robot_id, "boot": farm.boot, "session": farm.session, "owner": farm.owner,
                     "era": farm.key_era()}
            self.outcomes = [vector["outcome"]] if "outcome" in vector else []
            same("heard", list(farm.hear(raw(vector["frame"]))), [[vector["message"], vector["action"]]])
            same("outcomes left", self.outcomes, [])
            encodes(vector["message"], vector["frame"], robot)
        same("ack", farm.ack(), vector["ack"])
        same("ack_characters", wire.encode_ack(farm.ack()).decode(), vector["ack_characters"])
        same("ack decoded", wire.decode_ack(raw(vector["ack_characters"])), vector["ack"])
        same("active_count", len(farm.active), vector["active_count"])
        same("active_digest", wire.list_digest(farm.active), vector["active_digest"])


def check_step(vector: Vector) -> None:
    """A step of a transcript: `line` decodes to `fields`. What a robot answers is for robots to check."""
    if "line" in vector:
        check_line(vector)
    else:
        rest_known(vector, "hears", "outcome", "boots", "patience_bytes", "robot_id")


# By the kind of a file: NAME.jsonl, NAME-2.jsonl.
CHECKS: dict[str, Callable[[], Callable[[Vector], None]]] = {
    "checksums": lambda: check_checksum,
    "digests": lambda: check_digest,
    "lines": lambda: check_line,
    "streams": lambda: check_stream,
    "frames": lambda: check_frame,
    "conversation": lambda: Conversation().check,
    "level": lambda: check_step,
}

# Files that must be there.
EXPECTED = [f"{kind}.jsonl" for kind in CHECKS if kind != "level"] + [f"level-{level}.jsonl" for level in range(1, 6)]


def run(name: str, cases: Iterable[tuple[str, Callable[[], None]]]) -> tuple[int, int]:
    """Run every case of a file, print its failures and its counts."""
    passed = failed = 0
    for label, case in cases:
        try:
            case()
            passed += 1
        except Exception as error:          # any error fails its case and not the run
            failed += 1
            print(f"  FAILED {name}, {label}: {type(error).__name__}: {error}")
    print(f"{name}: {passed} passed, {failed} failed")
    return passed, failed


def fail(why: str) -> None:
    """A case that cannot pass."""
    raise AssertionError(why)


def vector_cases(path: Path) -> list[tuple[str, Callable[[], None]]]:
    """A case for each line of a vector file."""
    kind = path.stem.split("-")[0]
    if kind not in CHECKS:
        return [("the file", lambda: fail("no check for this name"))]
    check = CHECKS[kind]()
    lines = path.read_text(encoding="utf-8").split("\n") if path.is_file() else []
    numbered = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    if not numbered:
        return [("the file", lambda: fail("missing or empty"))]
    return [(f"line {number}", lambda line=line: check(json.loads(line))) for number, line in numbered]


def capture_cases(path: Path) -> list[tuple[str, Callable[[], None]]]:
    """Decode a capture and compare it with the info file beside it."""
    decoder, kinds = wire.StreamDecoder(), Counter()
    for _, result in decoder.feed(path.read_bytes()):
        if isinstance(result, dict):
            kinds[result["type"]] += 1
    info_path = path.with_suffix(".info.json")
    if not info_path.is_file():
        print(f"  {path.name}: no {info_path.name}, nothing to compare; found {decoder.counters}, {dict(kinds)}")
        return []
    info = json.loads(info_path.read_text(encoding="utf-8"))
    got = {name: decoder.counters[name] for name in ("bytes", "noise_bytes") if name in info}
    expected, skipped = {name: info[name] for name in got}, info.keys() - got.keys()
    for name in ("lines", "lines_by_type"):
        if isinstance(info.get(name), dict):
            for kind in sorted(info[name].keys() | kinds.keys()):
                got[f"{name}.{kind}"], expected[f"{name}.{kind}"] = kinds[kind], info[name].get(kind, 0)
            skipped -= {name}
    print(f"  {path.name}: compares {expected or 'nothing'}; skips {sorted(skipped) or 'nothing'}")
    return [(name, lambda name=name: same(name, got[name], expected[name])) for name in got]


def main() -> int:
    """Check all files; return the exit status."""
    vectors, captures = next((place for place in PLACES if place[0].is_dir()), PLACES[-1])
    names = sorted({path.name for path in vectors.glob("*.jsonl")} | set(EXPECTED))
    found = any(vectors.glob("*.jsonl"))
    results = [run(name, vector_cases(vectors / name)) for name in names] if found else []
    if not found:
        print(f"no vectors in {' or '.join(str(place[0]) for place in PLACES)}")
    if captures.is_dir():
        results += [run(path.name, capture_cases(path)) for path in sorted(captures.glob("*.txt"))]
    else:
        print(f"no captures in {captures}")
    passed, failed = (sum(column) for column in zip(*results)) if results else (0, 0)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not found else 0


if __name__ == "__main__":
    sys.exit(main())
