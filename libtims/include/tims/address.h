// Mailbox addresses: a 32-bit number of four fields, most significant first:
// system, class, instance, local. Text forms: "Ladar(3/0)", "Ladar(3/0):2" and "0x03140002".
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tims/export.h"

namespace tims {

// Bits of each field; they add up to 32. One fleet uses one set of widths.
struct AddressWidths {
  std::uint8_t system = 8;
  std::uint8_t class_id = 8;
  std::uint8_t instance = 8;
  std::uint8_t local = 8;

  [[nodiscard]] constexpr bool valid() const {
    return system + class_id + instance + local == 32 && system > 0 && class_id > 0 &&
           instance > 0 && local > 0;
  }
  bool operator==(const AddressWidths&) const = default;
};

// Class ids of the original (specification, section 2.2) and ours.
namespace class_id {
inline constexpr std::uint32_t kTims = 0x00;  // routers: instance = router id
inline constexpr std::uint32_t kGdos = 0x01;  // text sink
inline constexpr std::uint32_t kGui = 0x02;
inline constexpr std::uint32_t kTool = 0x0F;  // mailboxes of command-line tools
inline constexpr std::uint32_t kTest = 0x10;
inline constexpr std::uint32_t kChassis = 0x11;
inline constexpr std::uint32_t kOdometry = 0x12;
inline constexpr std::uint32_t kPosition = 0x13;
inline constexpr std::uint32_t kLadar = 0x14;
inline constexpr std::uint32_t kCamera = 0x15;
inline constexpr std::uint32_t kGps = 0x16;
inline constexpr std::uint32_t kJoystick = 0x17;
inline constexpr std::uint32_t kPilot = 0x18;
inline constexpr std::uint32_t kScan2d = 0x19;
inline constexpr std::uint32_t kDatalog = 0x1A;
inline constexpr std::uint32_t kObjRecog = 0x1B;
inline constexpr std::uint32_t kClock = 0x1C;
inline constexpr std::uint32_t kVehicle = 0x1D;
inline constexpr std::uint32_t kGyro = 0x1E;
inline constexpr std::uint32_t kIo = 0x1F;
inline constexpr std::uint32_t kServoDrive = 0x20;
inline constexpr std::uint32_t kScan3d = 0x21;
inline constexpr std::uint32_t kPlanner = 0x22;
inline constexpr std::uint32_t kFeatureMap = 0x23;
inline constexpr std::uint32_t kGridMap = 0x24;
inline constexpr std::uint32_t kPath = 0x25;
inline constexpr std::uint32_t kMcl = 0x26;
inline constexpr std::uint32_t kPtzDrive = 0x27;
inline constexpr std::uint32_t kCompass = 0x28;
}  // namespace class_id

class TIMS_API Address {
 public:
  struct Fields {
    std::uint32_t system = 0;
    std::uint32_t class_id = 0;
    std::uint32_t instance = 0;
    std::uint32_t local = 0;
  };

  constexpr Address() = default;
  constexpr explicit Address(std::uint32_t raw) : raw_(raw) {}
  // Values that exceed the width of their field are truncated.
  static constexpr Address of(const Fields& f, const AddressWidths& w = {}) {
    std::uint32_t raw = f.system & mask(w.system);
    raw = raw << w.class_id | (f.class_id & mask(w.class_id));
    raw = raw << w.instance | (f.instance & mask(w.instance));
    raw = raw << w.local | (f.local & mask(w.local));
    return Address(raw);
  }

  [[nodiscard]] constexpr std::uint32_t raw() const { return raw_; }
  [[nodiscard]] constexpr Fields fields(const AddressWidths& w = {}) const {
    return {raw_ >> (32 - w.system) & mask(w.system),
            raw_ >> (w.instance + w.local) & mask(w.class_id), raw_ >> w.local & mask(w.instance),
            raw_ & mask(w.local)};
  }

  // "Ladar(3/0)"; ":2" is appended when the local id is not 0. An unknown class is printed as
  // "unknown[ff](3/0)", as in the original GUI.
  [[nodiscard]] std::string to_string(const AddressWidths& w = {}) const;
  // The same text, written to `room` and cut at its end; allocates nothing.
  [[nodiscard]] std::string_view write_to(std::span<char> room, const AddressWidths& w = {}) const;
  // "0x03140002"
  [[nodiscard]] std::string to_hex() const;
  // Accepts both text forms and decimal numbers. Class names are case-insensitive.
  static std::optional<Address> parse(std::string_view text, const AddressWidths& w = {});
  // Why parse() or AddressPattern::parse() refuses this text: "no class is called Lader", "instance
  // 500 is out of range: 0 to 255 with the address widths of this fleet". Empty: the form is wrong.
  static std::string problem(std::string_view text, const AddressWidths& w = {});

  auto operator<=>(const Address&) const = default;

 private:
  static constexpr std::uint32_t mask(std::uint8_t bits) { return (1U << bits) - 1; }
  std::uint32_t raw_ = 0;
};

// Every component of every robot sends its log texts to this address: GDOS(0/0). Each host can have
// its own text sink: routers never advertise this address to each other, so a text is delivered to
// the nearest sink on its path up the tree.
constexpr Address text_sink(const AddressWidths& w = {}) {
  return Address::of({.class_id = class_id::kGdos}, w);
}

// "*", "Ladar(*/*)", "*(3/0)", "Ladar(3/0):*", "0x03140002". A form with parentheses and without
// ":local" matches every local id, that is, all mailboxes of the component.
class TIMS_API AddressPattern {
 public:
  AddressPattern() = default;  // matches everything
  static std::optional<AddressPattern> parse(std::string_view text, const AddressWidths& w = {});
  [[nodiscard]] bool matches(Address a) const { return (a.raw() & mask_) == value_; }

 private:
  std::uint32_t mask_ = 0;
  std::uint32_t value_ = 0;
};

// Printed name of a class id ("Ladar"); empty when the class has no name.
TIMS_API std::string_view class_name(std::uint32_t class_id);
// Class id of a printed name; case-insensitive.
TIMS_API std::optional<std::uint32_t> class_id_of(std::string_view name);
// Registers a name for a class of components that RACK does not define. This program then reads and
// writes "Thermometer(0/0)" instead of "unknown[80](0/0)". Call it before the program starts
// threads; `name` must remain valid. Returns false when the number or the name belongs to another
// class, or when 64 names are registered already.
TIMS_API bool name_class(std::uint32_t class_id, std::string_view name);

}  // namespace tims

template <>
struct std::hash<tims::Address> {
  std::size_t operator()(tims::Address a) const noexcept {
    return static_cast<std::size_t>(a.raw() * 0x9E3779B97F4A7C15ULL);
  }
};
