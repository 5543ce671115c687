/* See groundwave.h. Numbers of sections are those of protocol/SPEC.md. */

/* The Arduino builder compiles this file by itself, too, and knows no level then. */
#ifdef GW_LEVEL

#include "groundwave.h"

#include <string.h>

/* ---- Fields (section 3) ---- */

/* Writes the last digits; returns what is left of the value. */
static uint32_t put_last_digits(char *to, uint8_t width, uint32_t value) {
    while (width-- > 0) {
        to[width] = (char)('0' + value % 10);
        value /= 10;
    }
    return value;
}

/* A value that is too large becomes all nines. */
static void put_digits(char *to, uint8_t width, uint32_t value) {
    if (put_last_digits(to, width, value) > 0) {
        memset(to, '9', width);
    }
}

/* Returns the magnitude. */
static uint32_t put_sign(char *to, int32_t value) {
    *to = value < 0 ? '-' : '+';
    return value < 0 ? 0 - (uint32_t)value : (uint32_t)value;
}

static void put_signed(char *to, uint8_t width, int32_t value) {
    uint32_t magnitude = put_sign(to, value);
    put_digits(to + 1, (uint8_t)(width - 1), magnitude);
}

/* Hyphens for a value that is not there. */
static void put_optional(char *to, uint8_t width, int16_t value) {
    if (value < 0) {
        memset(to, '-', width);
    } else {
        put_digits(to, width, (uint32_t)value);
    }
}

static void put_six(char *to, uint8_t width, uint32_t value) {
    while (width-- > 0) {
        uint8_t six = value & 63;
        to[width] = (char)(six == 0 ? '`' : ' ' + six);
        value >>= 6;
    }
}

static uint32_t crc24(uint32_t remainder, const char *bytes, uint8_t count) {
    while (count-- > 0) {
        remainder ^= (uint32_t)(uint8_t)*bytes++ << 16;
        for (uint8_t bit = 0; bit < 8; bit++) {
            remainder = remainder & 0x800000 ? remainder << 1 ^ 0x7B01BD : remainder << 1;
        }
    }
    return remainder & 0xFFFFFF;
}

/* ---- Lines (section 5) ---- */

enum { HEAD_BYTES = 69, ACK_BYTES = 5, CRC_BYTES = 4, SEQUENCES = 100 };

static void begin_line(char *line, char type, uint8_t sequence) {
    memset(line, ' ', GW_LINE_BYTES);
    line[0] = type;
    put_digits(line + 1, 2, sequence);
}

/* Writes the acknowledgement behind the head of a line, and all that follows it. */
static void end_line(char *line, uint8_t head, uint32_t ack) {
    put_six(line + head, ACK_BYTES, ack);
    head += ACK_BYTES;
    put_six(line + head, CRC_BYTES, crc24(0xFFFFFF, line, head));
    line[head + CRC_BYTES] = '\r';
    line[head + CRC_BYTES + 1] = '\n';
}

/* Returns whether the coordinate fits. */
static uint8_t put_position(char *to, int32_t tenths_in) {
    uint32_t magnitude = put_sign(to, tenths_in);
    if (magnitude < 10000) {
        put_digits(to + 1, 4, magnitude);
        to[5] = to[4];
        to[4] = '.';
    } else {
        put_digits(to + 1, 5, magnitude / 10);
    }
    return magnitude < 1000000;
}

static void put_state(char *line, const struct gw_state *state) {
    uint8_t fits = put_position(line + 4, state->x_tenths_in);
    fits &= put_position(line + 11, state->y_tenths_in);
    put_digits(line + 18, 3, state->theta_deg < 360 ? state->theta_deg : 0);
    put_signed(line + 22, 3, state->velocity_in_s);
    put_signed(line + 26, 3, state->rotation_in_s);
    put_signed(line + 30, 3, state->wheel_left_in_s);
    put_signed(line + 34, 3, state->wheel_right_in_s);
    put_optional(line + 38, 3, state->sonar_left_in);
    put_optional(line + 42, 3, state->sonar_right_in);
    put_optional(line + 46, 2, state->photo_left_pct);
    put_optional(line + 49, 2, state->photo_right_pct);
    line[52] = state->bump;
    line[53] = state->infrared;
    line[54] = state->cliff;
    line[55] = state->arm;
    line[56] = state->drive == '.' && !fits ? 'o' : state->drive;
    line[57] = state->power;
    line[58] = state->link;
    line[60] = state->mode;
    memcpy(line + 61, state->layers, 7);
}

/* An acknowledgement that says: this robot cannot hear (section 6). */
#define CANNOT_HEAR ((uint32_t)1 << 17 | (uint32_t)79 << 10)

void gw_line_a(char line[GW_LINE_BYTES], const struct gw_state *state, uint8_t robot_id, uint8_t sequence) {
    begin_line(line, 'A', sequence);
    put_state(line, state);
    end_line(line, HEAD_BYTES, CANNOT_HEAR | robot_id);
}

#if GW_LEVEL >= 2 || defined(GW_LINE_I)

static const char MODES[] = "PRHXUWGFC";

static void put_abilities(char *line, const char *modes, uint8_t robot_id) {
    put_digits(line + 4, 2, robot_id);
    line[7] = '0' + GW_LEVEL;
    put_digits(line + 9, 3, GW_LEVEL >= 3 ? GW_WAYPOINTS : 0);
    for (uint8_t n = 0; MODES[n] != 0; n++) {
        line[13 + n] = strchr(modes, MODES[n]) != NULL ? MODES[n] : '.';
    }
    memcpy(line + 23, GW_MEASURED, 4);
    put_digits(line + 28, 5, GW_RATE);
    line[34] = '0' + GW_FIELDS;
}

#if GW_LEVEL == 1
void gw_line_i(char line[GW_LINE_BYTES], const char *modes, uint8_t robot_id, uint8_t sequence) {
    begin_line(line, 'I', sequence);
    put_abilities(line, modes, robot_id);
    end_line(line, HEAD_BYTES, CANNOT_HEAR | robot_id);
}
#endif

#endif

#if GW_LEVEL >= 2

static uint8_t get_six(const char *from, uint8_t width, uint32_t *value) {
    *value = 0;
    while (width-- > 0) {
        char character = *from++;
        if (character != '`' && (character <= ' ' || character > '_')) {
            return 0;
        }
        *value = *value << 6 | (character == '`' ? 0 : (uint32_t)(character - ' '));
    }
    return 1;
}

/* ---- Waypoint lists (sections 10 and 11) ---- */

#if GW_LEVEL >= 3

#define BLOCK 4
#define BLOCKS ((GW_WAYPOINTS + BLOCK - 1) / BLOCK)

static uint32_t crc32_pair(uint32_t remainder, uint16_t pair) {
    remainder ^= pair;
    for (uint8_t bit = 0; bit < 16; bit++) {
        remainder = remainder & 1 ? remainder >> 1 ^ 0xEDB88320 : remainder >> 1;
    }
    return remainder;
}

static uint32_t list_digest(const struct gw_waypoint *list, uint16_t count) {
    uint32_t remainder = crc32_pair(0xFFFFFFFF, count);
    for (; count > 0; count--, list++) {
        remainder = crc32_pair(remainder, (uint16_t)list->x_in);
        remainder = crc32_pair(remainder, (uint16_t)list->y_in);
    }
    return ~remainder;
}

static uint8_t has_block(const struct gw *gw, uint16_t block) {
    return block < BLOCKS && gw->arrived[block / 8] >> block % 8 & 1;
}

static uint16_t first_missing(const struct gw *gw) {
    uint16_t block = 0;
    while (has_block(gw, block)) {
        block++;
    }
    return block;
}

static void drop_staged(struct gw *gw) {
    gw->staged_is_open = 0;
    memset(gw->arrived, 0, sizeof gw->arrived);
}

static enum gw_outcome activate(struct gw *gw, uint8_t tag, uint16_t count, uint32_t digest) {
    uint8_t bank = 1 - gw->active_bank;
    if (count > GW_WAYPOINTS) {
        return GW_BAD_VALUE;
    }
    if (count > 0 && !(gw->staged_is_open && gw->staged_tag == tag && first_missing(gw) >= (count + BLOCK - 1) / BLOCK)) {
        return GW_LIST_INCOMPLETE;
    }
    if (list_digest(gw->banks[bank], count) != digest) {
        return GW_DIGEST_MISMATCH;
    }
    gw->active_bank = bank;
    gw->active_count = count;
    gw->active_digest = digest;
    gw->reached = 0;
    drop_staged(gw);
    gw->status_due = 1;
    gw_list_replaced();
    return GW_DONE;
}

struct gw_waypoint gw_waypoint(const struct gw *gw, uint16_t n) {
    return gw->banks[gw->active_bank][n];
}

#endif

/* ---- Frames (section 9) ---- */

struct message {
    char type;
    char order; /* of a command; '?' if it cannot be read */
    char mode;
    uint8_t sequence;
    int16_t receipt; /* or GW_NONE */
    int16_t era;     /* or GW_NONE */
    uint16_t owner;
    uint8_t boot, replaces;
    uint8_t which, allowed;
#if GW_LEVEL >= 3
    uint8_t tag, first_block, waypoints;
    uint16_t count;
    uint32_t digest;
#endif
#if GW_LEVEL >= 4
    int8_t velocity_in_s, rotation_in_s;
    uint8_t heard, drive_count;
    int16_t x_in, y_in;
    uint16_t theta_deg, silence_s;
#endif
#if GW_LEVEL >= 5
    uint8_t has_value;
    uint16_t place;
    uint32_t key;
    int32_t value;
#endif
};

enum verdict { HEARD, BAD_CHECKSUM, UNREADABLE };

/* Whether the four characters behind the bytes are their checksum. */
static uint8_t holds(const char *bytes, uint8_t count, uint32_t key) {
    char checksum[CRC_BYTES];
    put_six(checksum, CRC_BYTES, crc24(key, bytes, count));
    return memcmp(checksum, bytes + count, CRC_BYTES) == 0;
}

static uint32_t robot_key(const struct gw *gw) {
    return (uint32_t)gw->robot_id << 16;
}

static uint32_t session_key(const struct gw *gw) {
    uint32_t key = robot_key(gw) | (uint16_t)((gw->boots & 7) << 13 | gw->session << 10 | gw->owner);
    if (gw->is_numbered) {
        key ^= (uint32_t)(gw->era & 0x7F) << 16 | gw->era >> 7;
    }
    return key;
}

#if GW_LEVEL >= 3
static uint8_t get_waypoint(const char *from, int16_t *x_in, int16_t *y_in) {
    uint32_t bits;
    if (!get_six(from, 5, &bits)) {
        return 0;
    }
    *x_in = (int16_t)((int32_t)(bits >> 15) - 16384);
    *y_in = (int16_t)((int32_t)(bits & 0x7FFF) - 16384);
    return *x_in >= -9999 && *x_in <= 9999 && *y_in >= -9999 && *y_in <= 9999;
}
#endif

static uint8_t is_mode(char mode) {
    return mode != 0 && strchr(MODES, mode) != NULL;
}

/* Reads an order from the bytes behind its letter. */
static uint8_t read_order(const char *from, uint8_t count, struct message *message) {
    uint32_t bits;
    switch (message->order) {
    case 'M':
        message->mode = from[0];
        return count == 1 && is_mode(message->mode);
    case 'L':
        if (count != 3 || !get_six(from, 3, &bits)) {
            return 0;
        }
        message->which = (uint8_t)(bits >> 8);
        message->allowed = (uint8_t)bits;
        return bits >> 16 == 0 && (message->allowed & ~message->which) == 0;
#if GW_LEVEL >= 3
    case 'A': {
        uint32_t tag, top;
        if (count != 9 || !get_six(from, 1, &tag) || !get_six(from + 1, 2, &bits) || !get_six(from + 3, 1, &top)
            || !get_six(from + 4, 5, &message->digest)) {
            return 0;
        }
        message->tag = (uint8_t)tag;
        message->count = (uint16_t)bits;
        message->digest |= top << 30;
        return top < 4;
    }
#endif
#if GW_LEVEL >= 4
    case 'P':
        if (count != 7 || !get_waypoint(from, &message->x_in, &message->y_in) || !get_six(from + 5, 2, &bits)) {
            return 0;
        }
        message->theta_deg = (uint16_t)bits;
        return bits < 360;
    case 'S':
        return count == 0;
    case 'F':
        if (count != 3 || !get_six(from, 2, &bits)) {
            return 0;
        }
        message->silence_s = (uint16_t)bits;
        message->mode = from[2];
        return is_mode(message->mode) && (bits > 0 || message->mode == 'X');
#endif
#if GW_LEVEL >= 5
    case 'V':
        if ((count != 4 && count != 7) || !get_six(from, 4, &message->key)) {
            return 0;
        }
        message->has_value = count == 7;
        if (message->has_value) {
            if (!get_six(from + 4, 3, &bits)) {
                return 0;
            }
            message->value = bits & 0x20000 ? (int32_t)bits - 0x40000 : (int32_t)bits;
        }
        return 1;
    case 'N':
        if (count != 2 || !get_six(from, 2, &bits)) {
            return 0;
        }
        message->place = (uint16_t)bits;
        return 1;
    case 'K':
        return count == 0;
#endif
    default:
        return 0;
    }
}

static uint8_t read_message(const char *from, uint8_t count, struct message *message) {
    uint32_t bits;
    memset(message, 0, sizeof *message);
    message->type = *from++;
    count--;
    switch (message->type) {
    case 'X':
        message->receipt = GW_NONE;
        if (count == 0) {
            return 1;
        }
        if (count != 3 || !get_six(from, 3, &bits) || bits > 0x7FFF) {
            return 0;
        }
        message->receipt = (int16_t)bits;
        return 1;
    case 'O':
        message->era = GW_NONE;
        if ((count != 3 && count != 6) || !get_six(from, 3, &bits) || bits > 0xFFFF || (bits & 0x3FF) == 0) {
            return 0;
        }
        message->boot = (uint8_t)(bits >> 13);
        message->replaces = bits >> 10 & 7;
        message->owner = bits & 0x3FF;
        if (count == 6) {
            if (!get_six(from + 3, 3, &bits) || bits > 0x3FFF) {
                return 0;
            }
            message->era = (int16_t)bits;
        }
        return 1;
    case 'C':
        if (count == 0 || !get_six(from, 1, &bits)) {
            return 0;
        }
        message->sequence = (uint8_t)bits;
        message->order = count > 1 ? from[1] : '?';
        if (count < 2 || !read_order(from + 2, (uint8_t)(count - 2), message)) {
            message->order = '?';
        }
        return 1;
#if GW_LEVEL >= 3
    case 'W': {
        int16_t x_in, y_in;
        if (count < 7 || (count - 2) % 5 != 0 || count > 2 + 5 * 16 || !get_six(from, 2, &bits)) {
            return 0;
        }
        message->tag = (uint8_t)(bits >> 7);
        message->first_block = bits & 0x7F;
        message->waypoints = (uint8_t)((count - 2) / 5);
        for (uint8_t n = 0; n < message->waypoints; n++) {
            if (!get_waypoint(from + 2 + 5 * n, &x_in, &y_in)) {
                return 0;
            }
        }
        return message->tag > 0 && message->first_block < 75;
    }
#endif
#if GW_LEVEL >= 4
    case 'D':
        if (count != 4 || !get_six(from, 4, &bits)) {
            return 0;
        }
        message->velocity_in_s = (int8_t)((int8_t)(bits >> 18 & 0x3F) - (int8_t)(bits >> 17 & 0x40));
        message->rotation_in_s = (int8_t)((int16_t)(bits >> 11 & 0x7F) - (int16_t)(bits >> 10 & 0x80));
        message->heard = bits >> 4 & 0x7F;
        message->drive_count = bits & 0xF;
        return message->heard < SEQUENCES && message->velocity_in_s >= -31 && message->rotation_in_s >= -63;
    case 'L':
        if (count != 2 || !get_six(from, 2, &bits)) {
            return 0;
        }
        message->heard = (uint8_t)bits;
        return bits < SEQUENCES;
#endif
    default:
        return 0;
    }
}

/* Judges the bytes between two line feeds. */
static enum verdict read_frame(const struct gw *gw, const char *frame, uint8_t count, struct message *message) {
    uint8_t is_intact;
    if (count < 1 + CRC_BYTES) {
        return BAD_CHECKSUM;
    }
    count -= CRC_BYTES;
    switch (frame[0]) {
    case 'X':
        is_intact = holds(frame, count, robot_key(gw)) || holds(frame, count, 0);
        break;
    case 'O':
        is_intact = holds(frame, count, robot_key(gw));
        break;
    default:
        is_intact = gw->owner != 0 && holds(frame, count, session_key(gw));
    }
    if (!is_intact) {
        return BAD_CHECKSUM;
    }
    return read_message(frame, count, message) ? HEARD : UNREADABLE;
}

/* ---- The receiver (section 11) ---- */

static uint32_t ack_bits(const struct gw *gw, uint32_t detail) {
    uint16_t top = (uint16_t)((gw->boots & 7) << 11 | gw->session << 8 | (gw->sequence & 7) << 5 | gw->outcome << 2);
    return (uint32_t)top << 16 | detail;
}

static uint32_t owner_detail(const struct gw *gw) {
    return (uint32_t)gw->owner << 7 | gw->robot_id;
}

static uint32_t receiver_detail(const struct gw *gw) {
#if GW_LEVEL >= 3
    if (gw->staged_is_open) {
        uint16_t missing = first_missing(gw);
        uint8_t window = 0;
        for (uint8_t n = 0; n < 8; n++) {
            window |= (uint8_t)(has_block(gw, (uint16_t)(missing + 1 + n)) << n);
        }
        return (uint32_t)(1 << 9 | missing << 2 | (gw->staged_tag & 3)) << 8 | window;
    }
#endif
    return gw->receipt == GW_NONE ? owner_detail(gw) : (uint32_t)7 << 15 | (uint32_t)gw->receipt;
}

/* The acknowledgement in the line of a sequence. One in three shows the era, or in turn with it the owner. */
static uint32_t acknowledge(const struct gw *gw, uint8_t sequence) {
    uint8_t turn = sequence % 6;
    if (turn == 4 && gw->receipt != GW_NONE) {
        return ack_bits(gw, owner_detail(gw));
    }
    if (turn == 1 || turn == 4) {
        return ack_bits(gw, (uint32_t)0xD << 14 | gw->era);
    }
    return ack_bits(gw, receiver_detail(gw));
}

static void begin_session(struct gw *gw, uint16_t owner) {
    if (gw->session == 7) {
        gw->era = (gw->era + 1) & 0x3FFF;
    }
    gw->session = gw->session % 7 + 1;
    gw->owner = owner;
    gw->is_numbered = 0;
    gw->sequence = 0;
    gw->outcome = GW_DONE;
    gw->drive_count = 0;
    gw->receipt = GW_NONE;
#if GW_LEVEL >= 3
    drop_staged(gw);
    gw->staged_tag = 0;
#endif
}

static void enter_mode(struct gw *gw, char mode) {
    gw->mode = mode;
#if GW_LEVEL >= 4
    if (gw->failsafe_acts) {
        gw->failsafe_acts = 0;
        gw_say(gw, "failsafe ended by a command");
    }
#endif
}

#if GW_LEVEL >= 4

static uint8_t is_recent(const struct gw *gw, uint8_t sequence, uint32_t now_ms) {
    uint8_t behind = (uint8_t)(gw->line_sequence + SEQUENCES - sequence) % SEQUENCES;
    return behind < 16 && (uint16_t)((uint16_t)now_ms - gw->begun_ms[sequence % 16]) <= 1200;
}

static void drive(struct gw *gw, const struct message *message, uint32_t now_ms) {
    uint8_t ahead = (message->drive_count - gw->drive_count) & 0xF;
    if (ahead < 1 || ahead > 7 || gw->mode == 'X' || gw->failsafe_acts || !gw->is_live
        || !is_recent(gw, message->heard, now_ms)) {
        return;
    }
    gw->drive_count = message->drive_count;
    gw->live_ms = gw->drive_ms = now_ms;
    gw->is_driven = 1;
    gw_drive(message->velocity_in_s, message->rotation_in_s);
}

#endif

#if GW_LEVEL >= 5

static void queue_parameter(struct gw *gw, uint8_t index) {
    gw->parameters_due[index / 8] |= (uint8_t)(1 << index % 8);
}

static enum gw_outcome set_parameter(struct gw *gw, const struct message *message) {
    for (uint8_t index = 0; index < gw->parameter_count; index++) {
        struct gw_parameter *parameter = &gw->parameters[index];
        if (crc24(0xFFFFFF, parameter->name, (uint8_t)strlen(parameter->name)) != message->key) {
            continue;
        }
        queue_parameter(gw, index);
        if (message->has_value) {
            if (message->value < parameter->least || message->value > parameter->most) {
                return GW_BAD_VALUE;
            }
            parameter->value = message->value;
            gw_parameter_set(index);
        }
        return GW_DONE;
    }
    return GW_UNKNOWN;
}

static enum gw_outcome queue_parameters(struct gw *gw, uint16_t place) {
    if (place > gw->parameter_count) {
        return GW_BAD_VALUE;
    }
    if (place > 0) {
        queue_parameter(gw, (uint8_t)(place - 1));
        return GW_DONE;
    }
    for (uint8_t index = 0; index < gw->parameter_count; index++) {
        queue_parameter(gw, index);
    }
    return GW_DONE;
}

static enum gw_outcome keep_parameters(struct gw *gw) {
    enum gw_outcome outcome = gw_keep_parameters();
    if (outcome != GW_DONE) {
        return outcome;
    }
    for (uint8_t index = 0; index < gw->parameter_count; index++) {
        struct gw_parameter *parameter = &gw->parameters[index];
        if (parameter->kept != parameter->value) {
            parameter->kept = parameter->value;
            queue_parameter(gw, index);
        }
    }
    return GW_DONE;
}

#endif

static enum gw_outcome execute(struct gw *gw, const struct message *message) {
    switch (message->order) {
    case 'M':
        if (strchr(gw->modes, message->mode) == NULL) {
            return GW_NOT_FITTED;
        }
        enter_mode(gw, message->mode);
        gw_mode_entered();
        return GW_DONE;
    case 'L':
        if ((message->allowed & ~gw->fitted) != 0) {
            return GW_NOT_FITTED;
        }
        gw->allowed = (uint8_t)((gw->allowed & ~message->which) | message->allowed);
#if GW_LEVEL >= 3
        gw->status_due = 1;
#endif
        return GW_DONE;
#if GW_LEVEL >= 3
    case 'A':
        return activate(gw, message->tag, message->count, message->digest);
#endif
#if GW_LEVEL >= 4
    case 'P':
        return gw_set_pose(message->x_in, message->y_in, (int16_t)message->theta_deg);
    case 'S':
        return gw_scan();
    case 'F':
        if (message->silence_s > 0) {
            if (message->silence_s < 10 || message->mode == 'U' || message->mode == 'C') {
                return GW_BAD_VALUE;
            }
            if (strchr(gw->modes, message->mode) == NULL) {
                return GW_NOT_FITTED;
            }
        }
        gw->failsafe_silence_s = message->silence_s;
        gw->failsafe_mode = message->mode;
        return GW_DONE;
#endif
#if GW_LEVEL >= 5
    case 'V':
        return set_parameter(gw, message);
    case 'N':
        return queue_parameters(gw, message->place);
    case 'K':
        return keep_parameters(gw);
#endif
    default:
        return GW_UNKNOWN;
    }
}

#if GW_LEVEL >= 3
static void stage(struct gw *gw, const struct message *message) {
    uint8_t ahead = (message->tag - gw->staged_tag) & 31;
    uint16_t first = message->first_block * BLOCK;
    if (ahead == 0 ? !gw->staged_is_open : ahead > 15) {
        return;
    }
    if (ahead > 0) {
        drop_staged(gw);
        gw->staged_is_open = 1;
        gw->staged_tag = message->tag;
    }
    if (first + message->waypoints > GW_WAYPOINTS) {
        return;
    }
    for (uint8_t n = 0; n < message->waypoints; n++) {
        struct gw_waypoint *waypoint = &gw->banks[1 - gw->active_bank][first + n];
        uint16_t block = (uint16_t)(first + n) / BLOCK;
        get_waypoint(gw->frame + 3 + 5 * n, &waypoint->x_in, &waypoint->y_in);
        gw->arrived[block / 8] |= (uint8_t)(1 << block % 8);
    }
}
#endif

static void obey(struct gw *gw, const struct message *message, uint32_t now_ms) {
    (void)now_ms;
    switch (message->type) {
    case 'X':
        if (gw->owner != 0) {
            begin_session(gw, 0);
        } else {
            gw->sequence = (gw->sequence + 1) & 63;
        }
        gw->receipt = message->receipt;
        enter_mode(gw, 'X');
        gw_stop();
        break;
    case 'O':
        if (message->boot == (gw->boots & 7) && message->replaces == gw->session
            && (message->era == GW_NONE || message->era == (int16_t)gw->era)) {
            begin_session(gw, message->owner);
            gw->is_numbered = message->era != GW_NONE;
            gw->introductions = 1 + GW_FIELDS;
#if GW_LEVEL >= 4
            gw->is_live = 1;
            gw->live_ms = now_ms;
#endif
        }
        break;
    case 'C':
        if (message->sequence == ((gw->sequence + 1) & 63)) {
            gw->sequence = message->sequence;
            gw->outcome = (uint8_t)execute(gw, message);
        }
        break;
#if GW_LEVEL >= 3
    case 'W':
        stage(gw, message);
        break;
#endif
#if GW_LEVEL >= 4
    case 'D':
        drive(gw, message, now_ms);
        break;
    case 'L':
        if (is_recent(gw, message->heard, now_ms)) {
            gw->is_live = 1;
            gw->live_ms = now_ms;
        }
        break;
#endif
    default:
        break;
    }
}

void gw_receive(struct gw *gw, uint8_t byte, uint32_t now_ms) {
    struct message message;
    uint8_t length = gw->frame_length;
#if GW_LEVEL >= 4
    if (byte == '\n') {
        gw->echoes_due = 4;
    }
#endif
#if GW_LEVEL >= 5
    if (gw->turn_is_open) {
        gw->turn_has_heard = 1;
        gw->turn_silent = 0;
        gw->turn_has_line_feed |= byte == '\n';
        gw->turn_line_feeds = byte == '\n' ? gw->turn_line_feeds + 1 : 0;
    }
#endif
    if (byte != '\n') {
        if (length < GW_FRAME_BYTES) {
            gw->frame[length] = (char)byte;
        }
        if (length <= GW_FRAME_BYTES) {
            gw->frame_length++;
        }
        return;
    }
    gw->frame_length = 0;
    if (length == 0) {
        return;
    }
    if (length > GW_FRAME_BYTES || read_frame(gw, gw->frame, length, &message) != HEARD) {
#if GW_LEVEL >= 4
        gw->frames_rejected++;
#endif
        return;
    }
#if GW_LEVEL >= 4
    gw->frames_heard++;
    gw->frame_ms = now_ms;
#endif
    obey(gw, &message, now_ms);
}

/* ---- The other lines (section 5) ---- */

#if GW_LEVEL >= 4 || GW_FIELDS > 0
/* Printable characters, cut and padded with the spaces that are there. */
static void put_text(char *to, uint8_t width, const char *text) {
    for (; width > 0 && *text != 0; width--, text++) {
        *to++ = *text < ' ' || *text > '~' ? '?' : *text;
    }
}
#endif

#if GW_FIELDS > 0
static void put_field(const struct gw *gw, char *line, uint8_t index) {
    const struct gw_field *field = &gw->fields[index];
    line[4] = (char)('1' + index);
    line[5] = '/';
    line[6] = '0' + GW_FIELDS;
    put_text(line + 8, 18, field->name);
    put_digits(line + 27, 1, field->decimals);
    put_text(line + 29, 11, field->unit);
}

static void put_values(char *line, const int32_t *values, uint8_t count) {
    for (uint8_t n = 0; n < 9; n++, line += 7) {
        if (n < count && values[n] != GW_NO_VALUE) {
            put_signed(line + 4, 6, values[n]);
        } else {
            memset(line + 4, '-', 6);
        }
    }
}
#endif

#if GW_LEVEL >= 3

static void put_status(const struct gw *gw, char *line) {
    static const char LAYERS[] = "UBTISLMD";
    struct gw_status status;
    memset(&status, 0, sizeof status);
    gw_fill_status(&status);
    put_digits(line + 4, 2, gw->robot_id);
    if (status.battery_dv > 999) {
        status.battery_dv = 999;
    }
    put_digits(line + 7, 2, (uint32_t)status.battery_dv / 10);
    line[9] = '.';
    put_digits(line + 10, 1, (uint32_t)status.battery_dv % 10);
    if (status.has_target) {
        put_signed(line + 12, 5, status.target_x_in);
        put_signed(line + 18, 5, status.target_y_in);
    } else {
        memset(line + 12, '-', 5);
        memset(line + 18, '-', 5);
    }
    put_digits(line + 24, 3, gw->reached < gw->active_count ? gw->reached : gw->active_count);
    line[27] = '/';
    put_digits(line + 28, 3, gw->active_count);
    put_six(line + 32, 6, gw->active_digest);
    put_digits(line + 39, 2, status.max_count);
    put_optional(line + 42, 3, status.photo_left);
    put_optional(line + 46, 3, status.photo_right);
    for (uint8_t layer = 0; layer < 8; layer++) {
        uint8_t bit = (uint8_t)(1 << layer);
        line[50 + layer] = gw->allowed & bit ? LAYERS[layer] : gw->fitted & bit ? '-' : '.';
    }
    put_last_digits(line + 59, 3, gw->boots);
    put_last_digits(line + 63, 2, gw->odometer_resets);
}

void gw_status_changed(struct gw *gw) {
    gw->status_due = 1;
}

#endif

#if GW_LEVEL >= 4

static void put_counters(const struct gw *gw, char *line) {
    put_digits(line + 4, 2, gw->robot_id);
    put_last_digits(line + 7, 6, gw->uptime_s);
    put_last_digits(line + 14, 3, gw->boots);
    put_digits(line + 18, 2, gw->version_major);
    line[20] = '.';
    put_digits(line + 21, 2, gw->version_minor);
    for (uint8_t holder = 0; holder < 9; holder++) {
        put_six(line + 24 + 2 * holder, 2, gw->ticks_won[holder]);
    }
    put_last_digits(line + 43, 3, gw->frames_heard);
    put_last_digits(line + 47, 3, gw->frames_rejected);
    put_last_digits(line + 51, 3, gw->ticks_late);
    put_last_digits(line + 55, 4, gw->bumps);
    put_optional(line + 60, 4, gw->failsafe_silence_s > 0 ? (int16_t)gw->failsafe_silence_s : GW_NONE);
    line[65] = gw->failsafe_silence_s > 0 ? gw->failsafe_mode : '-';
}

void gw_say(struct gw *gw, const char *text) {
    gw->text = text;
}

#endif

#if GW_LEVEL >= 5

static void put_parameter(const struct gw *gw, char *line, uint8_t index) {
    const struct gw_parameter *parameter = &gw->parameters[index];
    put_digits(line + 4, 2, (uint32_t)index + 1);
    line[6] = '/';
    put_digits(line + 7, 2, gw->parameter_count);
    put_text(line + 10, 18, parameter->name);
    put_signed(line + 29, 6, parameter->value);
    put_signed(line + 36, 6, parameter->kept);
    put_signed(line + 43, 6, parameter->least);
    put_signed(line + 50, 6, parameter->most);
    put_text(line + 57, 11, parameter->unit);
}

static void put_song(char *line, const struct gw_note *notes, uint8_t count) {
    for (uint8_t n = 0; n < count && n < 21; n++) {
        put_six(line + 4 + 3 * n, 2, notes[n].hz);
        put_six(line + 6 + 3 * n, 1, notes[n].ticks);
    }
}

void gw_sing(struct gw *gw, const struct gw_note *notes, uint8_t count) {
    gw->song = notes;
    gw->song_notes = count;
}

#endif

/* ---- Order of the lines (section 7) ---- */

/* Lines between two times that the robot introduces itself, lines I and F: 16 s at most. */
enum { INTRODUCTION_LINES = GW_RATE < 240 ? GW_RATE / 5 : 48 };

/* The next line for the robot's own account: I, F, V; 0 if none is due. An A follows it. */
static char choose_own(struct gw *gw) {
    if (gw->introductions > 0) {
        return gw->introductions == 1 + GW_FIELDS ? 'I' : 'F';
    }
#if GW_FIELDS > 0
    if (gw->until_values == 0) {
        return 'V';
    }
#endif
    return 0;
}

static void count_down(struct gw *gw) {
    if (gw->until_introduction-- == 0) {
        gw->until_introduction = INTRODUCTION_LINES - 1;
        gw->introductions = 1 + GW_FIELDS;
    }
#if GW_FIELDS > 0
    if (gw->until_values > 0) {
        gw->until_values--;
    }
#endif
}

static void compose_own(struct gw *gw, char type) {
    if (type == 'I') {
        put_abilities(gw->line, gw->modes, gw->robot_id);
    }
#if GW_FIELDS > 0
    if (type == 'F') {
        put_field(gw, gw->line, (uint8_t)(1 + GW_FIELDS - gw->introductions - 1));
    }
    if (type == 'V') {
        int32_t values[GW_FIELDS];
        gw_fill_values(values);
        put_values(gw->line, values, GW_FIELDS);
        gw->until_values = 3;
        return;
    }
#endif
    gw->introductions--;
}

#if GW_LEVEL >= 3

enum { STATES_PER_OTHER = 5, LINES_APART = 3 };

#if GW_LEVEL >= 4
/* Lines B and C take turns; a line B that was just sent for a change is not repeated. */
static char choose_other(struct gw *gw) {
    if (gw->counters_turn && gw->since_status < LINES_APART) {
        return 0;
    }
    gw->counters_turn = !gw->counters_turn;
    return gw->counters_turn ? 'C' : 'B';
}
#else
static char choose_other(struct gw *gw) {
    return gw->since_status < LINES_APART ? 0 : 'B';
}
#endif

static char choose_line(struct gw *gw) {
    if (gw->boot_lines > 0) {
        return gw->boot_lines-- == 2 ? 'C' : 'B';
    }
    if (!gw->after_state) {
        return 'A';
    }
    if (gw->states >= STATES_PER_OTHER) {
        char other = choose_other(gw);
        if (other != 0) {
            gw->states = 0;
            return other;
        }
    }
    if (gw->status_due && gw->since_status >= LINES_APART) {
        return 'B';
    }
#if GW_LEVEL >= 4
    if (gw->text != NULL && gw->since_text >= LINES_APART) {
        return 'T';
    }
#endif
    {
        char own = choose_own(gw);
        if (own != 0) {
            return own;
        }
    }
#if GW_LEVEL >= 5
    if (gw->song != NULL) {
        return 'S';
    }
    for (uint8_t n = 0; n < sizeof gw->parameters_due; n++) {
        if (gw->parameters_due[n] != 0) {
            return 'P';
        }
    }
#endif
    return 'A';
}

#endif

/* Counts a line and puts its head into gw->line. */
static void load_line(struct gw *gw, char type, uint8_t head, uint8_t length, uint32_t now_ms) {
    (void)now_ms;
    gw->line_sequence = (uint8_t)((gw->line_sequence + 1) % SEQUENCES);
    begin_line(gw->line, type, gw->line_sequence);
    gw->position = 0;
    gw->head = head;
    gw->length = length;
#if GW_RATE > 240
    gw->line_ms = (uint16_t)now_ms;
#endif
#if GW_LEVEL >= 4
    gw->begun_ms[gw->line_sequence % 16] = (uint16_t)now_ms;
#endif
}

static void compose_state(struct gw *gw) {
    struct gw_state state;
    memset(&state, 0, sizeof state);
    gw_fill_state(&state);
    state.mode = gw->mode;
#if GW_LEVEL >= 4
    state.link = gw->failsafe_acts ? 'F' : gw->owner != 0 && gw->failsafe_silence_s > 0 ? 'f' : '.';
#else
    state.link = '.';
#endif
    put_state(gw->line, &state);
}

static void compose(struct gw *gw, uint32_t now_ms) {
    char type;
    count_down(gw);
#if GW_LEVEL >= 3
    if (gw->since_status < LINES_APART) {
        gw->since_status++;
    }
#if GW_LEVEL >= 4
    if (gw->since_text < LINES_APART) {
        gw->since_text++;
    }
#endif
    type = choose_line(gw);
    load_line(gw, type, HEAD_BYTES, GW_LINE_BYTES, now_ms);
    gw->after_state = type == 'A';
    switch (type) {
    case 'I':
    case 'F':
    case 'V':
        compose_own(gw, type);
        return;
    case 'B':
        gw->status_due = 0;
        gw->since_status = 0;
        put_status(gw, gw->line);
        return;
#if GW_LEVEL >= 4
    case 'C':
        put_counters(gw, gw->line);
        return;
    case 'T':
        gw->since_text = 0;
        put_text(gw->line + 4, 64, gw->text);
        gw->text = NULL;
        return;
#endif
#if GW_LEVEL >= 5
    case 'S':
        put_song(gw->line, gw->song, gw->song_notes);
        gw->song = NULL;
        return;
    case 'P': {
        uint8_t index = 0;
        while ((gw->parameters_due[index / 8] >> index % 8 & 1) == 0) {
            index++;
        }
        gw->parameters_due[index / 8] &= (uint8_t)~(1 << index % 8);
        put_parameter(gw, gw->line, index);
        return;
    }
#endif
    default:
        if (gw->states < STATES_PER_OTHER) {
            gw->states++;
        }
        compose_state(gw);
    }
#else
    type = gw->after_state ? choose_own(gw) : 0;
    gw->after_state = type == 0;
    load_line(gw, type != 0 ? type : 'A', HEAD_BYTES, GW_LINE_BYTES, now_ms);
    if (type != 0) {
        compose_own(gw, type);
    } else {
        compose_state(gw);
    }
#endif
}

/* ---- The transmitter (section 7) ---- */

enum next { LONG_LINE, ACK_LINE, GO_AHEAD, LISTEN };

enum { ACK_LINE_HEAD = 3, ACK_LINE_BYTES = 14 };

#if GW_LEVEL >= 5
/* Byte times of a turn, and turns after which a long line is sent. */
enum { TURN_BYTES = 240, TURNS_A_LINE = 3 };

/* The lines before a turn of the ground: a line G, and while the ground sends, a line K before it. */
static void end_turn(struct gw *gw, uint8_t is_talked_to) {
    gw->ack_lines_due = 1;
    gw->next = is_talked_to ? ACK_LINE : GO_AHEAD;
}

static void listen(struct gw *gw) {
    if (!gw->turn_is_open) {
        gw->turn_is_open = 1;
        gw->turn_has_heard = gw->turn_has_line_feed = gw->turn_line_feeds = 0;
        gw->turn_silent = gw->turn_heard = 0;
    }
    gw->turn_silent++;
    gw->turn_heard += gw->turn_has_heard;
    if (gw->turn_line_feeds < 3 && gw->turn_silent < gw->patience_bytes && gw->turn_heard < TURN_BYTES) {
        return;
    }
    gw->turns++;
    gw->next = LONG_LINE;
    if (gw->turn_has_line_feed && gw->turns < TURNS_A_LINE) {
        end_turn(gw, 1);
    }
    gw->turn_is_open = 0;
    gw->has_rested = 0;
}
#endif

static void begin_long_line(struct gw *gw, uint32_t now_ms) {
    compose(gw, now_ms);
#if GW_LEVEL >= 4
    uint8_t is_talked_to = gw->echoes_due > 0;
    gw->echoes_due -= is_talked_to;
#if GW_LEVEL >= 5
    gw->turns = 0;
    if (gw->patience_bytes > 0) {
        end_turn(gw, is_talked_to);
        return;
    }
#endif
    gw->ack_lines_due = 3;
    gw->next = is_talked_to ? ACK_LINE : LONG_LINE;
#endif
}

#if GW_RATE > 240
enum { LINE_MS_MIN = 84 };

/* Whether the next line would be the thirteenth in a second (section 2). */
static uint8_t must_pause(const struct gw *gw, uint32_t now_ms) {
#if GW_LEVEL >= 5
    if (gw->next == LISTEN) {
        return 0;
    }
#endif
    return gw->length > 0 && (uint16_t)((uint16_t)now_ms - gw->line_ms) < LINE_MS_MIN;
}
#endif

int16_t gw_transmit(struct gw *gw, uint32_t now_ms) {
    if (!gw->has_rested) {
        gw->has_rested = 1;
        return GW_NONE;
    }
    if (gw->position == gw->length) {
#if GW_RATE > 240
        if (must_pause(gw, now_ms)) {
            return GW_NONE;
        }
#endif
        switch (gw->next) {
        case LONG_LINE:
            begin_long_line(gw, now_ms);
            break;
#if GW_LEVEL >= 4
        case ACK_LINE:
            load_line(gw, 'K', ACK_LINE_HEAD, ACK_LINE_BYTES, now_ms);
            if (--gw->ack_lines_due == 0) {
                gw->next = LONG_LINE;
#if GW_LEVEL >= 5
                gw->next = gw->patience_bytes > 0 ? GO_AHEAD : LONG_LINE;
#endif
            }
            break;
#endif
#if GW_LEVEL >= 5
        case GO_AHEAD:
            load_line(gw, 'G', ACK_LINE_HEAD, ACK_LINE_BYTES, now_ms);
            gw->next = LISTEN;
            break;
        case LISTEN:
            listen(gw);
            return GW_NONE;
#endif
        default:
            break;
        }
    }
    if (gw->position == gw->head) {
        end_line(gw->line, gw->head, acknowledge(gw, gw->line_sequence));
    }
    return (uint8_t)gw->line[gw->position++];
}

/* ---- Time ---- */

void gw_tick(struct gw *gw, uint32_t now_ms) {
#if GW_LEVEL >= 4
    while (now_ms - gw->second_ms >= 1000) {
        gw->second_ms += 1000;
        gw->uptime_s++;
    }
    if (gw->is_live && now_ms - gw->live_ms > 2000) {
        gw->is_live = 0;
    }
    if (gw->is_driven && now_ms - gw->drive_ms >= 1000) {
        gw->is_driven = 0;
        gw_drive(0, 0);
    }
    if (gw->failsafe_silence_s > 0 && gw->owner != 0 && !gw->failsafe_acts && gw->mode != 'X'
        && now_ms - gw->frame_ms >= gw->failsafe_silence_s * (uint32_t)1000) {
        gw->mode = gw->failsafe_mode;
        gw->failsafe_acts = 1;
        gw_say(gw, "failsafe: the ground is silent");
        if (gw->mode == 'X') {
            gw_stop();
        } else {
            gw_mode_entered();
        }
    }
#else
    (void)gw;
    (void)now_ms;
#endif
}

void gw_init(struct gw *gw, uint8_t robot_id, uint16_t boots, uint32_t now_ms) {
    memset(gw, 0, sizeof *gw);
    gw->robot_id = robot_id;
    gw->boots = boots;
    gw->era = ((boots >> 3) * 1021) & 0x3FFF;
    gw->receipt = GW_NONE;
    gw->modes = "X";
    gw->mode = 'X';
    gw->line_sequence = SEQUENCES - 1;
    gw->after_state = GW_LEVEL >= 3;
#if GW_LEVEL >= 3
    gw->active_digest = list_digest(NULL, 0);
    gw->boot_lines = GW_LEVEL >= 4 ? 2 : 1;
    gw->since_status = LINES_APART;
#endif
#if GW_LEVEL >= 4
    gw->frame_ms = gw->second_ms = now_ms;
    gw->counters_turn = 1;
    gw->since_text = LINES_APART;
#else
    (void)now_ms;
#endif
}

#endif /* GW_LEVEL >= 2 */

#endif /* GW_LEVEL */
