// Receives other routers: their HELLOs and handshakes, until they have a link or a refusal. Also
// carries the handshakes that this router begins.
//
// Admission decides who may connect, Handshakes proves who it is, and here both meet the links.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/rate_limiter.h"
#include "router/link/admission.h"
#include "router/link/handshakes.h"
#include "router/link/link.h"

namespace tims::link {

class Reception final : private Handshakes::Observer {
 public:
  // RETRYs. In a flood of HELLOs, so many are answered, so that links and programs have their share
  // of the processor; a fleet that calls at once gets all its answers in a moment.
  static constexpr std::uint64_t kRetriesPerSecond = 20'000;
  static constexpr std::uint64_t kRetriesAtOnce = 2'000;

  // The links that others come to.
  class House : public core::Interface {
   public:
    virtual std::uint64_t random() = 0;
    virtual void send(const NetAddress& to, std::span<const std::byte> datagram) = 0;
    [[nodiscard]] virtual std::span<const LinkSettings> settings() const = 0;
    [[nodiscard]] virtual bool is_announced(const NetAddress& dds) const = 0;
    // Null: there is none.
    virtual Link* link_to(const Identity& peer) = 0;
    virtual Link* find(std::string_view name) = 0;
    // True when a link with these settings calls the router at `from`, or `peer`.
    virtual bool calls(const LinkSettings& settings, const NetAddress& from,
                       const Identity& peer) = 0;
    [[nodiscard]] virtual std::size_t links_in_use() const = 0;
    virtual Link& add(Time now, const LinkSettings& settings) = 0;
    // Its tokens or its other router may have changed, and it may have something to send.
    virtual void was_taken(Link& link) = 0;
    [[nodiscard]] virtual Standing standing(const PeerName& peer) const = 0;
    // What a router that this one has called says. `handshake`: null for an open link.
    virtual void on_welcome(Time now, const NetAddress& from, const Welcome& welcome,
                            Handshakes::One* handshake) = 0;
    virtual void on_refuse(Time now, const NetAddress& from, const Refuse& refuse) = 0;
  };

  struct Setup {
    Identity self{};
    core::SipKey secret{};             // of cookies
    Handshaker* handshaker = nullptr;  // null: this router has no keys
    std::uint32_t links_max = 0;
  };
  Reception(core::Router& router, House& house, const Setup& setup);

  // --- datagrams
  void on_hello(Time now, const NetAddress& from, const Hello& hello);
  void on_hello(Time now, const NetAddress& from, const SealedHello& hello);
  void on_crypto(Time now, const NetAddress& from, const Crypto& crypto);

  // --- handshakes
  [[nodiscard]] bool has_keys() const { return handshakes_.are_possible(); }
  void shake_hands(Time now, const NetAddress& to, const Retry& retry,
                   std::span<const std::byte> who, bool restarts) {
    handshakes_.connect(now, to, retry, who, restarts);
  }
  void on_progress(Time now, HandshakeProgress&& progress) {
    handshakes_.on_progress(now, std::move(progress));
  }
  [[nodiscard]] Time next_timeout() const { return handshakes_.next_timeout(); }
  void on_timeout(Time now) { handshakes_.on_timeout(now); }

  // HELLOs and handshakes that were refused, or not answered in a flood.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }
  [[nodiscard]] Handshakes::Counters handshakes() const { return handshakes_.counters(); }

 private:
  // Who asks for a link: a datagram from a proven address, or the message of a handshake.
  struct Caller {
    NetAddress address{};
    Handshakes::One* handshake = nullptr;
  };
  enum class Verdict : std::uint8_t {
    kTake,
    kWait,  // the linked router is given time to prove that it is running
    kRefuse
  };

  // Handshakes::Observer
  void on_message(Time now, Handshakes::One& handshake) override;
  void on_failed(Time now, const Handshakes::One& handshake, std::string_view why) override;
  void send(const NetAddress& to, std::span<const std::byte> datagram) override {
    house_.send(to, datagram);
  }

  bool is_believed(Time now, Handshakes::One& handshake);
  void on_who(Time now, Handshakes::One& handshake);
  void admit(Time now, const Caller& caller, const Hello& hello);
  const LinkSettings* settings_for(Time now, const Caller& caller, const Hello& hello,
                                   const Link* link);
  Verdict judge(Time now, const Caller& caller, const Hello& hello, const Link& link,
                Refuse& refusal);
  void take(Time now, const Caller& caller, const Hello& hello, Link& link);
  void resume(Time now, const Caller& caller, const Hello& hello, Link& link);
  void welcome(Time now, const Caller& caller, const Hello& hello, const Link& link,
               std::optional<std::uint8_t> resumed);
  void refuse(Time now, const Caller& caller, const Refuse& refusal);
  void ask_for_cookie(Time now, const NetAddress& from, std::uint64_t token, std::uint64_t epoch);
  template <typename Datagram>
  void answer(Time now, const Caller& caller, const Datagram& datagram);

  House& house_;
  const Setup setup_;
  Admission admission_;
  Handshakes handshakes_;
  base::RateLimiter refusals_;
  base::RateLimiter retries_{kRetriesPerSecond, kRetriesAtOnce};
  std::uint64_t refused_ = 0;
};

// A certificate is for one router.
bool is_named(const Identity& identity, const PeerName& certificate);
std::string name_mismatch(const Identity& identity, const PeerName& certificate);

}  // namespace tims::link
