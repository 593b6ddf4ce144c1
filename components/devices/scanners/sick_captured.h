// For tests only: reads recordings in tests/data/devices/sick.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "rack/devices/capture.h"

namespace rack::device {

inline std::vector<CaptureRecord> captured(const std::string& name) {
  std::ifstream file(DEVICE_DATA "/sick/" + name);
  if (!file) throw std::runtime_error("cannot open " DEVICE_DATA "/sick/" + name);
  std::vector<CaptureRecord> records;
  for (std::string line; std::getline(file, line);) {
    CaptureRecord record;
    const auto good = parse_record(line, record);
    if (!good) throw std::runtime_error(good.error().detail());
    if (*good) records.push_back(record);
  }
  return records;
}

inline std::vector<std::byte> stream_of(const std::vector<CaptureRecord>& records) {
  std::vector<std::byte> stream;
  for (const CaptureRecord& record : records)
    stream.insert(stream.end(), record.bytes.begin(), record.bytes.end());
  return stream;
}

}  // namespace rack::device
