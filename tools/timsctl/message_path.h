// The path of a message from router to router, as reported by the routers, and the link on it that
// is broken.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/cli/admin_client.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"

namespace timsctl {

struct Step {
  std::optional<tims::Address> router;  // empty: the router of the connection
  std::string name;
  json::object answer;  // to the request "route"
};

struct Path {
  std::vector<Step> steps;
  bool reached = false;                // the last router has the mailbox
  std::optional<std::string> failure;  // a router did not answer, or there is a loop
};

// Of which messages; `right`: of a question to a router, what it needs ("change"), else empty.
struct MessageKind {
  std::int8_t type = 0;
  std::string right{};

  // The type that is given with --type, or a right; without, GET_STATUS.
  static MessageKind of(const Options& options, tims::Address to,
                        const tims::AddressWidths& widths);
};

// Starts at the router of `first`.
Path find_path(const AdminClient& first, std::optional<tims::Address> from, tims::Address to,
               const MessageKind& kind);

// Asks all routers of the fleet which one has the mailbox. Empty: none has it.
std::optional<Step> find_owner(const AdminClient& first, tims::Address mailbox);

struct BrokenLink {
  std::string cause;   // one sentence
  std::string remedy;  // a command, or what to do
};

// Of the routers on the path: a link to the system of `to`, or the link upwards at its end, that is
// not up.
std::optional<BrokenLink> broken_link(const AdminClient& first, const Path& path, tims::Address to);

// The same for a component that does not answer. Empty also when the routers do not know.
std::optional<BrokenLink> broken_link_to(Context& context, Connection& connection,
                                         tims::Address to);

// The failure with the broken link that explains it, if there is one.
Failure with_broken_link(Context& context, Connection& connection, tims::Address to,
                         Failure failure);

}  // namespace timsctl
