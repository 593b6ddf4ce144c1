// tims-demo: small components made with libtims, as a user would write them. Each is a mailbox and
// a loop that runs until SIGINT or SIGTERM.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "components/demo/demo.h"
#include "components/runtime/logic/listeners.h"
#include "rack/clock.h"
#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"
#include "tims/session.h"

namespace tims::demo {

namespace {

using namespace std::chrono_literals;
using rack::now;

constexpr std::size_t kListenersMax = 64;
constexpr std::int8_t kReverse = 21;  // the only command of the server
constexpr std::size_t kScanMax = rack::body_max<rack::LadarData>();

// Blocks SIGINT and SIGTERM and polls them, instead of a handler.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }
  // Waits; true when it is time to stop.
  [[nodiscard]] bool stop_within(Duration wait) const {
    const timespec t = {.tv_sec = wait / 1s, .tv_nsec = (wait % 1s).count()};
    return sigtimedwait(&set_, nullptr, &t) > 0;
  }

 private:
  sigset_t set_;
};

int failed(const char* what, const Error& error) {
  std::fprintf(stderr, "%s: %s\n", what, error.message().c_str());
  return 1;
}

// A minimal component: no life cycle and no parameters; each scan is written directly into the
// mailbox of its receiver. Robots use rack::DataModule.
class Ladar {
 public:
  Ladar(Mailbox& mailbox, std::uint32_t sample_ms) : mailbox_(mailbox), sample_ms_(sample_ms) {}

  void answer(const PeekGuard& request);
  void send(const rack::LadarData& scan);

 private:
  Result<void> subscribe(const PeekGuard& request);
  Result<void> unsubscribe(const PeekGuard& request);
  Result<void> refuse(const Header& request) { return mailbox_.reply(request, type::kError); }
  Result<void> send_to(const rack::Listener& to, const rack::LadarData& scan);

  Mailbox& mailbox_;
  const std::uint32_t sample_ms_;
  rack::Listeners listeners_{kListenersMax};
  std::array<rack::Listener, kListenersMax> due_{};
};

void Ladar::answer(const PeekGuard& request) {
  const Header& header = request.header();
  if (header.type <= 0) return;
  Result<void> sent;
  switch (header.type) {
    case type::kGetStatus:
      sent = mailbox_.reply(header, type::kEnabled);
      break;
    case type::kGetContData:
      sent = subscribe(request);
      break;
    case type::kStopContData:
      sent = unsubscribe(request);
      break;
    default:
      sent = refuse(header);
  }
  if (!sent) std::fprintf(stderr, "ladar: %s\n", sent.error().message().c_str());
}

Result<void> Ladar::subscribe(const PeekGuard& request) {
  const Header& header = request.header();
  const auto wanted = rack::decode<rack::GetContDataRequest>({header, request.body()});
  if (!wanted) return refuse(header);
  const std::uint32_t each = rack::reduction(wanted->periodTime, sample_ms_);
  if (listeners_.add(header, header.src, wanted->dataMbxAdr, each) == rack::Listeners::Added::kFull)
    return refuse(header);
  std::array<std::byte, rack::wire_size<rack::ContDataReply>()> granted{};
  if (const auto size = rack::encode(rack::ContDataReply{each * sample_ms_}, granted); !size)
    return size.error();
  return mailbox_.reply(header, type::kContData, granted);
}

Result<void> Ladar::unsubscribe(const PeekGuard& request) {
  const Header& header = request.header();
  const auto unwanted = rack::decode<rack::StopContDataRequest>({header, request.body()});
  if (!unwanted) return refuse(header);
  listeners_.remove(unwanted->dataMbxAdr);
  return mailbox_.reply(header, type::kOk);
}

void Ladar::send(const rack::LadarData& scan) {
  for (const rack::Listener& to : listeners_.take_due(due_)) {
    const auto sent = send_to(to, scan);
    if (!sent && sent.error() == Errc::kNoMailbox) listeners_.remove(to.mailbox);
  }
}

Result<void> Ladar::send_to(const rack::Listener& to, const rack::LadarData& scan) {
  auto loan = mailbox_.loan({.dest = to.mailbox,
                             .type = type::kData,
                             .priority = to.priority,
                             .seq_nr = to.seq_nr,
                             .stream = true},
                            static_cast<std::uint32_t>(rack::encoded_size(scan)));
  if (!loan) return loan.error();
  if (const auto good = rack::encode(scan, loan->body()); !good) return good.error();
  return loan->send();
}

int run_ladar(Session& session, const StopSignals& signals, const Arguments& arguments) {
  const auto sample_ms = static_cast<std::uint32_t>(
      std::max<std::int64_t>(arguments.period / std::chrono::milliseconds(1), 1));
  auto mailbox = session.open({.address = arguments.at, .slots = 20, .body_max = 240});
  if (!mailbox) return failed("ladar", mailbox.error());
  Ladar ladar(*mailbox, sample_ms);
  Time next = now();
  for (std::uint32_t number = 0;; ++number) {
    while (auto request = mailbox->try_peek()) ladar.answer(*request);
    ladar.send(scan_of_a_room(number, rack::time_stamp()));
    next += arguments.period;
    if (signals.stop_within(std::max(next - now(), Duration{}))) return 0;
  }
}

Result<void> subscribe(Mailbox& mailbox, Address ladar) {
  std::array<std::byte, rack::wire_size<rack::GetContDataRequest>()> body{};
  (void)rack::encode(rack::GetContDataRequest{0, mailbox.address()}, body);
  return mailbox.send({.dest = ladar, .type = type::kGetContData}, body);
}

int run_viewer(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = arguments.at, .slots = 8, .body_max = kScanMax});
  if (!mailbox) return failed("viewer", mailbox.error());
  std::uint64_t all = 0;
  std::uint64_t second = 0;
  rack::i32 nearest = 0;
  Time report = now() + 1s;
  bool subscribed = false;
  Time ask = now();
  while (!signals.stop_within(Duration{})) {
    if (!subscribed && now() >= ask) {
      subscribed = subscribe(*mailbox, arguments.to).ok();
      ask = now() + 200ms;  // no server yet: waits before the next attempt
    }
    const auto scan = mailbox->peek_for(200ms);
    if (scan && scan->header().type == type::kData) {
      const auto data = rack::decode<rack::LadarData>({scan->header(), scan->body()});
      if (!data || data->points.empty()) continue;
      nearest = std::ranges::min_element(data->points, {}, &rack::LadarPoint::distance)->distance;
      ++all;
      ++second;
    }
    if (scan && scan->header().type == type::kNotAvailable) subscribed = false;
    if (now() < report) continue;
    report += 1s;
    std::printf("viewer: %llu scans/s, nearest %d mm\n", static_cast<unsigned long long>(second),
                nearest);
    subscribed = second > 0;  // a restarted ladar has lost the subscription
    second = 0;
  }
  return all > 0 ? 0 : 1;
}

int run_server(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = arguments.at, .slots = 16, .body_max = 1024});
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

// Sends a request and checks its answer; false when there was none, or a wrong one.
bool ask(Mailbox& mailbox, Address server, std::uint8_t number) {
  const std::string question = "question " + std::to_string(number);
  const auto sent = mailbox.send({.dest = server, .type = kReverse, .seq_nr = number},
                                 std::as_bytes(std::span(question)));
  if (!sent) return false;
  for (auto reply = mailbox.peek_for(1s); reply; reply = mailbox.peek_for(1s)) {
    if (reply->header().seq_nr != number) continue;  // a late answer to an earlier request
    const auto* text = reinterpret_cast<const char*>(reply->body().data());
    const std::string answer(text, reply->body().size());
    return reply->header().type == type::kOk &&
           std::equal(answer.begin(), answer.end(), question.rbegin(), question.rend());
  }
  return false;
}

int run_client(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = arguments.at, .slots = 4, .body_max = 1024});
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
  return good > 0 && bad <= 1
             ? 0
             : 1;  // the first request may have been sent before the server was running
}

}  // namespace
}  // namespace tims::demo

int main(int argc, char** argv) {
  using namespace tims::demo;
  using Run = int (*)(tims::Session&, const StopSignals&, const Arguments&);
  const std::map<std::string, Run> roles{
      {"ladar", run_ladar}, {"viewer", run_viewer}, {"server", run_server}, {"client", run_client}};
  const auto parsed = parse_arguments({argv + 1, argv + argc});
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) {
    std::fprintf(refusal->exit_code == 0 ? stdout : stderr, "%s\n", refusal->text.c_str());
    return refusal->exit_code;
  }
  const auto& arguments = std::get<Arguments>(parsed);
  const StopSignals signals;  // before the session starts its thread
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  auto session = tims::Session::connect(
      {.name = "demo-" + arguments.role, .timeout = std::chrono::seconds(10)});
  if (!session) return failed("tims-demo", session.error());
  return roles.at(arguments.role)(*session, signals, arguments);
}
