// devices_bench: how fast the decoders of devices/protocol are, on one core, beside memcpy in the
// same run. Every decoder gets what its device sends, in pieces as a network or a serial line bring
// them, and makes the data of it that a driver publishes.
//
//   devices_bench                      all decoders, with made streams
//   devices_bench cola-b lms511.txt    one of them, with a recording (tests/data/devices/sick)
//
// A new decoder is a line in kCases: a function that makes a stream, and one that decodes it.
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "devices/core/capture.h"
#include "devices/emulators/hokuyo_emulator.h"
#include "devices/emulators/ibeo_lux_emulator.h"
#include "devices/emulators/ld19_emulator.h"
#include "devices/emulators/room.h"
#include "devices/emulators/rplidar_emulator.h"
#include "devices/emulators/sick_compact_emulator.h"
#include "devices/emulators/sick_s_emulator.h"
#include "devices/emulators/spinning_scanner.h"
#include "devices/emulators/virtual_line.h"
#include "devices/protocol/cola_scan.h"
#include "devices/protocol/hokuyo.h"
#include "devices/protocol/ibeo_lux.h"
#include "devices/protocol/ld19.h"
#include "devices/protocol/lms200.h"
#include "devices/protocol/rplidar.h"
#include "devices/protocol/sick_s.h"

namespace rack::device {
namespace {

using Bytes = std::vector<std::byte>;
using Stopwatch = std::chrono::steady_clock;

// --- a decoder: pieces in, number of data sets out

class Decoder {
 public:
  virtual ~Decoder() = default;
  virtual std::size_t take(std::span<const std::byte> piece) = 0;
};

class ColaDecoder final : public Decoder {
 public:
  std::size_t take(std::span<const std::byte> piece) override {
    std::size_t found = 0;
    telegrams_.add({.bytes = piece});
    for (ColaTelegram telegram; telegrams_.next(telegram);)
      found += decode_cola_scan(telegram, scan_) && scan_of_cola(scan_, {}, data_) ? 1U : 0U;
    return found;
  }

 private:
  ColaTelegrams telegrams_;
  ColaScan scan_;
  LadarData data_;
};

class Lms200Decoder final : public Decoder {
 public:
  std::size_t take(std::span<const std::byte> piece) override {
    using What = Lms200Telegrams::What;
    std::size_t found = 0;
    telegrams_.add({.bytes = piece});
    Lms200Telegram telegram;
    for (What what = telegrams_.next(telegram); what != What::kNothing;
         what = telegrams_.next(telegram))
      found += what == What::kTelegram && decode_lms200_scan(telegram.body, data_) ? 1U : 0U;
    return found;
  }

 private:
  Lms200Telegrams telegrams_;
  LadarData data_;
};

class SickSDecoder final : public Decoder {
 public:
  std::size_t take(std::span<const std::byte> piece) override {
    std::size_t found = 0;
    telegrams_.add({.bytes = piece});
    for (SickSTelegram telegram; telegrams_.next(telegram);)
      found += decode_sick_s_scan(telegram, SickSDevice::kS300, data_) ? 1U : 0U;
    return found;
  }

 private:
  SickSTelegrams telegrams_;
  LadarData data_;
};

// A piece is a datagram.
class CompactDecoder final : public Decoder {
 public:
  std::size_t take(std::span<const std::byte> piece) override {
    return decode_compact(piece, segment_) == CompactKind::kSegment ? 1U : 0U;
  }

 private:
  CompactSegment segment_;
};

// A driver's whole dialogue; a millisecond passes from piece to piece.
template <class Dialog, class Data>
class DialogueDecoder final : public Decoder {
 public:
  explicit DialogueDecoder(Dialog dialogue) : dialogue_(std::move(dialogue)) {
    reserve_all(data_);
    dialogue_.start(now_, nobody_);
  }
  std::size_t take(std::span<const std::byte> piece) override {
    now_ += std::chrono::milliseconds(1);
    dialogue_.on_arrival({.bytes = piece, .first = now_, .last = now_}, nobody_);
    Time recorded;
    std::size_t found = 0;
    while (dialogue_.take(data_, recorded)) ++found;
    return found;
  }

 private:
  struct Nobody : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody_;
  Time now_{std::chrono::seconds(1000)};
  Dialog dialogue_;
  Data data_;
};

template <class Dialog, class Settings>
std::unique_ptr<Decoder> listen() {
  return std::make_unique<DialogueDecoder<Dialog, LadarData>>(
      Dialog(Settings{.only_listen = true}));
}
std::unique_ptr<Decoder> listen_to_lux() {
  return std::make_unique<DialogueDecoder<IbeoLux, LadarData>>(IbeoLux({}));
}
std::unique_ptr<Decoder> listen_to_velodyne() {
  return std::make_unique<DialogueDecoder<Velodyne, Scan3dData>>(Velodyne({}));
}
std::unique_ptr<Decoder> listen_to_ouster() {
  const auto metadata = OusterMetadata::parse(emulator::OusterScanner::metadata());
  return std::make_unique<DialogueDecoder<Ouster, Scan3dData>>(Ouster(*metadata, {}));
}

template <class Kind>
std::unique_ptr<Decoder> make() {
  return std::make_unique<Kind>();
}

// --- streams

Bytes cola_scan_of(ColaDialect dialect) {
  const emulator::Room room;
  ColaScan scan{.version = 1, .scan_frequency = 2500};
  scan.channels.resize(2);
  scan.channel_count = 2;
  for (std::size_t i = 0; i < 2; ++i) {
    ColaChannel& channel = scan.channels[i];
    std::ranges::copy(std::string_view(i == 0 ? "DIST1" : "RSSI1"), channel.content.begin());
    channel.start_angle = -50000;
    channel.step = 1667;
    channel.is_wide = i == 0;
    for (int value = 0; value < 1141; ++value)
      channel.values.push_back(
          static_cast<std::uint16_t>(i == 0 ? room.distance(value * 0.0029) : 100 + value % 150));
  }
  Bytes body;
  append_cola_scan(body, dialect, scan);
  Bytes telegram;
  append_cola(telegram, dialect, body);
  return telegram;
}

Bytes lms200_scan() {
  const emulator::Room room;
  Bytes body = {std::byte{0xB0}, std::byte{0xB5}, std::byte{0x40}};  // 181 values, millimetres
  for (int i = 0; i < 181; ++i) {
    const auto value = static_cast<unsigned>(room.distance((90 - i) * 0.01745));
    body.push_back(static_cast<std::byte>(value));
    body.push_back(static_cast<std::byte>(value >> 8));
  }
  body.push_back(std::byte{0x10});
  Bytes telegram;
  append_lms200(telegram, body, 0x80);
  return telegram;
}

Bytes s300_scan() {
  Bytes blocks;
  emulator::append_sick_s_scan(blocks, SickSDevice::kS300, {});
  Bytes telegram;
  append_sick_s(telegram, {.address = 7, .scan_number = 1, .blocks = blocks});
  return telegram;
}

Bytes compact_segment() {
  Bytes datagram;
  emulator::append_compact(datagram, {}, 1, 1, 1000000, 1050000);
  return datagram;
}

// What an emulator says to a driver in a while.
template <class Host, class Device>
Bytes said_by(Device device, Host host) {
  // Nine turns of an Ouster: when they begin anew, it is no datagram that comes late.
  constexpr std::size_t kEnough = 1 << 21;
  Bytes said;
  emulator::VirtualLine line(host, device, {.is_bus = true});
  line.set_lose([&](bool from_host, std::span<const std::byte> bytes) {
    if (!from_host) said.insert(said.end(), bytes.begin(), bytes.end());
    return false;
  });
  line.start();
  line.run(std::chrono::minutes(2), [&] { return said.size() >= kEnough; });
  return said;
}

template <std::uint8_t kType>
Bytes rplidar_says() {
  return said_by(emulator::Rplidar({.type = kType, .points_a_second = 16'000, .range = 25}),
                 Rplidar({.has_rate = false, .only_points = kType == rplidar::kPoints}));
}

Bytes ouster_says() {
  const auto metadata = OusterMetadata::parse(emulator::OusterScanner::metadata());
  return said_by(emulator::OusterScanner(), Ouster(*metadata, {}));
}

// --- what is measured

struct Case {
  std::string_view name;
  Bytes (*telegram)();  // of its device: one that carries data
  std::unique_ptr<Decoder> (*decoder)();
  std::size_t piece;  // bytes that come at once; 0: whole telegrams
  double target;      // MB/s
};

constexpr std::size_t kSegment = 1448;  // of TCP
constexpr std::size_t kSerial = 64;
constexpr std::size_t kOusterBytes = 3328;  // a datagram of 16 columns of 16 beams

constexpr std::array kCases = {
    Case{"cola-b", [] { return cola_scan_of(ColaDialect::kBinary); }, make<ColaDecoder>, kSegment,
         100},
    Case{"cola-a", [] { return cola_scan_of(ColaDialect::kAscii); }, make<ColaDecoder>, kSegment,
         100},
    Case{"lms200", lms200_scan, make<Lms200Decoder>, kSerial, 100},
    Case{"sick-s", s300_scan, make<SickSDecoder>, kSerial, 200},
    Case{"sick-compact", compact_segment, make<CompactDecoder>, 0, 200},
    Case{"hokuyo", [] { return said_by(emulator::Hokuyo(), Hokuyo({})); },
         listen<Hokuyo, HokuyoSettings>, kSerial, 200},
    Case{"ibeo-lux", [] { return said_by(emulator::IbeoLux(), IbeoLux({})); }, listen_to_lux,
         kSegment, 200},
    Case{"ld19", [] { return said_by(emulator::Ld19(), Ld19({})); }, listen<Ld19, Ld19Settings>,
         kSerial, 200},
    Case{"rplidar-81", rplidar_says<rplidar::kPoints>, listen<Rplidar, RplidarSettings>, kSerial,
         200},
    Case{"rplidar-82", rplidar_says<rplidar::kPairs>, listen<Rplidar, RplidarSettings>, kSerial,
         200},
    Case{"rplidar-84", rplidar_says<rplidar::kTriples>, listen<Rplidar, RplidarSettings>, kSerial,
         200},
    Case{"rplidar-85", rplidar_says<rplidar::kDense>, listen<Rplidar, RplidarSettings>, kSerial,
         200},
    Case{"velodyne", [] { return said_by(emulator::VelodyneScanner(), Velodyne({})); },
         listen_to_velodyne, velodyne::kBytes, 200},
    Case{"ouster", ouster_says, listen_to_ouster, kOusterBytes, 200},
};

// About a megabyte, again and again.
Bytes repeated(const Bytes& telegram) {
  constexpr std::size_t kSize = 1 << 20;
  Bytes stream;
  while (stream.size() < kSize) stream.insert(stream.end(), telegram.begin(), telegram.end());
  return stream;
}

Bytes recorded(const char* path) {
  std::ifstream file(path);
  Bytes stream;
  CaptureRecord record;
  for (std::string line; std::getline(file, line);)
    if (const auto good = parse_record(line, record); good && *good)
      stream.insert(stream.end(), record.bytes.begin(), record.bytes.end());
  return stream;
}

std::size_t decode(Decoder& decoder, std::span<const std::byte> stream, std::size_t piece) {
  std::size_t found = 0;
  while (!stream.empty()) {
    const auto next = stream.first(std::min(piece, stream.size()));
    found += decoder.take(next);
    stream = stream.subspan(next.size());
  }
  return found;
}

// 10^6 bytes a second: the best of some turns, so that other work does not count.
double speed(std::size_t bytes, const std::function<void()>& work) {
  constexpr int kTurns = 20;
  double best = 1e9;
  for (int i = 0; i < kTurns; ++i) {
    const auto begin = Stopwatch::now();
    work();
    best = std::min(best, std::chrono::duration<double>(Stopwatch::now() - begin).count());
  }
  return static_cast<double>(bytes) / best / 1e6;
}

double copy_speed(const Bytes& stream) {
  Bytes copy(stream.size());
  return speed(stream.size(), [&] {
    std::memcpy(copy.data(), stream.data(), stream.size());
    asm volatile("" : : "r"(copy.data()) : "memory");
  });
}

void measure(const Case& one, const Bytes& stream) {
  const auto decoder = one.decoder();
  const std::size_t piece = one.piece == 0 ? one.telegram().size() : one.piece;
  const std::size_t found = decode(*decoder, stream, piece);
  const double decoded = speed(stream.size(), [&] { (void)decode(*decoder, stream, piece); });
  const double copied = copy_speed(stream);
  std::printf("%-14s %8zu bytes %6zu data sets %8.0f MB/s   memcpy %8.0f MB/s   %6.1f x   %s\n",
              one.name.data(), stream.size(), found, decoded, copied, copied / decoded,
              decoded >= one.target ? "met" : "NOT met");
}

int run(int argc, char** argv) {
  const std::string_view wanted = argc > 1 ? argv[1] : "";
  bool is_known = wanted.empty();
  for (const Case& one : kCases) {
    if (!wanted.empty() && wanted != one.name) continue;
    is_known = true;
    measure(one, argc > 2 ? recorded(argv[2]) : repeated(one.telegram()));
  }
  if (is_known) return 0;
  std::fprintf(stderr, "devices_bench: no decoder %s; they are:", argv[1]);
  for (const Case& one : kCases) std::fprintf(stderr, " %s", one.name.data());
  std::fprintf(stderr, "\n");
  return 2;
}

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) { return rack::device::run(argc, argv); }
