// The admin protocol's service (ADMIN.md): takes questions as JSON, and returns answers as JSON
// (admin_answers.h) or executes their requests (admin_actions.h).
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/router.h"
#include "router/core/types.h"
#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

// The questions that have arrived and are not answered yet. The router must not be called while
// it delivers a question (core::RouterHooks::admin), so answers are generated at the end of a
// turn; a question for events may wait for one.
//
// A client that asks much delays only itself: one question per client is answered in each turn,
// and none while the client leaves earlier answers unread.
class AdminService {
 public:
  // Beyond this number, the oldest waiting question is answered with the current data.
  static constexpr std::size_t kWaitingMax = 256;
  // Limit per client; further questions are answered "busy". A link counts as one client.
  static constexpr std::size_t kPerClientMax = 64;
  // No further answer in a turn after this many bytes.
  static constexpr std::size_t kTurnBytesMax = 256 << 10;

  using Send = std::function<void(core::ClientId asker, core::Message& answer)>;

  explicit AdminService(AdminSource& source) : source_(source) {}

  // Called from core::RouterHooks::admin: copies what it needs. Requests that change something
  // are refused to TCP and WebSocket clients, unless tcp.admin allows them.
  void ask(Time now, core::ClientId from, const core::Message& request);
  // Called from core::RouterHooks::deny_admin: `rule` of the policy denies the question.
  void deny(core::ClientId from, const core::Message& request, std::string_view rule);
  // Called from core::RouterHooks::may_ask: the same for questions to other routers.
  [[nodiscard]] bool may_ask(core::ClientId from, const core::Message& request) const;
  // Called from core::RouterHooks::event.
  void event_happened() { changed_ = true; }

  // True when answer() would do anything.
  [[nodiscard]] bool has_work(Time now) const {
    return changed_ || more_ || blocked_ || now >= next_timeout();
  }
  // True when it could have answered more: it needs another turn after the other components.
  [[nodiscard]] bool needs_turn() const { return more_; }
  // Answers as many questions as possible: `send` is Router::answer. Call it at the end of each
  // turn and when next_timeout() is reached. The bytes passed to `send` stay valid until
  // release().
  void answer(const Clocks& clocks, const Send& send);
  // Call after the ports were flushed.
  void release() { sent_.clear(); }

  [[nodiscard]] Time next_timeout() const;

 private:
  struct Waiting {
    core::ClientId asker{};
    Header request{};
    std::variant<Question, QuestionError> question{};
    Time deadline{};
    bool due = false;  // waits only for its turn
  };
  struct Refused {
    core::ClientId asker{};
    Header request{};
  };
  bool has_room(core::ClientId from, const Header& request);
  [[nodiscard]] bool may_change(core::ClientId from) const;
  [[nodiscard]] bool is_for_agent(const core::Message& request) const;
  [[nodiscard]] bool is_due(const Waiting& waiting, Time now) const;
  [[nodiscard]] bool can_take_more(core::ClientId asker) const;
  void refuse(const Send& send);
  void tell_below(const Question& question, const Header& request, const Send& send);
  std::size_t send_answer(const Waiting& waiting, const Clocks& clocks, const Send& send);
  std::string carry_out(const Waiting& waiting, const Clocks& clocks, const Send& send);
  static void send_text(core::ClientId asker, const Header& request, std::string_view text,
                        std::span<std::byte> bytes, const Send& send);

  AdminSource& source_;
  std::vector<Waiting> waiting_;        // oldest first
  std::vector<Refused> refused_;        // since the last answer()
  std::vector<core::ClientId> served_;  // while other clients still wait for their first answer
  std::vector<std::vector<std::byte>> sent_;
  bool changed_ = false;  // a question arrived, or an event one may wait for
  bool more_ = false;     // there was more to answer than fits into a turn
  bool blocked_ = false;  // a client must read first
};

}  // namespace tims::io
