#include "router/io/net/resolver.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/basic_resolver.hpp>
#include <boost/asio/ip/udp.hpp>

#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using link::NetAddress;
using AsioResolver = asio::ip::basic_resolver<asio::ip::udp, asio::io_context::executor_type>;

// Rejects texts that cannot be names.
std::optional<Error> refusal(const std::string& host) {
  if (host.empty()) return Error(Errc::kInvalidArgument, "host name: empty");
  if (host.find_first_of(":%") != std::string::npos) {
    return Error(
        Errc::kInvalidArgument,
        "host name " + host + ": neither a name nor an address; does its interface exist?");
  }
  return std::nullopt;
}

Resolver::Addresses addresses_in(const AsioResolver::results_type& found, std::uint16_t port) {
  Resolver::Addresses addresses;
  for (const auto& entry : found) {
    NetAddress address = net_address(*entry.endpoint().data());
    address.port = port;
    if (std::ranges::find(addresses, address) == addresses.end()) addresses.push_back(address);
  }
  return addresses;
}

}  // namespace

// One try of a second for each name server; the caller retries.
void limit_name_servers() { ::setenv("RES_OPTIONS", "timeout:1 attempts:1", 0); }

class Resolver::Queries : public AsioResolver {
  using AsioResolver::AsioResolver;
};

Resolver::Resolver(Loop& loop)
    : queries_(std::make_unique<Queries>(loop.context().get_executor())),
      waiting_(std::make_shared<std::map<Question, std::vector<Callback>>>()) {}

Resolver::~Resolver() = default;

void Resolver::resolve(const std::string& host, std::uint16_t port, Callback callback) {
  if (const auto address = numeric_address(host, port)) return callback(Addresses{*address});
  if (const auto error = refusal(host)) return callback(*error);
  const Question question{host, port};
  auto& callbacks = (*waiting_)[question];
  callbacks.push_back(std::move(callback));
  if (callbacks.size() == 1) ask(question);
}

void Resolver::ask(const Question& question) {
  try {
    queries_->async_resolve(question.host, "", AsioResolver::flags(),
                            [this, question, alive = std::weak_ptr(waiting_)](
                                const error_code& error, const AsioResolver::results_type& found) {
                              if (alive.expired()) return;
                              if (error)
                                answer(question, Error(Errc::kSystem, "host name " + question.host +
                                                                          ": " + error.message()));
                              else
                                answer(question, addresses_in(found, question.port));
                            });
  } catch (const boost::system::system_error& error) {
    answer(question, Error(Errc::kSystem,
                           std::string("cannot start the thread for host names: ") + error.what()));
  }
}

void Resolver::answer(const Question& question, const Result<Addresses>& result) {
  const auto node = waiting_->extract(question);
  for (const Callback& callback : node.mapped()) callback(result);
}

}  // namespace tims::io
