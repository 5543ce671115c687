/*
 * The robot's end of the Groundwave wire (protocol/SPEC.md), for any C99 compiler: no heap, no floats, no libraries.
 *
 * Choose a level of section 1 of SPEC.md with -DGW_LEVEL=3. An Arduino sketch defines GW_LEVEL, then includes
 * groundwave.h and groundwave.c.
 *
 *   1  line A. The robot cannot hear.
 *   2  + commands, modes, layers, STOP
 *   3  + waypoint lists, line B
 *   4  + lines C, T and K, hand drive, failsafe, pose, scan
 *   5  + parameters, songs, half duplex
 *
 * Level 1 needs one function, gw_line_a. From level 2 on the robot's program
 *
 *   - calls gw_init once,
 *   - passes each byte of the radio to gw_receive,
 *   - sends the byte that gw_transmit returns, as often as the UART takes one,
 *   - calls gw_tick every 50 ms or more often,
 *   - defines the functions at the end of this file, which the library calls.
 *
 * None of these may run in an interrupt while another one runs: let the interrupts fill and empty a ring of 64 bytes.
 */
#ifndef GROUNDWAVE_H
#define GROUNDWAVE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if !defined(GW_LEVEL) || GW_LEVEL < 1 || GW_LEVEL > 5
#error "define GW_LEVEL: 1 to 5"
#endif

/* Most waypoints of a list, a multiple of 4 up to 300. Each takes 8 bytes of RAM: there are two lists. */
#ifndef GW_WAYPOINTS
#define GW_WAYPOINTS 40
#endif

/* Bytes a second that the robot takes: its baud rate / 10. The station sends no faster. Above 240 gw_transmit pauses between lines. */
#ifndef GW_RATE
#define GW_RATE 240
#endif

/* Readings of lines A and B that the robot has: B battery, W wheel speeds, S sonars, I max_count; a point for each that it lacks. */
#ifndef GW_MEASURED
#define GW_MEASURED "BWSI"
#endif

/* Fields of the robot's own in lines F and V, from level 2 on: 0 to 9. */
#ifndef GW_FIELDS
#define GW_FIELDS 0
#endif

#define GW_LINE_BYTES 80

/* Longest frame that this level can use, without its line feeds. */
#if GW_LEVEL >= 3
#define GW_FRAME_BYTES 87
#else
#define GW_FRAME_BYTES 24
#endif

/* A value that is not there: no echo, not fitted, no target. */
#define GW_NONE (-1)

/* What line A reports. Letters are those of SPEC.md, section 5. */
struct gw_state {
    int32_t x_tenths_in;
    int32_t y_tenths_in;
    uint16_t theta_deg;      /* 0 to 359, clockwise from +Y; 360 is sent as 0 */
    int8_t velocity_in_s;    /* requested, at the centre */
    int8_t rotation_in_s;    /* requested, left wheel minus right */
    int8_t wheel_left_in_s;  /* measured */
    int8_t wheel_right_in_s;
    int16_t sonar_left_in; /* or GW_NONE */
    int16_t sonar_right_in;
    int8_t photo_left_pct; /* 0 very bright to 99 dark, or GW_NONE */
    int8_t photo_right_pct;
    char bump;     /* . L C R l r S A J - */
    char infrared; /* . L R B J - */
    char cliff;    /* . L C R A - */
    char arm;      /* . u a L R B T - */
    char drive;    /* . s X 0; gw adds o, when X or Y do not fit */
    char power;    /* . l ! d + */
    char link;     /* . f F; from level 2 on set by the library */
    char mode;     /* P R H X U W G F C; from level 2 on set by the library */
    char layers[7]; /* . - or the layer's letter of BTISLMD, in lower case raised, in upper case holding the motors */
};

/* A robot without sensors that stands at its origin. */
#define GW_BLANK_STATE                                                                                                 \
    {                                                                                                                  \
        0, 0, 0, 0, 0, 0, 0, GW_NONE, GW_NONE, GW_NONE, GW_NONE, '-', '-', '-', '-', '.', '.', '.', 'P', {             \
            '.', '.', '.', '.', '.', '.', '.'                                                                          \
        }                                                                                                              \
    }

/* Writes line A with this sequence, 0 to 99, and an acknowledgement that says: this robot cannot hear. */
void gw_line_a(char line[GW_LINE_BYTES], const struct gw_state *state, uint8_t robot_id, uint8_t sequence);

#if GW_LEVEL == 1 && defined(GW_LINE_I)
/* Writes line I, which says what the robot lacks. Send it every 15 seconds. modes holds the letters of the robot's modes. From level 2 on
 * the library sends it. */
void gw_line_i(char line[GW_LINE_BYTES], const char *modes, uint8_t robot_id, uint8_t sequence);
#endif

#if GW_LEVEL >= 2

/* A field of the robot's own: line F. */
struct gw_field {
    const char *name; /* lower case letters, digits, hyphens; at most 18 */
    const char *unit; /* at most 11 characters */
    uint8_t decimals; /* digits of its values behind the point, 0 to 5 */
};

/* A field without a value at the moment. */
#define GW_NO_VALUE INT32_MIN

/* Bits of gw.fitted and gw.allowed. */
enum {
    GW_USER = 1 << 0,
    GW_BUMPERS = 1 << 1,
    GW_ROTATION = 1 << 2,
    GW_INFRARED = 1 << 3,
    GW_SONAR = 1 << 4,
    GW_PHOTO = 1 << 5,
    GW_MOTION = 1 << 6,
    GW_DEAD_RECKONING = 1 << 7
};

/* Result of an order. */
enum gw_outcome {
    GW_DONE = 0,
    GW_NOT_FITTED = 1,
    GW_BAD_VALUE = 2,
    GW_LIST_INCOMPLETE = 3,
    GW_DIGEST_MISMATCH = 4,
    GW_NOT_NOW = 5,
    GW_UNKNOWN = 6,
    GW_FAILED = 7
};

#if GW_LEVEL >= 3
struct gw_waypoint {
    int16_t x_in;
    int16_t y_in;
};

/* What line B reports besides what the library knows. */
struct gw_status {
    int16_t battery_dv;  /* tenths of a volt */
    int16_t target_x_in; /* meaningful if has_target */
    int16_t target_y_in;
    uint8_t has_target;
    uint8_t max_count;
    int16_t photo_left; /* 0 very bright to 255 dark, or GW_NONE */
    int16_t photo_right;
};
#endif

#if GW_LEVEL >= 5
/* A parameter: line P. Setting one calls gw_parameter_set. */
struct gw_parameter {
    const char *name; /* lower case letters, digits, hyphens; at most 18 */
    const char *unit; /* at most 11 characters */
    int32_t least; /* -99999 to 99999, as all values */
    int32_t most;
    int32_t value;
    int32_t kept; /* the value after a reset */
};

struct gw_note {
    uint16_t hz; /* 0: a rest */
    uint8_t ticks;
};
#endif

/* The state of the library. Fields without "read only" belong to the robot's program. */
struct gw {
    uint8_t fitted;    /* layers */
    uint8_t allowed;   /* layers, changed by orders */
    const char *modes; /* letters of the modes that the robot has, X among them */
    char mode;         /* changed by orders; the robot may change it, too */
#if GW_FIELDS > 0
    const struct gw_field *fields; /* a table of GW_FIELDS */
#endif

#if GW_LEVEL >= 3
    struct gw_waypoint banks[2][GW_WAYPOINTS]; /* read only; see gw_waypoint */
    uint8_t active_bank;                       /* read only */
    uint16_t active_count;                     /* read only */
    uint32_t active_digest;                    /* read only */
    uint16_t reached;                          /* waypoints of the active list; 0 after a new list */
    uint8_t staged_is_open;                    /* read only, as all that follows at this level */
    uint8_t staged_tag;
    uint8_t arrived[(GW_WAYPOINTS + 31) / 32];
    uint8_t boot_lines, status_due, states, since_status;
    uint16_t odometer_resets;
#endif

#if GW_LEVEL >= 4
    uint8_t version_major;
    uint8_t version_minor;
    uint16_t ticks_won[9]; /* by layers 0 to 7, then by prowl */
    uint16_t ticks_late;
    uint16_t bumps;
    uint16_t failsafe_silence_s; /* 0: carry on. Read only, as all that follows at this level */
    char failsafe_mode;
    uint8_t failsafe_acts;
    uint32_t frame_ms; /* time of the latest intact frame */
    uint32_t live_ms;  /* time of the latest sign that the ground is there */
    uint32_t drive_ms; /* time of the latest drive frame that was obeyed */
    uint32_t second_ms;
    uint32_t uptime_s;
    uint16_t begun_ms[16]; /* start of the latest lines, by sequence */
    uint16_t frames_heard;
    uint16_t frames_rejected;
    const char *text;
    uint8_t is_live, is_driven;
    uint8_t counters_turn, since_text;
    uint8_t echoes_due, ack_lines_due;
#endif

#if GW_LEVEL >= 5
    struct gw_parameter *parameters; /* a table of the robot's program */
    uint8_t parameter_count;
    uint8_t patience_bytes; /* 0: full duplex; else half duplex, 16 or more if the modem buffers */
    uint8_t parameters_due[13];
    const struct gw_note *song;
    uint8_t song_notes;
    uint8_t turn_is_open, turn_has_heard, turn_has_line_feed, turn_line_feeds, turn_silent, turn_heard, turns;
#endif

    /* Read only: the receiver. */
    uint8_t robot_id;
    uint16_t boots;
    uint8_t session;
    uint8_t is_numbered;
    uint16_t era;
    uint16_t owner; /* 0: no session is open */
    uint8_t sequence;
    uint8_t outcome;
    uint8_t drive_count;
    int16_t receipt; /* GW_NONE: no receipt */
    char frame[GW_FRAME_BYTES];
    uint8_t frame_length;

    /* Read only: the transmitter. */
    char line[GW_LINE_BYTES];
    uint8_t line_sequence, position, head, length, next, has_rested;
    uint8_t after_state;
#if GW_RATE > 240
    uint16_t line_ms; /* start of the latest line */
#endif
    uint8_t introductions, until_introduction; /* lines I and F to send, and lines A and B until the next ones */
#if GW_FIELDS > 0
    uint8_t until_values;
#endif
};

/* A robot that has just booted. boots counts up in memory that survives a reset; robot_id is 1 to 99. */
void gw_init(struct gw *gw, uint8_t robot_id, uint16_t boots, uint32_t now_ms);

/* Takes a byte of the radio. An order that it completes is carried out within the call. */
void gw_receive(struct gw *gw, uint8_t byte, uint32_t now_ms);

/* The next byte for the radio, once a byte time; GW_NONE leaves the carrier idle for that time. */
int16_t gw_transmit(struct gw *gw, uint32_t now_ms);

/* Lets time pass: hand drive that ends, the failsafe. Call it every 50 ms or more often. */
void gw_tick(struct gw *gw, uint32_t now_ms);

#if GW_LEVEL >= 3
/* A waypoint of the active list, from 0. */
struct gw_waypoint gw_waypoint(const struct gw *gw, uint16_t n);

/* Requests a line B, after a change that the library does not see: a new target. */
void gw_status_changed(struct gw *gw);
#endif

#if GW_LEVEL >= 4
/* Sends a text in a line T. It must stay valid until gw->text is NULL again; a text under way is replaced. */
void gw_say(struct gw *gw, const char *text);
#endif

#if GW_LEVEL >= 5
/* Sends a line S: up to 21 notes, which must stay valid until gw->song is NULL again. */
void gw_sing(struct gw *gw, const struct gw_note *notes, uint8_t count);
#endif

/* ---- Functions that the robot's program defines ---- */

/* Fills in line A. Events (bump, infrared, raised layers) cover the time since the previous call. */
void gw_fill_state(struct gw_state *state);

/* STOP: motors off, at once. gw.mode is 'X' already. */
void gw_stop(void);

/* A mode was ordered: gw.mode has it already. */
void gw_mode_entered(void);

#if GW_FIELDS > 0
/* Fills in line V: the fields' values, in units of their last decimal, -99999 to 99999, or GW_NO_VALUE. */
void gw_fill_values(int32_t values[GW_FIELDS]);
#endif

#if GW_LEVEL >= 3
/* The active list was replaced or cleared. */
void gw_list_replaced(void);

/* Fills in line B. */
void gw_fill_status(struct gw_status *status);
#endif

#if GW_LEVEL >= 4
/* Drives by hand at these speeds; called with 0, 0 when hand drive falls silent. */
void gw_drive(int8_t velocity_in_s, int8_t rotation_in_s);

/* Sets the pose; theta_deg is 0 to 359. */
enum gw_outcome gw_set_pose(int16_t x_in, int16_t y_in, int16_t theta_deg);

/* Turns on the spot and looks around. */
enum gw_outcome gw_scan(void);
#endif

#if GW_LEVEL >= 5
/* A parameter has a new value, within its limits. */
void gw_parameter_set(uint8_t index);

/* Stores the values of all parameters so that they survive a reset: GW_DONE, or GW_NOT_FITTED without such memory. */
enum gw_outcome gw_keep_parameters(void);
#endif

#endif /* GW_LEVEL >= 2 */

#ifdef __cplusplus
}
#endif

#endif
