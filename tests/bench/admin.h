// Sends admin requests to a router of this machine (router/io/ADMIN.md).
#pragma once

#include <boost/json/object.hpp>

#include "tims/session.h"

namespace tims::bench {

class Admin {
 public:
  static Result<Admin> open(const std::string& socket);

  // The answer; an error if there is none, or if the answer is an error.
  Result<boost::json::object> ask(const boost::json::object& question);
  // The number of mailboxes that the router knows.
  Result<std::size_t> mailboxes();
  Result<bool> knows(Address address);
  // The path of its only link: "udp", "dds".
  Result<std::string> path();

 private:
  Admin(Session session, Mailbox mailbox)
      : session_(std::move(session)), mailbox_(std::move(mailbox)) {}

  Session session_;
  Mailbox mailbox_;
};

}  // namespace tims::bench
