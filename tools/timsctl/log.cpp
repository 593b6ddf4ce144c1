// timsctl log: what components say to people.
#include <array>
#include <deque>
#include <fstream>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "os/clock.h"
#include "proxies/gdos_texts.h"
#include "rack/proxies/gdos_log.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/subscription.h"
#include "tools/timsctl/text_filter.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {
namespace {

using rack::gdos::Record;

class Follower {
 public:
  explicit Follower(Context& context)
      : context_(context),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.run_end()) {}

  Exit own_sink(Connection& connection);
  Exit subscribe(Connection& connection, tims::Address log);

 private:
  void tell(const Record& record);
  std::optional<Record> text_of(const Message& message, const tims::AddressWidths& widths) const;
  static std::optional<Record> record_of(const Message& message, const tims::AddressWidths& widths);
  void note_state(const Subscription& log, const std::string& name);
  [[nodiscard]] Exit end() const {
    return left_ > 0 && context_.options.count ? Exit::kTimeout : Exit::kDone;
  }

  Context& context_;
  std::uint64_t left_;
  tims::Time end_;
  TextFilter filter_;
  Missed missed_{"texts"};
  Subscription::State state_ = Subscription::State::kAsking;
};

void Follower::tell(const Record& record) {
  if (!filter_.passes(record)) return;
  --left_;
  show_text(context_.out, record, false);
}

// --- as the owner of the sink

std::optional<Record> Follower::text_of(const Message& message,
                                        const tims::AddressWidths& widths) const {
  const auto level = rack::gdos::level_of(message.header.type);
  if (!level) return std::nullopt;
  const auto words = rack::gdos::decode(message.body, message.header.body_order(), widths);
  return Record{.time = std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now()),
                .address = message.header.src,
                .component = message.header.src.to_string(widths),
                .level = *level,
                .text = words ? *words : words.error().detail() + " (malformed)"};
}

Exit Follower::own_sink(Connection& connection) {
  filter_ = text_filter(context_.options, connection.widths(),
                        std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now()));
  while (left_ > 0) {
    const auto message = receive(connection, context_.signals, end_);
    if (!message) break;
    missed_.note(connection, context_.out);
    if (const auto record = text_of(*message, connection.widths())) tell(*record);
  }
  return end();
}

// --- as a listener of the log

// Its clock may be another one: the time is the log's own, in the turn of the counter nearest to
// ours.
std::optional<Record> Follower::record_of(const Message& message,
                                          const tims::AddressWidths& widths) {
  rack::GdosData data;
  if (message.header.type != tims::type::kData) return std::nullopt;
  if (!rack::decode(message.view(), data)) return std::nullopt;
  const auto level = rack::gdos::level_of(static_cast<std::int8_t>(data.level));
  if (!level || data.level != static_cast<rack::i32>(*level)) return std::nullopt;
  const auto now = std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now());
  const auto age = rack::TimeStamp::of(now.time_since_epoch()) - data.recordingTime;
  return Record{.time = now - age,
                .address = data.sender,
                .component = data.sender.to_string(widths),
                .level = *level,
                .text = std::string(data.words())};
}

void Follower::note_state(const Subscription& log, const std::string& name) {
  if (log.state() == state_) return;
  const bool first = state_ == Subscription::State::kAsking;
  state_ = log.state();
  if (state_ == Subscription::State::kNoMailbox && first)
    throw Failure(Exit::kNoSuch, "no_such_mailbox", name + ": nobody has registered this address",
                  "`timsctl component list GDOS` shows all logs");
  if (state_ == Subscription::State::kOff || state_ == Subscription::State::kNoMailbox)
    context_.out.note(name + " has no texts now, waiting");
}

Exit Follower::subscribe(Connection& connection, tims::Address log) {
  filter_ = text_filter(context_.options, connection.widths(),
                        std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now()));
  const std::string name = log.to_string(connection.widths());
  Subscriptions subscriptions(connection, {log}, 0);
  const tims::Time patience = tims::os::deadline_after(context_.options.timeout);
  while (left_ > 0 && tims::os::now() < end_) {
    const auto tick = tims::os::deadline_after(std::chrono::milliseconds(200));
    const auto data = subscriptions.next(context_.signals, std::min(end_, tick));
    note_state(subscriptions.all().front(), name);
    missed_.note(connection, context_.out);
    const auto record = data ? record_of(data->message, connection.widths()) : std::nullopt;
    if (record) tell(*record);
    if (state_ == Subscription::State::kAsking && tims::os::now() > patience)
      throw Failure(Exit::kTimeout, "timeout", name + " does not answer GET_CONT_DATA");
  }
  return end();
}

// Who keeps the texts says where they are to be had; another owner of the sink says nothing.
std::optional<tims::Address> ask_for_log(Context& context, Connection& connection) {
  const std::uint8_t seq_nr = connection.next_seq_nr();
  if (!connection.send(
          {.dest = rack::gdos::kSink, .type = rack::GdosLogType::kGetLog, .seq_nr = seq_nr}, {}))
    return std::nullopt;
  const tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (const auto message = receive(connection, context.signals, deadline)) {
    if (message->header.src != rack::gdos::kSink || message->header.seq_nr != seq_nr) continue;
    if (message->header.type != rack::GdosLogType::kLog) return std::nullopt;
    const auto answer = rack::decode<rack::GdosLogAddress>(message->view());
    return answer ? std::optional(answer->log) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

Exit log_follow(Context& context) {
  const MailboxWish listener{.address = {}, .slots = 1024, .body_max = 2048};
  Follower follower(context);
  if (!context.options.arguments.empty()) {
    const std::string& log = context.options.arguments.front();
    (void)need_address(log, kAnyWidths);
    const auto connection = context.connect(listener);
    return follower.subscribe(*connection, need_address(log, connection->widths()));
  }
  std::unique_ptr<Connection> sink;
  std::optional<Failure> in_use;
  try {
    sink =
        context.connect({.address = rack::gdos::kSink.to_hex(), .slots = 1024, .body_max = 1024});
  } catch (const Failure& failure) {
    if (failure.exit != Exit::kDenied) throw;
    in_use = failure;
  }
  if (sink) return follower.own_sink(*sink);
  const auto connection = context.connect(listener);
  const auto log = ask_for_log(context, *connection);
  if (!log) throw Failure(*in_use);
  return follower.subscribe(*connection, *log);
}

// --- log show: what components said, from the files of gdos-log

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
  const TextFilter filter =
      text_filter(options, {}, std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now()));
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
