// The routers of the fleet as they announce themselves, and which of them a link means.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "router/link/datagram.h"
#include "router/link/link.h"

namespace tims::link {

class Fleet {
 public:
  explicit Fleet(const Identity& self) : self_(self) {}

  // False: this was known, or it is our own.
  bool add(const Announcement& announcement);
  void remove(const NetAddress& dds);

  // Who may be at the other end of a link, the likeliest first: the router it is linked with, and
  // nobody else while that is up; who has the address that the link is to connect to. For a super
  // link that says "auto", or has no use for an address and is `alone`, who has the role above
  // ours; of a subsystem's super routers those of our system.
  [[nodiscard]] std::vector<const Announcement*> candidates(const Link& link, bool alone) const;
  // What a super link looks for, in words: "a system router of system 3".
  [[nodiscard]] std::string looked_for() const;
  // Is this another router with our system and id?
  [[nodiscard]] bool is_double(const Identity& who) const;

  [[nodiscard]] const std::map<NetAddress, Announcement>& routers() const { return routers_; }

 private:
  const Identity self_;
  std::map<NetAddress, Announcement> routers_;  // by where they announce themselves from
};

}  // namespace tims::link
