/*
 * A robot without a body: it moves as it is told, at once and exactly. The program Host drives it in real time, the tests
 * of the library in virtual time.
 */
#ifndef HOST_ROBOT_H
#define HOST_ROBOT_H

#include "../../src/groundwave.h"

#include <math.h>
#include <string.h>

#define BYTES_PER_S GW_RATE
#define TICKS_PER_S 20
#define CRUISE_IN_S 6.0
#define TURN_DEG_S 90.0
#define ARRIVED_IN 1.0
#define DEG 0.017453292519943295

static double x_in, y_in, theta_deg;
static double velocity_in_s, turn_deg_s;

#if GW_LEVEL >= 2

static struct gw gw;
static unsigned orders_heard;

#if GW_LEVEL >= 4
static int8_t hand_velocity_in_s, hand_rotation_in_s;
static unsigned drives_heard;
/* Inches between the wheels: a rotation of 1 in/s turns by this share of a radian. */
#define TRACK_IN 8.0
#endif

#if GW_LEVEL >= 5
static unsigned parameters_kept;
static struct gw_parameter parameters[] = {
    {.name = "top-speed", .unit = "in/s", .least = 2, .most = 12, .value = 6, .kept = 6},
    {.name = "turn-rate", .unit = "deg/s", .least = 10, .most = 180, .value = 90, .kept = 90},
};
#endif

static void start_robot(uint16_t boots, uint8_t patience_bytes, uint32_t now_ms) {
    gw_init(&gw, 7, boots, now_ms);
    orders_heard = 0;
    gw.modes = "PXUG";
    gw.mode = 'P';
    gw.fitted = GW_USER | GW_SONAR | GW_DEAD_RECKONING;
    gw.allowed = gw.fitted;
    x_in = y_in = theta_deg = velocity_in_s = turn_deg_s = 0;
#if GW_LEVEL >= 5
    gw.parameters = parameters;
    gw.parameter_count = sizeof parameters / sizeof *parameters;
    for (uint8_t n = 0; n < gw.parameter_count; n++) {
        parameters[n].value = parameters[n].kept;
    }
    gw.patience_bytes = patience_bytes;
#endif
    (void)patience_bytes;
}

/* Turns and drives towards a point; returns whether the robot is there. */
static int head_for(double to_x_in, double to_y_in) {
    double dx = to_x_in - x_in, dy = to_y_in - y_in;
    double off = atan2(dx, dy) / DEG - theta_deg;
    while (off > 180) {
        off -= 360;
    }
    while (off < -180) {
        off += 360;
    }
    turn_deg_s = off > 2 ? TURN_DEG_S : off < -2 ? -TURN_DEG_S : off;
    velocity_in_s = fabs(off) < 20 ? CRUISE_IN_S : 0;
    return hypot(dx, dy) < ARRIVED_IN;
}

static void think(void) {
    velocity_in_s = turn_deg_s = 0;
    switch (gw.mode) {
    case 'P':
#if GW_LEVEL >= 3
        if (gw.allowed & GW_DEAD_RECKONING && gw.reached < gw.active_count) {
            struct gw_waypoint to = gw_waypoint(&gw, gw.reached);
            gw.reached += (uint16_t)head_for(to.x_in, to.y_in);
            return;
        }
#endif
        velocity_in_s = CRUISE_IN_S;
        turn_deg_s = 20;
        break;
    case 'G':
        if (head_for(0, 0)) {
            gw.mode = 'X';
        }
        break;
#if GW_LEVEL >= 4
    case 'U':
        velocity_in_s = hand_velocity_in_s;
        turn_deg_s = hand_rotation_in_s / TRACK_IN / DEG;
        break;
#endif
    default:
        break;
    }
}

void gw_stop(void) {
    velocity_in_s = turn_deg_s = 0;
#if GW_LEVEL >= 4
    hand_velocity_in_s = hand_rotation_in_s = 0;
#endif
}

void gw_mode_entered(void) { orders_heard++; }

#if GW_LEVEL >= 3
void gw_list_replaced(void) {
    gw.reached = 0;
#if GW_LEVEL >= 4
    gw_say(&gw, gw.active_count > 0 ? "a new list" : "no list");
#endif
}

void gw_fill_status(struct gw_status *status) {
    status->battery_dv = 124;
    status->photo_left = status->photo_right = GW_NONE;
    if (gw.reached < gw.active_count) {
        struct gw_waypoint to = gw_waypoint(&gw, gw.reached);
        status->has_target = 1;
        status->target_x_in = to.x_in;
        status->target_y_in = to.y_in;
    }
}
#endif

#if GW_LEVEL >= 4
void gw_drive(int8_t velocity, int8_t rotation) {
    drives_heard++;
    hand_velocity_in_s = velocity;
    hand_rotation_in_s = rotation;
}

enum gw_outcome gw_set_pose(int16_t x, int16_t y, int16_t theta) {
    x_in = x;
    y_in = y;
    theta_deg = theta;
    gw.odometer_resets++;
    orders_heard++;
    return GW_DONE;
}

enum gw_outcome gw_scan(void) { return GW_NOT_FITTED; }
#endif

#if GW_LEVEL >= 5
void gw_parameter_set(uint8_t index) {
    (void)index;
    orders_heard++;
}
enum gw_outcome gw_keep_parameters(void) {
    parameters_kept++;
    return GW_DONE;
}
#endif

#endif /* GW_LEVEL >= 2 */

static void move(double seconds) {
    theta_deg = fmod(theta_deg + turn_deg_s * seconds + 360, 360);
    x_in += velocity_in_s * seconds * sin(theta_deg * DEG);
    y_in += velocity_in_s * seconds * cos(theta_deg * DEG);
}

static void fill_state(struct gw_state *state) {
    memset(state, 0, sizeof *state);
    state->x_tenths_in = (int32_t)lround(x_in * 10);
    state->y_tenths_in = (int32_t)lround(y_in * 10);
    state->theta_deg = (uint16_t)lround(theta_deg) % 360;
    state->velocity_in_s = (int8_t)lround(velocity_in_s);
    state->wheel_left_in_s = state->wheel_right_in_s = state->velocity_in_s;
    state->sonar_left_in = state->sonar_right_in = GW_NONE;
    state->photo_left_pct = state->photo_right_pct = GW_NONE;
    state->bump = state->infrared = state->cliff = state->arm = '-';
    state->drive = state->power = state->link = '.';
    state->mode = 'P';
    memset(state->layers, '.', sizeof state->layers);
}

#if GW_LEVEL >= 2
void gw_fill_state(struct gw_state *state) {
    fill_state(state);
    state->layers[3] = gw.allowed & GW_SONAR ? '-' : '.';
    state->layers[6] = gw.allowed & GW_DEAD_RECKONING ? '-' : '.';
#if GW_LEVEL >= 3
    if (gw.mode == 'P' && gw.allowed & GW_DEAD_RECKONING && gw.reached < gw.active_count) {
        state->layers[6] = 'D';
    }
#endif
}
#endif

static uint32_t milliseconds(uint64_t byte_times) { return (uint32_t)(byte_times * 1000 / BYTES_PER_S); }

#if GW_LEVEL >= 2
static void hear(uint8_t byte, uint32_t now_ms) { gw_receive(&gw, byte, now_ms); }

/* Lets a byte time pass; returns the byte that the robot sends, or GW_NONE. */
static int16_t pass_byte_time(uint64_t byte_times) {
    int16_t sent = gw_transmit(&gw, milliseconds(byte_times));
    if (byte_times % (BYTES_PER_S / TICKS_PER_S) == 0) {
        gw_tick(&gw, milliseconds(byte_times));
        think();
    }
    move(1.0 / BYTES_PER_S);
    return sent;
}
#else
static char line[GW_LINE_BYTES];
static uint64_t bytes_sent;

static void start_robot(uint16_t boots, uint8_t patience_bytes, uint32_t now_ms) {
    (void)boots;
    (void)patience_bytes;
    (void)now_ms;
    velocity_in_s = CRUISE_IN_S;
    turn_deg_s = 20;
    bytes_sent = 0;
}

static void hear(uint8_t byte, uint32_t now_ms) {
    (void)byte;
    (void)now_ms;
}

static int16_t pass_byte_time(uint64_t byte_times) {
    (void)byte_times;
    if (bytes_sent % GW_LINE_BYTES == 0) {
        struct gw_state state;
        fill_state(&state);
        gw_line_a(line, &state, 7, (uint8_t)(bytes_sent / GW_LINE_BYTES % 100));
    }
    move(1.0 / BYTES_PER_S);
    return (uint8_t)line[bytes_sent++ % GW_LINE_BYTES];
}
#endif

#endif
