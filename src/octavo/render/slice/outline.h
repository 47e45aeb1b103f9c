// The border of labels on a section.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/render/slice/section_samples.h"

namespace octavo {

/// 1 for the pixels that draw the outlines of labels, [y][x]. A border pixel has a label other than
/// 0, and one of the four pixels beside it has another one or lies outside the volume. Drawn are
/// the pixels of the same label that are at most `thickness` - 1 from a border pixel; so an outline
/// lies inside its label, and two labels that touch have one each.
std::vector<std::uint8_t> label_outlines(const SectionSamples& labels, std::int64_t thickness);

}  // namespace octavo
