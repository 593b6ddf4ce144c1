// timsctl msg pub: sends messages.
#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "proxies/generic.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/message_fields.h"
#include "tools/timsctl/message_text.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

// Classes whose components move something.
bool is_actuator(tims::Address address, const tims::AddressWidths& widths) {
  const std::uint32_t class_id = address.fields(widths).class_id;
  for (const char* name : {"Chassis", "Pilot", "ServoDrive", "PtzDrive", "Vehicle"})
    if (tims::class_id_of(name) == class_id) return true;
  return false;
}

std::string read_all(const std::string& name) {
  std::ifstream file;
  if (name != "-") {
    file.open(name, std::ios::binary);
    if (!file)
      throw Failure(Exit::kNoSuch, "no_such_file",
                    name + ": " + std::generic_category().message(errno));
  }
  std::istream& in = name == "-" ? std::cin : file;
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Arguments {
  std::string target;
  std::string type;                 // a number or a name; empty: as in the file
  std::vector<std::string> fields;  // "vx=200"
  std::string file;                 // "-": stdin; empty: none
};

Arguments read_arguments(const Options& options) {
  Arguments out{.target = options.arguments[0], .type = {}, .fields = {}, .file = options.file};
  (void)need_address(out.target, kAnyWidths);
  for (const std::string& word : std::span(options.arguments).subspan(1)) {
    if (word == "-")
      out.file = word;
    else if (word.find('=') != std::string::npos)
      out.fields.push_back(word);
    else if (out.type.empty())
      out.type = word;
    else
      throw usage_error(fmt::format("msg pub: \"{}\" is one word too many", word),
                        "fields are FIELD=VALUE, such as vx=200");
  }
  const int bodies = int{!out.file.empty()} + int{!options.hex.empty()} + int{!out.fields.empty()};
  if (bodies > 1) throw usage_error("msg pub: only one of --hex, a file and FIELD=VALUE");
  if (!out.fields.empty() && out.type.empty())
    throw usage_error("msg pub: which TYPE has these fields?",
                      "its name behind ADDR, such as move; `timsctl msg types` shows all");
  return out;
}

// The body of a message that is called by its name: all fields that are not given are as in its
// struct. A bare number says nothing of the body.
std::vector<std::byte> body_of(const Arguments& arguments, std::uint32_t class_id,
                               const FieldStyle& style) {
  if (arguments.fields.empty() && parse_type(arguments.type)) return {};
  return make_body(need_message(class_id, arguments.type), class_id, arguments.fields, style);
}

std::vector<Draft> load_drafts(const Arguments& arguments, const Options& options,
                               std::uint32_t class_id, const FieldStyle& style) {
  Draft plain{.little_endian = std::endian::native == std::endian::little, .body = {}};
  std::vector<Draft> drafts;
  const auto type = parse_type(arguments.type, class_id);
  if (!type && !arguments.type.empty()) (void)need_message(class_id, arguments.type);
  if (!options.hex.empty()) {
    const auto body = parse_hex(options.hex);
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
      throw usage_error("msg pub: which TYPE?",
                        "a number or a name such as get_status, behind ADDR");
    drafts.push_back(std::move(plain));
  }
  for (Draft& draft : drafts) {
    if (type) draft.type = *type;
    if (options.priority) draft.priority = *options.priority;
  }
  return drafts;
}

void confirm(const Context& context, tims::Address target, const tims::AddressWidths& widths) {
  if (!is_actuator(target, widths) || context.options.yes || ::isatty(STDIN_FILENO) == 0) return;
  std::cerr << target.to_string(widths) << " moves something. Send? [y/N] " << std::flush;
  std::string answer;
  std::getline(std::cin, answer);
  if (answer != "y" && answer != "Y" && answer != "yes")
    throw Failure(Exit::kDenied, "not_confirmed", "nothing was sent", "-y sends without asking");
}

class Publisher {
 public:
  Publisher(Context& context, tims::Address target, Connection& connection, const FieldStyle& style)
      : context_(context),
        style_(style),
        target_(target),
        target_name_(target.to_string(connection.widths())),
        connection_(connection) {}

  // Data to nobody would be dropped without a word to the sender.
  void check_route(std::int8_t type);
  void send(const Draft& draft);
  // Again and again, as --rate says.
  void send_all(const std::vector<Draft>& drafts);
  Exit wait_for_answer();
  void report(const Message* answer);

 private:
  Context& context_;
  FieldStyle style_;  // of the answer
  tims::Address target_;
  std::string target_name_;
  Connection& connection_;
  std::uint64_t sent_ = 0;
  std::uint64_t bytes_ = 0;
};

void Publisher::check_route(std::int8_t type) {
  AdminClient admin = context_.admin(connection_);
  json::object route;
  try {
    route = admin.ask({{"ask", "route"}, {"to", target_.to_hex()}, {"type", type}});
  } catch (const Failure& failure) {
    if (failure.exit != Exit::kTimeout) throw;
    return context_.out.detail(failure.message);  // an original router: nobody to ask
  }
  if (text_at(route, "verdict") != "no_route") return;
  throw Failure(Exit::kNoSuch, "no_such_mailbox",
                target_name_ + ": nobody has registered this address",
                "`timsctl mbx list` shows all");
}

void Publisher::send(const Draft& draft) {
  const std::uint8_t order = draft.little_endian ? tims::flag::kBodyLittleEndian : 0;
  auto sent = connection_.send({.dest = target_,
                                .type = draft.type,
                                .priority = draft.priority,
                                .seq_nr = draft.seq_nr,
                                .tell_why = draft.type > 0,
                                .body_order = order},
                               draft.body);
  if (!sent) throw failure_of(sent.error(), target_name_);
  ++sent_;
  bytes_ += draft.body.size();
}

void Publisher::send_all(const std::vector<Draft>& drafts) {
  const Options& options = context_.options;
  const bool repeats = options.rate_hz.has_value();
  const std::uint64_t rounds = options.count.value_or(repeats ? UINT64_MAX : 1);
  const tims::Time end =
      options.run_for ? tims::os::deadline_after(*options.run_for) : tims::kNever;
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

Exit Publisher::wait_for_answer() {
  const tims::Time deadline = tims::os::deadline_after(context_.options.timeout);
  while (const auto message = receive(connection_, context_.signals, deadline)) {
    if (message->header.src != target_) continue;
    report(&*message);
    if (message->header.type == tims::type::kNotAvailable) return Exit::kNoSuch;
    if (const auto why = rack::reason_of(message->body);
        message->header.type == tims::type::kError && !why.empty())
      context_.out.note(target_name_ + ": " + std::string(why));
    const bool failed =
        message->header.type == tims::type::kError || message->header.type == tims::type::kTimeout;
    return failed ? Exit::kNo : Exit::kDone;
  }
  throw Failure(Exit::kTimeout, "timeout", target_name_ + " did not answer within the timeout",
                "a longer --timeout, or --no-wait");
}

void Publisher::report(const Message* answer) {
  const tims::AddressWidths widths = connection_.widths();
  if (context_.out.json()) {
    const json::value reply = answer == nullptr
                                  ? json::value()
                                  : json::value(described_json(*answer, wall_now(), style_));
    return context_.out.write(json::object{{"schema", "tims/pub/1"},
                                           {"target", address_json(target_, widths)},
                                           {"sent", sent_},
                                           {"sent_bytes", bytes_},
                                           {"answer", reply}});
  }
  if (answer != nullptr)
    context_.out.write(describe(*answer, wall_now(), style_));
  else
    context_.out.note(fmt::format("{} message{} sent to {}, {}", sent_, sent_ == 1 ? "" : "s",
                                  target_name_, human_bytes(static_cast<double>(bytes_))));
}

}  // namespace

Exit msg_pub(Context& context) {
  const Arguments arguments = read_arguments(context.options);
  const auto connection =
      context.connect({.address = {}, .body_max = context.options.body_max_bytes});
  const FieldStyle style{.widths = connection->widths(),
                         .utc = context.options.utc,
                         .si = context.options.si,
                         .fields = context.options.fields};
  const tims::Address target = need_address(arguments.target, style.widths);
  const std::vector<Draft> drafts =
      load_drafts(arguments, context.options, target.fields(style.widths).class_id, style);
  confirm(context, target, connection->widths());
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

}  // namespace timsctl
