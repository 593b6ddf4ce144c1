// Tests need no router: what is computed, and that the messages are what others expect.
#include "thermometer.h"

#include <cstdio>
#include <vector>

#include "smoothing.h"

namespace {

int failures = 0;

void expect(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "failed: %s\n", what);
  ++failures;
}

void smoothing() {
  thermometer::Smoothing three(3);
  for (const int sample : {1, 2, 3, 7}) three.add(sample);
  expect(three.mean() == 4, "the mean is of the last three");
}

void messages() {
  const thermometer::ThermometerData sent{.recordingTime = 5, .samples = {1, 2}};
  std::vector<std::byte> body(rack::encoded_size(sent));
  expect(rack::encode(sent, body, std::endian::big).ok(), "data can be sent");
  expect(body.size() == 25, "data are 17 bytes, and 4 for each sample");
  const auto got = rack::decode<thermometer::ThermometerData>(body, std::endian::big);
  expect(got && got->samples.size() == 2 && got->samples[1] == 2, "data arrive as they were sent");
  expect(rack::message_file(thermometer::kThermometerClass).ok(), "all messages can be described");
}

}  // namespace

int main() {
  smoothing();
  messages();
  return failures == 0 ? 0 : 1;
}
