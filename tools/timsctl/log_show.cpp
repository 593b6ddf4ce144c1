// timsctl log show: what components said, from the files of gdos-log.
#include <array>
#include <deque>
#include <fstream>

#include <fmt/format.h>

#include "proxies/gdos_files.h"
#include "proxies/gdos_reader.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/text_filter.h"

namespace timsctl {

namespace {

using rack::gdos::Record;

template <typename Take>
void read_file(const std::filesystem::path& path, rack::gdos::RecordReader& reader,
               const Signals& signals, Take take) {
  std::ifstream file(path, std::ios::binary);
  // One that went while the log went on is older than all that are left.
  if (!file && errno == ENOENT) return;
  if (!file)
    throw Failure(Exit::kDenied, "denied", path.string() + ": cannot be read",
                  "are you in the group that owns it?");
  std::array<char, 64 << 10> piece{};
  while (file) {
    file.read(piece.data(), piece.size());
    reader.read({piece.data(), static_cast<std::size_t>(file.gcount())}, take);
    signals.sleep_until({});  // Ctrl-C
  }
}

}  // namespace

Exit log_show(Context& context) {
  const Options& options = context.options;
  const TextFilter filter = text_filter(options, {}, wall_now_ms());
  const std::filesystem::path folder = options.directory.empty()
                                           ? rack::gdos::folder_to_read()
                                           : std::filesystem::path(options.directory);
  const auto paths = rack::gdos::log_paths(folder);
  if (paths.empty())
    throw Failure(Exit::kNoSuch, "no_log", folder.string() + ": no texts are kept here",
                  "start `gdos-log`, or name its folder with --directory");

  std::uint64_t shown = 0;
  std::deque<Record> newest;
  rack::gdos::RecordReader reader;
  const auto take = [&](Record&& record) {
    if (!filter.passes(record)) return;
    ++shown;
    if (!options.count) return show_text(context.out, record, true);
    newest.push_back(std::move(record));
    if (newest.size() > *options.count) newest.pop_front();
  };
  for (const auto& path : paths) read_file(path, reader, context.signals, take);
  for (const Record& record : newest) show_text(context.out, record, true);
  if (reader.strange() > 0)
    context.out.note(fmt::format("{} lines are no texts and were left out", reader.strange()));
  if (shown == 0) context.out.note("nothing was said");
  return shown > 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace timsctl
