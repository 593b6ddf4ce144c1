// What the library answers when it cannot make something.
#pragma once

#include <stdexcept>
#include <string>

namespace tims::io {

// Throws std::runtime_error for nullptr.
template <typename T>
T* require(T* made, const char* what) {
  if (made == nullptr) throw std::runtime_error(std::string("no ") + what + " could be made");
  return made;
}

}  // namespace tims::io
