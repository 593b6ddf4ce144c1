#include "components/datalog/recorder.h"

#include "components/datalog/log_list.h"
#include "rack/proxies/proxy.h"

namespace rack::datalog {
namespace {

constexpr auto kSilence = std::chrono::seconds(2);  // and not before five periods
constexpr auto kAskAgain = std::chrono::seconds(2);

}  // namespace

Result<void> Recorder::create(const std::string& path) {
  base_ = base_of(path);
  if (auto created = file_.create(path); !created) return created;
  return file_.append(heading(*recorded_, info_->moduleMbx, widths_));
}

Result<void> Recorder::subscribe(tims::Time now) {
  asked_ = now;
  if (auto on = proxy_.on(); !on) return on;
  const auto granted = proxy_.get_cont_data(info_->periodTime, stream_);
  if (!granted) return granted.error();
  period_ = std::chrono::milliseconds(granted->raw());
  heard_ = now;
  ended_ = false;
  return {};
}

void Recorder::take(const tims::MessageView& message, tims::Time now, bool binary_io,
                    TextLog& log) {
  heard_ = now;
  if (const auto good = check_data(message.header, module()); !good) {
    ended_ = true;
    return log.warning("%n has no data now", module());
  }
  const auto made = record(*recorded_, message, info_->setsLogged + 1, binary_io);
  const auto written = made ? write(*made) : made.error();
  if (!written && !failing_) log.error("Not recorded, %n: %s", module(), written.error().message());
  if (written && failing_) log.print("Recorded again: %n", module());
  failing_ = !written;
}

// The line last: it speaks of the other files.
Result<void> Recorder::write(const Record& record) {
  std::size_t bytes = record.line.size();
  const auto beside = [&](std::string_view suffix, const std::string& content) -> Result<void> {
    if (suffix.empty()) return {};
    bytes += content.size();
    LogFile file;
    auto created =
        file.create(base_ + "_" + std::to_string(info_->setsLogged + 1) + std::string(suffix));
    return created ? file.append(content) : created;
  };
  if (auto good = beside(record.suffix, record.file); !good) return good;
  if (auto good = beside(record.raw_suffix, record.raw); !good) return good;
  if (auto good = file_.append(record.line); !good) return good;
  info_->bytesLogged = info_->bytesLogged + static_cast<u32>(bytes);
  ++info_->setsLogged;
  return {};
}

bool Recorder::is_silent(tims::Time now) const {
  return ended_ || now - heard_ > std::max<tims::Duration>(kSilence, 5 * period_);
}

void Recorder::ask_again(tims::Time now, TextLog& log) {
  if (now - asked_ < kAskAgain) return;
  if (const auto asked = subscribe(now); asked) log.info("%n sends again", module());
}

}  // namespace rack::datalog
