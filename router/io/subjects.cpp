#include "router/io/subjects.h"

#include <algorithm>

#include <unistd.h>

#include "router/config/config.h"

namespace tims::io {
namespace {

namespace kind = policy::kind;

}  // namespace

bool is_own_user(uid_t uid) { return uid == 0 || uid == ::geteuid(); }

policy::Subject local_subject(const os::LocalPeer& peer) {
  policy::Subject subject;
  subject.add(kind::kUid, peer.uid).add(kind::kGid, peer.gid);
  for (const gid_t group : peer.groups)
    if (group != peer.gid) subject.add(kind::kGid, group);
  if (!peer.unit.empty()) subject.add(kind::kUnit, peer.unit);
  if (!peer.label.empty()) subject.add(kind::kLabel, peer.label);
  subject.add(kind::kPort, core::name(core::PortKind::kLocal));
  const bool in_group =
      peer.gid == ::getegid() || std::ranges::find(peer.groups, ::getegid()) != peer.groups.end();
  if (is_own_user(peer.uid) || in_group) subject.add_own();
  return subject;
}

policy::Subject visitor_subject(core::PortKind port, const Visitor& visitor) {
  policy::Subject subject;
  if (visitor.uid) subject.add(kind::kUid, *visitor.uid);
  if (const auto endpoint = config::Endpoint::parse(visitor.peer))
    subject.add(kind::kNet, endpoint->host);
  subject.add(kind::kPort, core::name(port));
  if (visitor.uid && is_own_user(*visitor.uid)) subject.add_own();
  return subject;
}

policy::Subject person_subject(core::PortKind port, const Person& person, const Visitor& visitor) {
  policy::Subject subject = person.proven;
  if (subject.identities.empty()) subject.add(kind::kUser, person.name);
  for (const Right right : {Right::kLook, Right::kDrive, Right::kConfigure})
    if (has(person.rights, right)) subject.add(kind::kRight, name(right));
  if (const auto endpoint = config::Endpoint::parse(visitor.peer))
    subject.add(kind::kNet, endpoint->host);
  return subject.add(kind::kPort, core::name(port));
}

}  // namespace tims::io
