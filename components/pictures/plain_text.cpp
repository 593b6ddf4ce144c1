#include "components/pictures/plain_text.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/text.h"

namespace rack::pictures {
namespace {

struct Replacement {
  std::string_view characters;  // in UTF-8
  std::string_view ascii;
};
constexpr std::array kReplacements = {
    Replacement{"ÀÁÂÃÅĀĂĄ", "A"}, Replacement{"àáâãåāăą", "a"},
    Replacement{"ÇĆČ", "C"},      Replacement{"çćč", "c"},
    Replacement{"ĎĐ", "D"},       Replacement{"ďđ", "d"},
    Replacement{"ÈÉÊËĒĖĘĚ", "E"}, Replacement{"èéêëēėęě", "e"},
    Replacement{"Ğ", "G"},        Replacement{"ğ", "g"},
    Replacement{"ÌÍÎÏĪİ", "I"},   Replacement{"ìíîïīı", "i"},
    Replacement{"Ł", "L"},        Replacement{"ł", "l"},
    Replacement{"ÑŃŇ", "N"},      Replacement{"ñńň", "n"},
    Replacement{"ÒÓÔÕŌŐ", "O"},   Replacement{"òóôõōő", "o"},
    Replacement{"Ř", "R"},        Replacement{"ř", "r"},
    Replacement{"ŚŞŠȘ", "S"},     Replacement{"śşšș", "s"},
    Replacement{"ŢŤȚ", "T"},      Replacement{"ţťț", "t"},
    Replacement{"ÙÚÛŪŮŰ", "U"},   Replacement{"ùúûūůű", "u"},
    Replacement{"ÝŸ", "Y"},       Replacement{"ýÿ", "y"},
    Replacement{"ŹŻŽ", "Z"},      Replacement{"źżž", "z"},
    Replacement{"Ä", "Ae"},       Replacement{"ä", "ae"},
    Replacement{"ÖØ", "Oe"},      Replacement{"öøœ", "oe"},
    Replacement{"Ü", "Ue"},       Replacement{"ü", "ue"},
    Replacement{"Æ", "AE"},       Replacement{"æ", "ae"},
    Replacement{"ß", "ss"},       Replacement{"°", "deg"},
    Replacement{"µμ", "u"},       Replacement{"²", "^2"},
    Replacement{"³", "^3"},       Replacement{"·", "*"},
    Replacement{"×", "x"},        Replacement{"±", "+-"},
    Replacement{"‐‑‒–—−", "-"},   Replacement{"‘’‚", "'"},
    Replacement{"“”„", "\""},     Replacement{"…", "..."},
    Replacement{"→", "->"},       Replacement{"\u00A0\u2009\u202F", " "},
};

bool contains(std::string_view characters, std::uint32_t code) {
  while (!characters.empty()) {
    const auto character = tims::base::first_character(characters);
    if (character.code == code) return true;
    characters.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  return false;
}

std::string_view ascii_of(std::uint32_t code) {
  for (const Replacement& replacement : kReplacements)
    if (contains(replacement.characters, code)) return replacement.ascii;
  return "?";
}

}  // namespace

std::string plain_text(std::string_view utf8) {
  std::string out;
  while (!utf8.empty() && out.size() <= kPlainTextMax) {
    const auto character = tims::base::first_character(utf8);
    const bool is_ascii = character.bytes == 1 && !tims::base::is_control(character.code);
    if (is_ascii)
      out += utf8.front();
    else if (character.bytes == 0)
      out += '?';
    else
      out += ascii_of(character.code);
    utf8.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  if (out.size() > kPlainTextMax) {
    constexpr std::string_view kMore = "...";
    out.resize(kPlainTextMax - kMore.size());
    out += kMore;
  }
  return out;
}

}  // namespace rack::pictures
