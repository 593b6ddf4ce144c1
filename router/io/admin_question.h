// A checked admin question. The body is untrusted input: every defect becomes an error answer.
// The questions are listed in ADMIN.md.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "router/core/driving_leases.h"
#include "router/core/newest_values.h"
#include "router/link/fault_injection.h"
#include "tims/address.h"

namespace tims::io {

inline constexpr std::size_t kQuestionBytesMax = 64 << 10;
inline constexpr std::size_t kPageItemsMax = 1000;

enum class Ask : std::uint8_t {
  kStatus,
  kClients,
  kRoutes,
  kRoute,
  kMailboxes,
  kStats,
  kEvents,
  kConfig,
  kPing,
  kRouters,
  kLinks,
  kFleet,
  kNewest,
  kStreams,
  kLeases,
  kLease,
  kRules,
  kVerdict,
  kLogin,
  kLinkDo,
  kFault,
  kRouteAdd,
  kRouteDelete,
};

// What a question does.
enum class Effect : std::uint8_t {
  kNone,    // it is only answered
  kDrives,  // accepted from whoever may send messages, but not over HTTP, where nobody stays
            // connected
  // Makes a secret: answered to programs of this host, and to connections whose owner has proven
  // who he is; never over HTTP or links.
  kLogin,
  kChanges,  // the router: by default not accepted from web pages
};
constexpr Effect effect(Ask ask) {
  if (ask >= Ask::kLinkDo) return Effect::kChanges;
  if (ask == Ask::kLogin) return Effect::kLogin;
  return ask == Ask::kLease ? Effect::kDrives : Effect::kNone;
}

// Whether a question to the configuration agent beside a router (tools/configuration/PROTOCOL.md)
// only reads. All others change something, also those that cannot be understood.
bool is_agent_reading(std::string_view body);
// Whether it is what the agents of one change tell each other. It begins no change: an agent takes
// it only from those of a change that was made there, and confirms or takes back that change alone.
bool is_agent_agreeing(std::string_view body);

struct Question {
  Ask ask = Ask::kStatus;
  AddressPattern match{};
  std::optional<Address> to{};
  std::optional<Address> from{};
  std::int8_t type = 0;
  std::size_t limit = kPageItemsMax;
  std::string after{};
  std::optional<std::uint64_t> since{};
  std::string epoch{};  // the epoch in which `since` was issued; empty: this router's
  std::chrono::milliseconds wait{};
  std::string pad{};
  std::string link{};           // name of the router at the link's other end
  std::string action{};         // up, down, reset
  std::string pattern{};        // the text of `match`
  std::optional<Address> of{};  // the source of a newest value
  core::StreamKind stream = core::StreamKind::kData;
  std::optional<std::uint32_t> robot{};
  core::LeaseVerb lease = core::LeaseVerb::kTake;
  std::string holder{};
  std::optional<Address> stick{};
  std::optional<Address> mailbox{};  // of the holder of a lease, from the router above
  std::string right{};  // of a login: look, drive, configure; empty: the highest that is possible
  std::string who{};    // of a verdict: identities, "user:guest"
  std::string what{};   // of a verdict, or a route: a type of messages, or a right
  std::uint8_t priority = 0;
  bool audit = false;   // of events: the log of those that are audited
  bool bearer = false;  // a session for a program, not a token for a browser
  link::Faults faults{};
  AddressWidths widths{};  // of the addresses in the question
};

// As it is written in a question: "route_add".
std::string_view name(Ask ask);

struct QuestionError {
  std::string code;
  std::string message;
  std::string hint{};
};

std::variant<Question, QuestionError> parse_question(std::string_view body,
                                                     const AddressWidths& widths);

}  // namespace tims::io
