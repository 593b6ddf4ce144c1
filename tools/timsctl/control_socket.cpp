#include "tools/timsctl/control_socket.h"

#include <array>

#include <boost/json/parse.hpp>
#include <fmt/format.h>

#include "os/clock.h"
#include "os/socket.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

constexpr std::size_t kQuestionMax = 4096;
constexpr std::size_t kAnswerMax = 64 << 10;
constexpr tims::Duration kQuestionComes = std::chrono::seconds(1);

json::object as_json(const Failure& failure) {
  return {{"error", json::object{{"code", failure.code},
                                 {"message", failure.message},
                                 {"hint", failure.hint},
                                 {"exit", static_cast<int>(failure.exit)}}}};
}

void throw_error_of(const json::object& answer) {
  if (at_path(answer, "error") == nullptr) return;
  throw Failure(static_cast<Exit>(static_cast<int>(number_or_zero(answer, "error.exit"))),
                text_at(answer, "error.code"), text_at(answer, "error.message"),
                text_at(answer, "error.hint"));
}

}  // namespace

bool somebody_listens(const std::string& path) { return tims::os::connect_unix(path).ok(); }

json::object ask_control(const std::string& path, const json::object& question,
                         const Signals& signals, tims::Duration timeout, const Failure& nobody) {
  const auto socket = tims::os::connect_unix(path);
  if (!socket) throw nobody;
  const std::string text = to_text(question);
  value_or_fail(tims::os::send_record(socket->get(), std::as_bytes(std::span(text))), path);
  std::vector<std::byte> answer(kAnswerMax);
  if (signals.wait(socket->get(), tims::os::deadline_after(timeout)) == Signals::Woken::kTimeout)
    throw Failure(Exit::kTimeout, "timeout", path + ": no answer", "a longer --timeout");
  const auto received = value_or_fail(tims::os::receive_record(socket->get(), answer, false), path);
  json::object object = parse_object({reinterpret_cast<const char*>(answer.data()), received.size});
  throw_error_of(object);
  return object;
}

void Asker::answer(const json::object& answer) {
  if (!socket_) return;
  const std::string text = to_text(answer);
  (void)tims::os::send_record(socket_.get(), std::as_bytes(std::span(text)), {}, false);
  socket_.reset();
}

void take_question(const tims::os::File& listener, const Signals& signals,
                   const std::function<void(const json::object& question, Asker& asker)>& handle) {
  auto socket = tims::os::accept_unix(listener);
  if (!socket) return;
  if (signals.wait(socket->get(), tims::os::deadline_after(kQuestionComes)) ==
      Signals::Woken::kTimeout)
    return;
  std::array<std::byte, kQuestionMax> buffer{};
  const auto received = tims::os::receive_record(socket->get(), buffer, false);
  if (!received || received->size == 0) return;  // it only wanted to know whether we are here
  Asker asker(std::move(*socket));
  try {
    handle(parse_object({reinterpret_cast<const char*>(buffer.data()), received->size}), asker);
  } catch (const Failure& failure) {
    asker.answer(as_json(failure));
  }
}

json::object parse_object(std::string_view text) {
  boost::system::error_code error;
  json::value value = json::parse(text, error);
  return !error && value.is_object() ? std::move(value.get_object()) : json::object();
}

}  // namespace timsctl
