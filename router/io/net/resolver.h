// Resolves host names without blocking the loop: by Asio, in its thread.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "router/io/loop.h"
#include "router/link/transport.h"
#include "tims/result.h"

namespace tims::io {

// Limits the time that silent name servers cost, for the whole process, unless RES_OPTIONS is set.
// Call before the first thread starts.
void limit_name_servers();

class Resolver {
 public:
  using Addresses = std::vector<link::NetAddress>;  // the preferred one first; never empty
  using Callback = std::function<void(Result<Addresses>)>;

  explicit Resolver(Loop& loop);
  Resolver(const Resolver&) = delete;
  Resolver& operator=(const Resolver&) = delete;
  // Calls no more callbacks. The end of the loop waits for the query in progress: a few seconds
  // when no name server answers.
  ~Resolver();

  // Numbers ("10.9.1.1", "fe80::1%eth0") are answered immediately, within this call; names later,
  // from the loop. Concurrent requests for the same name share one answer. A callback may call
  // resolve(), but must not destroy the resolver.
  void resolve(const std::string& host, std::uint16_t port, Callback callback);

 private:
  struct Question {
    std::string host{};
    std::uint16_t port = 0;
    auto operator<=>(const Question&) const = default;
  };
  class Queries;

  void ask(const Question& question);
  void answer(const Question& question, const Result<Addresses>& result);

  std::unique_ptr<Queries> queries_;
  std::shared_ptr<std::map<Question, std::vector<Callback>>> waiting_;  // queries may outlive it
};

}  // namespace tims::io
