/* The limit of what Python can reach: the loop of bench.py in C. send_peek ROUTER BYTES COUNT
 * prints ns a message. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "tims.h"

static tims_mailbox* open_at(tims_session* session, const char* name, uint32_t body_max) {
  struct tims_mailbox_options options = {.slots = 16, .body_max = body_max};
  tims_parse_address(session, name, &options.address);
  return tims_open(session, &options);
}

int main(int argc, char** argv) {
  if (argc != 4) return fprintf(stderr, "usage: %s ROUTER BYTES COUNT\n", argv[0]), 2;
  const size_t size = strtoul(argv[2], NULL, 10);
  const long count = strtol(argv[3], NULL, 10);
  tims_session* session = tims_connect(argv[1], "bench", TIMS_FOREVER);
  tims_mailbox* from = session == NULL ? NULL : open_at(session, "Tool(1/62)", 64);
  tims_mailbox* to = session == NULL ? NULL : open_at(session, "Tool(1/63)", (uint32_t)size);
  static char body[1 << 20];
  if (from == NULL || to == NULL || size > sizeof body)
    return fprintf(stderr, "%s\n", tims_error_text()), 1;
  struct tims_header header = {.dest = tims_mailbox_address(to), .type = 5, .priority = 20};
  struct timespec begin = {0}, end = {0};
  for (long i = -1; i < count; ++i) {
    if (i == 0) clock_gettime(CLOCK_MONOTONIC, &begin);
    if (tims_send(from, &header, body, size) != 0)
      return fprintf(stderr, "%s\n", tims_error_text()), 1;
    tims_release(tims_peek(to, NULL, NULL, 0));
  }
  clock_gettime(CLOCK_MONOTONIC, &end);
  const double ns =
      (double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec);
  printf("%.1f\n", ns / (double)count);
  tims_close(from);
  tims_close(to);
  tims_disconnect(session);
  return 0;
}
