"""The Groundwave wire, written from SPEC.md and the vectors alone: both directions, standard library only.

Down: `StreamDecoder` finds lines in bytes, `parse_line` turns a line into a dict.
Up: `encode_frame` and `decode_frame`, `list_digest`, and `Farm`, the robot's receiving end.
Names of fields are those of the vectors; hyphens on the wire are None.
"""

from __future__ import annotations

import re
import struct
import zlib
from typing import Any, Callable, Iterator

Fields = dict[str, Any]
Waypoint = list[int]

CRC_POLYNOMIAL = 0x7B01BD
LINE_START = 0xFFFFFF
LINE_BYTES, ACK_LINE_BYTES = 80, 14
FRAME_BYTES_MAX = 87
LIST_MAX, BLOCK, BLOCKS = 300, 4, 75
COORDINATE_MAX = 9999
MODES = "PRHXUWGFC"


def _within(value: int, low: int, high: int) -> int:
    if not low <= value <= high:
        raise ValueError(f"{value} is not within {low} to {high}")
    return value


# --- 6-bit characters and the checksum (sections 3 and 4) ---------------------------------------------------------

def crc24(start: int, data: bytes) -> int:
    """The remainder of `data`, beginning with `start`."""
    r = start
    for byte in data:
        r ^= byte << 16
        for _ in range(8):
            r = (r << 1) ^ CRC_POLYNOMIAL if r & 0x800000 else r << 1
            r &= 0xFFFFFF
    return r


def to_six(value: int, characters: int) -> bytes:
    """A number as 6-bit characters, most significant first; ValueError if it needs more of them."""
    if not 0 <= value < 1 << 6 * characters:
        raise ValueError(f"{value} does not fit into {characters} characters")
    sixes = [value >> 6 * i & 63 for i in reversed(range(characters))]
    return bytes(0x20 + six if six else 0x60 for six in sixes)


def from_six(data: bytes) -> int:
    """The number that 6-bit characters make; ValueError at any byte that is none."""
    value = 0
    for byte in data:
        if not 0x21 <= byte <= 0x60:
            raise ValueError(f"byte {byte} is no 6-bit character")
        value = value << 6 | (byte - 0x20) % 64
    return value


def checksum(start: int, data: bytes) -> bytes:
    """The four characters that follow `data`."""
    return to_six(crc24(start, data), 4)


# --- the acknowledgement (section 6) ------------------------------------------------------------------------------

def decode_ack(characters: bytes) -> Fields:
    """Five characters of a line as a dict; ValueError if a character is none."""
    bits = from_six(characters)
    ack = {"boot": bits >> 27, "session": bits >> 24 & 7, "sequence": bits >> 21 & 7, "outcome": bits >> 18 & 7}
    if bits >> 15 & 7 == 7:
        return ack | {"receipt": bits & 0x7FFF}
    if bits >> 7 & 0x7FF == 0b1_1001111_000:
        return ack | {"cannot_hear": True, "robot_id": bits & 0x7F}
    if bits >> 14 & 15 == 13:
        return ack | {"era": bits & 0x3FFF}
    if bits >> 17 & 1:
        return ack | {"first_missing": bits >> 10 & 127, "tag": bits >> 8 & 3, "window": bits & 255}
    return ack | {"owner": bits >> 7 & 1023, "robot_id": bits & 127}


def encode_ack(ack: Fields) -> bytes:
    """The five characters of an acknowledgement."""
    bits = ack["boot"] << 27 | ack["session"] << 24 | ack["sequence"] << 21 | ack["outcome"] << 18
    if "era" in ack:
        return to_six(bits | 13 << 14 | ack["era"], 5)
    if "cannot_hear" in ack:
        return to_six(bits | 0b1_1001111_000 << 7 | ack["robot_id"], 5)
    if "receipt" in ack:
        return to_six(bits | 7 << 15 | ack["receipt"], 5)
    if "tag" in ack:
        return to_six(bits | 1 << 17 | ack["first_missing"] << 10 | ack["tag"] << 8 | ack["window"], 5)
    return to_six(bits | ack["owner"] << 7 | ack["robot_id"], 5)


# --- lines (section 5) --------------------------------------------------------------------------------------------

class FieldError(ValueError):
    """An intact line that cannot be read; `column`, from 1, is that of the field to blame."""

    def __init__(self, column: int, why: str) -> None:
        super().__init__(f"column {column}: {why}")
        self.column = column


# A reader makes a value of a field's text, knowing the fields before it, and raises ValueError at every other form.
Reader = Callable[[str, Fields], Any]


def _match(pattern: str, text: str) -> str:
    if not re.fullmatch(pattern, text):
        raise ValueError(f"{text!r} is not of the form {pattern}")
    return text


def _digits(low: int = 0, high: int = 999999, optional: bool = False) -> Reader:
    """`ddd`, or hyphens if optional."""
    def read(text: str, _: Fields) -> int | None:
        return None if optional and set(text) == {"-"} else _within(int(_match("[0-9]+", text)), low, high)
    return read


def _signed(text: str, _: Fields) -> int:
    """`sdd`; zero has a plus."""
    return int(_match(r"(?!-0+\Z)[+-][0-9]+", text))


def _position(text: str, _: Fields) -> int:
    """Tenths of an inch, below 1000 inches with a point and beyond without."""
    if "." in text:
        return int(_match(r"(?!-000\.0)[+-][0-9]{3}\.[0-9]", text).replace(".", ""))
    return int(_match(r"[+-](?!00)[0-9]{5}", text)) * 10


def _target(text: str, before: Fields) -> int | None:
    """Whole inches, or hyphens in both fields."""
    value = None if text == "-----" else _signed(text, before)
    if before.get("target_in") and (before["target_in"][0] is None) != (value is None):
        raise ValueError("one coordinate alone")
    return value


def _failsafe_mode(text: str, before: Fields) -> str | None:
    """A mode that needs no operator; a hyphen where the silence is hyphens."""
    if before["failsafe_silence_s"] is None and text == "-":
        return None
    if before["failsafe_silence_s"] is None or text in "UC" or text not in MODES:
        raise ValueError(f"{text!r} is no mode to fall back to")
    return text


def _letter(letters: str) -> Reader:
    return _choice({letter: letter for letter in letters})


def _choice(states: Fields) -> Reader:
    def read(text: str, before: Fields) -> Any:
        if text not in states:
            raise ValueError(f"{text!r} is none of {''.join(states)}")
        if states[text] == "holds" and "holds" in before.get("layers", []):
            raise ValueError("a second layer holds the motors")
        return states[text]
    return read


def _layer(letter: str) -> Reader:
    return _choice({".": "off", "-": "quiet", letter.lower(): "raised", letter: "holds"})


def _allowance(letter: str) -> Reader:
    """(fitted, allowed) of one layer."""
    return _choice({".": (0, 0), "-": (1, 0), letter: (1, 1)})


def _volts(text: str, _: Fields) -> int:
    return int(_match(r"[0-9]{2}\.[0-9]", text).replace(".", ""))


def _version(text: str, _: Fields) -> list[int]:
    return [int(part) for part in _match(r"[0-9]{2}\.[0-9]{2}", text).split(".")]


def _progress(text: str, _: Fields) -> list[int]:
    driven, count = (int(part) for part in _match("[0-9]{3}/[0-9]{3}", text).split("/"))
    return [_within(driven, 0, count), count]


def _six(high: int) -> Reader:
    return lambda text, _: _within(from_six(text.encode("latin-1")), 0, high)


def _text(text: str, _: Fields) -> str:
    return _match("[ -~]*", text).rstrip(" ")


def _name(text: str, _: Fields) -> str:
    """A parameter's name: no capital, no space within it."""
    return _match("[a-z0-9-]+ *", text).rstrip(" ")


def _place(text: str, _: Fields) -> list[int]:
    place, count = (int(part) for part in _match("[0-9]{2}/[0-9]{2}", text).split("/"))
    return [_within(place, 1, count), count]


def _or_point(letter: str) -> Reader:
    """The letter, or a point for what is not there."""
    return _choice({".": "", letter: letter})


def _field_place(text: str, _: Fields) -> list[int]:
    place, count = (int(part) for part in _match("[0-9]/[0-9]", text).split("/"))
    return [_within(place, 1, count), count]


def _own_value(text: str, before: Fields) -> int | None:
    return None if text == "------" else _signed(text, before)


def _note(text: str, before: Fields) -> list[int] | None:
    """Frequency and length, or None behind the last note."""
    if text == "   ":
        return None
    if None in before.get("notes", []):
        raise ValueError("a note behind the last one")
    bits = from_six(text.encode("latin-1"))
    return [bits >> 6, _within(bits & 63, 1, 63)]


def _ack(text: str, _: Fields) -> Fields:
    return decode_ack(text.encode("latin-1"))


# Column, width, name, reader. A name with [] gathers its values in a list. Every column between fields is a space.
Layout = list[tuple[int, int, str, Reader]]
_ACK: Layout = [(70, 5, "ack", _ack)]
_ROBOT: Layout = [(5, 2, "robot_id", _digits(1))]

LAYOUTS: dict[str, Layout] = {
    "A": [
        (5, 6, "x_tenths_in", _position), (12, 6, "y_tenths_in", _position), (19, 3, "theta_deg", _digits(0, 359)),
        (23, 3, "velocity_in_s", _signed), (27, 3, "rotation_in_s", _signed),
        (31, 3, "wheel_left_in_s", _signed), (35, 3, "wheel_right_in_s", _signed),
        (39, 3, "sonar_left_in", _digits(optional=True)), (43, 3, "sonar_right_in", _digits(optional=True)),
        (47, 2, "photo_left_pct", _digits(optional=True)), (50, 2, "photo_right_pct", _digits(optional=True)),
        (53, 1, "bump", _letter(".LCRlrSAJ-")), (54, 1, "infrared", _letter(".LRBJ-")),
        (55, 1, "cliff", _letter(".LCRA-")), (56, 1, "arm", _letter(".uaLRBT-")), (57, 1, "drive", _letter(".sX0o")),
        (58, 1, "power", _letter(".l!d+")), (59, 1, "link", _letter(".fF")), (61, 1, "mode", _letter(MODES)),
        *((62 + i, 1, "layers[]", _layer(letter)) for i, letter in enumerate("BTISLMD")), *_ACK],
    "B": [
        *_ROBOT, (8, 4, "battery_dv", _volts), (13, 5, "target_in[]", _target), (19, 5, "target_in[]", _target),
        (25, 7, "progress", _progress), (33, 6, "digest", _six(0xFFFFFFFF)), (40, 2, "max_count", _digits()),
        (43, 3, "photo_left", _digits(0, 255, True)), (47, 3, "photo_right", _digits(0, 255, True)),
        *((51 + i, 1, "allowance[]", _allowance(letter)) for i, letter in enumerate("UBTISLMD")),
        (60, 3, "boots", _digits()), (64, 2, "odometer_resets", _digits()), *_ACK],
    "C": [
        *_ROBOT, (8, 6, "uptime_s", _digits()), (15, 3, "boots", _digits()), (19, 5, "version", _version),
        *((25 + 2 * i, 2, "ticks_won[]", _six(4095)) for i in range(9)),
        (44, 3, "frames_heard", _digits()), (48, 3, "frames_rejected", _digits()), (52, 3, "ticks_late", _digits()),
        (56, 4, "bumps", _digits()), (61, 4, "failsafe_silence_s", _digits(10, 4095, True)),
        (66, 1, "failsafe_mode", _failsafe_mode), *_ACK],
    "T": [(5, 64, "text", _text), *_ACK],
    "P": [
        (5, 5, "position", _place), (11, 18, "name", _name), (30, 6, "value", _signed), (37, 6, "kept", _signed),
        (44, 6, "least", _signed), (51, 6, "most", _signed), (58, 11, "unit", _text), *_ACK],
    "S": [*((5 + 3 * i, 3, "notes[]", _note) for i in range(21)), *_ACK],
    "I": [
        *_ROBOT, (8, 1, "level", _digits(1, 5)), (10, 3, "capacity", _digits(0, LIST_MAX)),
        *((14 + i, 1, "modes[]", _or_point(letter)) for i, letter in enumerate(MODES)),
        *((24 + i, 1, "measured[]", _or_point(letter)) for i, letter in enumerate("BWSI")),
        (29, 5, "rate_bytes_per_s", _digits(30)), (35, 1, "fields", _digits()), *_ACK],
    "F": [
        (5, 3, "position", _field_place), (9, 18, "name", _name), (28, 1, "decimals", _digits(0, 5)),
        (30, 11, "unit", _text), *_ACK],
    "V": [*((5 + 7 * i, 6, "values[]", _own_value) for i in range(9)), *_ACK],
    "K": [(4, 5, "ack", _ack)],
    "G": [(4, 5, "ack", _ack)],
}


def parse_line(line: bytes) -> Fields:
    """The fields of a line whose checksum holds, CR LF included; FieldError if it cannot be read."""
    text = line[:-6].decode("latin-1")
    kind = text[0]
    if kind not in LAYOUTS or (kind in "KG") != (len(line) == ACK_LINE_BYTES):
        raise FieldError(1, f"no line of type {kind!r}")
    fields: Fields = {"type": kind}
    column = 2
    for start, width, name, read in [(2, 2, "sequence", _digits()), *LAYOUTS[kind]]:
        for gap in range(column, start):
            if text[gap - 1] != " ":
                raise FieldError(gap, "no space")
        try:
            value = read(text[start - 1:start - 1 + width], fields)
        except ValueError as error:
            if name in ("text", "unit"):    # each character is a field of its own
                start += next(at for at, character in enumerate(text[start - 1:]) if not " " <= character <= "~")
            raise FieldError(start, str(error)) from error
        if name.endswith("[]"):
            fields.setdefault(name[:-2], []).append(value)
        else:
            fields[name] = value
        column = start + width
    if kind == "B":
        fields["list_driven"], fields["list_count"] = fields.pop("progress")
        if fields["target_in"][0] is None:
            fields["target_in"] = None
        allowance = fields.pop("allowance")
        fields["fitted"] = sum(fitted << bit for bit, (fitted, _) in enumerate(allowance))
        fields["allowed"] = sum(allowed << bit for bit, (_, allowed) in enumerate(allowance))
    elif kind == "I":
        fields["modes"], fields["measured"] = "".join(fields["modes"]), "".join(fields["measured"])
    elif kind in "PF":
        fields["place"], fields["count"] = fields.pop("position")
    elif kind == "S":
        fields["notes"] = [note for note in fields["notes"] if note]
    elif kind == "C":
        fields["version_major"], fields["version_minor"] = fields.pop("version")
    return fields


# --- finding lines (section 8) ------------------------------------------------------------------------------------

class StreamDecoder:
    """Finds lines in bytes by looking back at each LF, and counts everything it meets."""

    def __init__(self) -> None:
        self.counters = dict.fromkeys(("bytes", "lines", "ack_lines", "crc_rejected", "shape_rejected",
                                       "field_rejected", "noise_bytes", "lines_lost"), 0)
        self._since = bytearray()          # at most the last 80 bytes since the latest intact line
        self._newest: tuple[int, int] | None = None     # boot and sequence
        self._arrived = 31                 # bit n: the line n + 1 before the newest has arrived

    def feed(self, data: bytes) -> Iterator[tuple[bytes, Fields | str | FieldError]]:
        """Yield for each LF (line, fields), (line, FieldError), or (b"", "crc" or "shape"). Must be consumed."""
        for byte in data:
            self.counters["bytes"] += 1
            self.counters["noise_bytes"] += 1
            self._since.append(byte)
            if byte == 10:
                yield self._line_feed()
            if len(self._since) > LINE_BYTES:
                del self._since[0]

    def _line_feed(self) -> tuple[bytes, Fields | str | FieldError]:
        tail = bytes(self._since[-LINE_BYTES:])
        reason = "shape"
        for size in (LINE_BYTES, ACK_LINE_BYTES):
            line = tail[-size:]
            if len(line) < size or line[-2:] != b"\r\n" or size == ACK_LINE_BYTES and line[:1] not in (b"K", b"G"):
                continue
            if checksum(LINE_START, line[:-6]) == line[-6:-2]:
                self._since.clear()
                return line, self._intact(line)
            reason = "crc"
        self.counters[f"{reason}_rejected"] += 1
        return b"", reason

    def _intact(self, line: bytes) -> Fields | FieldError:
        try:
            fields = parse_line(line)
        except FieldError as error:
            self.counters["field_rejected"] += 1
            return error
        self.counters["lines" if len(line) == LINE_BYTES else "ack_lines"] += 1
        self.counters["noise_bytes"] -= len(line)
        self._account(fields["ack"]["boot"], fields["sequence"])
        return fields

    def _account(self, boot: int, sequence: int) -> None:
        """Count lost lines, from the sequence."""
        if self._newest is None or self._newest[0] != boot:
            self._newest, self._arrived = (boot, sequence), 31
            return
        ahead = (sequence - self._newest[1]) % 100
        if 1 <= ahead <= 94:
            self.counters["lines_lost"] += ahead - 1
            self._arrived = (self._arrived << 1 | 1) << (ahead - 1) & 31
            self._newest = boot, sequence
        elif ahead:
            late = 1 << 99 - ahead
            if not self._arrived & late:
                self.counters["lines_lost"] -= 1
            self._arrived |= late


# --- frames (section 9) -------------------------------------------------------------------------------------------

class FrameError(ValueError):
    """The bytes between two LFs are no frame; `reason` is `too_long`, `crc` or `unreadable`."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


def frame_key(robot_id: int, boot: int = 0, session: int = 0, owner: int = 0, era: int = 0) -> int:
    """The initial remainder of a frame's checksum."""
    return (robot_id << 16 | (boot & 7) << 13 | session << 10 | owner) ^ (era & 127) << 16 ^ era >> 7


# Bits, most significant first: name, how many, least and greatest value, what is added before it is sent. Without an
# addition a negative value is sent as two's complement. Leading zeros belong to the first number.
Bits = list[tuple[str, int, int, int, int]]
_HEARD, _POSE = (0, 99, 0), (15, -COORDINATE_MAX, COORDINATE_MAX, 16384)
WAYPOINT: Bits = [("x_in", *_POSE), ("y_in", *_POSE)]
PAYLOADS: dict[str, Bits] = {
    "X": [],                                                                        # or a receipt
    "O": [("boot", 5, 0, 7, 0), ("replaces", 3, 0, 7, 0), ("owner", 10, 1, 1023, 0)],
    "C": [("sequence", 6, 0, 63, 0)],                                               # then the order
    "W": [("tag", 5, 1, 31, 0), ("first_block", 7, 0, BLOCKS - 1, 0)],              # then the waypoints
    "D": [("velocity_in_s", 6, -31, 31, 0), ("rotation_in_s", 7, -63, 63, 0), ("heard", 7, *_HEARD),
          ("count", 4, 0, 15, 0)],
    "L": [("heard", 12, *_HEARD)],
}
ERA: Bits = [("era", 18, 0, 0x3FFF, 0)]                                             # only where there is one
RECEIPT: Bits = [("receipt", 18, 0, 0x7FFF, 0)]
SILENCE: Bits = [("silence_s", 12, 0, 4095, 0)]                                     # then a mode's letter
KEY: Bits = [("key", 24, 0, 0xFFFFFF, 0)]
VALUE: Bits = [("value", 18, -131072, 131071, 0)]                                   # only where there is one
ORDERS: dict[str, Bits] = {
    "L": [("which", 10, 0, 255, 0), ("allowed", 8, 0, 255, 0)],
    "P": [*WAYPOINT, ("theta_deg", 12, 0, 359, 0)],
    "S": [],
    "N": [("place", 12, 0, 4095, 0)],
    "K": [],
    "A": [("tag", 6, 0, 63, 0), ("count", 12, 0, 4095, 0), ("digest", 36, 0, 0xFFFFFFFF, 0)],
}


def _pack(layout: Bits, values: Fields) -> bytes:
    number = size = 0
    for name, bits, low, high, added in layout:
        number = number << bits | _within(values[name], low, high) + added & (1 << bits) - 1
        size += bits
    return to_six(number, size // 6)


def _unpack(layout: Bits, characters: bytes) -> Fields:
    size = sum(bits for _, bits, *_ in layout)
    if len(characters) * 6 != size:
        raise ValueError("another length")
    number, values = from_six(characters), {}
    for name, bits, low, high, added in layout:
        size -= bits
        value = (number >> size & (1 << bits) - 1) - added
        if low < 0 and not added and value >> bits - 1:
            value -= 1 << bits
        values[name] = _within(value, low, high)
    return values


def encode_frame(message: Fields, robot_id: int, boot: int, session: int, owner: int, era: int = 0,
                 to_all: bool = False) -> bytes:
    """The frame that says `message`, with its LFs; `to_all` makes a STOP that every robot obeys.

    ValueError if a value does not fit.
    """
    kind = message["type"]
    if kind not in PAYLOADS:
        raise ValueError("no such type")
    said = kind.encode("ascii") + _pack(RECEIPT if "receipt" in message else PAYLOADS[kind], message)
    if kind == "C":
        order = message["order"]
        if order == "M":
            said += b"M" + _letter(MODES)(message["mode"], {}).encode("ascii")
        elif order == "F":
            said += b"F" + _pack(SILENCE, message) + _letter(MODES)(message["mode"], {}).encode("ascii")
        elif order == "V":
            said += b"V" + _pack(KEY, message) + (b"" if message["value"] is None else _pack(VALUE, message))
        elif order in ORDERS:
            said += order.encode("ascii") + _pack(ORDERS[order], message)
        else:
            raise ValueError("no such order")
    elif kind == "O" and "era" in message:
        said += _pack(ERA, message)
    elif kind == "W":
        _within(len(message["waypoints"]), 1, 16)
        _within(message["first_block"] * BLOCK + len(message["waypoints"]), 1, LIST_MAX)
        said += b"".join(_pack(WAYPOINT, {"x_in": x, "y_in": y}) for x, y in message["waypoints"])
    key = frame_key(robot_id) if kind in "XO" else frame_key(robot_id, boot, session, owner, era)
    return b"\n" + said + checksum(0 if kind == "X" and to_all else key, said) + b"\n"


def _decode_order(order: bytes) -> Fields:
    """The fields of an order; {"order": None} if it cannot be read."""
    kind, rest = order[:1].decode("latin-1"), order[1:]
    try:
        if kind == "M":
            return {"order": kind, "mode": _letter(MODES)(rest.decode("latin-1"), {})}
        if kind == "F":
            mode = _letter(MODES)(rest[2:].decode("latin-1"), {})
            silence = _unpack(SILENCE, rest[:2])
            if silence["silence_s"] == 0 and mode != "X":
                raise ValueError("no silence goes with stop")
            return {"order": kind} | silence | {"mode": mode}
        if kind == "V":
            value = _unpack(VALUE, rest[4:]) if rest[4:] else {"value": None}
            return {"order": kind} | _unpack(KEY, rest[:4]) | value
        if kind in ORDERS:
            fields = _unpack(ORDERS[kind], rest)
            if kind == "L" and fields["allowed"] & ~fields["which"]:
                raise ValueError("allowed and not meant")
            return {"order": kind} | fields
    except ValueError:
        pass
    return {"order": None}


def _decode_said(kind: str, payload: bytes) -> Fields:
    """The message of a frame whose checksum holds; ValueError if it cannot be read."""
    if kind not in PAYLOADS:
        raise ValueError("no such type")
    size = {"C": 1, "W": 2, "O": 3}.get(kind, len(payload))
    layout = RECEIPT if kind == "X" and payload else PAYLOADS[kind]
    fields, rest = {"type": kind} | _unpack(layout, payload[:size]), payload[size:]
    if kind == "C":
        fields |= _decode_order(rest)
    elif kind == "O" and rest:
        fields |= _unpack(ERA, rest)
    elif kind == "W":
        waypoints = [_unpack(WAYPOINT, rest[at:at + 5]) for at in range(0, len(rest), 5)]
        _within(len(waypoints), 1, 16)
        fields["waypoints"] = [list(waypoint.values()) for waypoint in waypoints]
    return fields


def decode_frame(between: bytes, robot_id: int, boot: int, session: int, owner: int, era: int = 0) -> Fields:
    """The message between two LFs (not empty) as this robot hears it; FrameError if there is none."""
    if len(between) > FRAME_BYTES_MAX:
        raise FrameError("too_long")
    keys = [frame_key(robot_id, boot, session, owner, era)] if owner else []
    if between[:1] in (b"X", b"O"):
        keys = [frame_key(robot_id)] + ([0] if between[:1] == b"X" else [])
    said = between[:-4]
    if len(between) < 5 or not any(checksum(key, said) == between[-4:] for key in keys):
        raise FrameError("crc")
    try:
        return _decode_said(chr(said[0]), said[1:])
    except ValueError as error:
        raise FrameError("unreadable") from error


def list_digest(waypoints: list[Waypoint]) -> int:
    """The CRC-32 over the number of waypoints and their coordinates."""
    numbers = [coordinate for waypoint in waypoints for coordinate in waypoint]
    return zlib.crc32(struct.pack(f"<H{len(numbers)}h", len(waypoints), *numbers))


# --- the robot's receiving end (section 11) -----------------------------------------------------------------------

class Farm:
    """The robot's state of the uplink. `carry_out` is its program: it gets an order and returns the outcome."""

    def __init__(self, robot_id: int, boots: int, carry_out: Callable[[Fields], int]) -> None:
        self.robot_id, self.boot, self.carry_out = robot_id, boots % 8, carry_out
        self.session = self.owner = 0
        self.era, self.is_numbered = (boots >> 3) * 1021 % 16384, False
        self.sequence = self.outcome = self.drive_count = 0
        self.active: list[Waypoint] = []
        self.staged: dict[int, Waypoint] | None = None      # by number; None: not open
        self.tag, self.blocks = 0, set[int]()
        self.receipt: int | None = None
        self.mode = ""                                      # the specification names none at boot
        self.sending: int | None = None                     # sequence of the line being sent, if known
        self.counters = dict.fromkeys(("frames_heard", "crc", "too_long", "unreadable"), 0)
        self._between = bytearray()

    def hear(self, data: bytes) -> Iterator[tuple[Fields | None, str]]:
        """Each message found in bytes from the ground, and the action. Must be consumed."""
        for byte in data:
            if byte != 10:
                if len(self._between) <= FRAME_BYTES_MAX:
                    self._between.append(byte)
                continue
            between, self._between = bytes(self._between), bytearray()
            if not between:
                continue
            try:
                message = decode_frame(between, self.robot_id, self.boot, self.session, self.owner, self.key_era())
            except FrameError as error:
                self.counters[error.reason] += 1
                yield None, "not heard"
                continue
            self.counters["frames_heard"] += 1
            yield message, getattr(self, f"_on_{message['type']}")(message)

    def ack(self) -> Fields:
        """The acknowledgement at this moment."""
        ack = {"boot": self.boot, "session": self.session, "sequence": self.sequence % 8, "outcome": self.outcome}
        if self.receipt is not None:
            return ack | {"receipt": self.receipt}
        if self.staged is None:
            return ack | {"owner": self.owner, "robot_id": self.robot_id}
        first = next(block for block in range(BLOCKS + 1) if block not in self.blocks)
        window = sum(1 << n for n in range(8) if first + 1 + n in self.blocks)
        return ack | {"first_missing": first, "tag": self.tag % 4, "window": window}

    def key_era(self) -> int:
        """The era in the key of the session."""
        return self.era if self.is_numbered else 0

    def _new_session(self, owner: int) -> None:
        self.era = (self.era + (self.session == 7)) % 16384
        self.session, self.owner = self.session % 7 + 1, owner
        self.sequence = self.outcome = self.drive_count = self.tag = 0
        self.staged, self.blocks, self.receipt = None, set(), None

    def _on_X(self, message: Fields) -> str:
        self.mode = "X"
        if self.owner:
            self._new_session(0)
        else:
            self.sequence = (self.sequence + 1) % 64
        self.receipt = message.get("receipt")
        return "stop"

    def _on_O(self, message: Fields) -> str:
        present = self.boot, self.session, self.era
        if (message["boot"], message["replaces"], message.get("era", self.era)) == present:
            self._new_session(message["owner"])
            self.is_numbered = "era" in message
        return "nothing"

    def _on_C(self, message: Fields) -> str:
        if message["sequence"] != (self.sequence + 1) % 64:
            return "nothing"
        self.sequence, self.outcome = message["sequence"], 7
        if message["order"] == "A":
            self.outcome = self._activate(message)
            return "nothing" if self.outcome else "list replaced"
        self.outcome = self.carry_out(message)
        if message["order"] == "M" and self.outcome == 0:
            self.mode = message["mode"]
        return "execute"

    def _activate(self, order: Fields) -> int:
        count = order["count"]
        if count > LIST_MAX:
            return 2
        needed = set(range(-(-count // BLOCK)))
        if count and (self.staged is None or order["tag"] != self.tag or not needed <= self.blocks):
            return 3
        # A block marked but sent too short leaves a gap: the announced list is not what is staged.
        waypoints = [waypoint for i in range(count) if (waypoint := (self.staged or {}).get(i)) is not None]
        if len(waypoints) != count or list_digest(waypoints) != order["digest"]:
            return 4
        self.active, self.staged, self.blocks = waypoints, None, set()
        return 0

    def _on_W(self, message: Fields) -> str:
        if 1 <= (message["tag"] - self.tag) % 32 <= 15:
            self.tag, self.staged, self.blocks = message["tag"], {}, set()
        if self.staged is None or message["tag"] != self.tag:
            return "nothing"
        first = message["first_block"] * BLOCK
        if first + len(message["waypoints"]) > LIST_MAX:
            return "nothing"
        for number, waypoint in enumerate(message["waypoints"], first):
            self.staged[number] = waypoint
            self.blocks.add(number // BLOCK)
        return "nothing"

    def _on_D(self, message: Fields) -> str:
        if not 1 <= (message["count"] - self.drive_count) % 16 <= 7:
            return "nothing"
        self.drive_count = message["count"]
        old = self.sending is not None and (self.sending - message["heard"]) % 100 > 6
        return "nothing" if self.mode == "X" or old else "drive"

    def _on_L(self, _: Fields) -> str:
        return "nothing"
