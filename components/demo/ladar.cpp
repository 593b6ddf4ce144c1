#include <cstring>

#include "components/demo/program.h"
#include "components/demo/scan.h"
#include "components/demo/subscriptions.h"

namespace tims::demo {

namespace {

std::span<const std::byte> bytes_of(const std::uint32_t& number) {
  return std::as_bytes(std::span(&number, 1));
}

void answer(Mailbox& mailbox, const PeekGuard& request, Subscriptions& subscriptions,
            std::uint32_t sample_ms) {
  const Header& header = request.header();
  if (header.type <= 0) return;
  Result<void> sent;
  if (header.type == type::kGetStatus) {
    sent = mailbox.reply(header, type::kEnabled);
  } else if (header.type == type::kStopContData) {
    subscriptions.remove(header, request.body());
    sent = mailbox.reply(header, type::kOk);
  } else if (const auto period = header.type == type::kGetContData
                                     ? subscriptions.add(header, request.body(), sample_ms)
                                     : std::nullopt) {
    sent = mailbox.reply(header, type::kContData, bytes_of(*period));
  } else {
    sent = mailbox.reply(header, type::kError);
  }
  if (!sent) std::fprintf(stderr, "ladar: %s\n", sent.error().message().c_str());
}

}  // namespace

int run_ladar(Session& session, const StopSignals& signals, const Arguments& arguments) {
  const auto sample_ms = static_cast<std::uint32_t>(
      std::max<std::int64_t>(arguments.period / std::chrono::milliseconds(1), 1));
  auto mailbox = session.open({.address = *arguments.at, .slots = 20, .body_max = 240});
  if (!mailbox) return failed("ladar", mailbox.error());
  Subscriptions subscriptions;
  Time next = now();
  for (std::uint32_t number = 0;; ++number) {
    while (auto request = mailbox->try_peek()) answer(*mailbox, *request, subscriptions, sample_ms);
    const auto time_ms = static_cast<std::uint32_t>(std::time(nullptr) * 1000);
    // Each scan is built where its receiver will read it.
    subscriptions.deliver(now(), [&](const Subscriptions::Subscriber& to) {
      auto loan = mailbox->loan({.dest = to.data_mailbox,
                                 .type = type::kData,
                                 .priority = to.priority,
                                 .seq_nr = to.seq_nr,
                                 .stream = true},
                                kScanBytes);
      if (!loan) return !(loan.error() == Errc::kNoMailbox);
      write_scan(number, time_ms, loan->body().first<kScanBytes>());
      return loan->send().ok();
    });
    next += arguments.period;
    if (signals.stop_within(std::max(next - now(), Duration{}))) return 0;
  }
}

}  // namespace tims::demo
