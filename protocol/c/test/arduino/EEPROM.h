/* See Arduino.h. */
#ifndef EEPROM_H
#define EEPROM_H

struct EEPROMClass {
  template <typename T> T &get(int address, T &value);
  template <typename T> const T &put(int address, const T &value);
};
extern EEPROMClass EEPROM;

#endif
