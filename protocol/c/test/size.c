/* Links the library into an otherwise empty program, so that check.py measures its size. */
#include "robot.h"

#include <avr/io.h>

int main(void) {
#if GW_LEVEL == 1
    static char line[GW_LINE_BYTES];
    for (uint8_t sequence = 0;; sequence++) {
#ifdef GW_EMPTY
        line[sequence % GW_LINE_BYTES] = ((const char *)&STILL)[sequence % sizeof STILL];
#else
        gw_line_a(line, &STILL, 7, sequence % 100);
#endif
        for (uint8_t n = 0; n < GW_LINE_BYTES; n++) {
            UDR1 = (uint8_t)line[n];
        }
    }
#else
#ifndef GW_EMPTY
    static struct gw gw;
    gw_init(&gw, 7, UDR0, 0);
    for (uint32_t now_ms = 0;; now_ms++) {
        gw_receive(&gw, UDR1, now_ms);
        UDR1 = (uint8_t)gw_transmit(&gw, now_ms);
        gw_tick(&gw, now_ms);
    }
#else
    for (uint32_t now_ms = 0;; now_ms++) {
        UDR1 = (uint8_t)(UDR1 + now_ms);
    }
#endif
#endif
}
