/* A client and a server in C, as in any language with bindings to tims.h. c_api_test starts it:
 * c_api_example ROUTER. */
#include <poll.h>
#include <stdio.h>
#include <string.h>

#include "tims.h"

enum { kAsk = 21, kSlots = 8, kBodyMax = 64, kPriority = 7 };
static const int64_t kSecond = 1000000000;

static int failed(const char* what) {
  fprintf(stderr, "%s: %s (%s)\n", what, tims_error_text(), tims_error_name(tims_error_code()));
  return 1;
}

static void on_event(void* user, enum tims_event event, const char* text) {
  (void)text;
  if (event == TIMS_EVENT_CONNECTED) ++*(int*)user;
}

/* One step of a server's event loop. */
static int answer_one(tims_mailbox* server) {
  struct pollfd wait = {tims_event_fd(server), POLLIN, 0};
  struct tims_header request;
  const void* body = NULL;
  tims_guard* guard;
  int replied;
  while ((guard = tims_peek(server, &request, &body, 0)) == NULL) {
    if (tims_error_code() != TIMS_EEMPTY) return failed("peek");
    if (poll(&wait, 1, (int)(kSecond / 1000000)) != 1) return failed("poll");
  }
  replied = tims_reply(server, &request, 0, body, request.length - TIMS_HEADER_SIZE);
  tims_release(guard);
  return replied == 0 ? 0 : failed("reply");
}

static int ask(tims_session* session, tims_mailbox* client, tims_mailbox* server) {
  const struct tims_piece question[] = {{"what ", 5}, {"now?", 4}};
  struct tims_header header = {.type = kAsk, .priority = kPriority, .seq_nr = 1};
  struct tims_counters counters;
  char text[32];
  char answer[kBodyMax];
  int64_t size;
  header.dest = tims_mailbox_address(server);
  if (tims_send_pieces(client, &header, question, 2) != 0) return failed("send");
  if (answer_one(server) != 0) return 1;
  size = tims_receive(client, &header, answer, sizeof answer, kSecond);
  if (size < 0) return failed("receive");
  tims_mailbox_counters(client, &counters);
  tims_format_address(session, header.src, text, sizeof text);
  printf("%s answers \"%.*s\", message %d\n", text, (int)size, answer, (int)counters.received);
  return 0;
}

int main(int count, char** arguments) {
  int connected = 0;
  const struct tims_session_options options = {.router = count > 1 ? arguments[1] : NULL,
                                               .name = "c-example",
                                               .timeout_ns = 10 * kSecond,
                                               .on_event = on_event,
                                               .user = &connected};
  struct tims_mailbox_options wanted[2] = {{.slots = kSlots, .body_max = kBodyMax},
                                           {.slots = kSlots, .body_max = kBodyMax, .event_fd = 1}};
  tims_mailbox* mailboxes[2];
  tims_session* session = tims_connect_with(&options);
  int problem;
  if (session == NULL) return failed("connect");
  if (tims_parse_address(session, "Tool(1/1)", &wanted[0].address) != 0) return failed("address");
  if (tims_parse_address(session, "Test(1/2)", &wanted[1].address) != 0) return failed("address");
  if (tims_open_all(session, wanted, 2, mailboxes) != 0) return failed("open");
  problem = ask(session, mailboxes[0], mailboxes[1]);
  if (tims_close_linger(mailboxes[0], kSecond) != 0) problem = failed("close");
  tims_close(mailboxes[1]);
  printf("tims %s, connected %d time(s)\n", tims_version(), connected);
  tims_disconnect(session);
  return problem;
}
