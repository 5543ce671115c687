/*
 * A robot of one's own on a pseudo-terminal, to try the library and the ground station without a board:
 *
 *   cc -DGW_LEVEL=5 host.c ../../src/groundwave.c -lm -o host
 *   ./host                     prints the path of its terminal
 *   groundwave watch PATH
 *
 * `./host half` talks in half duplex.
 */
#define _XOPEN_SOURCE 600
#include "robot.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int open_terminal(void) {
    struct termios raw;
    int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    /* The other end stays open here, so that the terminal survives the programs that open it. */
    int other;
    if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0
        || (other = open(ptsname(terminal), O_RDWR | O_NOCTTY)) < 0 || tcgetattr(other, &raw) != 0) {
        perror("host: cannot open a pseudo-terminal");
        exit(1);
    }
    raw.c_iflag = raw.c_oflag = raw.c_lflag = 0;
    raw.c_cflag = CS8 | CREAD | CLOCAL;
    tcsetattr(other, TCSANOW, &raw);
    fcntl(terminal, F_SETFL, O_NONBLOCK);
    printf("%s\n", ptsname(terminal));
    fflush(stdout);
    return terminal;
}

int main(int count, char **arguments) {
    struct timespec next;
    int terminal = open_terminal();
    int is_half = count > 1 && strcmp(arguments[1], "half") == 0;
    start_robot((uint16_t)(time(NULL) % 1000), is_half ? 16 : 0, 0);
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (uint64_t byte_times = 1;; byte_times++) {
        uint8_t byte;
        int16_t sent;
        if (read(terminal, &byte, 1) == 1) {
            hear(byte, milliseconds(byte_times));
        }
        sent = pass_byte_time(byte_times);
        if (sent != GW_NONE) {
            byte = (uint8_t)sent;
            /* A terminal that nobody reads fills up; the radio would not wait either. */
            if (write(terminal, &byte, 1) < 0 && errno != EAGAIN) {
                return 1;
            }
        }
        next.tv_nsec += 1000000000 / BYTES_PER_S;
        if (next.tv_nsec >= 1000000000) {
            next.tv_nsec -= 1000000000;
            next.tv_sec++;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    }
}
