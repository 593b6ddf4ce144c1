// timsctl msg: prints received messages, and sends messages by name.
#include <algorithm>
#include <array>
#include <cerrno>
#include <iostream>
#include <iterator>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/file.h"
#include "proxies/message_files.h"
#include "rack/proxies/generic.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"
#include "tools/timsctl/message.h"
#include "tools/timsctl/rates.h"

namespace timsctl {
namespace {

// Limits for a body and a sequence on a terminal; there are none with -o wide or in a pipe.
constexpr std::size_t kTerminalBytes = 256;
constexpr std::size_t kTerminalElements = 3;

class Echo {
 public:
  Echo(Context& context, Connection& connection)
      : context_(context),
        connection_(connection),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.run_end()),
        filter_(context.options.filter, connection.widths()),
        style_{
            .widths = connection.widths(),
            .utc = context.options.utc,
            .si = context.options.si,
            .fields = context.options.fields,
            .header = !context.options.listen.empty() || context.options.format == Format::kWide} {}

  Exit subscribe() {
    const auto components = need_addresses(context_.options.arguments, connection_.widths());
    for (const tims::Address component : components) {
      const std::uint32_t class_id = component.fields(style_.widths).class_id;
      const auto* data = rack::find_message(class_id, tims::type::kData);
      if (data != nullptr && data->body != nullptr) filter_.check(*data->body);
      if (const std::string why = undescribed(class_id); !why.empty())
        context_.out.note(fmt::format("{}, so bytes are shown: {}", why, rack::message_places()));
    }
    const auto period =
        std::chrono::duration_cast<std::chrono::milliseconds>(context_.options.period);
    Subscriptions subscriptions(connection_, components,
                                static_cast<std::uint32_t>(period.count()));
    const tims::Time patience = tims::os::deadline_after(context_.options.timeout);
    silence_.emplace(components.size(), tims::os::now());
    while (left_ > 0 && tims::os::now() < end_) {
      const auto tick = tims::os::deadline_after(std::chrono::milliseconds(200));
      const auto data = subscriptions.next(context_.signals, std::min(end_, tick));
      note_changes(subscriptions);
      missed_.note(connection_, context_.out);
      if (data) silence_->on_data(data->index, data->at);
      if (data) print(data->message);
      note_silence(subscriptions.all());
      const bool asking = subscriptions.all().front().state() == Subscription::State::kAsking;
      if (components.size() == 1 && asking && tims::os::now() > patience)
        throw Failure(Exit::kTimeout, "timeout",
                      name_of(components.front()) + " does not answer GET_CONT_DATA",
                      "is its owner busy? `timsctl mbx show ADDR` shows its waiting messages");
    }
    return end();
  }

  Exit listen() {
    context_.out.note(name_of(connection_.address()) + " is registered; stop with Ctrl-C");
    while (left_ > 0) {
      const auto message = receive(connection_, context_.signals, end_);
      if (!message) break;
      print(*message);
      missed_.note(connection_, context_.out);
      // The sender of a command waits for an answer; this program cannot execute commands.
      if (message->header.type > 0)
        (void)connection_.send({.dest = message->header.src,
                                .type = tims::type::kError,
                                .priority = message->header.priority,
                                .seq_nr = message->header.seq_nr},
                               {});
    }
    return end();
  }

 private:
  void note_silence(const std::vector<Subscription>& all) {
    for (const std::string& note : silence_->take(all, tims::os::now(), style_.widths))
      context_.out.note(note);
  }

  void print(const Message& message) {
    const base::WallTime now = tims::os::wall_now();
    const Format format = context_.out.look().format;
    const bool lines = format == Format::kTable || format == Format::kWide;
    if (!lines || !filter_.empty()) {
      const json::object described = described_json(message, now, style_);
      if (!filter_.passes(described)) return;
      if (format == Format::kJson) context_.out.write(described);
      if (format == Format::kCsv) context_.out.write(csv_.add(described));
    }
    --left_;
    ++printed_;
    if (!lines) return;
    const bool shorten = context_.out.terminal() && format != Format::kWide;
    if (context_.options.raw)
      return context_.out.write(dump(message, now,
                                     {.widths = style_.widths,
                                      .utc = style_.utc,
                                      .bytes_max = shorten ? kTerminalBytes : SIZE_MAX}));
    FieldStyle style = style_;
    if (shorten) style.elements_max = kTerminalElements;
    context_.out.write(describe(message, now, style));
  }

  // Reports why data is missing. At the start, a single address without -n or --for that is not
  // registered is an error; later it may return.
  void note_changes(const Subscriptions& subscriptions) {
    const auto& all = subscriptions.all();
    states_.resize(all.size(), Subscription::State::kAsking);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto state = all[i].state();
      if (state == states_[i]) continue;
      const bool first = states_[i] == Subscription::State::kAsking;
      states_[i] = state;
      if (state != Subscription::State::kRunning) silence_->skip(i);
      const std::string mailbox = name_of(all[i].component());
      if (state == Subscription::State::kNoMailbox && first && all.size() == 1)
        throw no_such_mailbox(mailbox);
      if (state == Subscription::State::kOff && first && all.size() == 1)
        throw Failure(Exit::kNo, "component_off",
                      mailbox + " sends no data: it answers ERROR, like a component that is off",
                      fmt::format("`timsctl component on {}`",
                                  shell_name(all[i].component(), style_.widths)));
      if (state == Subscription::State::kNoMailbox)
        context_.out.note(mailbox + " is not registered; waiting");
      if (state == Subscription::State::kOff) context_.out.note(mailbox + " is off; waiting");
      if (state == Subscription::State::kNoData)
        context_.out.note(mailbox + " is being turned on and has no data yet; waiting");
      if (state == Subscription::State::kRunning)
        context_.out.detail(
            fmt::format("{} sends every {} ms", mailbox, all[i].granted_ms().value_or(0)));
    }
  }

  [[nodiscard]] std::string name_of(tims::Address address) const {
    return address.to_string(connection_.widths());
  }

  [[nodiscard]] Exit end() const {
    const bool complete = !context_.options.count || left_ == 0;
    return complete && (printed_ > 0 || !context_.options.run_for) ? Exit::kDone : Exit::kTimeout;
  }

  Context& context_;
  Connection& connection_;
  std::uint64_t left_;
  std::uint64_t printed_ = 0;
  tims::Time end_;
  std::vector<Subscription::State> states_;
  std::optional<SilenceNotes> silence_;
  LostMessages missed_{"messages"};
  FieldFilter filter_;
  FieldStyle style_;
  CsvLines csv_;
};

}  // namespace

Exit msg_echo(Context& context) {
  const Options& options = context.options;
  const bool listens = !options.listen.empty();
  if (listens != options.arguments.empty())
    throw usage_error("msg echo: either ADDR... or --listen ADDR");
  if (listens) (void)need_address(options.listen, kAnyWidths);
  (void)need_addresses(options.arguments, kAnyWidths);
  (void)FieldFilter(options.filter);
  const auto connection =
      context.connect({.address = options.listen, .body_max = options.body_max_bytes});
  Echo echo(context, *connection);
  return listens ? echo.listen() : echo.subscribe();
}

// --- msg pub: sends messages

namespace {

// Commands of these classes make something move. Those of every class (OFF, GET_DATA) do not.
bool moves_something(std::uint32_t class_id, std::int8_t type) {
  if (type <= 0 || rack::find_message(rack::kEveryClass, type) != nullptr) return false;
  const auto is = [&](const char* name) { return tims::class_id_of(name) == class_id; };
  return std::ranges::any_of(
      std::array{"Chassis", "Pilot", "Planner", "ServoDrive", "PtzDrive", "Vehicle"}, is);
}

std::string read_all(const std::string& name) {
  if (name == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  auto content = tims::os::read_file(name);
  if (!content) throw Failure(Exit::kNoSuch, "no_such_file", content.error().detail());
  return std::move(*content);
}

struct PubArguments {
  std::string target;
  std::string type;                 // a number or a name; empty: as in the file
  std::vector<std::string> fields;  // "vx=200"
  std::string file;                 // "-": stdin; empty: none
};

PubArguments read_arguments(const Options& options) {
  PubArguments out{.target = options.arguments[0], .type = {}, .fields = {}, .file = options.file};
  (void)need_address(out.target, kAnyWidths);
  for (const std::string& argument : std::span(options.arguments).subspan(1)) {
    if (argument == "-")
      out.file = argument;
    else if (argument.find('=') != std::string::npos)
      out.fields.push_back(argument);
    else if (out.type.empty())
      out.type = argument;
    else
      throw usage_error(fmt::format("msg pub: unexpected argument \"{}\"", argument),
                        "fields are FIELD=VALUE, such as vx=200");
  }
  const int bodies = int{!out.file.empty()} + int{!options.hex.empty()} + int{!out.fields.empty()};
  if (bodies > 1) throw usage_error("msg pub: only one of --hex, a file and FIELD=VALUE");
  if (!out.fields.empty() && out.type.empty())
    throw usage_error("msg pub: TYPE is missing for these fields",
                      "give its name after ADDR, such as move; `timsctl msg types` shows all");
  return out;
}

// The body of a message given by name; omitted fields keep the defaults of the struct. A type given
// as a number does not define a body.
std::vector<std::byte> body_of(const PubArguments& arguments, std::uint32_t class_id,
                               const FieldStyle& style) {
  if (arguments.fields.empty() && parse_type(arguments.type)) return {};
  return make_body(need_message(class_id, arguments.type), class_id, arguments.fields, style);
}

std::vector<Draft> load_drafts(const PubArguments& arguments, const Options& options,
                               std::uint32_t class_id, const FieldStyle& style) {
  Draft plain{.little_endian = std::endian::native == std::endian::little, .body = {}};
  std::vector<Draft> drafts;
  const auto type = parse_type(arguments.type, class_id);
  if (!type && !arguments.type.empty()) (void)need_message(class_id, arguments.type);
  if (!options.hex.empty()) {
    const auto body = base::parse_hex(options.hex);
    if (!body)
      throw usage_error(fmt::format("--hex: \"{}\" is not pairs of hex digits", options.hex));
    plain.body = *body;
  } else if (!arguments.file.empty()) {
    const std::string text = read_all(arguments.file);
    if (!options.raw && is_recorded(text)) drafts = parse_recorded(text);
    const auto bytes = std::as_bytes(std::span(text));
    plain.body.assign(bytes.begin(), bytes.end());
  } else if (type) {
    plain.body = body_of(arguments, class_id, style);
  }
  if (drafts.empty()) {
    if (!type)
      throw usage_error("msg pub: TYPE is missing",
                        "give a number or a name such as get_status after ADDR");
    drafts.push_back(std::move(plain));
  }
  for (Draft& draft : drafts) {
    if (type) draft.type = *type;
    if (options.priority) draft.priority = *options.priority;
  }
  return drafts;
}

// A program that runs without a user must state with -y that it means it.
void confirm(const Context& context, tims::Address target, const std::vector<Draft>& drafts,
             const tims::AddressWidths& widths) {
  const std::uint32_t class_id = target.fields(widths).class_id;
  const bool moves = std::ranges::any_of(
      drafts, [&](const Draft& draft) { return moves_something(class_id, draft.type); });
  if (!moves || context.options.yes) return;
  if (::isatty(STDIN_FILENO) == 0)
    throw Failure(Exit::kDenied, "not_confirmed",
                  target.to_string(widths) +
                      " moves something, and stdin is not a terminal: nothing was sent",
                  "use -y to send without confirmation");
  std::cerr << target.to_string(widths) << " moves something. Send? [y/N] " << std::flush;
  std::string answer;
  std::getline(std::cin, answer);
  if (answer != "y" && answer != "Y" && answer != "yes")
    throw Failure(Exit::kDenied, "not_confirmed", "nothing was sent",
                  "use -y to send without confirmation");
}

class Publisher {
 public:
  Publisher(Context& context, tims::Address target, Connection& connection, const FieldStyle& style)
      : context_(context),
        style_(style),
        target_(target),
        target_name_(target.to_string(connection.widths())),
        connection_(connection) {}

  // Data to an unregistered address would be dropped without an answer, and the answer to a denied
  // command does not say why.
  void check_route(std::int8_t type) {
    AdminClient admin = context_.admin(connection_);
    json::object route;
    try {
      route = admin.ask({{"ask", "route"},
                         {"to", target_.to_hex()},
                         {"from", connection_.address().to_hex()},
                         {"type", type}});
    } catch (const Failure& failure) {
      if (failure.exit != Exit::kTimeout) throw;
      return context_.out.detail(
          failure.message);  // an original router does not support this request
    }
    const std::string verdict = text_at(route, "verdict");
    if (verdict == "no_route") throw no_such_mailbox(target_name_);
    if (verdict == "denied" && type > 0)  // others pass as answers
      throw Failure(Exit::kDenied, "denied_by_rule",
                    target_name_ + ": " + base::printable(text_at(route, "reason")),
                    "`timsctl acl show` lists the rules");
  }

  void send(const Draft& draft) {
    const std::uint8_t order = draft.little_endian ? tims::flag::kBodyLittleEndian : 0;
    auto sent = connection_.send({.dest = target_,
                                  .type = draft.type,
                                  .priority = draft.priority,
                                  .seq_nr = draft.seq_nr,
                                  .report_reason = draft.type > 0,
                                  .body_order = order},
                                 draft.body);
    if (!sent) throw failure_of(sent.error(), target_name_);
    ++sent_;
    bytes_ += draft.body.size();
  }

  // Sends repeatedly, with --rate.
  void send_all(const std::vector<Draft>& drafts) {
    const Options& options = context_.options;
    const bool repeats = options.rate_hz.has_value();
    const std::uint64_t rounds = options.count.value_or(repeats ? UINT64_MAX : 1);
    const tims::Time end = context_.run_end();
    const tims::Duration pause(repeats ? std::llround(1e9 / *options.rate_hz) : 0);
    tims::Time next = tims::os::now();
    for (std::uint64_t round = 0; round < rounds && tims::os::now() < end; ++round)
      for (const Draft& draft : drafts) {
        if (sent_ > 0 && repeats) {
          next += pause;
          context_.signals.sleep_until(std::min(next, end));
          if (next >= end) return;
        }
        send(draft);
      }
  }

  Exit wait_for_answer() {
    const tims::Time deadline = tims::os::deadline_after(context_.options.timeout);
    while (const auto message = receive(connection_, context_.signals, deadline)) {
      if (message->header.src != target_) continue;
      report(&*message);
      if (message->header.type == tims::type::kNotAvailable) {
        note_not_available();
        return Exit::kNoSuch;
      }
      const bool failed = message->header.type == tims::type::kError ||
                          message->header.type == tims::type::kTimeout;
      return failed ? Exit::kNo : Exit::kDone;
    }
    throw Failure(Exit::kTimeout, "timeout", target_name_ + " did not answer within the timeout",
                  "use a longer --timeout, or --no-wait");
  }

  // By a router on the way, which knows more or permits less than ours.
  void note_not_available() {
    const tims::AddressWidths widths = connection_.widths();
    context_.out.note(fmt::format(
        "it is gone, or a rule denies it: `timsctl explain {} {}` names the router and the rule",
        shell_name(connection_.address(), widths), shell_name(target_, widths)));
  }

  void report(const Message* answer) {
    const tims::AddressWidths widths = connection_.widths();
    if (context_.out.json()) {
      const json::value reply =
          answer == nullptr ? json::value()
                            : json::value(described_json(*answer, tims::os::wall_now(), style_));
      return context_.out.write(json::object{{"schema", "tims/pub/1"},
                                             {"target", address_json(target_, widths)},
                                             {"sent", sent_},
                                             {"sent_bytes", bytes_},
                                             {"answer", reply}});
    }
    if (answer != nullptr)
      context_.out.write(describe(*answer, tims::os::wall_now(), style_));
    else
      context_.out.note(fmt::format("{} message{} sent to {}, {}", sent_, sent_ == 1 ? "" : "s",
                                    target_name_, base::human_bytes(static_cast<double>(bytes_))));
  }

 private:
  Context& context_;
  FieldStyle style_;  // of the answer
  tims::Address target_;
  std::string target_name_;
  Connection& connection_;
  std::uint64_t sent_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Exit msg_pub(Context& context) {
  const PubArguments arguments = read_arguments(context.options);
  const auto connection =
      context.connect({.address = {}, .body_max = context.options.body_max_bytes});
  const FieldStyle style{.widths = connection->widths(),
                         .utc = context.options.utc,
                         .si = context.options.si,
                         .fields = context.options.fields};
  const tims::Address target = need_address(arguments.target, style.widths);
  const std::vector<Draft> drafts =
      load_drafts(arguments, context.options, target.fields(style.widths).class_id, style);
  confirm(context, target, drafts, connection->widths());
  Publisher publisher(context, target, *connection, style);
  publisher.check_route(drafts.front().type);
  try {
    publisher.send_all(drafts);
  } catch (const Interrupted&) {
    publisher.report(nullptr);
    if (context.options.rate_hz && context.options.endless()) return Exit::kDone;
    throw;
  }
  const bool one_command = drafts.size() == 1 && drafts.front().type > 0 &&
                           context.options.count.value_or(1) == 1 && !context.options.rate_hz;
  if (one_command && !context.options.no_wait) return publisher.wait_for_answer();
  publisher.report(nullptr);
  return Exit::kDone;
}

// --- msg types and show: the catalogue of messages; needs no router

namespace {

constexpr Column kTypes[] = {
    {"NAME", "name"},
    {"CLASS", "class"},
    {"TYPE", "type", Cell::kCount},
    {"BODY", "body"},
    {"MAX", "body_max_bytes", Cell::kBytes},
};

constexpr Column kFields[] = {
    {"FIELD", "name"},
    {"UNIT", "unit"},
    {"SI", "si_unit"},
    {"TYPE", "type"},
};

json::object message_item(const rack::MessageInfo& message) {
  const std::string_view name = tims::class_name(message.class_id);
  json::object item{{"class", message.class_id == rack::kEveryClass ? "every" : name},
                    {"type", message.type},
                    {"name", base::lower(message.name)},
                    {"body", nullptr},
                    {"body_max_bytes", 0}};
  if (message.body == nullptr) return item;
  item["body"] = message.body->name;
  item["body_max_bytes"] = message.body->size_max;
  return item;
}

json::array fields_of(const rack::MessageInfo& message) {
  json::array items;
  if (message.body == nullptr) return items;
  for (const rack::Column& column : rack::columns_of(*message.body))
    items.push_back({{"name", column.name},
                     {"unit", column.unit},
                     {"si_unit", column.si_unit},
                     {"type", column.type}});
  return items;
}

}  // namespace

Exit msg_types(Context& context) {
  const auto& arguments = context.options.arguments;
  std::optional<std::uint32_t> class_id;
  if (!arguments.empty() && base::lower(arguments[0]) == "every")
    class_id = rack::kEveryClass;
  else if (!arguments.empty())
    class_id = need_class(arguments[0]);
  json::array items;
  for (const auto table : rack::message_tables())
    for (const rack::MessageInfo& message : table)
      if (!class_id || message.class_id == *class_id) items.push_back(message_item(message));
  return show_list(context, "tims/message_types/1", std::move(items), kTypes);
}

Exit msg_show(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::uint32_t class_id = need_class(arguments[0]);
  const rack::MessageInfo& message = need_message(class_id, arguments[1]);
  json::object answer = message_item(message);
  answer["schema"] = "tims/message_type/1";
  answer["fields"] = fields_of(message);
  context.out.write(answer, [&] {
    const Look& look = context.out.look();
    std::string text;
    if (look.for_people())
      text = fmt::format("{}{} (type {}): {}\n", base::lower(message.name),
                         message.class_id == rack::kEveryClass ? ", of every class" : "",
                         message.type, message.body == nullptr ? "no body" : message.body->name);
    const json::array& fields = answer["fields"].as_array();
    return fields.empty() ? text : text + render_items(fields, kFields, look);
  });
  return Exit::kDone;
}

}  // namespace timsctl
