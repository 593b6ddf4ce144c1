#include "tools/timsctl/admin_client.h"

#include <boost/json/parse.hpp>

#include "os/clock.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

// Before the data that may fill the mailbox, which are asked for with 0; behind what robots say.
constexpr std::uint8_t kPriority = 10;

json::object parse_answer(const Message& message, const std::string& where) {
  if (auto answer = json_of(message)) return std::move(*answer);
  throw Failure(Exit::kVersion, "version", where + ": the router's answer is not JSON",
                "install timsctl and tims-router of the same version");
}

Exit exit_of(std::string_view code) {
  if (code.starts_with("no_such")) return Exit::kNoSuch;
  if (code == "denied") return Exit::kDenied;
  if (code == "unknown_question") return Exit::kVersion;
  return Exit::kNo;
}

void throw_error(const json::object& answer) {
  if (at_path(answer, "error") == nullptr) return;
  std::string code = text_at(answer, "error.code");
  const Exit exit = exit_of(code);
  throw Failure(exit, std::move(code), text_at(answer, "error.message"),
                text_at(answer, "error.hint"));
}

}  // namespace

std::optional<json::object> json_of(const Message& message) {
  const std::string_view text(reinterpret_cast<const char*>(message.body.data()),
                              message.body.size());
  boost::system::error_code error;
  json::value value = json::parse(text, error);
  if (error || !value.is_object()) return std::nullopt;
  return std::move(value.get_object());
}

json::object AdminClient::ask(const json::object& question, tims::Duration patience) {
  json::object answer = ask_once(question, patience);
  json::object next = question;
  while (const json::value* after = at_path(answer, "next")) {
    next["after"] = *after;
    json::object page = ask_once(next, patience);
    json::array& items = items_of(answer);
    for (json::value& item : items_of(page)) items.push_back(std::move(item));
    answer.erase("next");
    if (const json::value* more = at_path(page, "next")) answer["next"] = *more;
  }
  return answer;
}

tims::Result<void> AdminClient::send(std::span<const std::byte> body, std::uint8_t seq_nr) {
  const tims::Envelope envelope{.dest = router_.value_or(tims::Address()),
                                .type = tims::type::kAdminRequest,
                                .priority = kPriority,
                                .seq_nr = seq_nr};
  return router_ ? connection_.send(envelope, body) : connection_.send_to_router(envelope, body);
}

std::string AdminClient::where() const {
  return router_ ? router_->to_string(widths()) : connection_.where();
}

json::object AdminClient::ask_once(const json::object& question, tims::Duration patience) {
  const std::string text = to_text(question);
  const auto bytes = std::as_bytes(std::span(text));
  const std::uint8_t seq_nr = connection_.next_seq_nr();
  const tims::Time asked = tims::os::now();
  const std::uint64_t losses = connection_.losses();
  if (auto sent = send(bytes, seq_nr); !sent) throw failure_of(sent.error(), where());
  while (auto message = receive(connection_, signals_, asked + timeout_ + patience, losses)) {
    const bool from_there = !router_ || message->header.src == *router_;
    if (message->header.seq_nr != seq_nr || !from_there) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw Failure(Exit::kNoSuch, "no_such_router", "no router " + where() + " can be reached",
                    "`timsctl router list` shows the routers of the fleet");
    // What a question that was given up is answered late is not meant either.
    if (message->header.type != tims::type::kAdminReply) continue;
    json::object answer = parse_answer(*message, where());
    throw_error(answer);
    const auto age = tims::os::now() - asked;
    answer["age_ms"] = std::chrono::duration_cast<std::chrono::milliseconds>(age).count();
    return answer;
  }
  throw Failure(Exit::kTimeout, "timeout", where() + " did not answer the admin question in time",
                "a longer --timeout; an original RACK router knows no admin questions");
}

}  // namespace timsctl
