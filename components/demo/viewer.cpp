#include <array>

#include "components/demo/program.h"
#include "components/demo/scan.h"
#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"

namespace tims::demo {

namespace {

using namespace std::chrono_literals;

Result<void> subscribe(Mailbox& mailbox, Address ladar) {
  std::array<std::byte, rack::wire_size<rack::GetContDataRequest>()> body{};
  (void)rack::encode(rack::GetContDataRequest{0, mailbox.address()}, body);
  return mailbox.send({.dest = ladar, .type = type::kGetContData}, body);
}

}  // namespace

int run_viewer(Session& session, const StopSignals& signals, const Arguments& arguments) {
  auto mailbox = session.open({.address = *arguments.at, .slots = 8, .body_max = kScanBytes});
  if (!mailbox) return failed("viewer", mailbox.error());
  std::uint64_t all = 0;
  std::uint64_t second = 0;
  ScanSummary summary;
  Time report = now() + 1s;
  bool subscribed = false;
  Time ask = now();
  while (!signals.stop_within(Duration{})) {
    if (!subscribed && now() >= ask) {
      subscribed = subscribe(*mailbox, arguments.to).ok();
      ask = now() + 200ms;  // nobody is there yet: not at once again
    }
    const auto scan = mailbox->peek_for(200ms);
    if (scan && scan->header().type == type::kData && read_scan(scan->body(), summary)) {
      ++all;
      ++second;
    }
    if (scan && scan->header().type == type::kNotAvailable) subscribed = false;
    if (now() < report) continue;
    report += 1s;
    std::printf("viewer: %llu scans/s, nearest %d mm\n", static_cast<unsigned long long>(second),
                summary.nearest_mm);
    subscribed = second > 0;  // a ladar that was restarted has forgotten us
    second = 0;
  }
  return all > 0 ? 0 : 1;
}

}  // namespace tims::demo
