// Finds the sender of each message that a recording shows as delivered.
#pragma once

#include <deque>
#include <string>
#include <unordered_map>

#include "tests/support/inbox.h"
#include "tims/message.h"

namespace tims::test {

// A delivered message is assigned to the first connection that sent an equal message which has not
// been delivered yet; otherwise to the router itself.
class Origins {
 public:
  void sent(int conn, const MessageView& message) { senders_[key(message)].push_back(conn); }

  // A connection, or kFromRouter.
  int of_delivered(const MessageView& message) {
    const auto found = senders_.find(key(message));
    if (found == senders_.end()) return kFromRouter;
    const int conn = found->second.front();
    found->second.pop_front();
    if (found->second.empty()) senders_.erase(found);
    return conn;
  }

 private:
  // Everything that forwarding does not change.
  static std::string key(const MessageView& message) {
    const Header& h = message.header;
    const std::uint32_t flags = h.flags & ~std::uint32_t{flag::kHeaderLittleEndian};
    std::string text;
    for (const std::uint32_t part :
         {flags, static_cast<std::uint32_t>(h.type), std::uint32_t{h.priority},
          std::uint32_t{h.seq_nr}, h.dest.raw(), h.src.raw()}) {
      text += std::to_string(part) + ' ';
    }
    return text.append(reinterpret_cast<const char*>(message.body.data()), message.body.size());
  }

  std::unordered_map<std::string, std::deque<int>> senders_;
};

}  // namespace tims::test
