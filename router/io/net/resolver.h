// Resolves host names without blocking the loop, in a thread of its own.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "os/file.h"
#include "router/io/loop.h"
#include "router/link/transport.h"
#include "tims/result.h"

namespace tims::io {

class Resolver {
 public:
  using Addresses = std::vector<link::NetAddress>;  // the preferred one first; never empty
  using Callback = std::function<void(Result<Addresses>)>;

  explicit Resolver(Loop& loop) : loop_(loop) {}
  Resolver(const Resolver&) = delete;
  Resolver& operator=(const Resolver&) = delete;
  // Calls no more callbacks. Waits for the query in progress: a few seconds when no name server
  // answers.
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
  struct Answer {
    Question question{};
    Result<Addresses> result;
  };

  void ask(const Question& question);
  Result<void> start_thread();
  void take_answers();
  void work();  // runs in the thread

  Loop& loop_;
  os::File answered_;  // an eventfd
  std::optional<Watch> watch_;
  std::map<Question, std::vector<Callback>> waiting_;
  std::thread thread_;  // started with the first name

  // Shared by both threads.
  std::mutex mutex_;
  std::condition_variable asked_;
  std::deque<Question> questions_;
  std::vector<Answer> answers_;
  bool ending_ = false;
};

}  // namespace tims::io
