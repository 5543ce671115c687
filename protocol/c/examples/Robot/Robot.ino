/*
 * Level 5: a robot with two driven wheels, encoders and a bumper that prowls, drives waypoint lists, goes home, is driven by
 * hand and keeps its parameters.
 *
 * Wiring of an Arduino Mega: radio on Serial1; motor driver (TB6612 or L298) on the pins below; encoders on 2 and 3; a bumper
 * switch from pin 37 to ground. On another board change the pins.
 */
#define GW_LEVEL 5
#define GW_WAYPOINTS 40
#include <groundwave.h>
#include <groundwave.c>

#include <EEPROM.h>
#include <math.h>

const uint8_t ROBOT_ID = 7;
const uint8_t PWM_LEFT = 11, PWM_RIGHT = 12, FORWARD_LEFT = 22, BACK_LEFT = 23, FORWARD_RIGHT = 24, BACK_RIGHT = 25;
const uint8_t ENCODER_LEFT = 2, ENCODER_RIGHT = 3, BUMPER = 37, BATTERY = A2;
const float COUNTS_PER_IN = 16, TRACK_IN = 8, BATTERY_V_PER_STEP = 15.0f / 1023;
const uint16_t TICK_MS = 50, BACK_OFF_MS = 800, TURN_MS = 900;

enum { TOP_SPEED, GAIN, PARAMETERS };
struct gw_parameter parameters[PARAMETERS] = {
  {"top-speed", "in/s", 2, 12, 8, 8},
  {"gain", "pwm/in/s", 1, 40, 12, 12},
};

struct Stored {
  uint16_t boots;
  int16_t values[PARAMETERS];
  uint8_t is_written; // 0xA5
};

struct gw gw;
float x_in, y_in, theta_rad;
float wanted_left_in_s, wanted_right_in_s, left_in_s, right_in_s;
int8_t hand_velocity_in_s, hand_rotation_in_s;
int16_t pwm_left, pwm_right;
uint32_t bumped_ms;
bool is_escaping, was_bumped;
volatile int16_t counts_left, counts_right;

void count_left() { counts_left += digitalRead(FORWARD_LEFT) ? 1 : -1; }
void count_right() { counts_right += digitalRead(FORWARD_RIGHT) ? 1 : -1; }

// ---- What the library calls ----

void gw_fill_state(struct gw_state *state) {
  const struct gw_state blank = GW_BLANK_STATE;
  *state = blank;
  state->x_tenths_in = lround(x_in * 10);
  state->y_tenths_in = lround(y_in * 10);
  state->theta_deg = (lround(theta_rad * 57.29578f) % 360 + 360) % 360;
  state->velocity_in_s = lround((wanted_left_in_s + wanted_right_in_s) / 2);
  state->rotation_in_s = lround(wanted_left_in_s - wanted_right_in_s);
  state->wheel_left_in_s = lround(left_in_s);
  state->wheel_right_in_s = lround(right_in_s);
  state->bump = was_bumped ? 'C' : '.';
  state->layers[0] = !(gw.allowed & GW_BUMPERS) ? '.' : is_escaping ? 'B' : '-';
  bool drives_list = gw.mode == 'P' && gw.allowed & GW_DEAD_RECKONING && gw.reached < gw.active_count;
  state->layers[6] = !(gw.allowed & GW_DEAD_RECKONING) ? '.' : drives_list && !is_escaping ? 'D' : '-';
  was_bumped = false;
}

void gw_fill_status(struct gw_status *status) {
  status->battery_dv = lround(analogRead(BATTERY) * BATTERY_V_PER_STEP * 10);
  status->photo_left = status->photo_right = GW_NONE;
  if (gw.reached < gw.active_count) {
    struct gw_waypoint to = gw_waypoint(&gw, gw.reached);
    status->has_target = 1;
    status->target_x_in = to.x_in;
    status->target_y_in = to.y_in;
  }
}

void set_motor(uint8_t pwm_pin, uint8_t forward_pin, uint8_t back_pin, int16_t pwm) {
  digitalWrite(forward_pin, pwm > 0);
  digitalWrite(back_pin, pwm < 0);
  analogWrite(pwm_pin, pwm < 0 ? -pwm : pwm);
}

void set_motors(int16_t left, int16_t right) {
  pwm_left = left;
  pwm_right = right;
  set_motor(PWM_LEFT, FORWARD_LEFT, BACK_LEFT, left);
  set_motor(PWM_RIGHT, FORWARD_RIGHT, BACK_RIGHT, right);
}

void gw_stop() {
  hand_velocity_in_s = hand_rotation_in_s = 0;
  wanted_left_in_s = wanted_right_in_s = 0;
  set_motors(0, 0);
}

void gw_mode_entered() { is_escaping = false; }
void gw_list_replaced() { gw_say(&gw, gw.active_count ? "list taken" : "list cleared"); }

void gw_drive(int8_t velocity_in_s, int8_t rotation_in_s) {
  hand_velocity_in_s = velocity_in_s;
  hand_rotation_in_s = rotation_in_s;
}

enum gw_outcome gw_set_pose(int16_t to_x_in, int16_t to_y_in, int16_t to_theta_deg) {
  x_in = to_x_in;
  y_in = to_y_in;
  theta_rad = to_theta_deg / 57.29578f;
  gw.odometer_resets++;
  return GW_DONE;
}

enum gw_outcome gw_scan() { return GW_NOT_FITTED; }
void gw_parameter_set(uint8_t) {}

enum gw_outcome gw_keep_parameters() {
  Stored stored;
  EEPROM.get(0, stored);
  for (uint8_t n = 0; n < PARAMETERS; n++) {
    stored.values[n] = parameters[n].value;
  }
  EEPROM.put(0, stored);
  return GW_DONE;
}

// ---- The robot ----

void drive(float velocity_in_s, float rotation_in_s) {
  wanted_left_in_s = velocity_in_s + rotation_in_s / 2;
  wanted_right_in_s = velocity_in_s - rotation_in_s / 2;
}

bool head_for(float to_x_in, float to_y_in) {
  float dx = to_x_in - x_in, dy = to_y_in - y_in;
  float off = atan2(dx, dy) - theta_rad;
  off = atan2(sin(off), cos(off));
  drive(fabs(off) < 0.4f ? parameters[TOP_SPEED].value : 0, constrain(off * 6, -6, 6));
  return dx * dx + dy * dy < 9;
}

void think(uint32_t now_ms) {
  bool is_bumped = digitalRead(BUMPER) == LOW;
  was_bumped |= is_bumped;
  if (is_bumped && gw.allowed & GW_BUMPERS && gw.mode != 'X' && !is_escaping) {
    is_escaping = true;
    bumped_ms = now_ms;
    gw.bumps++;
  }
  if (is_escaping && now_ms - bumped_ms > BACK_OFF_MS + TURN_MS) {
    is_escaping = false;
  }
  if (gw.mode == 'X') {
    drive(0, 0);
  } else if (is_escaping) {
    gw.ticks_won[1]++;
    now_ms - bumped_ms < BACK_OFF_MS ? drive(-4, 0) : drive(0, 6);
  } else if (gw.mode == 'U') {
    gw.ticks_won[0]++;
    drive(hand_velocity_in_s, hand_rotation_in_s);
  } else if (gw.mode == 'G') {
    if (head_for(0, 0)) {
      gw.mode = 'X';
    }
  } else if (gw.allowed & GW_DEAD_RECKONING && gw.reached < gw.active_count) {
    gw.ticks_won[7]++;
    struct gw_waypoint to = gw_waypoint(&gw, gw.reached);
    if (head_for(to.x_in, to.y_in)) {
      gw.reached++;
      gw_status_changed(&gw);
    }
  } else {
    gw.ticks_won[8]++;
    drive(parameters[TOP_SPEED].value, 0);
  }
}

void take_odometry() {
  noInterrupts();
  float left_in = counts_left / COUNTS_PER_IN, right_in = counts_right / COUNTS_PER_IN;
  counts_left = counts_right = 0;
  interrupts();
  left_in_s = left_in * 1000 / TICK_MS;
  right_in_s = right_in * 1000 / TICK_MS;
  theta_rad += (left_in - right_in) / TRACK_IN;
  x_in += (left_in + right_in) / 2 * sin(theta_rad);
  y_in += (left_in + right_in) / 2 * cos(theta_rad);
}

int16_t follow(int16_t pwm, float wanted_in_s, float in_s) {
  return wanted_in_s == 0 ? 0 : constrain(pwm + (wanted_in_s - in_s) * parameters[GAIN].value / 4, -255, 255);
}

void setup() {
  Stored stored;
  const uint8_t outputs[] = {PWM_LEFT, PWM_RIGHT, FORWARD_LEFT, BACK_LEFT, FORWARD_RIGHT, BACK_RIGHT};
  for (uint8_t pin : outputs) {
    pinMode(pin, OUTPUT);
  }
  pinMode(BUMPER, INPUT_PULLUP);
  pinMode(ENCODER_LEFT, INPUT_PULLUP);
  pinMode(ENCODER_RIGHT, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(ENCODER_LEFT), count_left, CHANGE);
  attachInterrupt(digitalPinToInterrupt(ENCODER_RIGHT), count_right, CHANGE);
  Serial1.begin(2400);

  EEPROM.get(0, stored);
  if (stored.is_written == 0xA5) {
    for (uint8_t n = 0; n < PARAMETERS; n++) {
      parameters[n].value = parameters[n].kept = stored.values[n];
    }
  } else {
    stored.boots = 0;
    stored.is_written = 0xA5;
    for (uint8_t n = 0; n < PARAMETERS; n++) {
      stored.values[n] = parameters[n].kept;
    }
  }
  stored.boots++;
  EEPROM.put(0, stored);

  gw_init(&gw, ROBOT_ID, stored.boots, millis());
  gw.modes = "PXUG";
  gw.fitted = GW_USER | GW_BUMPERS | GW_DEAD_RECKONING;
  gw.allowed = gw.fitted;
  gw.parameters = parameters;
  gw.parameter_count = PARAMETERS;
  // gw.patience_bytes = 16; // an HC-12 or another radio that takes turns
}

void loop() {
  static uint32_t tick_ms, byte_us;
  while (Serial1.available() > 0) {
    gw_receive(&gw, Serial1.read(), millis());
  }
  // One byte in a byte time, so that little waits in the UART and the acknowledgement is fresh.
  if (micros() - byte_us >= 1000000 / 240) {
    byte_us += 1000000 / 240;
    int16_t byte = gw_transmit(&gw, millis());
    if (byte != GW_NONE) {
      Serial1.write((uint8_t)byte);
    }
  }
  if (millis() - tick_ms >= TICK_MS) {
    tick_ms += TICK_MS;
    take_odometry();
    think(millis());
    gw_tick(&gw, millis());
    set_motors(follow(pwm_left, wanted_left_in_s, left_in_s), follow(pwm_right, wanted_right_in_s, right_in_s));
  }
}
