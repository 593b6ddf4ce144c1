// Text for a font that has the characters of ASCII only. Pure.
#pragma once

#include <string>
#include <string_view>

namespace rack::pictures {

// Letters and signs of European languages and of units become those of ASCII: "ä" "ae", "é" "e",
// "°" "deg", "µ" "u". Each other character, and each byte that is not UTF-8, becomes '?'. Texts of
// more than kPlainTextMax characters end with "...".
std::string plain_text(std::string_view utf8);

inline constexpr std::size_t kPlainTextMax = 400;  // more than fit on a picture

}  // namespace rack::pictures
