// Scanners of space from their side: a Velodyne VLP-16 and an Ouster OS-0-32, both at ten turns a
// second in a room, or what else they see, sending datagrams as soon as they are switched on.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "components/devices/core/dialogue.h"
#include "components/devices/scan3d/ouster.h"
#include "components/devices/scan3d/velodyne.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

// What both have in common: a datagram is due, and is made.
class SpinningScanner : public Dialogue {
 public:
  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

 protected:
  explicit SpinningScanner(Duration period) : period_(period) {}
  // The `index`-th datagram since it was switched on, whose first column was measured then.
  virtual void make(std::uint64_t index, Time began, std::vector<std::byte>& packet) = 0;

 private:
  Duration period_;
  Time began_{};
  Time next_ = tims::kNever;
  std::uint64_t sent_ = 0;
  std::vector<std::byte> packet_;
};

class VelodyneScanner final : public SpinningScanner {
 public:
  explicit VelodyneScanner(Sight sight = Room{});

 private:
  void make(std::uint64_t index, Time began, std::vector<std::byte>& packet) override;

  Sight sight_;
};

class OusterScanner final : public SpinningScanner {
 public:
  explicit OusterScanner(Sight sight = Room{});

  // What it says of itself.
  static std::string_view metadata();

 private:
  void make(std::uint64_t index, Time began, std::vector<std::byte>& packet) override;

  Sight sight_;
  OusterMetadata metadata_;
};

// Its other side: who asks for anything by HTTP is told its metadata.
class OusterPage final : public Dialogue {
 public:
  void start(Time, Output&) override { question_.clear(); }
  void on_arrival(const Arrival& arrival, Output& out) override;

 private:
  std::string question_;
};

}  // namespace rack::device::emulator
