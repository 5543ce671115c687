/*
 * Plays a robot that stands still: protocol/vectors/level-*.jsonl. Questions, one a line on standard input:
 *
 *   boot ID BOOTS PATIENCE     the robot boots
 *   hear HEX                   it hears these bytes; answers the outcome of the latest order
 *   line                       answers the next line, in hexadecimal
 */
#define GW_WAYPOINTS 8
#include "../src/groundwave.c"
#include "robot.h"

#include <stdio.h>
#include <stdlib.h>

#if GW_LEVEL >= 2
static struct gw robot;

static void boot(unsigned id, unsigned boots, unsigned patience_bytes) {
    gw_init(&robot, (uint8_t)id, (uint16_t)boots, 0);
    robot.modes = "PX";
    robot.mode = 'P';
    robot.fitted = robot.allowed = GW_USER | GW_DEAD_RECKONING;
#if GW_LEVEL >= 5
    robot.patience_bytes = (uint8_t)patience_bytes;
#endif
    (void)patience_bytes;
}

static void hear(const char *hex) {
    unsigned byte;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2) {
#if GW_LEVEL >= 5
        if (robot.position == robot.length && robot.next == LISTEN) {
            gw_transmit(&robot, 0);
        }
#endif
        gw_receive(&robot, (uint8_t)byte, 0);
    }
#if GW_LEVEL >= 5
    if (robot.turn_is_open) {
        gw_transmit(&robot, 0);
    }
#endif
    printf("%u\n", robot.outcome);
}

static void answer_line(void) {
    uint8_t count = 0;
    do {
        int16_t byte = gw_transmit(&robot, 0);
        if (byte != GW_NONE) {
            printf("%02x", (unsigned)byte);
            count++;
        }
    } while (count == 0 || robot.position < robot.length);
    printf("\n");
}
#else
static uint8_t sequence;
static uint8_t robot_id;

static void boot(unsigned id, unsigned boots, unsigned patience_bytes) {
    (void)boots;
    (void)patience_bytes;
    robot_id = (uint8_t)id;
    sequence = 0;
}

static void hear(const char *hex) {
    (void)hex;
    printf("0\n");
}

static void answer_line(void) {
    char line[GW_LINE_BYTES];
    gw_line_a(line, &STILL, robot_id, sequence++);
    for (uint8_t n = 0; n < GW_LINE_BYTES; n++) {
        printf("%02x", (unsigned)(uint8_t)line[n]);
    }
    printf("\n");
}
#endif

int main(void) {
    static char question[1024], hex[1024];
    unsigned id, boots, patience_bytes;
    while (fgets(question, sizeof question, stdin) != NULL) {
        if (sscanf(question, "boot %u %u %u", &id, &boots, &patience_bytes) == 3) {
            boot(id, boots, patience_bytes);
            printf("booted\n");
        } else if (sscanf(question, "hear %1023s", hex) == 1) {
            hear(hex);
        } else {
            answer_line();
        }
        fflush(stdout);
    }
    return 0;
}
