// The entry of librack-pictures (grey_picture.h: kReadGreySymbol).
#include "components/pictures/grey_picture.h"

extern "C" [[gnu::visibility("default")]] void rack_read_grey(
    const std::string_view& bytes, tims::Result<rack::pictures::GreyPicture>& picture) {
  picture = rack::pictures::read_grey(bytes);
}

static_assert(std::is_same_v<decltype(&rack_read_grey), rack::pictures::ReadGrey>);
