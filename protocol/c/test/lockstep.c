/*
 * The robot of examples/Host in virtual time, for tests that hold the other end of standard input and output.
 *
 *   B boots patience        the robot boots
 *   + byte                  it hears a byte
 *   -                       a byte time passes; answers + and the byte sent, or - and 0
 *   ?                       answers a line: mode, orders heard, drive frames, active count, active digest, reached, X and Y
 *                           in inches, odometer resets
 *   W                       answers a line: X and Y of the active list's waypoints
 *   line feed               sends the answers
 */
#include "../examples/Host/robot.h"

#include <stdio.h>

static void tell(void) {
    char mode = 'P';
    unsigned orders = 0, drives = 0, active = 0, reached = 0, resets = 0;
    unsigned long digest = 0;
#if GW_LEVEL >= 2
    mode = gw.mode;
    orders = orders_heard;
#endif
#if GW_LEVEL >= 4
    drives = drives_heard;
#endif
#if GW_LEVEL >= 3
    active = gw.active_count;
    digest = gw.active_digest;
    reached = gw.reached;
    resets = gw.odometer_resets;
#endif
    printf("%c %u %u %u %lu %u %ld %ld %u\n", mode, orders, drives, active, digest, reached, lround(x_in), lround(y_in), resets);
}

static void tell_waypoints(void) {
#if GW_LEVEL >= 3
    for (uint16_t n = 0; n < gw.active_count; n++) {
        struct gw_waypoint waypoint = gw_waypoint(&gw, n);
        printf("%d %d ", waypoint.x_in, waypoint.y_in);
    }
#endif
    putchar('\n');
}

int main(void) {
    uint64_t byte_times = 0;
    int question;
    start_robot(1, 0, 0);
    while ((question = getchar()) != EOF) {
        if (question == 'B') {
            int boots = getchar(), patience = getchar();
            start_robot((uint16_t)boots, (uint8_t)patience, milliseconds(byte_times));
        } else if (question == '+') {
            hear((uint8_t)getchar(), milliseconds(byte_times));
        } else if (question == '-') {
            int16_t sent = pass_byte_time(++byte_times);
            putchar(sent == GW_NONE ? '-' : '+');
            putchar(sent == GW_NONE ? 0 : sent);
        } else if (question == '?') {
            tell();
        } else if (question == 'W') {
            tell_waypoints();
        } else {
            fflush(stdout);
        }
    }
    return 0;
}
