// A folder with packages that is carried to hosts: its index as apt-ftparchive writes it, and which
// of its packages a host needs. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace timsctl::deploy {

struct Package {
  std::string name{};
  std::string version{};
  std::string architecture{};        // "amd64", "all"
  std::vector<std::string> needs{};  // names in Depends and Pre-Depends, with alternatives
  std::string file{};                // in the folder, without slashes
  std::string sha256{};
  std::uint64_t size = 0;   // bytes
  std::string paragraph{};  // as it is in the index
};

// The packages of an index. Those without a name, version, plain file name, size or checksum are
// left out.
std::vector<Package> packages_in(std::string_view index);

// As `dpkg --compare-versions`: negative, zero or positive.
int compare_versions(std::string_view a, std::string_view b);

// The newest of the wanted packages, and of all that they need as far as the folder has it.
std::vector<Package> needed(std::span<const Package> all, std::span<const std::string> wanted,
                            std::string_view architecture);

}  // namespace timsctl::deploy
