#include "router/io/event_log.h"

#include "router/io/report_json.h"

namespace tims::io {

void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths) {
  using Kind = core::EventKind;
  switch (event.kind) {
    // A guest can cause any number of these, each with another text.
    case Kind::kClientRefused:
    case Kind::kAddressRefused:
    case Kind::kMailboxLimit:
    case Kind::kDeleteRefused:
    case Kind::kWatchdogClosed:
    case Kind::kProtocolError:
    case Kind::kLinkRefused:
    case Kind::kDuplicateAddress:
    case Kind::kDuplicateRouter:
    case Kind::kLoop:
    case Kind::kLinkUp:
    case Kind::kLinkDown:
    case Kind::kLinkPath:
    case Kind::kUplinkChanged:
      return limited_log.on_event(event.at, event, widths);
    default:
      // A restart of the fleet brings a hundred thousand of these.
      if (log.writes(config::LogLevel::kDebug)) log.debug(event_text(event, widths));
  }
}

}  // namespace tims::io
