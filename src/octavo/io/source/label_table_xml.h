// Labels in the XML of a GIFTI file.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// One element <Label Key="7" Red="1" Green="0.5" Blue="0">Left Lung</Label>.
struct XmlLabel {
  std::size_t line = 0;  ///< from 1
  std::string key;       ///< as it stands there
  std::array<std::string, 3> color;  ///< 0 to 255, in digits
  std::string name;
};

/// The labels of a table as GIFTI has it, of a whole file or of the table alone, in their order;
/// other elements are left out. Older files say Index for Key.
/// Throws  Error{source_rejected} beginning with the line, for an element that is cut off, lacks a
///         key or a color, or holds references other than numbers and those to & < > " and '
std::vector<XmlLabel> labels_in_xml(std::string_view text);

}  // namespace octavo
