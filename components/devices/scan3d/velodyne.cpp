#include "components/devices/scan3d/velodyne.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "rack/devices/stream_buffer.h"

namespace rack::device {
namespace {

using namespace velodyne;

constexpr std::uint16_t kBlockMark = 0xEEFF;
constexpr std::uint64_t kHour = 3'600'000'000;  // us
constexpr double kVelodyneRadians = std::numbers::pi / 180;
constexpr Duration kVelodyneFirstWithin = std::chrono::seconds(3);
// A head turns by 0.1 to 0.8 degrees per block: a larger difference means that a datagram is
// missing.
constexpr std::uint32_t kTurnedMax = 400;

constexpr std::array<VelodyneLaser, 16> kVlp16 = {{{-15, 0, 11.2},
                                                   {1, 0, -0.7},
                                                   {-13, 0, 9.7},
                                                   {3, 0, -2.2},
                                                   {-11, 0, 8.1},
                                                   {5, 0, -3.7},
                                                   {-9, 0, 6.6},
                                                   {7, 0, -5.1},
                                                   {-7, 0, 5.1},
                                                   {9, 0, -6.6},
                                                   {-5, 0, 3.7},
                                                   {11, 0, -8.1},
                                                   {-3, 0, 2.2},
                                                   {13, 0, -9.7},
                                                   {-1, 0, 0.7},
                                                   {15, 0, -11.2}}};

constexpr std::array<VelodyneLaser, 16> kHiRes = {{{-10, 0, 7.4},
                                                   {0.67, 0, -0.9},
                                                   {-8.67, 0, 6.5},
                                                   {2, 0, -1.8},
                                                   {-7.33, 0, 5.5},
                                                   {3.33, 0, -2.7},
                                                   {-6, 0, 4.6},
                                                   {4.67, 0, -3.7},
                                                   {-4.67, 0, 3.7},
                                                   {6, 0, -4.6},
                                                   {-3.33, 0, 2.7},
                                                   {7.33, 0, -5.5},
                                                   {-2, 0, 1.8},
                                                   {8.67, 0, -6.5},
                                                   {-0.67, 0, 0.9},
                                                   {10, 0, -7.4}}};

constexpr std::array<VelodyneLaser, 32> kVlp32 = {
    {{-25, 1.4},    {-1, -4.2},     {-1.667, 1.4}, {-15.639, -1.4}, {-11.31, 1.4}, {0, -1.4},
     {-0.667, 4.2}, {-8.843, -1.4}, {-7.254, 1.4}, {0.333, -4.2},   {-0.333, 1.4}, {-6.148, -1.4},
     {-5.333, 4.2}, {1.333, -1.4},  {0.667, 4.2},  {-4, -1.4},      {-4.667, 1.4}, {1.667, -4.2},
     {1, 1.4},      {-3.667, -4.2}, {-3.333, 4.2}, {3.333, -1.4},   {2.333, 1.4},  {-2.667, -1.4},
     {-3, 1.4},     {7, -1.4},      {4.667, 1.4},  {-2.333, -4.2},  {-2, 4.2},     {15, -1.4},
     {10.333, 1.4}, {-1.333, -1.4}}};

// Two interleaved fans of 16 lasers: from -30.67 and from -9.33 degrees, with a step of 4/3
// degrees.
constexpr std::array<VelodyneLaser, 32> make_hdl32() {
  std::array<VelodyneLaser, 32> lasers{};
  for (std::size_t i = 0; i < lasers.size(); ++i)
    lasers.at(i).elevation =
        (i % 2 == 0 ? -92.0 : -28.0) / 3 + 4.0 / 3 * static_cast<double>(i / 2);
  return lasers;
}
constexpr std::array<VelodyneLaser, 32> kHdl32 = make_hdl32();

}  // namespace

const VelodyneLayout* velodyne_layout(std::uint8_t model) {
  static constexpr VelodyneLayout kOfVlp16{kVlp16, 2.304, 55.296, 1, 2, 131'070};
  static constexpr VelodyneLayout kOfHiRes{kHiRes, 2.304, 55.296, 1, 2, 131'070};
  static constexpr VelodyneLayout kOfHdl32{kHdl32, 1.152, 46.08, 1, 2, 131'070};
  static constexpr VelodyneLayout kOfVlp32{kVlp32, 2.304, 55.296, 2, 4, 262'140};
  switch (static_cast<VelodyneModel>(model)) {
    case VelodyneModel::kVlp16:
      return &kOfVlp16;
    case VelodyneModel::kPuckHiRes:
      return &kOfHiRes;
    case VelodyneModel::kHdl32:
      return &kOfHdl32;
    case VelodyneModel::kVlp32:
      return &kOfVlp32;
  }
  // Variants of the VLP-16 have their own model numbers.
  return (model & 0xF0) == 0x10 ? &kOfVlp16 : nullptr;
}

Velodyne::Velodyne(const SpinSettings& settings)
    : scan_(settings), directions_(kTurn), clock_(std::chrono::microseconds(1), kHour) {
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const double angle = static_cast<double>(i) / 100 * kVelodyneRadians + settings.direction;
    directions_[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }
}

void Velodyne::start(Time now, Output&) {
  clear_failure();
  timer_.wait_until(now + kVelodyneFirstWithin);
  scan_.clear();
  clock_.reset();
  has_received_ = false;
  last_head_ = 0;
}

void Velodyne::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  fail(tims::Errc::kTimeout,
       "no data of a Velodyne at this port; check that its destination is this host");
}

void Velodyne::set_model(std::uint8_t model) {
  model_ = model;
  layout_ = velodyne_layout(model);
  if (layout_ == nullptr) {
    fail(tims::Errc::kInvalidArgument, "unknown Velodyne model " + std::to_string(model) +
                                           "; supported are VLP-16, HDL-32E, VLP-32C");
    return;
  }
  beams_.clear();
  for (const VelodyneLaser& laser : layout_->lasers) {
    const double up = laser.elevation * kVelodyneRadians;
    const auto rank = std::ranges::count_if(layout_->lasers, [&](const VelodyneLaser& other) {
      return other.elevation < laser.elevation;
    });
    const auto aside = static_cast<std::int32_t>(std::lround(laser.azimuth * 100));
    beams_.push_back(
        {.level = static_cast<float>(std::cos(up)),
         .down = static_cast<float>(-std::sin(up)),
         .begin = static_cast<float>(-laser.above),
         .azimuth = static_cast<std::uint32_t>(aside + static_cast<std::int32_t>(kTurn)),
         .rank = static_cast<std::size_t>(rank)});
  }
  scan_.clear();
  scan_.set_device(layout_->range_max, model);
}

void Velodyne::on_arrival(const Arrival& arrival, Output&) {
  const auto bytes = arrival.bytes;
  bool is_good = bytes.size() >= kBytes;
  for (std::size_t i = 0; is_good && i < kBlocks; ++i)
    is_good = little_endian<std::uint16_t>(bytes, i * kBlockBytes) == kBlockMark &&
              little_endian<std::uint16_t>(bytes, i * kBlockBytes + 2) < kTurn;
  if (!is_good) {
    ++broken_;
    return;
  }
  has_received_ = true;
  timer_.stop();
  const auto tail = bytes.last(kTailBytes);
  const auto model = std::to_integer<std::uint8_t>(tail[5]);
  if (model != model_ || layout_ == nullptr) set_model(model);
  if (layout_ == nullptr) return;
  // In dual return mode, the odd blocks contain the stronger echo.
  const std::size_t step = tail[4] == std::byte{kDualReturn} ? 2 : 1;
  const double block_us =
      layout_->sequence_us * static_cast<double>(kReturns) / static_cast<double>(beams_.size());
  const auto time_of = [&](std::size_t blocks) {
    return std::chrono::nanoseconds(std::llround(block_us * 1000 * static_cast<double>(blocks)));
  };
  // The datagram was sent after its last block was measured.
  const auto whole = time_of(kBlocks / step);
  const auto began = little_endian<std::uint32_t>(tail);
  const auto ended = began + static_cast<std::uint64_t>(whole / std::chrono::microseconds(1));
  const Time end = clock_.to_host(ended % kHour, arrival.last);
  const auto azimuth = [&](std::size_t i) -> std::uint32_t {
    return little_endian<std::uint16_t>(bytes, i * kBlockBytes + 2);
  };
  std::uint32_t turned = 0;
  for (std::size_t i = step - 1; i < kBlocks; i += step) {
    if (i + step < kBlocks) turned = (azimuth(i + step) + kTurn - azimuth(i)) % kTurn;
    if (turned > kTurnedMax) turned = 0;
    take_block(bytes.subspan(i * kBlockBytes + 4, 3 * kReturns), azimuth(i), turned,
               end - whole + time_of(i / step));
  }
}

// `turned`: rotation until the next block, 1/100 degree.
void Velodyne::take_block(std::span<const std::byte> block, std::uint32_t azimuth,
                          std::uint32_t turned, Time began) {
  const std::size_t lasers = beams_.size();
  const std::size_t sequences = kReturns / lasers;
  const auto sectors = static_cast<std::uint32_t>(scan_.settings().sectors);
  const double turned_in_us = turned / (layout_->sequence_us * static_cast<double>(sequences));
  for (std::size_t s = 0; s < sequences; ++s) {
    const double since = layout_->sequence_us * static_cast<double>(s);
    const auto head = (azimuth + static_cast<std::uint32_t>(turned_in_us * since)) % kTurn;
    const Time when = began + std::chrono::nanoseconds(std::llround(since * 1000));
    // A turn begins at the front.
    const bool is_new_turn = last_head_ > head + kTurn / 2;
    last_head_ = head;
    const auto points =
        scan_.add(static_cast<int>(head * sectors / kTurn), is_new_turn, when, lasers);
    if (points.empty()) continue;
    const float turned_in_firing = static_cast<float>(turned_in_us * layout_->firing_us);
    for (std::size_t i = 0; i < lasers; ++i) {
      const std::size_t at = 3 * (s * lasers + i);
      const Beam& beam = beams_[i];
      const i32 range = little_endian<std::uint16_t>(block, at) * layout_->range_unit;
      const auto firing = static_cast<float>(i / static_cast<std::size_t>(layout_->at_once));
      const auto aside = static_cast<std::uint32_t>(turned_in_firing * firing + 0.5F);
      const auto& direction = directions_[(head + beam.azimuth + aside) % kTurn];
      const float level = static_cast<float>(range) * beam.level;
      scan_.put(points[beam.rank], range, level * direction[0], level * direction[1],
                static_cast<float>(range) * beam.down + beam.begin,
                std::to_integer<i16>(block[at + 2]));
    }
  }
}

}  // namespace rack::device
