// What is to be written into one TCP connection.
//
// As long as the socket takes everything, messages go from where they were received into the
// socket without a copy, as many as possible with one system call. What it does not take waits in
// a MessageQueue, whole messages in order of importance, until the socket is writable again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <sys/uio.h>

#include "router/core/message_queue.h"
#include "router/core/statistics.h"

namespace tims::io {

class TcpOutput {
 public:
  TcpOutput(int socket, core::BlockPool& pool, std::uint64_t queue_bytes_max,
            const core::PriorityClasses& classes = core::kConventionalClasses)
      : socket_(socket),
        classes_(classes),
        queue_(pool, queue_bytes_max, core::MessageQueue::Share::kFair, classes) {}

  void set_queue_bytes_max(std::uint64_t bytes) { queue_.set_bytes_max(bytes); }

  // A whole message. The bytes must stay until write_batch(), unless the queue has taken them.
  // `priority` is the one it waits with, if it must.
  core::Outcome add(std::span<const std::byte> message, std::uint8_t priority);

  // Writes what was added since the last time; after it the bytes are not needed any more.
  void write_batch();
  // The socket is writable again: writes from the queue, a bounded amount. Returns how much.
  std::size_t write_queue();

  enum class State : std::uint8_t {
    kIdle,         // everything is written
    kWaiting,      // for the socket to become writable
    kBroken,       // the connection is gone
    kOutOfMemory,  // a message could be written only in part, and there is no room for its rest
  };
  [[nodiscard]] State state() const;
  [[nodiscard]] std::uint64_t queued_bytes() const { return queue_.bytes(); }

  // Messages that were taken and then lost, by reason; told once.
  struct Lost {
    core::Losses replaced{};
    core::Losses refused{};
    core::Losses gone{};
  };
  // Null when there certainly are none.
  [[nodiscard]] const Lost* lost() const { return may_have_lost_ ? &lost_ : nullptr; }
  void forget_lost();
  // Counts everything not yet written as gone.
  void abandon();

 private:
  static constexpr std::size_t kPiecesMax = 64;

  std::size_t send(std::span<const iovec> pieces);
  void keep_rest(std::size_t written);
  void keep(std::span<const std::byte> message, const Header& header, std::size_t written);
  template <typename Visit>
  void for_each_message(Visit visit) const;

  int socket_;
  const core::PriorityClasses& classes_;
  State failure_ = State::kIdle;
  std::size_t piece_count_ = 0;
  std::size_t batch_bytes_ = 0;
  // Whole messages, one behind the other in each piece.
  std::array<iovec, kPiecesMax> pieces_{};
  core::MessageQueue queue_;
  Lost lost_;
  bool may_have_lost_ = false;
};

}  // namespace tims::io
