/*
 * random SEED STEPS: feeds a robot with random bytes, random frames and damaged frames, all with valid checksums or nearly
 * so, and lets it transmit. The sanitizers watch; this program checks what must hold in any case.
 */
#include "robot.h"

#include <stdio.h>
#include <stdlib.h>

static uint32_t seed;

static uint32_t next_random(uint32_t below) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed % below;
}

static void require(int holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "random: %s\n", what);
        exit(1);
    }
}

static uint32_t crc24(uint32_t remainder, const char *bytes, unsigned count) {
    for (unsigned n = 0; n < count; n++) {
        remainder ^= (uint32_t)(uint8_t)bytes[n] << 16;
        for (int bit = 0; bit < 8; bit++) {
            remainder = remainder & 0x800000 ? (remainder << 1) ^ 0x7B01BD : remainder << 1;
        }
    }
    return remainder & 0xFFFFFF;
}

static char six(uint32_t value) { return (char)((value & 63) == 0 ? '`' : ' ' + (value & 63)); }

/* A frame of the session that is open, with a random payload. */
static unsigned make_frame(const struct gw *gw, char *frame) {
    static const char TYPES[] = "XOCCCCWWDLZ", ORDERS[] = "MLPSFVNKAQ", MODES[] = "PRHXUWGFC";
    unsigned length = 0, payload = next_random(next_random(4) == 0 ? 90 : 14);
    uint32_t key = (uint32_t)gw->robot_id << 16;
    char type = TYPES[next_random(sizeof TYPES - 1)];
    frame[length++] = type;
    if (type == 'C') {
        frame[length++] = six(gw->sequence + next_random(3));
        frame[length++] = ORDERS[next_random(sizeof ORDERS - 1)];
        if (next_random(3) == 0) {
            frame[length++] = MODES[next_random(sizeof MODES - 1)];
            payload = 0;
        }
    }
    if (type == 'O' && next_random(2) == 0) {
        uint32_t bits = (uint32_t)(gw->boots & 7) << 13 | (uint32_t)gw->session << 10 | (1 + next_random(1023));
        for (int shift = 12; shift >= 0; shift -= 6) {
            frame[length++] = six(bits >> shift);
        }
        payload = 0;
    }
    for (unsigned n = 0; n < payload; n++) {
        frame[length++] = next_random(40) == 0 ? (char)next_random(256) : six(next_random(64));
    }
    if (type != 'X' && type != 'O') {
        key |= (uint32_t)(gw->boots & 7) << 13 | (uint32_t)gw->session << 10 | gw->owner;
        if (gw->is_numbered) {
            key ^= (uint32_t)(gw->era & 0x7F) << 16 | (uint32_t)(gw->era >> 7);
        }
    }
    key = crc24(key, frame, length);
    for (int shift = 18; shift >= 0; shift -= 6) {
        frame[length++] = six(key >> shift);
    }
    if (next_random(8) == 0) {
        frame[next_random(length)] ^= (char)(1 << next_random(8));
    }
    return length;
}

static void check(const struct gw *gw) {
    require(gw->session <= 7 && gw->sequence <= 63 && gw->outcome <= 7 && gw->owner <= 1023, "the receiver's counters");
    require(strchr("PRHXUWGFC", gw->mode) != NULL, "the mode");
    require((gw->allowed & ~gw->fitted) == 0, "an allowed layer that is not fitted");
#if GW_LEVEL >= 3
    require(gw->active_count <= GW_WAYPOINTS && gw->active_bank <= 1, "the active list");
#endif
}

static void check_line(const char *line, unsigned length) {
    unsigned head = length - 6;
    uint32_t checksum = crc24(0xFFFFFF, line, head);
    for (unsigned n = 0; n < length - 2; n++) {
        require(line[n] >= ' ' && line[n] <= '~', "a line with a character that is not printable");
    }
    for (int n = 0; n < 4; n++) {
        require(line[head + n] == six(checksum >> (18 - 6 * n)), "a line with a wrong checksum");
    }
}

int main(int count, char **arguments) {
    static struct gw gw;
    unsigned lines = 0;
    uint32_t now_ms = 0;
    require(count == 3, "usage: random SEED STEPS");
    seed = (uint32_t)strtoul(arguments[1], NULL, 10);
    gw_init(&gw, 7, 9, now_ms);
    gw.fields = FIELDS;
    gw.modes = "PXUG";
    gw.fitted = 0x1F;
#if GW_LEVEL >= 5
    static struct gw_parameter parameters[] = {
        {.name = "top-speed", .unit = "in/s", .least = 2, .most = 12, .value = 8, .kept = 8},
        {.name = "low-battery", .unit = "0.1 V", .least = 50, .most = 120, .value = 110, .kept = 110},
    };
    gw.parameters = parameters;
    gw.parameter_count = 2;
    gw.patience_bytes = next_random(2) ? 16 : 0;
#endif
    for (unsigned long step = strtoul(arguments[2], NULL, 10); step > 0; step--) {
        char frame[128];
        unsigned length = make_frame(&gw, frame);
        gw_receive(&gw, '\n', now_ms);
        for (unsigned n = 0; n < length; n++) {
            gw_receive(&gw, (uint8_t)frame[n], now_ms);
        }
        if (next_random(20) == 0) {
            gw_receive(&gw, (uint8_t)next_random(256), now_ms);
        }
        gw_receive(&gw, '\n', now_ms);
        check(&gw);
        for (uint32_t byte = next_random(40); byte > 0; byte--) {
            if (gw_transmit(&gw, now_ms) == '\n') {
                require(gw.position == gw.length, "a line feed within a line");
                check_line(gw.line, gw.length);
                lines++;
            }
        }
        now_ms += next_random(300);
        gw_tick(&gw, now_ms);
    }
    require(lines > 0, "no line was sent");
    return 0;
}
