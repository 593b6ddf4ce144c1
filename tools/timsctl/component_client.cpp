#include "tools/timsctl/component_client.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/wakeup.h"
#include "tools/cli/admin_client.h"

namespace timsctl {

Message ComponentClient::ask(tims::Address component, std::int8_t type,
                             std::span<const std::byte> body,
                             std::optional<tims::Duration> timeout) {
  try {
    return timsctl::ask(*connection_, context_.signals, component, type, body,
                        timeout.value_or(context_.options.timeout));
  } catch (const Failure& failure) {
    throw with_broken_link(context_, *connection_, component, failure);
  }
}

std::optional<BrokenLink> ComponentClient::why_absent(tims::Address component) {
  return broken_link_to(context_, *connection_, component);
}

std::optional<Message> ComponentClient::newest_data(tims::Address component) {
  Message answer = ask(component, tims::type::kGetData, rack::GetDataRequest{});
  if (answer.header.type != tims::type::kData) return std::nullopt;
  return answer;
}

std::optional<Message> ComponentClient::kept_data(tims::Address component,
                                                  std::optional<double>& age_s) {
  json::object answer;
  try {
    AdminClient admin = context_.admin(*connection_);
    answer = admin.ask({{"ask", "newest"}, {"of", component.to_hex()}});
  } catch (const Failure& failure) {
    if (failure.code == "none_kept") return std::nullopt;
    throw;
  }
  const auto body = base::parse_hex(text_at(answer, "body"));
  const json::value* age = answer.if_contains("age_s");
  const json::value* little = answer.if_contains("little_endian");
  if (!body || age == nullptr || !age->is_number() || little == nullptr || !little->is_bool())
    throw Failure(Exit::kVersion, "bad_answer", "the router's answer is not a newest value");
  age_s = age->to_number<double>();
  Message message;
  message.header = {.flags = little->get_bool() ? tims::flag::kBodyLittleEndian : std::uint8_t{0},
                    .type = tims::type::kData,
                    .src = component,
                    .length = static_cast<std::uint32_t>(tims::kHeaderSize + body->size())};
  message.body = *body;
  return message;
}

std::string ComponentClient::description(tims::Address component) {
  std::string text;
  for (bool more = true; more;) {
    const Message answer = ask(component, tims::type::kGetDescription,
                               rack::DescriptionRequest{.offset = static_cast<int>(text.size())});
    if (answer.header.type != tims::type::kDescription)
      throw Failure(Exit::kNo, "no_description", name_of(component) + " does not describe itself",
                    "it is a component of the original RACK, or older than this timsctl");
    const auto page =
        value_or_fail(rack::decode<rack::DescriptionPage>(answer.view()), name_of(component));
    more = value_or_fail(rack::append_page(text, page), name_of(component));
  }
  return text;
}

std::vector<std::optional<std::int8_t>> ComponentClient::states(
    std::span<const tims::Address> components, std::optional<tims::Duration> timeout) {
  std::vector<std::optional<std::int8_t>> states(components.size());
  for (const tims::Address component : components) {
    const auto sent = connection_->send({.dest = component, .type = tims::type::kGetStatus}, {});
    if (!sent)
      throw with_broken_link(context_, *connection_, component,
                             failure_of(sent.error(), name_of(component)));
  }
  const tims::Time deadline = tims::os::deadline_after(timeout.value_or(context_.options.timeout));
  std::size_t missing = components.size();
  while (missing > 0) {
    const auto message = receive(*connection_, context_.signals, deadline);
    if (!message) break;
    const auto asked = std::ranges::find(components, message->header.src);
    if (asked == components.end()) continue;
    auto& state = states[static_cast<std::size_t>(asked - components.begin())];
    if (!state) --missing;
    state = message->header.type;
  }
  return states;
}

bool is_component(tims::Address address, const tims::AddressWidths& widths) {
  const auto fields = address.fields(widths);
  return fields.local == 0 && fields.class_id >= tims::class_id::kTest;
}

void need_ok(const Message& answer, const std::string& what, const std::string& hint) {
  if (answer.header.type == tims::type::kOk) return;
  const std::string_view reason = rack::reason_of(answer.body);
  if (reason.empty())
    throw Failure(Exit::kNo, "refused", what, hint + " `timsctl log follow` shows its messages");
  throw Failure(Exit::kNo, "refused", what + ": " + std::string(reason), hint);
}

bool waited(const Context& context, const std::function<bool()>& attempt) {
  constexpr tims::Duration kPause = std::chrono::milliseconds(50);
  const tims::Time deadline =
      tims::os::deadline_after(context.options.wait.value_or(tims::Duration{}));
  for (;;) {
    try {
      if (attempt()) return true;
      if (tims::os::now() >= deadline) return false;
    } catch (const Failure&) {
      if (tims::os::now() >= deadline) throw;
    }
    context.signals.sleep_until(tims::os::now() + kPause);
  }
}

std::string state_text(std::int8_t state) {
  switch (state) {
    case tims::type::kEnabled:
      return "on";
    case tims::type::kDisabled:
      return "off";
    case tims::type::kError:
      return "error";
    case tims::type::kNotAvailable:
      return "gone";
    default:
      if (const std::string name = type_name(state); !name.empty()) return "answer " + name;
      return "answer " + std::to_string(state);
  }
}

json::object parameter_json(const rack::Parameter& parameter,
                            const std::optional<rack::ParameterEffects>& effects) {
  json::object item{{"name", parameter.name.view()}};
  switch (parameter.type) {
    case rack::Parameter::kInt:
      item["type"] = "int";
      item["value"] = parameter.valueInt;
      break;
    case rack::Parameter::kFloat:
      item["type"] = "float";
      item["value"] = parameter.valueFloat;
      break;
    default:
      item["type"] = "string";
      item["value"] = parameter.valueString.view();
  }
  if (const auto effect = effect_of(effects, parameter.name.view()))
    item["takes_effect"] = rack::name(*effect);
  return item;
}

rack::ParameterList ComponentClient::parameters(tims::Address component) {
  Message answer;
  waited(context_, [&] { return answer = ask(component, tims::type::kGetParam), true; });
  return value_or_fail(rack::decode<rack::ParameterList>(answer.view()), name_of(component));
}

std::optional<rack::TakesEffect> effect_of(const std::optional<rack::ParameterEffects>& effects,
                                           std::string_view name) {
  if (!effects) return std::nullopt;
  const auto found = std::ranges::find_if(
      effects->effects, [&](const rack::ParameterEffect& e) { return e.name.view() == name; });
  if (found == effects->effects.end()) return std::nullopt;
  return static_cast<rack::TakesEffect>(found->takesEffect);
}

// --- data subscriptions

using namespace std::chrono_literals;

namespace {

// A component that is off or missing may start at any time; a silent component may have been
// restarted and lost the subscription.
constexpr tims::Duration kAskOffAgain = 1s;
constexpr tims::Duration kAskSilentAgain = 10s;
constexpr tims::Duration kSilencePatience = 2s;
constexpr tims::Duration kComponentClientStopPatience = 300ms;
constexpr std::uint8_t kStopPriority = 255;  // highest: data must not displace its answer

template <rack::Struct Body>
tims::Result<void> send(Connection& connection, const tims::Envelope& envelope, const Body& body) {
  std::array<std::byte, rack::wire_size<Body>()> bytes{};
  if (const auto size = rack::encode(body, bytes); !size) return size.error();
  return connection.send(envelope, bytes);
}

}  // namespace

std::string_view Subscription::state_name() const {
  constexpr std::array<std::string_view, 5> kNames = {"asking", "on", "off", "no_mailbox",
                                                      "no_data"};
  return kNames[static_cast<std::size_t>(state_)];
}

tims::Result<void> Subscription::on_time(Connection& connection, tims::Time now) {
  if (now < next_question_) return {};
  next_question_ = now + kAskOffAgain;
  asked_ = true;
  return send(connection,
              {.dest = component_, .type = tims::type::kGetContData, .report_reason = true},
              rack::GetContDataRequest{period_ms_, connection.address()});
}

void Subscription::set_state(State state, tims::Time ask_again_at) {
  state_ = state;
  next_question_ = ask_again_at;
}

bool Subscription::on_message(const Message& message, tims::Time now) {
  switch (message.header.type) {
    case tims::type::kContData:
      if (const auto reply = rack::decode<rack::ContDataReply>(message.view()))
        granted_ms_ = reply->periodTime;
      set_state(State::kRunning, now + kAskSilentAgain);
      return false;
    case tims::type::kError:
      set_state(rack::reason_of(message.body) == rack::kNoDataYet ? State::kNoData : State::kOff,
                now + kAskOffAgain);
      return false;
    case tims::type::kNotAvailable:
      set_state(State::kNoMailbox, now + kAskOffAgain);
      return false;
    case tims::type::kOk:
      return false;
    default:
      set_state(State::kRunning,
                now + std::max<tims::Duration>(
                          kAskSilentAgain, 3 * std::chrono::milliseconds(granted_ms_.value_or(0))));
      return true;
  }
}

void Subscription::stop(Connection& connection) const {
  (void)send(connection,
             {.dest = component_, .type = tims::type::kStopContData, .priority = kStopPriority},
             rack::StopContDataRequest{connection.address()});
}

namespace {

// Why nothing comes.
std::string silence_of(const Subscription& subscription, const std::string& name,
                       tims::Duration silent) {
  const std::string duration = base::human_duration(base::seconds(silent));
  switch (subscription.state()) {
    case Subscription::State::kRunning:
      return fmt::format(
          "nothing comes from {} for {}: it has accepted the subscription, but sends no data", name,
          duration);
    case Subscription::State::kOff:
      return fmt::format("nothing comes from {}: it is off; `timsctl component on {}`", name, name);
    case Subscription::State::kNoData:
      return fmt::format("nothing comes from {}: it is being turned on and has no data yet", name);
    case Subscription::State::kNoMailbox:
      return fmt::format("nothing comes from {}: it is not registered", name);
    case Subscription::State::kAsking:
      break;
  }
  return fmt::format("nothing comes from {}: it has not answered for {}; `timsctl ping {}`", name,
                     duration, name);
}

}  // namespace

std::vector<std::string> SilenceNotes::take(std::span<const Subscription> subscriptions,
                                            tims::Time now, const tims::AddressWidths& widths,
                                            bool at_end) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    const Subscription& one = subscriptions[i];
    const auto period = std::chrono::milliseconds(one.granted_ms().value_or(0));
    const tims::Duration silent = now - last_[i].data;
    const tims::Duration patience = std::max<tims::Duration>(kSilencePatience, 3 * period);
    if (last_[i].noted || (silent < patience && (!at_end || last_[i].any))) continue;
    last_[i].noted = true;
    notes.push_back(silence_of(one, shell_name(one.component(), widths), silent));
  }
  return notes;
}

Subscriptions::Subscriptions(Connection& connection, const std::vector<tims::Address>& components,
                             std::uint32_t period_ms)
    : connection_(connection) {
  for (const tims::Address component : components) list_.emplace_back(component, period_ms);
}

Subscriptions::~Subscriptions() {
  try {
    finish();
  } catch (const std::exception&) {
    // The connection is lost: unsubscribing is impossible.
  }
}

std::optional<Subscriptions::Data> Subscriptions::next(const Signals& signals,
                                                       tims::Time deadline) {
  for (;;) {
    const tims::Time now = tims::os::now();
    if (now >= deadline) return std::nullopt;
    tims::Time until = deadline;
    for (Subscription& subscription : list_) {
      if (auto sent = subscription.on_time(connection_, now); !sent)
        throw failure_of(sent.error(), subscription.component().to_string(connection_.widths()));
      until = std::min(until, subscription.next_time());
    }
    auto message = receive(connection_, signals, until);
    if (!message) continue;
    const auto from = std::ranges::find(list_, message->header.src, &Subscription::component);
    if (from == list_.end()) continue;
    const tims::Time at = tims::os::now();
    if (from->on_message(*message, at))
      return Data{static_cast<std::size_t>(from - list_.begin()), std::move(*message), at};
  }
}

// Signals are ignored here: Ctrl-C may have caused this call.
void Subscriptions::finish() {
  std::size_t open = 0;
  for (const Subscription& subscription : list_) {
    if (!subscription.needs_stop()) continue;
    subscription.stop(connection_);
    ++open;
  }
  const tims::Time deadline = tims::os::deadline_after(kComponentClientStopPatience);
  while (open > 0 && tims::os::now() < deadline) {
    auto message = connection_.take();
    if (message) {
      const std::int8_t type = message->header.type;
      if (type == tims::type::kOk || type == tims::type::kNotAvailable) --open;
      continue;
    }
    if (message.error().code() != tims::Errc::kEmpty) return;
    (void)tims::os::is_readable(connection_.descriptor(), 20ms);
  }
}

}  // namespace timsctl
