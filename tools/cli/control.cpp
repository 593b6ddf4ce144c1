#include "tools/cli/control.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <boost/json/parse.hpp>
#include <fmt/format.h>

#include "os/clock.h"
#include "os/socket.h"
#include "os/wakeup.h"

namespace timsctl {

namespace {

constexpr std::size_t kQuestionMax = 4096;
constexpr std::size_t kServiceAnswerMax = 64 << 10;
constexpr tims::Duration kQuestionComes = std::chrono::seconds(1);

json::object as_json(const Failure& failure) {
  return {{"error", json::object{{"code", failure.code},
                                 {"message", failure.message},
                                 {"hint", failure.hint},
                                 {"exit", static_cast<int>(failure.exit)}}}};
}

void send_answer(const tims::os::File& socket, const json::object& answer) {
  const std::string text = to_text(answer);
  (void)tims::os::send_record(socket.get(), std::as_bytes(std::span(text)), {}, false);
}

void throw_error_of(const json::object& answer) {
  if (at_path(answer, "error") == nullptr) return;
  throw Failure(static_cast<Exit>(static_cast<int>(number_or_zero(answer, "error.exit"))),
                text_at(answer, "error.code"), text_at(answer, "error.message"),
                text_at(answer, "error.hint"));
}

}  // namespace

std::string Services::folder_of(std::string_view key) const {
  return fmt::format("{}/{}", folder_, key);
}

std::string Services::control_socket(std::string_view key) const {
  return folder_of(key) + "/control.sock";
}

bool Services::is_running(std::string_view key) const {
  return tims::os::connect_unix(control_socket(key)).ok();
}

std::vector<std::string> Services::running() const {
  std::vector<std::string> keys;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, ignored))
    if (std::string key = entry.path().filename(); is_running(key)) keys.push_back(std::move(key));
  std::ranges::sort(keys);
  return keys;
}

std::string Services::only_one(const std::vector<std::string>& keys) const {
  if (keys.size() == 1) return keys.front();
  if (keys.empty())
    throw Failure(Exit::kNoSuch, fmt::format("no_such_{}", what_),
                  fmt::format("no {} runs on this host", what_), std::string(hints_.none));
  throw usage_error(fmt::format("several {}s run: {}", what_, fmt::join(keys, ", ")),
                    std::string(hints_.several));
}

Failure Services::not_running(std::string_view key, std::string_view hint) const {
  return {Exit::kNoSuch, fmt::format("no_such_{}", what_),
          fmt::format("{} {} is not running", what_, name_of(key)),
          std::string(hint.empty() ? hints_.not_running : hint)};
}

json::object Services::ask(std::string_view key, const json::object& question,
                           const Signals& signals, tims::Duration timeout) const {
  const std::string path = control_socket(key);
  const auto socket = tims::os::connect_unix(path);
  if (!socket) throw not_running(key);
  const std::string text = to_text(question);
  value_or_fail(tims::os::send_record(socket->get(), std::as_bytes(std::span(text))), path);
  std::vector<std::byte> answer(kServiceAnswerMax);
  if (signals.wait(socket->get(), tims::os::deadline_after(timeout)) ==
      Signals::WaitResult::kTimeout)
    throw Failure(Exit::kTimeout, "timeout", path + ": no answer", "use a longer --timeout");
  const auto received = value_or_fail(tims::os::receive_record(socket->get(), answer, false), path);
  json::object object = parse_object({reinterpret_cast<const char*>(answer.data()), received.size});
  throw_error_of(object);
  return object;
}

void ControlServer::wait(std::vector<int> others, tims::Time deadline) const {
  others.push_back(listener_.get());
  constexpr tims::Duration kWithoutDescriptors = std::chrono::milliseconds(100);
  const auto any = tims::os::any_of(others);
  if (!any) deadline = std::min(deadline, tims::os::deadline_after(kWithoutDescriptors));
  (void)signals_.wait(any ? any->get() : -1, deadline);
}

void ControlServer::take_question(
    const std::function<json::object(const json::object& question)>& answer) {
  auto socket = tims::os::accept_unix(listener_);
  if (!socket) return;
  if (signals_.wait(socket->get(), tims::os::deadline_after(kQuestionComes)) ==
      Signals::WaitResult::kTimeout)
    return;
  std::array<std::byte, kQuestionMax> buffer{};
  const auto received = tims::os::receive_record(socket->get(), buffer, false);
  if (!received || received->size == 0) return;  // only a test whether this process listens
  try {
    const json::object question =
        parse_object({reinterpret_cast<const char*>(buffer.data()), received->size});
    if (text_at(question, "do") == "down")
      ending_ = std::move(*socket);
    else
      send_answer(*socket, answer(question));
  } catch (const Failure& failure) {
    send_answer(*socket, as_json(failure));
  }
}

void ControlServer::end(const json::object& answer) {
  listener_.reset();
  if (ending_) send_answer(ending_, answer);
}

json::object parse_object(std::string_view text) {
  boost::system::error_code error;
  json::value value = json::parse(text, error);
  return !error && value.is_object() ? std::move(value.get_object()) : json::object();
}

}  // namespace timsctl
