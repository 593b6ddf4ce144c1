#include "components/gdos_log/journal.h"

#include <array>
#include <cstdlib>
#include <cstring>

#include <sys/uio.h>

// Without it the library would add this file and line as those of the text.
#define SD_JOURNAL_SUPPRESS_LOCATION
#include <systemd/sd-journal.h>

namespace rack::gdos_log {

int journal_priority(gdos::Level level) {
  switch (level) {
    case gdos::Level::kError:
      return 3;
    case gdos::Level::kWarning:
      return 4;
    case gdos::Level::kPrint:
      return 5;
    case gdos::Level::kInfo:
      return 6;
    case gdos::Level::kDetail:
      return 7;
  }
  return 5;
}

tims::Result<void> to_journal(const gdos::Record& record) {
  std::array<std::string, 6> fields{
      "MESSAGE=" + record.text,
      "PRIORITY=" + std::to_string(journal_priority(record.level)),
      "SYSLOG_IDENTIFIER=" + record.component,
      "TIMS_ADDRESS=" + record.address.to_hex(),
      "TIMS_COMPONENT=" + record.component,
      "TIMS_LEVEL=" + std::string(gdos::name(record.level)),
  };
  std::array<iovec, 6> pieces{};
  for (std::size_t i = 0; i < fields.size(); ++i) pieces[i] = {fields[i].data(), fields[i].size()};
  const int sent = ::sd_journal_sendv(pieces.data(), static_cast<int>(pieces.size()));
  if (sent < 0)
    return tims::Error(tims::Errc::kSystem, "journal: " + std::generic_category().message(-sent));
  return {};
}

bool runs_under_journal() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
  return std::getenv("JOURNAL_STREAM") != nullptr;
}

}  // namespace rack::gdos_log
