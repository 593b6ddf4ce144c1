#include "security/keys/fleet_list.h"

#include <algorithm>

#include "base/text.h"
#include "security/keys/bytes.h"
#include "security/keys/identity.h"

namespace tims::security {
namespace {

// magic, number, made, fleet, roots, revoked, issuing certificate; then the signature of all that.
constexpr std::string_view kMagic = "TIMSLST1";

std::array<std::byte, 16> serial_of(const Certificate& certificate) {
  std::string digits = certificate.serial();
  if (digits.size() % 2 != 0) digits.insert(digits.begin(), '0');
  const Bytes bytes = base::parse_hex(digits).value_or(Bytes());
  std::array<std::byte, 16> serial{};
  const std::size_t size = std::min(bytes.size(), serial.size());
  std::copy_n(bytes.end() - static_cast<std::ptrdiff_t>(size), size,
              serial.end() - static_cast<std::ptrdiff_t>(size));
  return serial;
}

Error damaged(std::string_view what) {
  return {Errc::kMalformed, "list of the fleet: " + std::string(what)};
}

bool is_trusted(const Certificate& signer, const std::vector<Certificate>& trusted) {
  return signer.is_authority() && std::ranges::any_of(trusted, [&](const Certificate& root) {
           return root == signer || (root.is_authority() && root.has_signed(signer));
         });
}

}  // namespace

Revoked Revoked::of(const Certificate& certificate) {
  return {serial_of(certificate), certificate.public_key_hash()};
}

void FleetList::revoke(const Certificate& certificate) {
  const Revoked entry = Revoked::of(certificate);
  revoked_.insert(entry);
  revoked_keys_.insert(entry.public_key);
  revoked_serials_.insert(entry.serial);
}

Bytes Revoked::to_bytes() const {
  Bytes bytes;
  append(bytes, serial);
  append(bytes, public_key);
  return bytes;
}

std::optional<Revoked> Revoked::from_bytes(View bytes) {
  Revoked entry;
  if (bytes.size() != entry.serial.size() + entry.public_key.size()) return std::nullopt;
  std::ranges::copy(bytes.first(entry.serial.size()), entry.serial.begin());
  std::ranges::copy(bytes.subspan(entry.serial.size()), entry.public_key.begin());
  return entry;
}

bool FleetList::revokes(const Revoked& entry) const {
  return revoked_keys_.contains(entry.public_key) || revoked_serials_.contains(entry.serial);
}

Result<Bytes> FleetList::sign(const Certificate& issuing, const PrivateKey& key) const {
  if (roots.empty() || roots.size() > kRootsMax || revoked_.size() > kEntriesMax)
    return Error(Errc::kTooBig, "list of the fleet: at most 8 roots and 20000 certificates");
  Bytes out;
  append(out, view_of(kMagic));
  append(out, number);
  append(out, static_cast<std::uint64_t>(made));
  append_counted<std::uint8_t>(out, view_of(fleet));
  append(out, static_cast<std::uint8_t>(roots.size()));
  for (const Certificate& root : roots) append_counted<std::uint16_t>(out, root.to_der());
  append(out, static_cast<std::uint32_t>(revoked_.size()));
  for (const Revoked& entry : revoked_) {
    append(out, entry.serial);
    append(out, entry.public_key);
  }
  append_counted<std::uint16_t>(out, issuing.to_der());
  auto signature = key.sign(out);
  if (!signature) return signature.error();
  append_counted<std::uint16_t>(out, *signature);
  return out;
}

std::uint64_t FleetList::number_of(View bytes) {
  Reader reader(bytes);
  const bool is_list = text_of(reader.take(kMagic.size())) == kMagic;
  const auto number = reader.number<std::uint64_t>();
  return is_list && reader.ok() ? number : 0;
}

Result<FleetList> FleetList::open(View bytes, const std::vector<Certificate>& trusted,
                                  std::string_view fleet) {
  if (bytes.size() > kBytesMax) return damaged("more than 1 MB");
  Reader reader(bytes);
  if (text_of(reader.take(kMagic.size())) != kMagic) return damaged("is none");
  FleetList list;
  list.number = reader.number<std::uint64_t>();
  list.made = static_cast<std::int64_t>(reader.number<std::uint64_t>());
  list.fleet = text_of(reader.counted<std::uint8_t>());
  const auto roots = reader.number<std::uint8_t>();
  if (roots == 0 || roots > kRootsMax) return damaged("must have 1 to 8 roots");
  std::vector<View> encoded;
  for (unsigned i = 0; i < roots; ++i) encoded.push_back(reader.counted<std::uint16_t>());
  const auto count = reader.number<std::uint32_t>();
  if (count > kEntriesMax) return damaged("more than 20000 certificates");
  const View entries = reader.take(count * sizeof(Revoked));
  const View issuing = reader.counted<std::uint16_t>();
  const View content = bytes.first(bytes.size() - reader.left().size());
  const View signature = reader.counted<std::uint16_t>();
  if (!reader.ok() || !reader.left().empty()) return damaged("is not complete");
  if (!is_name(list.fleet) || list.fleet != fleet)
    return damaged("is of the fleet \"" + base::printable(list.fleet) + "\"");

  // Nothing of it is looked at more closely before it is known who made it.
  const auto signer = Certificate::from_der(issuing);
  if (!signer) return damaged("the signer's certificate: " + signer.error().detail());
  if (!is_trusted(*signer, trusted)) return damaged("is not signed by this fleet's authority");
  if (!signer->verify(content, signature)) return damaged("its signature is wrong");

  for (const View der : encoded) {
    auto root = Certificate::from_der(der);
    if (!root || !root->is_authority()) return damaged("a root is no certificate of an authority");
    list.roots.push_back(std::move(*root));
  }
  Reader entry(entries);
  for (std::uint32_t i = 0; i < count; ++i) {
    Revoked one;
    std::ranges::copy(entry.take(one.serial.size()), one.serial.begin());
    std::ranges::copy(entry.take(one.public_key.size()), one.public_key.begin());
    list.revoked_.insert(one);
    list.revoked_keys_.insert(one.public_key);
    list.revoked_serials_.insert(one.serial);
  }
  return list;
}

}  // namespace tims::security
