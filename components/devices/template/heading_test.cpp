// Tests without device, router and waiting.
#include "heading.h"

#include <cmath>
#include <cstdio>
#include <span>

#include <rack/devices/virtual_line.h>

#include "heading_compass.h"

namespace {

using namespace std::chrono_literals;

int failures = 0;

void expect(bool good, std::string_view what) {
  if (good) return;
  std::fprintf(stderr, "failed: %.*s\n", static_cast<int>(what.size()), what.data());
  ++failures;
}

class Silent final : public rack::device::Output {
 public:
  void send(std::span<const std::byte>, std::uint32_t) override { ++sent; }
  int sent = 0;
};

void receive(heading::Heading& dialogue, std::string_view text, Silent& out) {
  dialogue.on_arrival({.bytes = std::as_bytes(std::span(text))}, out);
}

void every_split_gives_the_same() {
  const std::string_view text = "1.5\n90.0\n";  // begins in the middle of an answer
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    heading::Heading dialogue(100ms);
    Silent out;
    dialogue.start(tims::Time{1s}, out);
    receive(dialogue, text.substr(0, cut), out);
    receive(dialogue, text.substr(cut), out);
    rack::CompassData data;
    tims::Time recorded;
    expect(dialogue.take(data, recorded), "there are data");
    expect(std::abs(data.orientation.raw() - 1.5708F) < 1e-3F, "the newest heading is taken");
    expect(!dialogue.take(data, recorded), "data are taken once");
  }
}

void invalid_headings_are_rejected() {
  rack::CompassData data;
  for (const char* line : {"", " ", "-1", "360", "nan", "90x", "9e999", "\xFF\xFE"})
    expect(!heading::decode_heading(line, data), line);
}

void asks_at_its_period() {
  heading::Heading dialogue(100ms);
  Silent out;
  dialogue.start(tims::Time{1s}, out);
  for (tims::Time now{1s}; now <= tims::Time{2s}; now += 10ms) dialogue.on_timeout(now, out);
  expect(out.sent == 11, "asks every 100 ms");
}

// Driver and emulator on a simulated line with its rate; every fifth answer is lost.
void survives_lost_answers() {
  heading::Heading dialogue(100ms);
  heading::HeadingCompass compass;
  rack::device::emulator::VirtualLine line(
      dialogue, compass, {.has_rate = true, .host_baud = 9600, .device_baud = 9600, .piece = 1});
  int answers = 0;
  line.set_lose([&](bool from_host, auto) { return !from_host && ++answers % 5 == 0; });
  line.start();
  int data_sets = 0;
  rack::CompassData data;
  tims::Time recorded;
  line.run(10s, [&] {
    if (dialogue.take(data, recorded)) ++data_sets;
    return false;
  });
  expect(data_sets >= 75 && data_sets <= 81, "four of five answers of ten seconds arrive");
}

}  // namespace

int main() {
  every_split_gives_the_same();
  invalid_headings_are_rejected();
  asks_at_its_period();
  survives_lost_answers();
  return failures == 0 ? 0 : 1;
}
