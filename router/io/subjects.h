// Who a client is, as rules of the policy name it (router/policy/subject.h).
#pragma once

#include <sys/types.h>

#include "os/peer.h"
#include "router/core/types.h"
#include "router/io/rights.h"
#include "router/io/visitor.h"
#include "router/policy/subject.h"

namespace tims::io {

// Root, or the user that this router runs as: they can write its rules and its keys.
bool is_own_user(uid_t uid);

// A program at the Unix socket. It is the router's own if it runs as its user, as root, or in its
// group, to whom the socket is open.
policy::Subject local_subject(const os::LocalPeer& peer);

// Somebody at the TCP or HTTP port. Within this host the kernel knows its user.
policy::Subject visitor_subject(core::PortKind port, const Visitor& visitor);

// Somebody who has logged in there, or has a certificate of the fleet.
policy::Subject person_subject(core::PortKind port, const Person& person, const Visitor& visitor);

}  // namespace tims::io
