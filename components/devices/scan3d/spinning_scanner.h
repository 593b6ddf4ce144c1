// Emulators of 3D scanners: a Velodyne VLP-16 and an Ouster OS-0-32, both with ten turns per second
// in a room or another scene; they send datagrams from power-on.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "components/devices/scan3d/ouster.h"
#include "components/devices/scan3d/velodyne.h"
#include "components/devices/scanners/room.h"
#include "rack/devices/dialogue.h"

namespace rack::device::emulator {

// Common part: creates and sends datagrams when they are due.
class SpinningScanner : public Dialogue {
 public:
  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

 protected:
  explicit SpinningScanner(Duration period) : period_(period) {}
  // Creates the datagram `index` since power-on, whose first column was measured at `began`.
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

  // The metadata of the emulated scanner, JSON.
  static std::string_view metadata();

 private:
  void make(std::uint64_t index, Time began, std::vector<std::byte>& packet) override;

  Sight sight_;
  OusterMetadata metadata_;
};

// The HTTP server of an emulated Ouster, which sends its metadata.
class OusterPage final : public Dialogue {
 public:
  void start(Time, Output&) override { question_.clear(); }
  void on_arrival(const Arrival& arrival, Output& out) override;

 private:
  std::string question_;
};

}  // namespace rack::device::emulator
