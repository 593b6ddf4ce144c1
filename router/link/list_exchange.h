// The newest list of the fleet (revoked certificates and believed roots, security/keys) goes from
// router to router: each states the number of its list when a sealed link comes up and whenever it
// has another one; a router that has an older list gets the newer one in parts, and offers it in
// turn. So a revocation reaches a connected fleet within a second.
//
// The bytes are opaque here. A ListKeeper verifies and stores them, elsewhere and later. Whoever is
// on a link can only waste its own turn: an offer that does not become a valid list within a minute
// is put aside for a minute, at most four lists are received at once, and the link to the router
// above takes precedence. The receiver asks for each part, so at most one part waits in front of
// urgent messages, and its sender chooses its size by the rate of the link.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "router/core/router.h"
#include "router/link/frame.h"

namespace tims::link {

// A list of the fleet as it is passed on. Number 0: none.
struct FleetListBytes {
  std::uint64_t number = 0;
  std::shared_ptr<const std::vector<std::byte>> bytes{};
};

class ListKeeper : public core::Interface {
 public:
  // Verifies a list, which should have this number, and stores it; returns at once, and the result
  // is passed to Links::on_list_checked(). `from`: the name of the router that has sent it.
  virtual void check(std::uint64_t transfer, std::uint64_t number, std::string_view from,
                     std::vector<std::byte>&& bytes) = 0;
};

class ListExchange {
 public:
  static constexpr std::size_t kBytesMax = 1U << 20;
  // Of a part, except that the last one may be smaller.
  static constexpr std::size_t kPartMin = 1024;
  static constexpr std::size_t kPartMax = 8 << 10;
  static constexpr std::size_t kAtOnce = 4;  // lists being received or verified
  static constexpr Duration kAskAgain = std::chrono::seconds(1);
  static constexpr Duration kSilenceMax = std::chrono::seconds(5);  // between parts
  // Within this time a link has brought a valid list, or its offers are put aside as long.
  static constexpr Duration kTimeMax = std::chrono::minutes(1);

  // A link is known by its slot.
  class Carrier : public core::Interface {
   public:
    virtual void send_list_message(Time now, std::uint32_t slot, ControlMessage& message) = 0;
    // The size of a part that may be sent now; 0: none.
    [[nodiscard]] virtual std::size_t list_part_size(std::uint32_t slot) const = 0;
    virtual void check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t slot,
                            std::vector<std::byte>&& bytes) = 0;
  };
  explicit ListExchange(Carrier& carrier) : carrier_(carrier) {}

  // The list in force here; of a list that is not newer than the present one only the bytes count.
  void set_own(Time now, FleetListBytes list);
  [[nodiscard]] std::uint64_t number() const { return own_.number; }

  // A sealed link is up. `above`: to the super router.
  void begin(Time now, std::uint32_t slot, bool above);
  void end(Time now, std::uint32_t slot);
  // LIST, LIST_GET or LIST_PART; false: it violates the protocol.
  [[nodiscard]] bool on_control(Time now, std::uint32_t slot, const core::Message& message);
  // The keeper's result. What is good becomes set_own() a moment later.
  void on_checked(Time now, std::uint64_t transfer, bool is_good);

  [[nodiscard]] Time next_timeout() const { return next_; }
  void on_timeout(Time now);

  [[nodiscard]] std::size_t transfers() const { return transfers_.size(); }

 private:
  struct Neighbour {
    bool above = false;
    std::uint64_t told = 0;  // number of our list that it knows
    ListPlace offer{};       // its newest list
    Time until = kNever;     // when it must have brought a valid list
    Time aside_until{};
  };
  using Neighbours = std::map<std::uint32_t, Neighbour>;
  struct Transfer {
    std::uint64_t id = 0;
    std::uint32_t slot = 0;
    ListPlace list{};
    std::vector<std::byte> bytes{};
    Time asked{};
    Time moved{};  // when it began, or the last part came
    bool checking = false;
  };

  [[nodiscard]] bool on_offer(Neighbour& from, std::uint32_t slot, const ListPlace& offer);
  void on_get(Time now, std::uint32_t slot, const ListPlace& place);
  [[nodiscard]] bool on_part(Time now, std::uint32_t slot, const ListPlace& place,
                             std::span<const std::byte> bytes);
  void send(Time now, std::uint32_t slot, std::int8_t type, const ListPlace& place,
            std::span<const std::byte> bytes = {});
  void ask(Time now, Transfer& transfer);
  void put_aside(Time now, std::uint32_t slot);
  // What is to be told and asked for now, and when the next step is due.
  void plan(Time now);
  void tell(Time now);
  void begin_transfers(Time now);
  [[nodiscard]] Neighbours::value_type* candidate(Time now);
  [[nodiscard]] bool make_room(const Neighbour& neighbour);
  [[nodiscard]] Transfer* receiving(std::uint32_t slot);
  [[nodiscard]] Time due() const;

  Carrier& carrier_;
  FleetListBytes own_;
  std::uint64_t good_ = 0;  // number of the newest list that was good
  Neighbours neighbours_;
  std::vector<Transfer> transfers_;
  std::uint64_t last_ = 0;
  Time next_ = kNever;
};

}  // namespace tims::link
