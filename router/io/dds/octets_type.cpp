#include "router/io/dds/octets_type.h"

#include <algorithm>
#include <cstring>

namespace tims::io {
namespace {

constexpr std::array<unsigned char, 4> kLittleEndianCdr{0, 1, 0, 0};

std::size_t serialized_size(const OctetsOut& sample) {
  return kLittleEndianCdr.size() + sample.parts[0].size() + sample.parts[1].size();
}

}  // namespace

void OctetsIn::assign(std::span<const std::byte> bytes) {
  if (!memory_) memory_ = std::make_unique_for_overwrite<std::byte[]>(kSampleBytesMax);
  size_ = bytes.size() <= kSampleBytesMax ? bytes.size() : 0;
  if (size_ > 0) std::memcpy(memory_.get(), bytes.data(), size_);
}

OctetsType::OctetsType() {
  setName(kName);
  m_typeSize = kSampleBytesMax + kLittleEndianCdr.size();
  m_isGetKeyDefined = false;
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool OctetsType::serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) {
  const auto& sample = *static_cast<const OctetsOut*>(data);
  const std::size_t size = serialized_size(sample);
  if (size > payload->max_size) return false;
  payload->encapsulation = CDR_LE;
  payload->length = static_cast<std::uint32_t>(size);
  unsigned char* to = std::ranges::copy(kLittleEndianCdr, payload->data).out;
  for (const auto part : sample.parts) {
    if (!part.empty()) std::memcpy(to, part.data(), part.size());
    to += part.size();
  }
  return true;
}

bool OctetsType::deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) {
  const std::span all(payload->data, payload->length);
  const std::size_t header = std::min(all.size(), kLittleEndianCdr.size());
  static_cast<OctetsIn*>(data)->assign(std::as_bytes(all.subspan(header)));
  return true;
}

std::function<std::uint32_t()> OctetsType::getSerializedSizeProvider(void* data) {
  return [data] {
    return static_cast<std::uint32_t>(serialized_size(*static_cast<const OctetsOut*>(data)));
  };
}

}  // namespace tims::io
