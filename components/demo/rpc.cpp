#include <algorithm>
#include <string>
#include <vector>

#include "components/demo/program.h"

namespace tims::demo {

using namespace std::chrono_literals;

int run_server(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = *arguments.at, .slots = 16, .body_max = 1024});
  if (!mailbox) return failed("server", mailbox.error());
  while (!signals.stop_within(Duration{})) {
    const auto request = mailbox->peek_for(200ms);
    if (!request || request->header().type <= 0) continue;
    Result<void> sent;
    if (request->header().type == type::kGetStatus) {
      sent = mailbox->reply(request->header(), type::kEnabled);
    } else if (request->header().type == kReverse) {
      const std::vector<std::byte> reversed(request->body().rbegin(), request->body().rend());
      sent = mailbox->reply(request->header(), type::kOk, reversed);
    } else {
      sent = mailbox->reply(request->header(), type::kError);
    }
    if (!sent) std::fprintf(stderr, "server: %s\n", sent.error().message().c_str());
  }
  return 0;
}

namespace {

// One question and its answer; false when there was none, or a wrong one.
bool ask(Mailbox& mailbox, Address server, std::uint8_t number) {
  const std::string question = "question " + std::to_string(number);
  const auto sent = mailbox.send({.dest = server, .type = kReverse, .seq_nr = number},
                                 std::as_bytes(std::span(question)));
  if (!sent) return false;
  for (auto reply = mailbox.peek_for(1s); reply; reply = mailbox.peek_for(1s)) {
    if (reply->header().seq_nr != number) continue;  // a late answer to an earlier question
    const auto* text = reinterpret_cast<const char*>(reply->body().data());
    const std::string answer(text, reply->body().size());
    return reply->header().type == type::kOk &&
           std::equal(answer.begin(), answer.end(), question.rbegin(), question.rend());
  }
  return false;
}

}  // namespace

int run_client(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = *arguments.at, .slots = 4, .body_max = 1024});
  if (!mailbox) return failed("client", mailbox.error());
  std::uint64_t good = 0;
  std::uint64_t bad = 0;
  Duration fastest = Duration::max();  // since the last report
  Time report = now() + 1s;
  for (std::uint8_t number = 0; !signals.stop_within(arguments.period); ++number) {
    const Time asked = now();
    if (ask(*mailbox, arguments.to, number)) {
      ++good;
      fastest = std::min(fastest, now() - asked);
    } else {
      ++bad;
    }
    if (now() < report) continue;
    report = now() + 1s;
    std::printf("client: %llu answers, %llu failures", static_cast<unsigned long long>(good),
                static_cast<unsigned long long>(bad));
    if (fastest == Duration::max())
      std::printf(", none since\n");
    else
      std::printf(", in %.3f ms\n", std::chrono::duration<double, std::milli>(fastest).count());
    fastest = Duration::max();
  }
  return good > 0 && bad <= 1 ? 0 : 1;  // the first may have been asked before the server was there
}

}  // namespace tims::demo
