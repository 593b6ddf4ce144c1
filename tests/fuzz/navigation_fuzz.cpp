// The data of a receiver, gyro, compass or radio clock do not depend on how its stream is divided,
// and they are valid: positions on the Earth, angles, times.
#include <cmath>
#include <string>
#include <vector>

#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/dcf77.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ublox.h"
#include "components/devices/positioning/xsens.h"
#include "tests/fuzz/finite.h"

namespace {

using namespace rack::device;
using Story = std::vector<std::string>;

class NoOutput : public Output {
 public:
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void drain(NmeaLines& lines, Story& story) {
  NmeaSentence sentence;
  while (lines.next(sentence)) {
    story.emplace_back(sentence.type);
    for (std::size_t i = 0; i < sentence.count; ++i) story.emplace_back(sentence.fields[i]);
  }
}

void drain(UbxStream& stream, Story& story) {
  UbxFrame frame;
  NmeaSentence sentence;
  for (auto what = stream.next(frame, sentence); what != UbxStream::What::kNothing;
       what = stream.next(frame, sentence))
    story.push_back(what == UbxStream::What::kFrame ? text_of(frame.payload)
                                                    : std::string(sentence.type));
}

void drain(XsensMessages& messages, Story& story) {
  XsensMessage message;
  while (messages.next(message)) {
    story.push_back(text_of(message.data));
    XsensSample sample;
    if (!decode_xsens(message, sample)) continue;
    rack::GyroData data;
    for (const auto mounting :
         {XsensMounting::kUnchanged, XsensMounting::kLabelUp, XsensMounting::kLabelDown})
      if (to_gyro(sample, mounting, data)) tims::fuzz::require_finite(data);
  }
}

template <class Decoder>
Story read(std::span<const std::byte> stream, std::size_t piece) {
  Decoder decoder;
  Story story;
  while (!stream.empty()) {
    const auto next = stream.first(std::min(piece, stream.size()));
    stream = stream.subspan(next.size());
    decoder.add({.bytes = next});
    drain(decoder, story);
  }
  return story;
}

template <class Decoder>
void run(std::span<const std::byte> stream, std::size_t piece) {
  const Story whole = read<Decoder>(stream, Decoder::kPieceMax);
  tims::fuzz::require(read<Decoder>(stream, piece) == whole);
  tims::fuzz::require(read<Decoder>(stream, 1) == whole);
}

void check(const rack::GpsData& data) {
  constexpr double kHalfTurn = 3.1415927;
  constexpr double kOfUbx = 6.4;  // rad; the 32-bit number can exceed the valid range
  tims::fuzz::require(std::abs(data.latitude) <= kOfUbx && std::abs(data.longitude) <= kOfUbx);
  tims::fuzz::require(data.heading >= 0 && data.heading <= 2 * kHalfTurn + 1e-3);
}
void check(const rack::GyroData&) {}
void check(const rack::CompassData& data) { tims::fuzz::require(data.orientation >= 0); }
void check(const rack::ClockData& data) {
  tims::fuzz::require(data.hour <= 23 && data.month >= 1 && data.month <= 12);
}

// Time passes between the pieces, and the dialogue is restarted after failures.
template <class Data, class Dialog>
void talk(Dialog& dialogue, std::span<const std::byte> stream, std::size_t piece) {
  NoOutput out;
  Time now{std::chrono::seconds(1)};
  dialogue.start(now, out);
  while (!stream.empty()) {
    const auto next = stream.first(std::min(piece, stream.size()));
    stream = stream.subspan(next.size());
    now += std::chrono::milliseconds(50);
    dialogue.on_arrival({.bytes = next, .first = now, .last = now}, out);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, out);
    if (dialogue.failure()) dialogue.start(now, out);
    Data data;
    Time recorded;
    if (!dialogue.take(data, recorded)) continue;
    tims::fuzz::require_finite(data);
    check(data);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const std::size_t piece = std::size_t{input.number<std::uint8_t>()} + 1;
  const auto stream = input.rest();
  run<NmeaLines>(stream, piece);
  run<UbxStream>(stream, piece);
  run<XsensMessages>(stream, piece);
  NmeaReceiver receiver({});
  talk<rack::GpsData>(receiver, stream, piece);
  Ublox ublox({.baud = 115200});
  talk<rack::GpsData>(ublox, stream, piece);
  Xsens xsens({});
  talk<rack::GyroData>(xsens, stream, piece);
  Cmps03 compass({});
  talk<rack::CompassData>(compass, stream, piece);
  for (const Dcf77Kind kind : {Dcf77Kind::kMeinberg, Dcf77Kind::kEmcPro}) {
    Dcf77 clock(kind);
    talk<rack::ClockData>(clock, stream, piece);
  }
  return 0;
}
