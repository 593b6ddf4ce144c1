/* The same in C, as other languages bind to it. */
#include <stdio.h>
#include <string.h>
#include <tims.h>

int main(void) {
  uint32_t address = 0;
  char text[32];
  if (tims_parse_address(NULL, "Ladar(3/0)", &address) != 0 || address != 0x03140000) return 1;
  tims_format_address(NULL, address, text, sizeof text);
  if (strcmp(text, "Ladar(3/0)") != 0) return 1;
  if (tims_connect("/nonexistent/router.sock", "outside", 1000000) != NULL) return 1;
  printf("%s\n", tims_error_text());
  return 0;
}
