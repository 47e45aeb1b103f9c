// The order in which texts give the numbers of sizes and places.
#pragma once

namespace octavo {

enum class TextOrder { xyz, zyx };

/// The order of size_text and point_text: x, y, z until this is called. To be called before others
/// call them, by programs whose users count z, y, x.
void set_text_order(TextOrder order) noexcept;

}  // namespace octavo
