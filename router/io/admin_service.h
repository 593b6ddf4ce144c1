// What the router itself answers. The admin protocol's service (ADMIN.md): questions as JSON in,
// answers as JSON out, made of what reports.h tells; and what some of them ask to be done: links
// taken up and down, faults, routes. And hop records (Tracer).
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
#include "router/io/reports.h"

namespace tims::io {

inline constexpr std::size_t kAnswerBytesMax = 256 << 10;

inline constexpr std::size_t kStaticRoutesMax = 256;

// The answer to any bytes, at once: a question that would wait is answered with what there is, and
// one that would change something is refused.
std::string answer_admin(std::string_view question, const AdminSource& source,
                         const Clocks& clocks);

// The static routes after a reload: those of the configuration, as it has changed from `before` to
// `after`, and what people have added and deleted at run time since.
std::vector<core::StaticRoute> reload_routes(const std::vector<core::StaticRoute>& running,
                                             const std::vector<core::StaticRoute>& before,
                                             const std::vector<core::StaticRoute>& after);

// The questions that have come and are not answered yet. The router may not be called while it
// hands over a question (core::RouterHooks::admin), so answers are made at the end of a turn; and
// a question for events may wait for one.
//
// Whoever asks much waits, and nobody else: of each client one question is answered in its turn,
// and none as long as it leaves earlier answers unread.
class AdminService {
 public:
  // Beyond this many, the one that waits longest is answered with what there is.
  static constexpr std::size_t kWaitingMax = 256;
  // Of one client; further ones are answered "busy". A link counts as one client.
  static constexpr std::size_t kPerClientMax = 64;
  // No further answer in a turn that has made so much.
  static constexpr std::size_t kTurnBytesMax = 256 << 10;

  using Send = std::function<void(core::ClientId asker, core::Message& answer)>;

  explicit AdminService(AdminSource& source) : source_(source) {}

  // From core::RouterHooks::admin: copies what it needs. What would change something is refused to
  // clients of TCP and of WebSockets, unless tcp.admin allows it.
  void ask(Time now, core::ClientId from, const core::Message& request);
  // From core::RouterHooks::may_ask: the same for questions to other routers.
  [[nodiscard]] bool may_ask(core::ClientId from, const core::Message& request) const;
  // From core::RouterHooks::event.
  void event_happened() { changed_ = true; }

  // Whether answer() would do anything.
  [[nodiscard]] bool has_work(Time now) const {
    return changed_ || more_ || blocked_ || now >= next_timeout();
  }
  // Whether it could have answered more: it wants another turn when others have had theirs.
  [[nodiscard]] bool wants_turn() const { return more_; }
  // Answers what can be answered: `send` is Router::answer. Call it at the end of each turn and
  // when next_timeout() is reached. The bytes given to `send` stay valid until release().
  void answer(const Clocks& clocks, const Send& send);
  // After the ports were flushed.
  void release() { sent_.clear(); }

  [[nodiscard]] Time next_timeout() const;

 private:
  struct Waiting {
    core::ClientId asker{};
    Header request{};
    std::variant<Question, QuestionError> question{};
    Time deadline{};
    bool due = false;  // waits for nothing but its turn
  };
  struct Refused {
    core::ClientId asker{};
    Header request{};
  };
  [[nodiscard]] bool may_change(core::ClientId from) const;
  [[nodiscard]] bool is_due(const Waiting& waiting, Time now) const;
  [[nodiscard]] bool can_take_more(core::ClientId asker) const;
  void refuse(const Send& send);
  std::size_t send_answer(const Waiting& waiting, const Clocks& clocks, const Send& send);
  static void send_text(core::ClientId asker, const Header& request, std::string_view text,
                        std::span<std::byte> bytes, const Send& send);

  AdminSource& source_;
  std::vector<Waiting> waiting_;        // oldest first
  std::vector<Refused> refused_;        // since the last answer()
  std::vector<core::ClientId> served_;  // while others still wait for their first answer
  std::vector<std::vector<std::byte>> sent_;
  bool changed_ = false;  // a question came, or something one may wait for
  bool more_ = false;     // there was more to answer than fits into a turn
  bool blocked_ = false;  // somebody has to read first
};

// --- hop records

class Tracer {
 public:
  // Of one turn; more are not told. Traces are for people, one message in a thousand.
  static constexpr std::size_t kPerTurnMax = 64;

  using Send = std::function<void(core::Message& record)>;

  // From core::RouterHooks::traced.
  void on_traced(core::ClientId from, core::ClientId to, const core::Message& message);
  [[nodiscard]] bool has_records() const { return !hops_.empty(); }
  // At the end of a turn: `send` is Router::answer. The bytes stay valid until release().
  void send_records(const core::Router& router, std::string_view name, const Clocks& clocks,
                    const Send& send);
  void release() { sent_.clear(); }

 private:
  struct Hop {
    core::ClientId from{};
    core::ClientId to{};
    Header header{};
    std::uint8_t hops = 0;
    Duration waited{};
  };
  std::vector<Hop> hops_;
  std::vector<std::vector<std::byte>> sent_;
};

}  // namespace tims::io
