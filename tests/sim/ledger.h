// Records every message that was sent in a simulated network, and whether it arrived.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "tests/sim/simulated_network.h"

namespace tims::sim {

class Ledger {
 public:
  struct Entry {
    Header header{};
    std::size_t from = 0;  // nodes
    std::size_t to = 0;
    Time at{};
    core::Outcome outcome{};
    bool arrived = false;
    bool answered = false;  // NOT_AVAILABLE

    [[nodiscard]] bool is_sample() const { return (header.flags & flag::kStream) != 0; }
    [[nodiscard]] std::size_t message_class() const {
      return core::kConventionalClasses.of(header);
    }
  };

  explicit Ledger(std::function<void(const std::string&)> fail) : fail_(std::move(fail)) {}

  // Messages from one address to another must arrive in order.
  bool keeps_order = true;

  // Numbers the message and generates its body.
  std::size_t add(const Entry& entry, std::size_t body_size, std::vector<std::byte>& body);
  void set_outcome(std::size_t number, core::Outcome outcome) {
    entries_[number].outcome = outcome;
  }
  void on_arrival(const Arrival& arrival);
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  static std::string describe(const Entry& entry);

 private:
  using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint8_t>;
  using Flow = std::tuple<std::uint32_t, std::uint32_t, std::size_t, bool>;
  void check_order(std::size_t number);

  std::function<void(const std::string&)> fail_;
  std::vector<Entry> entries_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint8_t> counts_;
  std::map<Key, std::size_t> numbers_;
  std::map<Flow, std::size_t> newest_;
};

}  // namespace tims::sim
