// USB devices that we know: what they are, which of our programs drives them, which module of the
// kernel makes them a serial port, a CAN interface or a camera.
//
// The identifiers of converters (CP210x, FT232, CH340, PL2303) say nothing about what is behind
// them: for those the programs are only the likely ones.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace rack::device {

enum class UsbUse : std::uint8_t {
  kSerial,     // a device that is a serial port by itself
  kConverter,  // a serial port, and anything behind it
  kCan,        // a CAN interface
  kRaw,        // spoken to by way of libusb
};

struct KnownUsb {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  UsbUse use = UsbUse::kSerial;
  std::string_view name;      // of /dev/rack/NAME-SERIALNUMBER
  std::string_view device;    // for people
  std::string_view programs;  // of ours, "LadarRplidar, LadarHokuyoUrg"; empty: none
  std::string_view module;    // of the kernel; empty: it needs none
};

// By vendor and product, ascending.
std::span<const KnownUsb> known_usb();
// Or none.
const KnownUsb* find_usb(std::uint16_t vendor, std::uint16_t product);

}  // namespace rack::device
