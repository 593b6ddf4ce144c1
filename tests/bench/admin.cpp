#include "tests/bench/admin.h"

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>

namespace tims::bench {
namespace {

constexpr Duration kAdminPatience = std::chrono::seconds(5);
constexpr std::uint32_t kAnswerMax = 256 << 10;
constexpr Address kOwn = Address::of({.class_id = class_id::kTool, .instance = 0xBE});

}  // namespace

Result<Admin> Admin::open(const std::string& socket) {
  auto session = Session::connect({.name = "bench-admin",
                                   .router = socket,
                                   .timeout = kAdminPatience,
                                   .on_event = [](const SessionEvent&) {}});
  if (!session) return session.error();
  auto mailbox = session->open({.address = kOwn, .slots = 4, .body_max = kAnswerMax});
  if (!mailbox) return mailbox.error();
  return Admin(std::move(*session), std::move(*mailbox));
}

Result<boost::json::object> Admin::ask(const boost::json::object& question) {
  const std::string text = boost::json::serialize(question);
  const auto sent = mailbox_.send({.dest = session_.router(), .type = type::kAdminRequest},
                                  std::as_bytes(std::span(text)));
  if (!sent) return sent.error();
  const auto reply = mailbox_.peek_for(kAdminPatience);
  if (!reply) return reply.error();
  const auto body = reply->body();
  boost::system::error_code error;
  auto answer =
      boost::json::parse({reinterpret_cast<const char*>(body.data()), body.size()}, error);
  if (error || !answer.is_object()) return Error(Errc::kVersion, "the answer is not JSON");
  if (answer.get_object().contains("error"))
    return Error(Errc::kRefused, boost::json::serialize(answer));
  return std::move(answer.get_object());
}

Result<std::size_t> Admin::mailboxes() {
  const auto status = ask({{"ask", "status"}});
  if (!status) return status.error();
  return static_cast<std::size_t>(status->at("mailboxes").as_int64());
}

Result<bool> Admin::knows(Address address) {
  const auto routes = ask({{"ask", "routes"}, {"match", address.to_hex()}});
  if (!routes) return routes.error();
  return !routes->at("items").as_array().empty();
}

Result<std::string> Admin::path() {
  const auto links = ask({{"ask", "links"}});
  if (!links) return links.error();
  return std::string(links->at("items").as_array().at(0).at("path").as_string());
}

}  // namespace tims::bench
