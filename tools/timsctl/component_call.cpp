#include "tools/timsctl/component_call.h"

#include <algorithm>

#include "os/clock.h"
#include "rack/proxies/generic.h"
#include "tools/timsctl/values.h"

namespace timsctl {

Message ComponentCall::ask(tims::Address component, std::int8_t type,
                           std::span<const std::byte> body, std::optional<tims::Duration> timeout) {
  const std::uint8_t seq_nr = connection_.next_seq_nr();
  const std::uint64_t losses = connection_.losses();
  value_or_fail(
      connection_.send({.dest = component, .type = type, .seq_nr = seq_nr, .tell_why = true}, body),
      name_of(component));
  const tims::Time deadline = tims::os::deadline_after(timeout.value_or(context_.options.timeout));
  while (auto message = receive(connection_, context_.signals, deadline, losses)) {
    if (message->header.src != component || message->header.seq_nr != seq_nr) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw Failure(Exit::kNoSuch, "no_such_mailbox",
                    name_of(component) + ": nobody has registered this address",
                    "`timsctl component list` shows all");
    return std::move(*message);
  }
  throw Failure(Exit::kTimeout, "timeout", name_of(component) + " did not answer",
                "a longer --timeout? `timsctl explain` shows whether it can be reached");
}

std::optional<Message> ComponentCall::newest_data(tims::Address component) {
  Message answer = ask(component, tims::type::kGetData, rack::GetDataRequest{});
  if (answer.header.type != tims::type::kData) return std::nullopt;
  return answer;
}

std::vector<std::optional<std::int8_t>> ComponentCall::states(
    std::span<const tims::Address> components) {
  std::vector<std::optional<std::int8_t>> states(components.size());
  for (const tims::Address component : components)
    value_or_fail(connection_.send({.dest = component, .type = tims::type::kGetStatus}, {}),
                  name_of(component));
  const tims::Time deadline = tims::os::deadline_after(context_.options.timeout);
  std::size_t missing = components.size();
  while (missing > 0) {
    const auto message = receive(connection_, context_.signals, deadline);
    if (!message) break;
    const auto asked = std::ranges::find(components, message->header.src);
    if (asked == components.end()) continue;
    auto& state = states[static_cast<std::size_t>(asked - components.begin())];
    if (!state) --missing;
    state = message->header.type;
  }
  return states;
}

void need_ok(const Message& answer, const std::string& what, const std::string& hint) {
  if (answer.header.type == tims::type::kOk) return;
  const std::string_view reason = rack::reason_of(answer.body);
  if (reason.empty())
    throw Failure(Exit::kNo, "refused", what, hint + " `timsctl log follow` shows its words");
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

}  // namespace timsctl
