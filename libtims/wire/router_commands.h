// Commands between a TCP client and its router: messages with dest = src = 0 (specification,
// section 3.2). The same numbers mean something else between mailboxes.
#pragma once

#include <cstdint>

namespace tims::wire::router_command {

inline constexpr std::int8_t kLogin = 10;  // accepted and ignored
inline constexpr std::int8_t kMailboxInit = 11;
inline constexpr std::int8_t kMailboxDelete = 12;
inline constexpr std::int8_t kMailboxInitWithReply = 13;
inline constexpr std::int8_t kMailboxDeleteWithReply = 14;
inline constexpr std::int8_t kMailboxPurge = 15;
inline constexpr std::int8_t kLifesign = 17;  // router to client; answered with type::kOk
inline constexpr std::int8_t kEnableWatchdog = 18;
inline constexpr std::int8_t kDisableWatchdog = 19;

}  // namespace tims::wire::router_command
