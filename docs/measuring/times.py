"""Times from a packet to the screen and from a key to the serial line, computed from noted times."""

import bisect
import random
import re
import time
from collections.abc import Callable

from line import SerialLine
from terminal import COLUMNS, ROWS, Program

#: Pause between two keys, in which the effect of the first one ends.
KEY_EVERY_S = 1.0
#: Timeout of the answer to a key.
ANSWER_S = 0.9
#: Pause for the program to process the keys typed before.
AHEAD_S = 0.3
#: Time before a key in which unrelated bytes could be mistaken for its answer.
QUIET_S = 0.02


def percentile(times_s: list[float], share: float) -> float:
    """The given quantile of the times."""
    ordered = sorted(times_s)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def to_screen(program: Program, serial: SerialLine, shown: Callable[[bytes], str | None], since: float) -> list[float]:
    """Seconds from the last byte of each packet to the output after which the screen shows it; packets that are never
    shown are omitted."""
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
    """At each time at which the terminal read, between two times: seconds since the first packet that the screen does
    not show yet; 0 if it shows the newest."""
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
    """Seconds from each of `count` keys to the first byte of its answer on the line; keys without an answer are
    omitted."""
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
        # The interval of keys varies against that of the packets.
        time.sleep(KEY_EVERY_S - ANSWER_S + pace.random() / 3)
    return times
