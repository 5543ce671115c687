/*
 * Answers questions about the library, one a line on standard input; check.py asks them from the vectors.
 *
 *   crc INIT HEX                          remainder
 *   digest X Y ...                        digest of the waypoints
 *   A|B|C|P|S|T|F|V|K|G SEQUENCE ACK ...      the line, in hexadecimal
 *   level-1 SEQUENCE ID ...               line A of a robot that cannot hear
 *   frame ID BOOT SESSION OWNER ERA HEX   verdict on the last frame in these bytes, and its message
 *   boot ID BOOTS                         a robot boots
 *   hear OUTCOME HEX                      the robot hears these bytes; orders have this outcome
 */
#define GW_LEVEL 5
#define GW_WAYPOINTS 300
#define GW_FIELDS 9
#include "../src/groundwave.c"

#include <stdio.h>
#include <stdlib.h>

static struct gw robot;
static struct gw_state state;
static struct gw_status status;
static const char *action;

void gw_fill_state(struct gw_state *filled) { *filled = state; }
void gw_fill_status(struct gw_status *filled) { *filled = status; }
void gw_fill_values(int32_t values[GW_FIELDS]) { memset(values, 0, GW_FIELDS * sizeof *values); }
void gw_stop(void) { action = "stop"; }
void gw_mode_entered(void) {}
void gw_list_replaced(void) { action = "list replaced"; }
void gw_drive(int8_t velocity_in_s, int8_t rotation_in_s) {
    (void)velocity_in_s;
    (void)rotation_in_s;
    action = "drive";
}
enum gw_outcome gw_set_pose(int16_t x_in, int16_t y_in, int16_t theta_deg) {
    (void)x_in;
    (void)y_in;
    (void)theta_deg;
    return GW_DONE;
}
enum gw_outcome gw_scan(void) { return GW_DONE; }
void gw_parameter_set(uint8_t index) { (void)index; }
enum gw_outcome gw_keep_parameters(void) { return GW_DONE; }

/* The next word of the question; words are separated by tabs, so that texts may have spaces. */
static char *word(void) {
    char *next = strtok(NULL, "\t\n");
    if (next == NULL) {
        fprintf(stderr, "judge: a word is missing\n");
        exit(2);
    }
    return next;
}

static long number(void) { return strtol(word(), NULL, 0); }

static size_t from_hex(const char *text, uint8_t *bytes, size_t room) {
    size_t count = 0;
    unsigned byte;
    if (strcmp(text, "-") == 0) {
        return 0;
    }
    while (count < room && sscanf(text + 2 * count, "%2x", &byte) == 1) {
        bytes[count++] = (uint8_t)byte;
    }
    return count;
}

static void print_hex(const char *bytes, size_t count) {
    for (size_t n = 0; n < count; n++) {
        printf("%02x", (unsigned)(uint8_t)bytes[n]);
    }
    printf("\n");
}

static void fill_state(void) {
    state.x_tenths_in = number();
    state.y_tenths_in = number();
    state.theta_deg = number();
    state.velocity_in_s = number();
    state.rotation_in_s = number();
    state.wheel_left_in_s = number();
    state.wheel_right_in_s = number();
    state.sonar_left_in = number();
    state.sonar_right_in = number();
    state.photo_left_pct = number();
    state.photo_right_pct = number();
    state.bump = *word();
    state.infrared = *word();
    state.cliff = *word();
    state.arm = *word();
    state.drive = *word();
    state.power = *word();
    state.link = *word();
    state.mode = *word();
    memcpy(state.layers, word(), 7);
}

static void fill_status(void) {
    robot.robot_id = number();
    status.battery_dv = number();
    status.has_target = number();
    status.target_x_in = number();
    status.target_y_in = number();
    robot.reached = number();
    robot.active_count = number();
    robot.active_digest = strtoul(word(), NULL, 0);
    status.max_count = number();
    status.photo_left = number();
    status.photo_right = number();
    robot.fitted = number();
    robot.allowed = number();
    robot.boots = number();
    robot.odometer_resets = number();
}

static void fill_counters(void) {
    robot.robot_id = number();
    robot.uptime_s = number();
    robot.boots = number();
    robot.version_major = number();
    robot.version_minor = number();
    for (int holder = 0; holder < 9; holder++) {
        robot.ticks_won[holder] = number();
    }
    robot.frames_heard = number();
    robot.frames_rejected = number();
    robot.ticks_late = number();
    robot.bumps = number();
    robot.failsafe_silence_s = number();
    robot.failsafe_mode = *word();
}

static void fill_parameter(struct gw_parameter *parameter) {
    parameter->name = word();
    parameter->value = number();
    parameter->kept = number();
    parameter->least = number();
    parameter->most = number();
    parameter->unit = word();
}

static void answer_line(char type) {
    uint8_t sequence = number();
    uint32_t ack = strtoul(word(), NULL, 0);
    char *line = robot.line;
    if (type == 'K' || type == 'G') {
        begin_line(line, type, sequence);
        end_line(line, ACK_LINE_HEAD, ack);
        print_hex(line, ACK_LINE_BYTES);
        return;
    }
    begin_line(line, type, sequence);
    if (type == 'A') {
        fill_state();
        put_state(line, &state);
    } else if (type == 'B') {
        fill_status();
        put_status(&robot, line);
    } else if (type == 'C') {
        fill_counters();
        put_counters(&robot, line);
    } else if (type == 'T') {
        put_text(line + 4, 64, word());
    } else if (type == 'P') {
        static struct gw_parameter parameters[99];
        uint8_t place = number();
        robot.parameter_count = number();
        robot.parameters = parameters;
        fill_parameter(&parameters[place - 1]);
        put_parameter(&robot, line, place - 1);
    } else if (type == 'F') {
        static struct gw_field fields[GW_FIELDS];
        uint8_t place = number();
        robot.fields = fields;
        fields[place - 1].name = word();
        fields[place - 1].decimals = number();
        fields[place - 1].unit = word();
        put_field(&robot, line, place - 1);
    } else if (type == 'V') {
        int32_t values[GW_FIELDS];
        for (uint8_t n = 0; n < GW_FIELDS; n++) {
            const char *value = word();
            values[n] = *value == '-' && value[1] == 0 ? GW_NO_VALUE : strtol(value, NULL, 10);
        }
        put_values(line, values, GW_FIELDS);
    } else {
        struct gw_note notes[21];
        uint8_t count = number();
        for (uint8_t n = 0; n < count; n++) {
            notes[n].hz = number();
            notes[n].ticks = number();
        }
        put_song(line, notes, count);
    }
    end_line(line, HEAD_BYTES, ack);
    print_hex(line, GW_LINE_BYTES);
}

static void print_message(const struct gw *gw, const struct message *message) {
    printf("type=%c", message->type);
    switch (message->type) {
    case 'X':
        if (message->receipt != GW_NONE) {
            printf(" receipt=%d", message->receipt);
        }
        break;
    case 'O':
        printf(" boot=%u replaces=%u owner=%u", message->boot, message->replaces, message->owner);
        if (message->era != GW_NONE) {
            printf(" era=%d", message->era);
        }
        break;
    case 'W':
        printf(" tag=%u first_block=%u waypoints=", message->tag, message->first_block);
        for (int n = 0; n < message->waypoints; n++) {
            int16_t x_in = 0, y_in = 0;
            get_waypoint(gw->frame + 3 + 5 * n, &x_in, &y_in);
            printf("%s%d,%d", n == 0 ? "" : ",", x_in, y_in);
        }
        break;
    case 'D':
        printf(" velocity_in_s=%d rotation_in_s=%d heard=%u count=%u", message->velocity_in_s, message->rotation_in_s,
               message->heard, message->drive_count);
        break;
    case 'L':
        printf(" heard=%u", message->heard);
        break;
    default:
        printf(" sequence=%u order=%c", message->sequence, message->order);
        switch (message->order) {
        case 'M':
            printf(" mode=%c", message->mode);
            break;
        case 'L':
            printf(" which=%u allowed=%u", message->which, message->allowed);
            break;
        case 'P':
            printf(" x_in=%d y_in=%d theta_deg=%u", message->x_in, message->y_in, message->theta_deg);
            break;
        case 'F':
            printf(" silence_s=%u mode=%c", message->silence_s, message->mode);
            break;
        case 'A':
            printf(" tag=%u count=%u digest=%lu", message->tag, message->count, (unsigned long)message->digest);
            break;
        case 'V':
            printf(" key=%lu value=", (unsigned long)message->key);
            if (message->has_value) {
                printf("%ld", (long)message->value);
            }
            break;
        case 'N':
            printf(" place=%u", message->place);
            break;
        default:
            break;
        }
    }
    printf("\n");
}

/* Judges the last run of bytes that a line feed ends. */
static void answer_frame(void) {
    uint8_t bytes[1024];
    struct message message;
    enum verdict verdict = HEARD;
    uint8_t is_too_long = 0, has_frame = 0;
    uint8_t id = number();
    gw_init(&robot, id, number(), 0);
    robot.session = number();
    robot.owner = number();
    robot.era = number();
    robot.is_numbered = 1;
    size_t count = from_hex(word(), bytes, sizeof bytes);
    for (size_t n = 0; n < count; n++) {
        if (bytes[n] == '\n' && robot.frame_length > 0) {
            has_frame = 1;
            is_too_long = robot.frame_length > GW_FRAME_BYTES;
            verdict = is_too_long ? HEARD : read_frame(&robot, robot.frame, robot.frame_length, &message);
            robot.frame_length = 0;
        } else if (bytes[n] != '\n') {
            if (robot.frame_length < GW_FRAME_BYTES) {
                robot.frame[robot.frame_length] = (char)bytes[n];
            }
            robot.frame_length += robot.frame_length <= GW_FRAME_BYTES;
        }
    }
    if (!has_frame) {
        printf("none\n");
    } else if (is_too_long) {
        printf("too_long\n");
    } else if (verdict != HEARD) {
        printf("%s\n", verdict == UNREADABLE ? "unreadable" : "crc");
    } else {
        print_message(&robot, &message);
    }
}

static void answer_hear(void) {
    uint8_t bytes[1024];
    char ack[6] = {0};
    enum gw_outcome outcome = (enum gw_outcome)number();
    size_t count = from_hex(word(), bytes, sizeof bytes);
    uint16_t heard = robot.frames_heard;
    action = "nothing";
    for (size_t n = 0; n < count; n++) {
        struct message message;
        uint8_t sequence = robot.sequence, session = robot.session, length = robot.frame_length;
        memset(&message, 0, sizeof message);
        if (bytes[n] == '\n' && length > 0 && length <= GW_FRAME_BYTES
            && read_frame(&robot, robot.frame, length, &message) == HEARD) {
            /* The vectors look at the count of a drive frame only. */
            robot.is_live = 1;
            robot.mode = 'P';
            robot.failsafe_acts = 0;
            robot.line_sequence = message.heard;
        }
        gw_receive(&robot, bytes[n], 0);
        if (message.type == 'C' && robot.session == session && robot.sequence != sequence && message.order != 'A') {
            action = "execute";
            robot.outcome = (uint8_t)outcome;
        }
    }
    put_six(ack, ACK_BYTES, ack_bits(&robot, receiver_detail(&robot)));
    printf("%s\t%s\t%u\t%lu\n", robot.frames_heard == heard ? "not heard" : action, ack, robot.active_count,
           (unsigned long)robot.active_digest);
}

int main(void) {
    static char question[8192];
    while (fgets(question, sizeof question, stdin) != NULL) {
        char *kind = strtok(question, "\t\n");
        if (kind == NULL) {
            continue;
        }
        memset(&state, 0, sizeof state);
        memset(&status, 0, sizeof status);
        if (strcmp(kind, "crc") == 0) {
            uint8_t bytes[256];
            uint32_t init = strtoul(word(), NULL, 16);
            size_t count = from_hex(word(), bytes, sizeof bytes);
            printf("%06lx\n", (unsigned long)crc24(init, (const char *)bytes, (uint8_t)count));
        } else if (strcmp(kind, "digest") == 0) {
            static struct gw_waypoint waypoints[300];
            uint16_t count = number();
            for (uint16_t n = 0; n < count; n++) {
                waypoints[n].x_in = number();
                waypoints[n].y_in = number();
            }
            printf("%lu\n", (unsigned long)list_digest(waypoints, count));
        } else if (strcmp(kind, "level-1") == 0) {
            uint8_t sequence = number(), id = number();
            fill_state();
            gw_line_a(robot.line, &state, id, sequence);
            print_hex(robot.line, GW_LINE_BYTES);
        } else if (strcmp(kind, "frame") == 0) {
            answer_frame();
        } else if (strcmp(kind, "boot") == 0) {
            uint8_t id = number();
            gw_init(&robot, id, number(), 0);
            robot.modes = "PRHXUWGFC";
            robot.fitted = 0xFF;
            printf("booted\n");
        } else if (strcmp(kind, "hear") == 0) {
            answer_hear();
        } else {
            answer_line(*kind);
        }
        fflush(stdout);
    }
    return 0;
}
