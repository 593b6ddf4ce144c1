// Connects two dialogues, for example of a driver and an emulator, by a simulated line with a
// virtual clock: minutes of communication run in milliseconds. Bytes have a transmission time and
// can be lost or split.
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "rack/devices/device_clock.h"
#include "rack/devices/dialogue.h"

namespace rack::device::emulator {

struct LineSettings {
  bool has_rate = false;  // serial line: bytes take time and are garbled at a different rate
  bool is_bus = false;    // CAN: frames are not split
  std::uint32_t host_baud = 0;
  std::uint32_t device_baud = 0;
  std::size_t piece = 0;  // bytes per arrival; 0: as they were sent
  Duration delay{};
};

class VirtualLine {
 public:
  VirtualLine(Dialogue& host, Dialogue& device, const LineSettings& settings)
      : settings_(settings),
        host_(*this, host, settings.host_baud),
        device_(*this, device, settings.device_baud) {}

  // Returns true if the bytes are lost. `from_host`: direction.
  using Lose = std::function<bool(bool from_host, std::span<const std::byte> bytes)>;
  void set_lose(Lose lose) { lose_ = std::move(lose); }

  void start() {
    device_.dialogue.start(now_, device_);
    host_.dialogue.start(now_, host_);
  }
  void start_host() { host_.dialogue.start(now_, host_); }
  void stop_host() { host_.dialogue.stop(now_, host_); }
  // The device was switched off and on.
  void start_device() {
    device_.baud = settings_.device_baud;
    device_.dialogue.start(now_, device_);
  }
  // The cable was unplugged: bytes in transit are lost. When the line is opened again, it has its
  // initial rate.
  void unplug() {
    for (End* const end : {&host_, &device_}) {
      end->coming.clear();
      end->free = {};
    }
    host_.baud = settings_.host_baud;
  }

  // Duplicates everything the device sends.
  void set_doubled(bool doubled) { is_doubled_ = doubled; }

  // Runs until `done` returns true or the time has elapsed. Returns the last result of `done`.
  bool run(Duration at_most, const std::function<bool()>& done) {
    const Time end = now_ + at_most;
    while (!done()) {
      const Time next = std::min({host_.next(), device_.next(), end});
      now_ = std::max(now_, next);
      if (next == end) return done();
      step();
    }
    return true;
  }
  void run(Duration how_long) {
    run(how_long, [] { return false; });
  }

  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] std::uint32_t host_baud() const { return host_.baud; }
  [[nodiscard]] std::uint32_t device_baud() const { return device_.baud; }
  [[nodiscard]] bool dtr() const { return device_.dtr; }
  // Injects bytes to the host that the device has not sent.
  void disturb(std::vector<std::byte> noise) {
    host_.coming.push_back({now_, now_, std::move(noise), 0, host_.baud});
  }

 private:
  struct Piece {
    Time first{};
    Time last{};
    std::vector<std::byte> bytes;
    std::uint32_t id = 0;
    std::uint32_t baud = 0;
  };

  struct End final : Output {
    End(VirtualLine& its_line, Dialogue& its_dialogue, std::uint32_t its_baud)
        : line(its_line), dialogue(its_dialogue), baud(its_baud) {}

    void send(std::span<const std::byte> bytes, std::uint32_t id) override {
      line.carry(*this, bytes, id);
      if (line.is_doubled_ && this == &line.device_) line.carry(*this, bytes, id);
    }
    void set_baud(std::uint32_t rate) override {
      if (line.settings_.has_rate) baud = rate;
    }
    void set_dtr(bool on) override { line.other(*this).dtr = on; }

    [[nodiscard]] Time next() const {
      return std::min(dialogue.next_timeout(), coming.empty() ? tims::kNever : coming.front().last);
    }

    VirtualLine& line;
    Dialogue& dialogue;
    std::uint32_t baud;
    bool dtr = true;  // set by the other end
    Time free{};      // when the line is free to transmit in this direction
    std::deque<Piece> coming{};
  };

  End& other(End& end) { return &end == &host_ ? device_ : host_; }

  void carry(End& from, std::span<const std::byte> bytes, std::uint32_t id) {
    if (lose_ && lose_(&from == &host_, bytes)) return;
    const bool splits = settings_.piece > 0 && !settings_.is_bus;
    const std::size_t piece = splits ? settings_.piece : std::max<std::size_t>(1, bytes.size());
    Time begin = std::max(from.free, now_ + settings_.delay);
    do {
      const auto part = bytes.first(std::min(piece, bytes.size()));
      const Duration takes = settings_.has_rate ? line_time(part.size(), from.baud) : Duration(0);
      other(from).coming.push_back(
          {begin, begin + takes, std::vector(part.begin(), part.end()), id, from.baud});
      begin += takes;
      bytes = bytes.subspan(part.size());
    } while (!bytes.empty());
    from.free = begin;
  }

  void step() {
    for (End* const end : {&device_, &host_}) {
      while (!end->coming.empty() && end->coming.front().last <= now_) {
        Piece piece = std::move(end->coming.front());
        end->coming.pop_front();
        // At the wrong rate the bytes are garbled.
        if (settings_.has_rate && piece.baud != end->baud)
          for (std::byte& byte : piece.bytes) byte = (byte << 1 | byte >> 3) ^ std::byte{0x95};
        end->dialogue.on_arrival(
            {.bytes = piece.bytes, .first = piece.first, .last = piece.last, .id = piece.id}, *end);
      }
      if (end->dialogue.next_timeout() <= now_) end->dialogue.on_timeout(now_, *end);
    }
  }

  LineSettings settings_;
  Lose lose_;
  bool is_doubled_ = false;
  Time now_{std::chrono::seconds(1000)};
  End host_;
  End device_;
};

}  // namespace rack::device::emulator
