/*
 * Level 1: a robot on the map in ten minutes. It cannot hear.
 *
 * Wire a radio (or a USB adapter) to Serial1, fill in the four places below, then run: groundwave watch PORT
 */
#define GW_LEVEL 1
#include <groundwave.h>
#include <groundwave.c>

const uint8_t ROBOT_ID = 7; // 1 to 99

struct gw_state state = GW_BLANK_STATE;
uint8_t sequence;

void setup() {
  Serial1.begin(2400);
  delay(10); // the line must be idle before the first byte
}

void loop() {
  char line[GW_LINE_BYTES];

  state.x_tenths_in = 0;   // 1: your odometry, tenths of an inch; positive to the east
  state.y_tenths_in = 0;   //    positive to the north
  state.theta_deg = 0;     // 2: your heading, 0 to 359, clockwise from north
  state.sonar_left_in = GW_NONE; // 3: your sensors
  state.velocity_in_s = 0; // 4: your motors, and the speeds of your wheels; without encoders those requested
  state.wheel_left_in_s = state.wheel_right_in_s = state.velocity_in_s;

  gw_line_a(line, &state, ROBOT_ID, sequence);
  sequence = (sequence + 1) % 100;
  Serial1.write((const uint8_t *)line, GW_LINE_BYTES); // waits while the buffer is full: three lines a second
}
