#include "tools/timsctl/log.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <deque>
#include <fstream>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "rack/proxies/gdos_log.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

using rack::gdos::Record;
using rack::gdos::RecordTime;

namespace {

Tone tone_of(rack::gdos::Level level) {
  switch (level) {
    case rack::gdos::Level::kError:
      return Tone::kBad;
    case rack::gdos::Level::kWarning:
      return Tone::kWarning;
    case rack::gdos::Level::kInfo:
      return Tone::kGood;
    case rack::gdos::Level::kDetail:
      return Tone::kDim;
    case rack::gdos::Level::kPrint:
      break;
  }
  return Tone::kPlain;
}

RecordTime now() { return std::chrono::floor<std::chrono::milliseconds>(tims::os::wall_now()); }

std::tm fields_of(RecordTime time, bool utc) {
  const std::time_t whole =
      std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
  std::tm fields{};
  utc ? ::gmtime_r(&whole, &fields) : ::localtime_r(&whole, &fields);
  return fields;
}

RecordTime time_of(std::tm fields, bool utc) {
  fields.tm_isdst = -1;
  return RecordTime(std::chrono::seconds(utc ? ::timegm(&fields) : ::mktime(&fields)));
}

std::string day_of(RecordTime time, bool utc) {
  const std::tm fields = fields_of(time, utc);
  return fmt::format("{:04}-{:02}-{:02}", fields.tm_year + 1900, fields.tm_mon + 1, fields.tm_mday);
}

// Missing parts of the date keep the values of `fields`. The whole text must be consumed.
bool parse_with(const char* form, const std::string& text, std::tm& fields) {
  std::tm parsed = fields;
  const char* const end = ::strptime(text.c_str(), form, &parsed);
  if (end == nullptr || *end != 0) return false;
  fields = parsed;
  return true;
}

RecordTime need_when(const std::string& text, RecordTime now, bool utc) {
  if (const auto time = parse_when(text, now, utc)) return *time;
  throw usage_error(
      "\"" + text + "\" is not a time",
      "10min (ago), 03:15, 2026-11-22, '2026-11-22 03:15:30' or the same with T and Z");
}

}  // namespace

std::optional<RecordTime> parse_when(std::string_view text, RecordTime now, bool utc) {
  if (const auto ago = base::parse_duration(text))
    return now - std::chrono::floor<std::chrono::milliseconds>(*ago);
  if (const auto exact = rack::gdos::record_time(text)) return exact;
  const bool zulu = text.ends_with('Z');
  const std::string plain(text.substr(0, text.size() - (zulu ? 1 : 0)));
  utc = utc || zulu;
  std::tm fields = fields_of(now, utc);
  fields.tm_hour = fields.tm_min = fields.tm_sec = 0;
  for (const char* form : {"%Y-%m-%d", "%Y-%m-%d %H:%M", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M",
                           "%Y-%m-%dT%H:%M:%S", "%H:%M", "%H:%M:%S"})
    if (parse_with(form, plain, fields)) return time_of(fields, utc);
  return std::nullopt;
}

SenderPattern::SenderPattern(std::string_view text) {
  (void)need_pattern(text, kAnyWidths);
  const std::string form = pattern_text(text);
  name_ = name_of(form, "*");
  if (!name_ && form != "*") address_ = tims::Address::parse(form);
}

// The parts of "Ladar(3/500):2"; the class in lower case, by its name if it has one. `local`: if
// the text has none.
std::optional<SenderPattern::Name> SenderPattern::name_of(std::string_view text,
                                                          std::string_view local) {
  const auto cut = [&text](std::string_view mark) {
    const std::size_t at = text.find(mark);
    const std::string part(text.substr(0, at));
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + mark.size());
    return part;
  };
  if (text.find('(') == std::string_view::npos) return std::nullopt;
  Name name{.class_name = base::lower(with_class_names(cut("("))),
            .system = cut("/"),
            .instance = cut(")"),
            .local = std::string(local)};
  if (text.starts_with(':')) name.local = text.substr(1);
  return name;
}

bool SenderPattern::matches(const Record& record) const {
  if (address_) return record.address == *address_;
  if (!name_) return true;
  const auto sender = name_of(record.component, "0");
  const auto fits = [](const std::string& wanted, const std::string& found) {
    return wanted == "*" || wanted == found;
  };
  return sender && fits(name_->class_name, sender->class_name) &&
         fits(name_->system, sender->system) && fits(name_->instance, sender->instance) &&
         fits(name_->local, sender->local);
}

TextFilter text_filter(const Options& options, RecordTime now) {
  TextFilter filter;
  if (!options.component.empty()) filter.component.emplace(options.component);
  if (options.level) filter.level = *options.level;
  if (!options.since.empty()) filter.since = need_when(options.since, now, options.utc);
  if (!options.until.empty()) filter.until = need_when(options.until, now, options.utc);
  return filter;
}

bool TextFilter::passes(const Record& record) const {
  return record.level >= level && (!component || component->matches(record)) &&
         (!since || record.time >= *since) && (!until || record.time <= *until);
}

void show_text(Output& out, const Record& record, bool with_day) {
  const std::string_view level = rack::gdos::name(record.level);
  const std::string component = with_class_names(record.component);
  if (out.json())
    return out.write(
        json::object{{"schema", "tims/text/1"},
                     {"time", rack::gdos::to_text(record.time)},
                     {"address", {{"name", component}, {"raw", record.address.to_hex()}}},
                     {"level", level},
                     {"text", record.text}});
  const bool utc = out.look().utc;
  const std::string day = with_day ? day_of(record.time, utc) + " " : "";
  const std::string line = fmt::format("{}{} {:<18} {:<7} {}", day, time_of_day(record.time, utc),
                                       component, level, record.text);
  out.write(paint(base::printable(line), tone_of(record.level), out.look().colour) + "\n");
}

// --- texts from the files of gdos-log

namespace {

std::filesystem::path log_folder(const Options& options) {
  return options.directory.empty() ? rack::gdos::folder_to_read()
                                   : std::filesystem::path(options.directory);
}

template <typename Take>
void read_file(const std::filesystem::path& path, rack::gdos::RecordReader& reader,
               const Signals& signals, Take take) {
  std::ifstream file(path, std::ios::binary);
  // A file that was deleted during the listing is older than all remaining files.
  if (!file && errno == ENOENT) return;
  if (!file)
    throw Failure(Exit::kDenied, "denied", "cannot read " + path.string(),
                  "are you a member of its group?");
  std::array<char, 64 << 10> piece{};
  while (file) {
    file.read(piece.data(), piece.size());
    reader.read({piece.data(), static_cast<std::size_t>(file.gcount())}, take);
    signals.sleep_until({});  // Ctrl-C
  }
}

// Passes all texts that the filter selects to `take`, oldest first.
template <typename Take>
void read_texts(Context& context, const TextFilter& filter, Take take) {
  rack::gdos::RecordReader reader;
  const auto pass = [&](Record&& record) {
    if (filter.passes(record)) take(std::move(record));
  };
  for (const auto& path : rack::gdos::log_paths(log_folder(context.options)))
    read_file(path, reader, context.signals, pass);
  if (reader.strange() > 0)
    context.out.note(fmt::format("{} invalid lines were skipped", reader.strange()));
}

// The newest ones, as many as --count.
std::deque<Record> kept_texts(Context& context, const TextFilter& filter) {
  std::deque<Record> newest;
  read_texts(context, filter, [&](Record&& record) {
    newest.push_back(std::move(record));
    if (newest.size() > *context.options.count) newest.pop_front();
  });
  return newest;
}

}  // namespace

// --- timsctl log: texts of components for the user

namespace {

using rack::gdos::Record;

class Follower {
 public:
  explicit Follower(Context& context)
      : context_(context), end_(context.run_end()), filter_(text_filter(context.options, now())) {}

  // Received directly, as owner of the GDOS mailbox.
  Exit own_sink(Connection& connection) {
    show_backlog();
    for (;;) {
      const auto message = receive(connection, context_.signals, end_);
      if (!message) break;
      missed_.note(connection, context_.out);
      if (const auto record = text_of(*message, connection.widths())) print(*record);
    }
    return Exit::kDone;
  }

  // Received from gdos-log, as a subscriber.
  Exit subscribe(Connection& connection, tims::Address log) {
    const std::string name = log.to_string(connection.widths());
    Subscriptions subscriptions(connection, {log}, 0);
    const tims::Time patience = tims::os::deadline_after(context_.options.timeout);
    while (tims::os::now() < end_) {
      const auto tick = tims::os::deadline_after(std::chrono::milliseconds(200));
      const auto data = subscriptions.next(context_.signals, std::min(end_, tick));
      note_state(subscriptions.all().front(), name);
      missed_.note(connection, context_.out);
      // Texts that arrive from now on are not missed: they wait in the mailbox.
      if (state_ != Subscription::State::kAsking) show_backlog();
      const auto record = data ? record_of(data->message, connection.widths()) : std::nullopt;
      if (record) print(*record);
      if (state_ == Subscription::State::kAsking && tims::os::now() > patience)
        throw Failure(Exit::kTimeout, "timeout", name + " does not answer GET_CONT_DATA");
    }
    return Exit::kDone;
  }

 private:
  void print(const Record& record) {
    if (filter_.passes(record) && !is_in_backlog(record)) show_text(context_.out, record, false);
  }

  // -n N: the newest N texts that gdos-log has kept on this host.
  void show_backlog() {
    if (!context_.options.count || backlog_shown_) return;
    backlog_shown_ = true;
    const std::filesystem::path folder = log_folder(context_.options);
    if (rack::gdos::log_paths(folder).empty())
      return context_.out.note(fmt::format(
          "no messages of the past: there are no log files in {} on this host", folder.string()));
    backlog_ = kept_texts(context_, filter_);
    for (const Record& record : backlog_) show_text(context_.out, record, true);
  }

  // A text may arrive that was read from the files already.
  [[nodiscard]] bool is_in_backlog(const Record& record) const {
    constexpr auto kRounding = std::chrono::milliseconds(2);
    return std::ranges::any_of(backlog_, [&](const Record& kept) {
      return kept.address == record.address && kept.text == record.text &&
             std::chrono::abs(kept.time - record.time) <= kRounding;
    });
  }

  std::optional<Record> text_of(const Message& message, const tims::AddressWidths& widths) const {
    const auto level = rack::gdos::level_of(message.header.type);
    if (!level) return std::nullopt;
    const auto decoded = rack::gdos::decode(message.body, message.header.body_order(), widths);
    return Record{.time = now(),
                  .address = message.header.src,
                  .component = message.header.src.to_string(widths),
                  .level = *level,
                  .text = decoded ? *decoded : decoded.error().detail() + " (malformed)"};
  }

  // The clock of the log may differ from ours: the time is that of the log, unwrapped to the value
  // nearest to ours.
  static std::optional<Record> record_of(const Message& message,
                                         const tims::AddressWidths& widths) {
    rack::GdosData data;
    if (message.header.type != tims::type::kData) return std::nullopt;
    if (!rack::decode(message.view(), data)) return std::nullopt;
    const auto level = rack::gdos::level_of(static_cast<std::int8_t>(data.level));
    if (!level || data.level != static_cast<rack::i32>(*level)) return std::nullopt;
    const RecordTime now = timsctl::now();
    const auto age = rack::TimeStamp::of(now.time_since_epoch()) - data.recordingTime;
    return Record{.time = now - age,
                  .address = data.sender,
                  .component = data.sender.to_string(widths),
                  .level = *level,
                  .text = std::string(data.as_text())};
  }

  void note_state(const Subscription& log, const std::string& name) {
    if (log.state() == state_) return;
    const bool first = state_ == Subscription::State::kAsking;
    state_ = log.state();
    if (state_ == Subscription::State::kNoMailbox && first)
      throw no_such_mailbox(name, "`timsctl component list GDOS` shows all logs");
    if (state_ == Subscription::State::kOff || state_ == Subscription::State::kNoMailbox)
      context_.out.note(name + " has no messages; waiting");
  }

  Context& context_;
  tims::Time end_;
  TextFilter filter_;
  bool backlog_shown_ = false;
  std::deque<Record> backlog_;
  LostMessages missed_{"texts"};
  Subscription::State state_ = Subscription::State::kAsking;
};

// gdos-log reports the address of its log; other owners of the GDOS mailbox do not.
std::optional<tims::Address> ask_for_log(Context& context, Connection& connection) {
  const std::uint8_t seq_nr = connection.next_seq_nr();
  const tims::Address sink = tims::text_sink(connection.widths());
  if (!connection.send({.dest = sink, .type = rack::GdosLogType::kGetLog, .seq_nr = seq_nr}, {}))
    return std::nullopt;
  const tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (const auto message = receive(connection, context.signals, deadline)) {
    if (message->header.src != sink || message->header.seq_nr != seq_nr) continue;
    if (message->header.type != rack::GdosLogType::kLog) return std::nullopt;
    const auto answer = rack::decode<rack::GdosLogAddress>(message->view());
    return answer ? std::optional(answer->log) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

namespace {

Exit follow(Context& context) {
  const MailboxRequest listener{.address = {}, .slots = 1024, .body_max = 2048};
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
    sink = context.connect({.address = "GDOS(0/0)", .slots = 1024, .body_max = 1024});
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

}  // namespace

// Ctrl-C is the usual end; -n is no limit here.
Exit log_follow(Context& context) {
  try {
    return follow(context);
  } catch (const Interrupted&) {
    return context.options.run_for ? Exit::kInterrupted : Exit::kDone;
  }
}

// --- log show

Exit log_show(Context& context) {
  const TextFilter filter = text_filter(context.options, now());
  const std::filesystem::path folder = log_folder(context.options);
  if (rack::gdos::log_paths(folder).empty())
    throw Failure(Exit::kNoSuch, "no_log", folder.string() + ": there are no log files",
                  "start `gdos-log`, or name its folder with --directory");
  std::uint64_t shown = 0;
  const auto show = [&](const Record& record) {
    ++shown;
    show_text(context.out, record, true);
  };
  if (context.options.count)
    std::ranges::for_each(kept_texts(context, filter), show);
  else
    read_texts(context, filter, show);
  if (shown == 0) context.out.note("no messages found");
  return shown > 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace timsctl
