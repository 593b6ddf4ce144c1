#include "tools/timsctl/rates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

void RateMeter::on_message(tims::Time now, std::uint32_t body_bytes, std::uint8_t seq_nr) {
  ++window_.messages;
  window_.bytes += body_bytes;
  window_.body_min = std::min(window_.body_min, body_bytes);
  window_.body_max = std::max(window_.body_max, body_bytes);
  if (last_message_) {
    on_interval(tims::base::seconds(now - *last_message_));
    on_sequence(seq_nr);
  }
  last_message_ = now;
  last_seq_nr_ = seq_nr;
  ++total_;
}

void RateMeter::on_interval(double value) {
  Intervals& i = intervals_;
  i.min = i.count == 0 ? value : std::min(i.min, value);
  i.max = std::max(i.max, value);
  ++i.count;
  i.sum += value;
  const double before = value - i.mean;
  i.mean += before / static_cast<double>(i.count);
  i.square_sum += before * (value - i.mean);
  if (previous_interval_) i.jitter_sum += std::abs(value - *previous_interval_);
  previous_interval_ = value;
}

// Data of a component carries the constant number of the request. Losses can be detected only if
// the sender counts.
void RateMeter::on_sequence(std::uint8_t seq_nr) {
  const auto step = static_cast<std::uint8_t>(seq_nr - last_seq_nr_);
  if (step == 0) return;
  counts_ = true;
  lost_ += step - 1U;
}

RateReport RateMeter::report(tims::Time now) {
  RateReport report{.messages = window_.messages, .messages_total = total_};
  const double elapsed = tims::base::seconds(now - window_begin_);
  if (window_.messages > 0) {
    report.body_min_bytes = window_.body_min;
    report.body_max_bytes = window_.body_max;
    report.body_mean_bytes =
        static_cast<double>(window_.bytes) / static_cast<double>(window_.messages);
    if (elapsed > 0) report.bytes_per_s = static_cast<double>(window_.bytes) / elapsed;
  }
  if (intervals_.count > 0 && intervals_.sum > 0) {
    const auto count = static_cast<double>(intervals_.count);
    last_intervals_ = {.rate_hz = count / intervals_.sum,
                       .min_s = intervals_.min,
                       .max_s = intervals_.max,
                       .std_s = std::sqrt(intervals_.square_sum / count),
                       .jitter_s = intervals_.jitter_sum / count};
    intervals_ = {};
  }
  report.intervals = last_intervals_;
  if (counts_) report.lost = lost_;
  if (last_message_) report.silent_s = tims::base::seconds(now - *last_message_);
  // After a silence of ten intervals the stream counts as stopped, without a rate.
  const bool silent = report.messages == 0 && report.silent_s > 1.0;
  if (silent && report.intervals && *report.silent_s * report.intervals->rate_hz > 10) {
    report.intervals.reset();
    last_intervals_.reset();
  }
  window_ = {};
  window_begin_ = now;
  return report;
}

json::array TopRates::update(tims::Time now, std::span<const json::value> clients,
                             std::span<const json::value> mailboxes) {
  std::map<std::int64_t, double> taken;
  for (const json::object& mailbox : objects(mailboxes)) {
    taken[static_cast<std::int64_t>(number_or_zero(mailbox, "owner.client"))] +=
        number_or_zero(mailbox, "received");
  }
  const double elapsed = tims::base::seconds(now - last_);
  std::map<std::int64_t, Sample> samples;
  json::array items;
  for (const json::value& value : clients) {
    json::object item = value.as_object();
    const auto id = static_cast<std::int64_t>(number_or_zero(item, "id"));
    const Sample sample{.in = number_or_zero(item, "in_messages"),
                        .out = number_or_zero(item, "out_messages"),
                        .in_bytes = number_or_zero(item, "in_bytes"),
                        .out_bytes = number_or_zero(item, "out_bytes"),
                        .taken = taken[id]};
    samples[id] = sample;
    const auto before = samples_.find(id);
    if (before != samples_.end() && elapsed > 0) {
      // The counters of a closed mailbox disappear.
      const auto rate = [&](double Sample::*field) {
        return std::max(0.0, (sample.*field - before->second.*field) / elapsed);
      };
      item["in_per_s"] = rate(&Sample::in);
      item["out_per_s"] = rate(&Sample::out);
      item["in_bytes_per_s"] = rate(&Sample::in_bytes);
      item["out_bytes_per_s"] = rate(&Sample::out_bytes);
      item["taken_per_s"] = rate(&Sample::taken);
    }
    items.push_back(std::move(item));
  }
  samples_ = std::move(samples);
  last_ = now;
  return items;
}

// --- msg hz and bw: several streams side by side

namespace {

using namespace std::chrono_literals;

constexpr Column kHz[] = {
    {"ADDRESS", "address.name"},
    {"HZ", "rate_hz", Cell::kRate},
    {"MIN", "interval_min_s", Cell::kDuration},
    {"MAX", "interval_max_s", Cell::kDuration},
    {"STD", "interval_std_s", Cell::kDuration},
    {"JITTER", "jitter_s", Cell::kDuration},
    {"MESSAGES", "messages_total", Cell::kCount},
    {"LOST", "lost", Cell::kCount, false, true},
    {"BYTES/S", "bytes_per_s", Cell::kBytes, true},
    {"SILENT", "silent_s", Cell::kDuration, true},
    {"STATE", "state"},
};
constexpr Column kBw[] = {
    {"ADDRESS", "address.name"},
    {"BYTES/S", "bytes_per_s", Cell::kBytes},
    {"MIN", "body_min_bytes", Cell::kBytes},
    {"MEAN", "body_mean_bytes", Cell::kBytes},
    {"MAX", "body_max_bytes", Cell::kBytes},
    {"HZ", "rate_hz", Cell::kRate},
    {"MESSAGES", "messages_total", Cell::kCount},
    {"LOST", "lost", Cell::kCount, false, true},
    {"STATE", "state"},
};

json::value or_null(const std::optional<double>& value) {
  return value ? json::value(*value) : json::value();
}

json::object item_json(const Subscription& subscription, const RateReport& report,
                       const tims::AddressWidths& widths) {
  json::object item{{"address", address_json(subscription.component(), widths)},
                    {"state", subscription.state_name()},
                    {"messages", report.messages},
                    {"messages_total", report.messages_total},
                    {"bytes_per_s", report.bytes_per_s},
                    {"body_min_bytes", report.body_min_bytes},
                    {"body_mean_bytes", report.body_mean_bytes},
                    {"body_max_bytes", report.body_max_bytes},
                    {"lost", report.lost ? json::value(*report.lost) : json::value()},
                    {"silent_s", or_null(report.silent_s)}};
  if (const auto granted = subscription.granted_ms()) item["period_s"] = *granted / 1000.0;
  const auto& intervals = report.intervals;
  const auto put = [&](const char* name, double RateReport::Intervals::*field) {
    item[name] = intervals ? json::value((*intervals).*field) : json::value();
  };
  put("rate_hz", &RateReport::Intervals::rate_hz);
  put("interval_min_s", &RateReport::Intervals::min_s);
  put("interval_max_s", &RateReport::Intervals::max_s);
  put("interval_std_s", &RateReport::Intervals::std_s);
  put("jitter_s", &RateReport::Intervals::jitter_s);
  return item;
}

class RateWatch {
 public:
  RateWatch(Context& context, Connection& connection, const std::vector<tims::Address>& components,
            std::span<const Column> columns)
      : context_(context),
        connection_(connection),
        widths_(connection.widths()),
        columns_(columns),
        subscriptions_(connection, components, period_ms(context.options)),
        meters_(components.size(), RateMeter(tims::os::now())),
        silence_(components.size(), tims::os::now()) {}

  Exit run() {
    const Options& options = context_.options;
    const std::uint64_t count = options.count.value_or(UINT64_MAX);
    const tims::Time end = context_.run_end();
    const tims::Duration interval = options.interval.value_or(1s);
    if (context_.out.terminal() && !context_.out.json() && count > 1) context_.out.write("\033[2J");
    tims::Time next = tims::os::now();
    for (std::uint64_t i = 0; i < count && next < end; ++i) {
      next = std::min(next + interval, end);
      listen_until(next);
      if (i == 0) check_reachable();
      report();
    }
    note_silence(true);
    return verdict();
  }

 private:
  void note_silence(bool at_end) {
    for (const std::string& note :
         silence_.take(subscriptions_.all(), tims::os::now(), widths_, at_end))
      context_.out.note(note);
  }

  static std::uint32_t period_ms(const Options& options) {
    return static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(options.period).count());
  }

  void listen_until(tims::Time deadline) {
    while (const auto data = subscriptions_.next(context_.signals, deadline)) {
      silence_.on_data(data->index, data->at);
      meters_[data->index].on_message(data->at,
                                      static_cast<std::uint32_t>(data->message.body.size()),
                                      data->message.header.seq_nr);
    }
  }

  void report() {
    json::array items;
    totals_.clear();
    const tims::Time now = tims::os::now();
    for (std::size_t i = 0; i < meters_.size(); ++i) {
      const RateReport numbers = meters_[i].report(now);
      totals_.push_back(numbers.messages_total);
      items.push_back(item_json(subscriptions_.all()[i], numbers, widths_));
    }
    if (context_.out.json())
      return context_.out.write(json::object{{"schema", "tims/rate/1"},
                                             {"time", base::rfc3339(tims::os::wall_now())},
                                             {"items", std::move(items)}});
    missed_.note(connection_, context_.out);
    const std::string table = render_items(items, columns_, context_.out.look());
    context_.options.count == 1 ? context_.out.write(table) : context_.out.redraw(table);
    note_silence(false);
  }

  // For an unregistered address the user would wait for ever.
  void check_reachable() const {
    const auto& all = subscriptions_.all();
    for (const Subscription& s : all)
      if (s.state() != Subscription::State::kNoMailbox) return;
    throw no_such_mailbox(all.front().component().to_string(widths_));
  }

  [[nodiscard]] Exit verdict() const {
    for (const Subscription& s : subscriptions_.all())
      if (s.state() == Subscription::State::kNoMailbox) return Exit::kNoSuch;
    return std::ranges::count(totals_, 0U) > 0 ? Exit::kTimeout : Exit::kDone;
  }

  Context& context_;
  Connection& connection_;
  tims::AddressWidths widths_;
  std::span<const Column> columns_;
  Subscriptions subscriptions_;
  std::vector<RateMeter> meters_;
  std::vector<std::uint64_t> totals_;
  SilenceNotes silence_;
  LostMessages missed_{"messages"};
};

Exit measure(Context& context, std::span<const Column> columns) {
  const Options& options = context.options;
  (void)need_addresses(options.arguments, kAnyWidths);
  const auto connection =
      context.connect({.address = {}, .slots = 256, .body_max = options.body_max_bytes});
  const auto components = need_addresses(options.arguments, connection->widths());
  return RateWatch(context, *connection, components, columns).run();
}

}  // namespace

Exit msg_hz(Context& context) { return measure(context, kHz); }
Exit msg_bw(Context& context) { return measure(context, kBw); }

// --- timsctl top: live rates of all clients

namespace {

using namespace std::chrono_literals;

constexpr Column kTop[] = {
    {"CLIENT", "id", Cell::kCount},
    {"NAME", "name"},
    {"PORT", "port"},
    {"PID", "pid", Cell::kText},
    {"MAILBOXES", "mailboxes", Cell::kCount},
    {"TAKEN/S", "taken_per_s", Cell::kRate},
    {"IN/S", "in_per_s", Cell::kRate},
    {"OUT/S", "out_per_s", Cell::kRate},
    {"IN_BYTES/S", "in_bytes_per_s", Cell::kBytes},
    {"OUT_BYTES/S", "out_bytes_per_s", Cell::kBytes},
    {"DROPS", "drops", Cell::kCount, false, true},
    {"QUEUE", "queue_bytes", Cell::kBytes},
};
// Reads single keys from a terminal, without Enter and echo, during its lifetime.
enum class Key { kNone, kQuit, kLeft, kRight, kHelp };

class Keys {
 public:
  Keys() {
    termios now{};
    if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
    before_ = now;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    now.c_cc[VMIN] = 0;
    now.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
  }  // does nothing if stdin is not a terminal
  ~Keys() {
    if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
  }

  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  // A file descriptor to wait for; -1 without a terminal.
  [[nodiscard]] int descriptor() const { return before_ ? STDIN_FILENO : -1; }
  Key read() const {
    std::array<char, 16> buffer{};
    const ssize_t size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (size == 0) return Key::kQuit;  // the terminal was closed
    const std::string_view text(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    if (text == "q" || text == "Q") return Key::kQuit;
    if (text == "\033[D" || text == "<") return Key::kLeft;
    if (text == "\033[C" || text == ">") return Key::kRight;
    if (text == "h" || text == "H" || text == "?") return Key::kHelp;
    return Key::kNone;
  }

 private:
  std::optional<termios> before_;
};

constexpr std::size_t kFirstSortable = 4;

constexpr std::string_view kTopHelp =
    "  h or ?         show this help, or the clients again\n"
    "  left or <      sort by the column to the left\n"
    "  right or >     sort by the column to the right\n"
    "  q or Ctrl-C    quit\n\n"
    "  IN, OUT        messages per second from and to the client through the router\n"
    "  TAKEN          messages per second from the client's mailboxes, also of local senders\n"
    "  DROPS          messages for it that were lost; `timsctl stats --by reason` states why\n"
    "  QUEUE          bytes that wait until it reads\n";

// Requesting very many mailboxes every second would be a considerable load.
constexpr double kMailboxesMax = 5000;

class Top {
 public:
  explicit Top(Context& context) : context_(context), sort_(context.options.sort) {
    if (sort_.empty()) sort_ = kTop[column_].title;
    for (std::size_t i = 0; i < std::size(kTop); ++i)
      if (kTop[i].title == sort_) column_ = i;
  }

  Exit run() {
    const Options& options = context_.options;
    const bool live = context_.out.terminal() && !context_.out.json() && options.count != 1;
    if (live) {
      keys_.emplace();
      context_.out.write("\033[2J");
    }
    const tims::Duration interval = options.interval.value_or(1s);
    const std::uint64_t count = options.count.value_or(UINT64_MAX);
    const tims::Time end = context_.run_end();
    sample();
    tims::Time next = tims::os::now();
    for (std::uint64_t i = 0; i < count && !quit_ && next < end; ++i) {
      next = std::min(next + interval, end);
      wait_until(next);
      if (quit_) break;
      try {
        sample();
        draw();
      } catch (const Failure& failure) {
        if (!live || (failure.exit != Exit::kNoRouter && failure.exit != Exit::kTimeout)) throw;
        connection_.reset();
        context_.out.redraw(failure.message + "; retrying\n");
      }
    }
    return Exit::kDone;
  }

 private:
  void sample() {
    if (!connection_) connection_ = context_.connect();
    AdminClient admin = context_.admin(*connection_);
    status_ = admin.ask({{"ask", "status"}});
    const json::object clients = admin.ask({{"ask", "clients"}});
    json::object mailboxes;
    if (number_or_zero(status_, "mailboxes") <= kMailboxesMax)
      mailboxes = admin.ask({{"ask", "mailboxes"}});
    items_ = rates_.update(tims::os::now(), items_of(clients), items_of(mailboxes));
  }

  void draw() {
    if (context_.out.json())
      return context_.out.write(json::object{{"schema", "tims/top/1"},
                                             {"router", text_at(status_, "router")},
                                             {"time", base::rfc3339(tims::os::wall_now())},
                                             {"items", items_}});
    sort_items(items_, kTop, sort_);
    const std::string table =
        help_ ? std::string(kTopHelp) : render_items(items_, kTop, context_.out.look());
    keys_ ? context_.out.redraw(heading() + table) : context_.out.write(table);
  }

  void wait_until(tims::Time deadline) {
    const int fd = keys_ ? keys_->descriptor() : -1;
    while (context_.signals.wait(fd, deadline) == Signals::WaitResult::kReadable) {
      const Key key = keys_->read();
      if (key == Key::kQuit) quit_ = true;
      if (quit_) return;
      if (key == Key::kLeft && column_ > kFirstSortable) --column_;
      if (key == Key::kRight && column_ + 1 < std::size(kTop)) ++column_;
      if (key == Key::kNone) continue;
      if (key == Key::kHelp) help_ = !help_;
      sort_ = kTop[column_].title;
      draw();
    }
  }

  [[nodiscard]] std::string heading() const {
    return fmt::format(
        "{} up {}, {} clients, {} mailboxes, {} dropped in the last minute   by {}; h for help, q "
        "quits\n\n",
        base::printable(text_at(status_, "name")),
        base::human_duration(number_or_zero(status_, "uptime_s")),
        number_or_zero(status_, "clients"), number_or_zero(status_, "mailboxes"),
        number_or_zero(status_, "drops_last_minute"), sort_);
  }

  Context& context_;
  std::string sort_;
  std::size_t column_ = 5;
  bool quit_ = false;
  bool help_ = false;
  std::unique_ptr<Connection> connection_;
  TopRates rates_;
  json::object status_;
  json::array items_;
  std::optional<Keys> keys_;
};

}  // namespace

Exit top(Context& context) { return Top(context).run(); }

}  // namespace timsctl
