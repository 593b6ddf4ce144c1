// The handshakes in progress, of both sides: carries the bytes between a Handshaker and the other
// router, and bounds what strangers can make this router do. A handshake begins only for an address
// that has been proven by a cookie.
//
// A handshake ends with one message of each side: WHO of the connecting side, and WELCOME or REFUSE
// of the accepting side.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "router/link/crypto_stream.h"
#include "router/link/datagram.h"
#include "router/link/seal.h"
#include "tims/time.h"

namespace tims::link {

class Handshakes {
 public:
  using Side = Handshaker::Side;
  static constexpr std::size_t kAcceptedMax = 64;
  static constexpr Duration kTimeMax = std::chrono::seconds(10);
  // Without a datagram of the other side, the connecting side begins again.
  static constexpr Duration kSilenceMax = std::chrono::seconds(3);
  // A router that gives another cookie than before, or answers from elsewhere, is believed when it
  // has said nothing for so long: others, who see the HELLO, can forge its answer, and a handshake
  // that each such answer began anew would not succeed over a long round trip.
  static constexpr Duration kBelievedAfter = 2 * CryptoStream::kRepeatFirst;
  // Another cookie of one that is known to be restarting.
  static constexpr Duration kRestartTime = std::chrono::milliseconds(50);
  // When there are too many, one makes room whose other side has kept this router waiting for so
  // long in all; less when only the acknowledgement of the answer is missing.
  static constexpr Duration kYieldsAfter = std::chrono::seconds(2);
  static constexpr Duration kAnsweredYieldsAfter = 2 * CryptoStream::kRepeatFirst;
  static constexpr std::size_t kBeginning = 64;

  struct One {
    std::uint64_t number = 0;
    Side side{};
    NetAddress address{};     // of the other router
    std::uint64_t token = 0;  // of the HELLO
    std::uint64_t cookie = 0;
    Time began{};
    Time heard{};               // the last datagram of the other side
    Duration waited{};          // for the other side, before its newest bytes
    Time waits_since = kNever;  // for the other side; kNever: it is this side's turn
    Time asks_again = kNever;
    CryptoStream stream{};
    // How an accepted one began: TLS's random number is in it.
    std::array<std::byte, kBeginning> beginning{};
    std::vector<std::byte> behind{};   // bytes of the other side, until its turn
    std::vector<std::byte> message{};  // of the verified other side
    Verified verified{};
    bool answered = false;  // this side has nothing more to say
    bool answer_sent = false;
    [[nodiscard]] bool is_our_turn() const { return waits_since == kNever; }
  };
  // Of those that this side has accepted, since its start.
  struct Counters {
    std::size_t in_progress = 0;  // now
    std::uint64_t accepted = 0;
    std::uint64_t answered = 0;     // by a link or a refusal
    std::uint64_t given_up = 0;     // they made room, took too long, or were begun again
    std::uint64_t turned_away = 0;  // datagrams that would have begun one, without room
  };
  class Observer : public core::Interface {
   public:
    // The other side is verified and has sent its message. It may be given again (ask_again()).
    virtual void on_message(Time now, One& handshake) = 0;
    virtual void on_failed(Time now, const One& handshake, std::string_view why) = 0;
    virtual void send(const NetAddress& to, std::span<const std::byte> datagram) = 0;
  };

  Handshakes(Handshaker* handshaker, Observer& observer)
      : handshaker_(handshaker), observer_(observer) {}

  // True when this router has keys.
  [[nodiscard]] bool are_possible() const { return handshaker_ != nullptr; }

  // `who` is sent inside. One with this token that is in progress goes on, at once if it waited; of
  // several paths, the first that has answered is used. `restarts`: the other router is known to do
  // so just now.
  void connect(Time now, const NetAddress& to, const Retry& retry, std::span<const std::byte> who,
               bool restarts);
  // Returns false when there is no room.
  bool accept(Time now, const NetAddress& from, const Crypto& first);
  // Returns false when the datagram belongs to no handshake: also when the connecting side has
  // begun again meanwhile, with the cookie that is still valid. While it is this side's turn, that
  // is ignored until it is repeated: one handshaker works for all, and whoever has a cookie could
  // give it work without end.
  bool on_crypto(Time now, const NetAddress& from, const Crypto& crypto);
  // That of an accepted one in progress. Its other side begins again when it gets another one.
  [[nodiscard]] std::optional<std::uint64_t> cookie_of(const NetAddress& from,
                                                       std::uint64_t token) const;
  void on_progress(Time now, HandshakeProgress&& progress);
  // The last message of the accepting side.
  void answer(Time now, One& handshake, std::span<const std::byte> message);
  // Gives its message again after this time.
  static void ask_again(Time now, One& handshake, Duration after) {
    handshake.asks_again = now + after;
  }
  // The message of the other side ends it, once its acknowledgement has been sent.
  void finish(Time now, One& handshake);

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);
  [[nodiscard]] std::size_t count() const { return all_.size(); }
  [[nodiscard]] Counters counters() const;

 private:
  One& add(Time now, Side side, const NetAddress& address, std::uint64_t token,
           std::uint64_t cookie);
  One* find(const NetAddress& from, const Crypto& crypto);
  One* calling(std::uint64_t token);
  bool goes_on(Time now, One& one, const NetAddress& to, const Retry& retry, bool restarts);
  One* find(std::uint64_t number);
  void give(Time now, One& one, const Crypto& crypto);
  void pass_on(Time now, One& one);
  void flush(Time now, One& one);
  void fail(Time now, std::uint64_t number, std::string_view why);
  void end(std::uint64_t number);
  void give_up(const One& one);
  [[nodiscard]] std::size_t accepted_now() const;
  bool make_room(Time now);
  static void take_turn(Time now, One& one);
  [[nodiscard]] static Time due(const One& one);

  Handshaker* handshaker_;
  Observer& observer_;
  std::uint64_t last_ = 0;
  std::map<std::uint64_t, One> all_;  // by number
  Counters counters_;                 // without in_progress
};

}  // namespace tims::link
