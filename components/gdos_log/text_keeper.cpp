#include "components/gdos_log/text_keeper.h"

#include <utility>

#include "components/gdos_log/journal.h"

namespace rack::gdos_log {

tims::Result<void> TextKeeper::open(const std::filesystem::path& folder,
                                    const TextFileLimits& limits) {
  const auto opened = files_.open(folder, limits);
  // A full disk may have room later; no such folder will not.
  if (!opened && opened.error().code() != tims::Errc::kDiskFull) return opened.error();
  if (opened && *opened > 0)
    log_.warning("%u bytes of a text that was not written to its end were cut off", *opened);
  return {};
}

void TextKeeper::keep(const gdos::Record& record) {
  report(files_.append(gdos::to_line(record)));
  if (!journal_) return;
  const auto sent = to_journal(record);
  if (!sent && !journal_failed_) log_.warning("%s", sent.error().detail());
  journal_failed_ = !sent;
}

// What it says of itself comes back to it as a text: so never more than once.
void TextKeeper::report(const tims::Result<void>& written) {
  if (!written) {
    if (not_kept_++ == 0) log_.error("Texts are not kept: %s", written.error().message());
    return;
  }
  if (const std::uint32_t lost = std::exchange(not_kept_, 0))
    log_.warning("Texts are kept again; %u were not", lost);
}

void TextKeeper::on_time(tims::Time now) {
  if (now < next_sync_) return;
  next_sync_ = now + sync_each_;
  if (auto good = files_.sync(); !good) report(good);
}

}  // namespace rack::gdos_log
