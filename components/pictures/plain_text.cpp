#include "components/pictures/plain_text.h"

#include <algorithm>
#include <cstdint>

#include "base/text.h"

namespace rack::pictures {
namespace {

// A line for each replacement: what is written, a tab, the characters that it is written for.
constexpr std::string_view kReplacements =
    "A\tÀÁÂÃÅĀĂĄ\n"
    "a\tàáâãåāăą\n"
    "C\tÇĆČ\n"
    "c\tçćč\n"
    "D\tĎĐ\n"
    "d\tďđ\n"
    "E\tÈÉÊËĒĖĘĚ\n"
    "e\tèéêëēėęě\n"
    "G\tĞ\n"
    "g\tğ\n"
    "I\tÌÍÎÏĪİ\n"
    "i\tìíîïīı\n"
    "L\tŁ\n"
    "l\tł\n"
    "N\tÑŃŇ\n"
    "n\tñńň\n"
    "O\tÒÓÔÕŌŐ\n"
    "o\tòóôõōő\n"
    "R\tŘ\n"
    "r\tř\n"
    "S\tŚŞŠȘ\n"
    "s\tśşšș\n"
    "T\tŢŤȚ\n"
    "t\tţťț\n"
    "U\tÙÚÛŪŮŰ\n"
    "u\tùúûūůű\n"
    "Y\tÝŸ\n"
    "y\týÿ\n"
    "Z\tŹŻŽ\n"
    "z\tźżž\n"
    "Ae\tÄ\n"
    "ae\tä\n"
    "Oe\tÖØ\n"
    "oe\töøœ\n"
    "Ue\tÜ\n"
    "ue\tü\n"
    "AE\tÆ\n"
    "ae\tæ\n"
    "ss\tß\n"
    "deg\t°\n"
    "u\tµμ\n"
    "^2\t²\n"
    "^3\t³\n"
    "*\t·\n"
    "x\t×\n"
    "+-\t±\n"
    "-\t‐‑‒–—−\n"
    "'\t‘’‚\n"
    "\"\t“”„\n"
    "...\t…\n"
    "->\t→\n"
    " \t\u00A0\u2009\u202F\n";

bool contains(std::string_view characters, std::uint32_t code) {
  while (!characters.empty()) {
    const auto character = tims::base::first_character(characters);
    if (character.code == code) return true;
    characters.remove_prefix(std::max<std::size_t>(character.bytes, 1));
  }
  return false;
}

std::string_view ascii_of(std::uint32_t code) {
  for (std::string_view left = kReplacements; !left.empty();) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(line.size() + 1);
    const std::size_t tab = line.find('\t');
    if (contains(line.substr(tab + 1), code)) return line.substr(0, tab);
  }
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
