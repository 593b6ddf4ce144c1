// Numbered commands from a program of one host to a program of another, as fast as a component
// sends: which of them arrive, in which order, and how long none does.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "tims/address.h"
#include "tims/mailbox.h"
#include "tims/result.h"
#include "tims/session.h"
#include "tims/time.h"

namespace tims::test {

class NumberedTraffic {
 public:
  struct End {
    std::string router;  // its socket
    Address address{};
  };
  // Of 64 bytes, every fiftieth of many datagrams.
  static Result<std::unique_ptr<NumberedTraffic>> begin(const End& from, const End& to,
                                                        Duration pace);
  NumberedTraffic(const NumberedTraffic&) = delete;
  NumberedTraffic& operator=(const NumberedTraffic&) = delete;
  ~NumberedTraffic();

  // Waits until all has arrived, at most for this time.
  void end(Duration patience);

  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  [[nodiscard]] std::uint64_t arrived() const { return arrived_; }
  // The longest time in which nothing arrived.
  [[nodiscard]] Duration silence() const { return Duration(silence_ns_.load()); }
  // Since the last call.
  Duration take_silence() { return Duration(silence_ns_.exchange(0)); }
  // Lost, doubled, out of order, or answered with NOT_AVAILABLE.
  [[nodiscard]] std::uint64_t wrong() const { return wrong_; }
  // Attempts to send while the sender's host had no router.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  NumberedTraffic(Session&& from, Session&& to, Mailbox&& source, Mailbox&& sink, Duration pace);
  void find_path();
  void send();
  void receive();

  Session from_;
  Session to_;
  Mailbox source_;
  Mailbox sink_;
  const Duration pace_;
  std::atomic<bool> sends_ = true;
  std::atomic<bool> receives_ = true;
  std::atomic<bool> is_found_ = false;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> arrived_ = 0;
  std::atomic<std::uint64_t> wrong_ = 0;
  std::atomic<std::uint64_t> refused_ = 0;
  std::atomic<std::int64_t> silence_ns_ = 0;
  std::thread sender_;
  std::thread receiver_;
};

}  // namespace tims::test
