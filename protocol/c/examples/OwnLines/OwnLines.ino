/*
 * Level 0: lines of your own. Prints a position, a heading and the battery ten times a second, and takes two commands.
 */
long x_mm, y_mm, heading_deg; // fill them in from your encoders

void setup() {
  Serial.begin(115200);
}

void loop() {
  static char command;
  while (Serial.available()) {
    char c = Serial.read();
    if (c == '\n') {
      Serial.print("OK ");
      Serial.println(command);
      // S: switch your motors off here. G: start them.
    } else {
      command = c;
    }
  }
  Serial.print(x_mm);
  Serial.print(',');
  Serial.print(y_mm);
  Serial.print(',');
  Serial.print(heading_deg);
  Serial.print(',');
  Serial.println(analogRead(A0) * 12L); // millivolts, for your voltage divider
  delay(100);
}
