// A component that a test kills: it does one task, reports it in a line, and runs until it is
// killed.
#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <unistd.h>

#include "tests/support/patience.h"
#include "tims/session.h"

namespace {

using tims::Address;
using tims::Mailbox;

void print_line(const char* text) {
  std::puts(text);
  std::fflush(stdout);
}

[[noreturn]] void wait_for_death() {
  for (;;) ::pause();
}

// Takes loans of all free slots of mailbox 2, and never sends them.
void hold_loans(Mailbox& own) {
  std::vector<tims::Loan> loans;
  for (;;) {
    auto loan = own.loan({.dest = Address(2)}, 8);
    if (!loan) break;
    loans.push_back(std::move(*loan));
  }
  print_line("holding");
  wait_for_death();
}

// Peeks the first message and keeps it.
void hold_peek(Mailbox& own) {
  print_line("ready");
  const auto held = own.peek();
  print_line("peeking");
  wait_for_death();
}

// Sends numbers to mailbox 2 as fast as they are accepted.
void flood(Mailbox& own) {
  print_line("sending");
  for (std::uint64_t number = 0;; ++number)
    (void)own.send({.dest = Address(2), .type = -6}, std::as_bytes(std::span(&number, 1)));
}

// Sends a number to mailbox 2, and on request 899 more.
void send_many(Mailbox& own) {
  for (std::uint32_t number = 0; number < 900; ++number) {
    const auto body = std::as_bytes(std::span(&number, 1));
    if (const auto sent = own.send({.dest = Address(2), .type = -6}, body); !sent)
      return print_line(sent.error().message().c_str());
    if (number != 0) continue;
    print_line("ready");
    (void)own.peek();
  }
  print_line("sent");
}
void send_many_and_close(Mailbox& own) { send_many(own); }
void send_many_and_die(Mailbox& own) {
  send_many(own);
  ::raise(SIGKILL);
}

// Echoes messages until it is killed.
void echo(Mailbox& own) {
  print_line("ready");
  for (;;)
    if (const auto request = own.peek(); request && request->header().type > 0)
      (void)own.reply(request->header(), tims::type::kOk, request->body());
}

}  // namespace

// actor ROLE SOCKET ADDRESS
int main(int argc, char** argv) {
  const std::map<std::string, std::function<void(Mailbox&)>> roles{
      {"hold-loans", hold_loans},
      {"hold-peek", hold_peek},
      {"flood", flood},
      {"echo", echo},
      {"send-and-close", send_many_and_close},
      {"send-and-die", send_many_and_die}};
  if (argc != 4 || !roles.contains(argv[1])) return 2;
  auto session = tims::Session::connect(
      {.name = argv[1], .router = argv[2], .timeout = tims::test::kPatience});
  if (!session) return 3;
  auto mailbox = session->open({.address = *Address::parse(argv[3]), .slots = 8, .body_max = 64});
  if (!mailbox) return 4;
  roles.at(argv[1])(*mailbox);
}
