#include "router/io/admin_service.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "router/io/admin_actions.h"
#include "router/io/admin_answers.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using base::valid_utf8;

namespace json = boost::json;

std::string_view text_of(const core::Message& request) {
  const auto body = request.body();
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as the text they are
  return {reinterpret_cast<const char*>(body.data()), body.size()};
}

QuestionError denied() {
  return {"denied", "TCP and WebSocket clients have read-only access",
          "ask over the Unix socket of the router's host, or set tcp.admin = true at the router "
          "you ask"};
}

}  // namespace

bool AdminService::has_room(core::ClientId from, const Header& request) {
  changed_ = true;
  const auto is_his = [&](const Waiting& waiting) { return waiting.asker == from; };
  if (std::ranges::count_if(waiting_, is_his) < static_cast<std::ptrdiff_t>(kPerClientMax))
    return true;
  refused_.push_back({from, request});
  return false;
}

void AdminService::deny(core::ClientId from, const core::Message& request, std::string_view rule) {
  if (!has_room(from, request.header)) return;
  waiting_.push_back(
      {.asker = from,
       .request = request.header,
       .question = QuestionError{"denied", fmt::format("the policy does not permit it: {}", rule),
                                 "`timsctl acl show` on the router's host lists its rules"}});
}

void AdminService::ask(Time now, core::ClientId from, const core::Message& request) {
  if (!has_room(from, request.header)) return;
  Waiting waiting{.asker = from,
                  .request = request.header,
                  .question = read_question(text_of(request), source_, now)};
  if (const auto* question = std::get_if<Question>(&waiting.question)) {
    waiting.deadline = now + question->wait;
    if (effect(question->ask) == Effect::kChanges && !may_change(from)) waiting.question = denied();
  }
  // A question to the agent beside a router comes here only when it is refused.
  if (is_for_agent(request)) waiting.question = denied();
  waiting_.push_back(std::move(waiting));
}

bool AdminService::is_for_agent(const core::Message& request) const {
  return request.header.dest.fields(source_.router().settings().widths).local != 0;
}

bool AdminService::may_change(core::ClientId from) const {
  const core::Client* client = source_.router().client(from);
  if (const Person* person =
          client == nullptr ? nullptr : source_.person(client->info.port, client->info.token))
    return has(person->rights, Right::kConfigure);
  const bool guest = client != nullptr && (client->info.port == core::PortKind::kTcp ||
                                           client->info.port == core::PortKind::kWebSocket);
  return !guest || source_.config().tcp.admin;
}

bool AdminService::may_ask(core::ClientId from, const core::Message& request) const {
  if (may_change(from)) return true;
  if (is_for_agent(request)) return is_agent_reading(text_of(request));
  const auto read = parse_question(text_of(request), source_.router().settings().widths);
  const auto* question = std::get_if<Question>(&read);
  // What this router cannot read, the other one may understand.
  return question != nullptr && effect(question->ask) != Effect::kChanges;
}

bool AdminService::is_due(const Waiting& waiting, Time now) const {
  const auto* question = std::get_if<Question>(&waiting.question);
  if (question == nullptr || question->ask != Ask::kEvents || !question->since) return true;
  const std::uint64_t last = log_of(*question, source_.router()).last();
  // Greater than the last number: it is from before a restart, and there is much to report.
  return last != *question->since || now >= waiting.deadline;
}

// Answers one question of each client in turn until the limit of the turn is reached; clients
// that were not served are first in the next turn.
void AdminService::answer(const Clocks& clocks, const Send& send) {
  changed_ = more_ = blocked_ = false;
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    return source_.router().client(waiting.asker) == nullptr;
  });
  refuse(send);
  const std::size_t too_many = waiting_.size() - std::min(waiting_.size(), kWaitingMax);
  std::size_t bytes = 0;
  bool somebody_waits = false;
  std::vector<Waiting> still;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    Waiting& waiting = waiting_[i];
    waiting.due = waiting.due || i < too_many || is_due(waiting, clocks.now);
    const bool due = waiting.due;
    const bool served = std::ranges::find(served_, waiting.asker) != served_.end();
    const bool reads = !due || can_take_more(waiting.asker);
    if (due && reads && !served && bytes < kTurnBytesMax) {
      bytes += send_answer(waiting, clocks, send);
      served_.push_back(waiting.asker);
      continue;
    }
    more_ = more_ || (due && reads);
    somebody_waits = somebody_waits || (due && reads && !served);
    blocked_ = blocked_ || (due && !reads);
    still.push_back(std::move(waiting));
  }
  waiting_ = std::move(still);
  if (!somebody_waits) served_.clear();
}

// Questions of a slow reader wait: no answer is generated before it has read the previous ones.
bool AdminService::can_take_more(core::ClientId asker) const {
  const core::Client& client = *source_.router().client(asker);
  return source_.queued_bytes(client.info.port, client.info.token) < kAnswerBytesMax;
}

void AdminService::refuse(const Send& send) {
  if (refused_.empty()) return;
  const std::string text = error_text(
      {"busy", fmt::format("{} questions of this client are not answered yet", kPerClientMax),
       "wait for their answers before sending more"});
  auto& bytes = sent_.emplace_back(refused_.size() * (kHeaderSize + text.size()));
  std::span<std::byte> rest(bytes);
  for (const Refused& refused : refused_) {
    send_text(refused.asker, refused.request, text, rest.first(kHeaderSize + text.size()), send);
    rest = rest.subspan(kHeaderSize + text.size());
  }
  refused_.clear();
}

// The other routers of the robot refuse others, too. They forget a lease that is not renewed.
void AdminService::tell_below(const Question& question, const Header& request, const Send& send) {
  const core::Router& router = source_.router();
  const core::DrivingLease* lease = router.leases().find(*question.robot);
  const core::DrivingLease ended{.robot = *question.robot, .mailbox = request.src};
  const core::DrivingLease& told = lease == nullptr ? ended : *lease;
  json::object body{{"ask", "lease"},
                    {"robot", told.robot},
                    {"do", lease == nullptr ? "release" : "take_over"},
                    {"mailbox", told.mailbox.to_hex()}};
  if (lease != nullptr) body["name"] = valid_utf8(told.holder.view());
  if (told.stick.raw() != 0) body["stick"] = told.stick.to_hex();
  const std::string text = json::serialize(body);
  std::vector<Address> below;
  router.clients().for_each([&](const core::Client& client) {
    const auto& with = client.info.link;
    if (client.info.port == core::PortKind::kLink && with.kind == core::LinkKind::kSub &&
        with.role == core::Role::kSubsystem && with.system == told.robot)
      below.push_back(with.router);
  });
  for (const Address to : below) {
    auto& bytes = sent_.emplace_back(kHeaderSize + text.size());
    std::memcpy(bytes.data() + kHeaderSize, text.data(), text.size());
    core::Message message{.header = {.type = type::kAdminRequest,
                                     .priority = request.priority,
                                     .dest = to,
                                     .src = router.settings().address,
                                     .length = static_cast<std::uint32_t>(bytes.size())},
                          .bytes = bytes};
    wire::encode_header(message.header, message.bytes.first<kHeaderSize>());
    send({}, message);
  }
}

std::size_t AdminService::send_answer(const Waiting& waiting, const Clocks& clocks,
                                      const Send& send) {
  const std::string text = carry_out(waiting, clocks, send);
  const std::size_t size = kHeaderSize + text.size();
  send_text(waiting.asker, waiting.request, text, sent_.emplace_back(size), send);
  return size;
}

// Returns the answer.
std::string AdminService::carry_out(const Waiting& waiting, const Clocks& clocks,
                                    const Send& send) {
  const auto* question = std::get_if<Question>(&waiting.question);
  if (question == nullptr) return error_text(std::get<QuestionError>(waiting.question));
  switch (effect(question->ask)) {
    case Effect::kNone:
      break;
    case Effect::kDrives:
      if (const auto refused =
              change_lease(*question, waiting.asker, waiting.request, source_, clocks.now))
        return error_text(*refused);
      tell_below(*question, waiting.request, send);
      return lease_text(*question, source_, clocks);
    case Effect::kLogin:
      return make_login(*question, waiting.asker, source_, clocks);
    case Effect::kChanges:
      return act(*question, waiting.asker, source_, clocks);
  }
  return answer_text(*question, source_, clocks);
}

void AdminService::send_text(core::ClientId asker, const Header& request, std::string_view text,
                             std::span<std::byte> bytes, const Send& send) {
  std::memcpy(bytes.data() + kHeaderSize, text.data(), text.size());
  core::Message message{
      .header = wire::reply_to(request, type::kAdminReply, static_cast<std::uint32_t>(text.size())),
      .bytes = bytes};
  wire::encode_header(message.header, message.bytes.first<kHeaderSize>());
  send(asker, message);
}

Time AdminService::next_timeout() const {
  Time next = kNever;
  for (const Waiting& waiting : waiting_)
    if (!waiting.due) next = std::min(next, waiting.deadline);
  return next;
}

}  // namespace tims::io
