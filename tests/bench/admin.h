// Asks a router of this machine (router/io/ADMIN.md).
#pragma once

#include <boost/json/object.hpp>

#include "tims/session.h"

namespace tims::bench {

class Admin {
 public:
  static Result<Admin> open(const std::string& socket);

  // The answer; an error when there is none, or when it is one.
  Result<boost::json::object> ask(const boost::json::object& question);
  // How many mailboxes the router knows.
  Result<std::size_t> mailboxes();
  Result<bool> knows(Address address);
  // Which way its only link goes: "udp", "dds".
  Result<std::string> path();

 private:
  Admin(Session session, Mailbox mailbox)
      : session_(std::move(session)), mailbox_(std::move(mailbox)) {}

  Session session_;
  Mailbox mailbox_;
};

}  // namespace tims::bench
