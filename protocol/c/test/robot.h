/* A robot that does nothing, for programs that need one. */
#ifndef ROBOT_H
#define ROBOT_H

#include "../src/groundwave.h"

#include <string.h>

static const struct gw_state STILL = GW_BLANK_STATE;

#if GW_LEVEL >= 2
void gw_fill_state(struct gw_state *state) { *state = STILL; }
void gw_stop(void) {}
void gw_mode_entered(void) {}
#endif
#if GW_FIELDS > 0
static const struct gw_field FIELDS[GW_FIELDS] = {{"motor-current", "A", 2}, {"z", "", 0}, {"z", "", 0}};
void gw_fill_values(int32_t values[GW_FIELDS]) {
    for (uint8_t n = 0; n < GW_FIELDS; n++) {
        values[n] = n == 0 ? 125 : GW_NO_VALUE;
    }
}
#endif
#if GW_LEVEL >= 3
void gw_list_replaced(void) {}
void gw_fill_status(struct gw_status *status) { status->photo_left = status->photo_right = GW_NONE; }
#endif
#if GW_LEVEL >= 4
void gw_drive(int8_t velocity_in_s, int8_t rotation_in_s) {
    (void)velocity_in_s;
    (void)rotation_in_s;
}
enum gw_outcome gw_set_pose(int16_t x_in, int16_t y_in, int16_t theta_deg) {
    (void)x_in;
    (void)y_in;
    (void)theta_deg;
    return GW_DONE;
}
enum gw_outcome gw_scan(void) { return GW_NOT_FITTED; }
#endif
#if GW_LEVEL >= 5
void gw_parameter_set(uint8_t index) { (void)index; }
enum gw_outcome gw_keep_parameters(void) { return GW_DONE; }
#endif

#endif
