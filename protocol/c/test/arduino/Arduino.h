/* Declarations of the parts of Arduino that the sketches use, to compile them without Arduino. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>

#define LOW 0
#define INPUT_PULLUP 2
#define OUTPUT 1
#define CHANGE 1
#define A0 54
#define A2 56
#define constrain(value, least, most) ((value) < (least) ? (least) : (value) > (most) ? (most) : (value))
#define digitalPinToInterrupt(pin) (pin)

void setup();
void loop();
void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
int digitalRead(uint8_t pin);
int analogRead(uint8_t pin);
void analogWrite(uint8_t pin, int value);
void attachInterrupt(uint8_t interrupt, void (*function)(), int mode);
void noInterrupts();
void interrupts();
unsigned long millis();
unsigned long micros();
void delay(unsigned long ms);

struct HardwareSerial {
  void begin(unsigned long baud);
  int available();
  int read();
  size_t write(uint8_t byte);
  size_t write(const uint8_t *bytes, size_t count);
  size_t print(const char *text);
  size_t print(char c);
  size_t print(long number);
  size_t println(char c);
  size_t println(long number);
};
extern HardwareSerial Serial;
extern HardwareSerial Serial1;

#endif
