#include <algorithm>
#include <array>

#include "components/demo/program.h"
#include "components/demo/scan.h"
#include "components/runtime/logic/listeners.h"
#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"

namespace tims::demo {

namespace {

constexpr std::size_t kListenersMax = 64;

// A component as small as one can be: no life, no parameters, and each scan built where its
// receiver reads it. rack::DataModule is what robots are made of.
class Ladar {
 public:
  Ladar(Mailbox& mailbox, std::uint32_t sample_ms) : mailbox_(mailbox), sample_ms_(sample_ms) {}

  void answer(const PeekGuard& request);
  void send_scan(std::uint32_t number, std::uint32_t time_ms);

 private:
  Result<void> subscribe(const PeekGuard& request);
  Result<void> unsubscribe(const PeekGuard& request);
  Result<void> refuse(const Header& request) { return mailbox_.reply(request, type::kError); }
  Result<void> send_to(const rack::Listener& to, std::uint32_t number, std::uint32_t time_ms);

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
  if (listeners_.add(header, wanted->dataMbxAdr, each) == rack::Listeners::Added::kFull)
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

void Ladar::send_scan(std::uint32_t number, std::uint32_t time_ms) {
  for (const rack::Listener& to : listeners_.take_due(due_)) {
    const auto sent = send_to(to, number, time_ms);
    if (!sent && sent.error() == Errc::kNoMailbox) listeners_.remove(to.mailbox);
  }
}

Result<void> Ladar::send_to(const rack::Listener& to, std::uint32_t number, std::uint32_t time_ms) {
  auto loan = mailbox_.loan({.dest = to.mailbox,
                             .type = type::kData,
                             .priority = to.priority,
                             .seq_nr = to.seq_nr,
                             .stream = true},
                            kScanBytes);
  if (!loan) return loan.error();
  write_scan(number, time_ms, loan->body().first<kScanBytes>());
  return loan->send();
}

}  // namespace

int run_ladar(Session& session, const StopSignals& signals, const Arguments& arguments) {
  const auto sample_ms = static_cast<std::uint32_t>(
      std::max<std::int64_t>(arguments.period / std::chrono::milliseconds(1), 1));
  auto mailbox = session.open({.address = *arguments.at, .slots = 20, .body_max = 240});
  if (!mailbox) return failed("ladar", mailbox.error());
  Ladar ladar(*mailbox, sample_ms);
  Time next = now();
  for (std::uint32_t number = 0;; ++number) {
    while (auto request = mailbox->try_peek()) ladar.answer(*request);
    ladar.send_scan(number, static_cast<std::uint32_t>(std::time(nullptr) * 1000));
    next += arguments.period;
    if (signals.stop_within(std::max(next - now(), Duration{}))) return 0;
  }
}

}  // namespace tims::demo
