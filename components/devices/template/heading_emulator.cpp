// HeadingEmulator: the emulated compass at the end of a line.
#include <rack/devices/emulator.h>

#include "heading_compass.h"

int main(int argc, char** argv) {
  heading::HeadingCompass compass;
  return rack::device::run_emulator(
      argc, argv, {.name = "heading", .address = "pty:/tmp/heading", .baud = 9600}, compass);
}
