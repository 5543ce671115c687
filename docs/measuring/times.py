"""From a packet to the screen, and from a key to the line: times between moments that were noted."""

import bisect
import random
import re
import time
from collections.abc import Callable

from line import SerialLine
from terminal import COLUMNS, ROWS, Program

#: Between two keys, so that what the first one led to is over.
KEY_EVERY_S = 1.0
#: A key whose answer has not come by then has none.
ANSWER_S = 0.9
#: For the keys that are typed ahead to be taken.
AHEAD_S = 0.3
#: Bytes that come within this before a key may be those that are taken for its answer.
QUIET_S = 0.02


def percentile(times_s: list[float], share: float) -> float:
    """The least of the times within which this share of them lies."""
    ordered = sorted(times_s)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def to_screen(program: Program, serial: SerialLine, shown: Callable[[bytes], str | None], since: float) -> list[float]:
    """Seconds from the last byte of each packet to the bytes after which the screen shows it; one that is never shown has
    none."""
    import pyte  # an emulator that knows what all these programs write

    screen = pyte.Screen(COLUMNS, ROWS)
    stream = pyte.ByteStream(screen)
    packets = [(at, text) for at, packet in list(serial.sent) if at >= since and (text := shown(packet))]
    begins = [at for at, _ in packets]
    times: list[float] = []
    first = 0
    for at, data in list(program.written):
        stream.feed(data)
        sent = bisect.bisect_right(begins, at)
        if first == sent:
            continue
        rows = "\n".join(screen.display)
        for place in range(first, sent):
            begin, text = packets[place]
            if text in rows:
                times.append(at - begin)
                first = place + 1
    return times


def behind(
    program: Program, serial: SerialLine, shown: Callable[[bytes], str | None], since: float, until: float, size: tuple[int, int]
) -> list[float]:
    """At each moment between two at which the terminal took something: seconds since the first packet that its screen does not
    show yet, 0 when it shows the newest."""
    import pyte  # as above

    screen = pyte.Screen(*size)
    stream = pyte.ByteStream(screen)
    packets = [(at, text) for at, packet in list(serial.sent) if (text := shown(packet))]
    found: list[float] = []
    newest = -1
    for at, data in list(program.written):
        stream.feed(data)
        rows = "\n".join(screen.display)
        sent = bisect.bisect_right([begin for begin, _ in packets], at)
        newest = max([place for place in range(max(newest, sent - 600, 0), sent) if packets[place][1] in rows], default=newest)
        if since <= at < until:
            missing = packets[newest + 1][0] if newest + 1 < sent else at
            found.append(at - missing)
    return found


def to_line(program: Program, serial: SerialLine, ahead: bytes, key: bytes, answer: bytes, count: int) -> list[float]:
    """Seconds from each of `count` keys to the first byte that it led to on the line; a key without an answer has none."""
    times = []
    pace = random.Random(1)
    for _ in range(count):
        if ahead:
            program.type(ahead)
            time.sleep(AHEAD_S)
        heard = len(serial.received)
        pressed = program.type(key)
        time.sleep(ANSWER_S)
        if heard and pressed - serial.received[heard - 1][0] < QUIET_S:
            continue
        answers = [at for at, data in serial.received[heard:] if at >= pressed and re.search(answer, data, re.DOTALL)]
        if answers:
            times.append(answers[0] - pressed)
        # No key keeps step with the packets.
        time.sleep(KEY_EVERY_S - ANSWER_S + pace.random() / 3)
    return times
