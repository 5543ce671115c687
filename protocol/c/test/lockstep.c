/*
 * The robot of examples/Host in virtual time, for tests that hold the other end of standard input and output.
 *
 *   B boots patience        the robot boots
 *   + byte | -              a byte time passes, with or without a byte from the ground; answers + byte or -
 *   ?                       answers a line: mode, orders heard, drive frames, active count, active digest, reached
 */
#include "../examples/Host/robot.h"

#include <stdio.h>

#if GW_LEVEL < 2
#error "lockstep needs a robot that hears"
#endif

#define BYTES_PER_S 240

int main(void) {
    uint64_t byte_times = 0;
    int question;
    start_robot(1, 0);
    while ((question = getchar()) != EOF) {
        uint32_t now_ms = (uint32_t)(byte_times * 1000 / BYTES_PER_S);
        if (question == 'B') {
            int boots = getchar(), patience = getchar();
            start_robot((uint16_t)boots, now_ms);
            orders_heard = 0;
#if GW_LEVEL >= 5
            gw.patience_bytes = (uint8_t)patience;
#endif
            (void)patience;
        } else if (question == '?') {
            unsigned drives = 0, active = 0, reached = 0;
            unsigned long digest = 0;
#if GW_LEVEL >= 4
            drives = drives_heard;
#endif
#if GW_LEVEL >= 3
            active = gw.active_count;
            digest = gw.active_digest;
            reached = gw.reached;
#endif
            printf("%c %u %u %u %lu %u\n", gw.mode, orders_heard, drives, active, digest, reached);
            fflush(stdout);
        } else {
            int16_t sent;
            byte_times++;
            now_ms = (uint32_t)(byte_times * 1000 / BYTES_PER_S);
            if (question == '+') {
                gw_receive(&gw, (uint8_t)getchar(), now_ms);
            }
            sent = gw_transmit(&gw, now_ms);
            if (byte_times % 12 == 0) {
                gw_tick(&gw, now_ms);
                think();
            }
            move(1.0 / BYTES_PER_S);
            putchar(sent == GW_NONE ? '-' : '+');
            putchar(sent == GW_NONE ? 0 : sent);
            fflush(stdout);
        }
    }
    return 0;
}
