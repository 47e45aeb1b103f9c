#include "octavo/ops/label/label_pieces.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

std::size_t at_rank(int rank) { return static_cast<std::size_t>(rank); }

std::uint64_t hash_of(std::span<const std::int64_t> labels) {
  std::uint64_t hash = labels.size();
  for (const std::int64_t label : labels) {
    hash = (hash ^ static_cast<std::uint64_t>(label)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

void sort_unique(std::vector<std::int64_t>& labels) {
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
}

std::uint32_t place_in(const std::vector<std::int64_t>& labels, std::int64_t label) {
  const auto at = std::lower_bound(labels.begin(), labels.end(), label);
  return static_cast<std::uint32_t>(at - labels.begin());
}

std::vector<std::uint32_t> places_in(const std::vector<std::int64_t>& labels,
                                     std::span<const std::int64_t> wanted) {
  std::vector<std::uint32_t> places;
  places.reserve(wanted.size());
  for (const std::int64_t label : wanted) places.push_back(place_in(labels, label));
  return places;
}

// Puts the palettes of a table into a tree and tells their numbers there.
std::vector<std::uint32_t> take_palettes(const PaletteTable& table, LabelArrays& out) {
  std::vector<std::uint32_t> numbers(table.count());
  std::vector<std::uint32_t> labels;
  labels.reserve(table.all_labels().size());
  out.palette_starts = {0};
  out.palette_starts.reserve(table.count() + std::size_t{1});
  for (const std::uint32_t palette : table.in_order()) {
    numbers[palette] = static_cast<std::uint32_t>(out.palette_starts.size() - 1);
    for (const std::int64_t label : table.labels(palette)) {
      labels.push_back(place_in(out.labels, label));
    }
    out.palette_starts.push_back(labels.size());
  }
  out.palette_labels = PackedNumbers(labels);
  return numbers;
}

// The directories of planes, once all words and palettes are there.
void find_deeper(LabelArrays& arrays) {
  int plane_count = 0;
  while (plane_count < kMostLabelPlanes && !arrays.planes[at_rank(plane_count)].empty()) {
    ++plane_count;
  }
  for (int p = 0; p + 1 < plane_count; ++p) {
    arrays.deeper[at_rank(p)].reserve(arrays.planes[at_rank(p)].size());
  }
  if (plane_count < 2) return;
  for (std::uint64_t word = 0; word < arrays.palettes.size(); ++word) {
    const std::uint32_t palette = arrays.palettes[word];
    const int planes = label_planes(arrays.palette_starts[palette + std::size_t{1}] -
                                    arrays.palette_starts[palette]);
    for (int p = 0; p < planes && p + 1 < plane_count; ++p) {
      arrays.deeper[at_rank(p)].push_back(p + 1 < planes);
    }
  }
}

// Puts parts side by side, and the ranks above them on top.
class Join {
 public:
  Join(const Size3& size, std::vector<LabelPart> parts)
      : size_(size), parts_(std::move(parts)), rank_count_(MaskTree::rank_count_for(size)) {}

  LabelTree make() {
    find_labels();
    find_palettes();
    reserve();
    out_.cubes.resize(at_rank(rank_count_));
    values_.resize(at_rank(rank_count_));
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      append(parts_[i].arrays, palettes_of_[i], word);
      parts_[i].arrays = {};
      palettes_of_[i] = {};
    }
    find_deeper(out_);
    const Child root = cube(rank_count_ - 1, 0);
    out_.cubes.back().push_back(root.cube);
    if (root.is_uniform) values_.back().push_back(root.label);
    for (const std::vector<std::uint32_t>& values : values_) out_.values.emplace_back(values);
    return {size_, std::move(out_)};
  }

 private:
  // What a cube turned out to be.
  struct Child {
    bool is_uniform = true;
    std::uint32_t label = 0;
    LabelCube cube;  // where it is uniform, as a root
  };

  void find_labels() {
    std::vector<std::int64_t>& labels = out_.labels;
    if (parts_.size() < std::uint64_t{1} << 6 * (rank_count_ - 2)) labels.push_back(0);
    for (const LabelPart& part : parts_) {
      labels.insert(labels.end(), part.arrays.labels.begin(), part.arrays.labels.end());
      if (labels.size() > 2 * known_labels_ + 4096) {
        sort_unique(labels);
        known_labels_ = labels.size();
      }
    }
    sort_unique(labels);
    labels.shrink_to_fit();
    zero_ = place_in(labels, 0);
  }

  void find_palettes() {
    PaletteTable table;
    std::vector<std::int64_t> labels;
    for (const LabelPart& part : parts_) {
      const LabelArrays& from = part.arrays;
      std::vector<std::uint32_t>& numbers = palettes_of_.emplace_back();
      for (std::size_t palette = 0; palette + 1 < from.palette_starts.size(); ++palette) {
        labels.clear();
        for (std::uint64_t i = from.palette_starts[palette]; i < from.palette_starts[palette + 1];
             ++i) {
          labels.push_back(from.labels[from.palette_labels[i]]);
        }
        numbers.push_back(table.number_of(labels));
      }
    }
    const std::vector<std::uint32_t> in_tree = take_palettes(table, out_);
    for (std::vector<std::uint32_t>& numbers : palettes_of_) {
      for (std::uint32_t& number : numbers) number = in_tree[number];
    }
  }

  void reserve() {
    for (std::size_t p = 0; p < out_.planes.size(); ++p) {
      std::size_t count = 0;
      for (const LabelPart& part : parts_) count += part.arrays.planes[p].size();
      out_.planes[p].reserve(count);
      if (p == 0) {
        const auto palettes = static_cast<std::uint32_t>(out_.palette_starts.size() - 1);
        out_.palettes = PackedNumbers(count, palettes == 0 ? 0 : palettes - 1);
      }
    }
    std::size_t cubes = 0;
    for (const LabelPart& part : parts_) cubes += part.arrays.cubes[0].size();
    out_.cubes.resize(at_rank(rank_count_));
    out_.cubes[0].reserve(cubes);
  }

  // Appends what is below the root of a part, and keeps the root as a child of the ranks above.
  void append(const LabelArrays& from, const std::vector<std::uint32_t>& palettes,
              std::uint64_t& word) {
    const std::vector<std::uint32_t> labels = places_in(out_.labels, from.labels);
    const std::uint64_t first_cube = out_.cubes[0].size();
    const std::uint64_t first_word = word;
    const std::uint64_t first_value = values_[0].size();
    for (LabelCube cube : from.cubes[0]) {
      cube.first += first_word;
      cube.first_value += first_value;
      out_.cubes[0].push_back(cube);
    }
    for (std::uint64_t i = 0; i < from.values[0].size(); ++i) {
      values_[0].push_back(labels[from.values[0][i]]);
    }
    for (std::size_t p = 0; p < out_.planes.size(); ++p) {
      out_.planes[p].insert(out_.planes[p].end(), from.planes[p].begin(), from.planes[p].end());
    }
    for (std::uint64_t i = 0; i < from.palettes.size(); ++i) {
      out_.palettes.set(word++, palettes[from.palettes[i]]);
    }
    Child root;
    root.cube = from.cubes[1].front();
    root.is_uniform = root.cube.is_uniform();
    root.label = root.is_uniform ? labels[from.values[1][0]] : 0;
    root.cube.first += first_cube;
    root.cube.first_value = root_values_.size();
    if (!root.is_uniform) {
      for (std::uint64_t i = 0; i < from.values[1].size(); ++i) {
        root_values_.push_back(labels[from.values[1][i]]);
      }
    }
    roots_.push_back(root);
  }

  // The cube of `rank` with that code, whose parts are next.
  Child cube(int rank, std::uint64_t code) {
    if (rank == 1) return root_of_part(code);
    std::vector<LabelCube>& below = out_.cubes[at_rank(rank) - 1];
    const std::uint64_t first = below.size();
    LabelRuns<std::uint32_t> runs;
    for (int bit = 0; bit < 64; ++bit) {
      const std::uint64_t child_code = code << 6 | static_cast<std::uint64_t>(bit);
      Child child;
      child.label = zero_;
      if (next_ < parts_.size() && parts_[next_].code >> 6 * (rank - 2) == child_code) {
        child = cube(rank - 1, child_code);
      }
      if (child.is_uniform) {
        runs.add_uniform(bit, child.label);
      } else {
        runs.add_mixed(bit);
        below.push_back(child.cube);
      }
    }
    Child made{runs.cube().is_uniform(), runs.labels().empty() ? 0 : runs.labels().front(),
               runs.cube()};
    std::vector<std::uint32_t>& values = values_[at_rank(rank)];
    made.cube.first = first;
    made.cube.first_value = values.size();
    if (!made.is_uniform) {
      values.insert(values.end(), runs.labels().begin(), runs.labels().end());
    }
    return made;
  }

  Child root_of_part(std::uint64_t code) {
    if (next_ == parts_.size() || parts_[next_].code != code) {
      return {true, zero_, {0, 1, 0, 0}};
    }
    const Child root = roots_[next_++];
    if (root.is_uniform) return root;
    // Roots come in order, so their values do.
    const std::uint64_t begin = root.cube.first_value;
    values_[1].insert(values_[1].end(), root_values_.begin() + static_cast<std::ptrdiff_t>(begin),
                      root_values_.begin() + static_cast<std::ptrdiff_t>(root.cube.end_value()));
    return root;
  }

  Size3 size_;
  std::vector<LabelPart> parts_;
  int rank_count_;
  LabelArrays out_;
  std::size_t known_labels_ = 0;
  std::uint32_t zero_ = 0;
  std::vector<std::vector<std::uint32_t>> palettes_of_;  // by part
  std::vector<std::vector<std::uint32_t>> values_;       // by rank
  std::vector<Child> roots_;                             // by part
  std::vector<std::uint32_t> root_values_;
  std::size_t next_ = 0;
};

}  // namespace

void PaletteTable::clear() {
  labels_.clear();
  starts_.assign(1, 0);
  std::fill(slots_.begin(), slots_.end(), 0);
  last_ = 0;
}

std::uint32_t PaletteTable::number_of(std::span<const std::int64_t> wanted) {
  // Neighboring words mostly have the same labels.
  if (last_ < count() && std::ranges::equal(labels(last_), wanted)) return last_;
  if (2 * starts_.size() > slots_.size()) grow();
  std::uint32_t& slot = slots_[slot_of(wanted)];
  if (slot == 0) {
    if (starts_.size() >= std::numeric_limits<std::uint32_t>::max()) {
      throw Error(ErrorKind::limit_exceeded, "the labels stand together in too many ways");
    }
    labels_.insert(labels_.end(), wanted.begin(), wanted.end());
    starts_.push_back(labels_.size());
    slot = count();
  }
  return last_ = slot - 1;
}

std::size_t PaletteTable::slot_of(std::span<const std::int64_t> wanted) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>(hash_of(wanted)) & mask;
  while (slots_[slot] != 0 && !std::ranges::equal(labels(slots_[slot] - 1), wanted)) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

void PaletteTable::grow() {
  slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), 0);
  for (std::uint32_t palette = 0; palette < count(); ++palette) {
    slots_[slot_of(labels(palette))] = palette + 1;
  }
}

std::vector<std::uint32_t> PaletteTable::in_order() const {
  std::vector<std::uint32_t> order(count());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
    const std::span<const std::int64_t> la = labels(a);
    const std::span<const std::int64_t> lb = labels(b);
    return la.size() != lb.size() ? la.size() < lb.size()
                                  : std::ranges::lexicographical_compare(la, lb);
  });
  return order;
}

void LabelFold::add_mixed(std::span<LabelBits> labels) {
  std::sort(labels.begin(), labels.end(),
            [](const LabelBits& a, const LabelBits& b) { return a.label < b.label; });
  std::array<std::int64_t, 64> palette;
  std::array<std::uint64_t, kMostLabelPlanes> planes{};
  for (std::size_t entry = 0; entry < labels.size(); ++entry) {
    palette[entry] = labels[entry].label;
    for (std::size_t p = 0; p < planes.size(); ++p) {
      if ((entry >> p & 1) != 0) planes[p] |= labels[entry].bits;
    }
  }
  palette_of_.push_back(palettes_.number_of(std::span(palette).first(labels.size())));
  for (int p = 0; p < label_planes(labels.size()); ++p) {
    planes_[at_rank(p)].push_back(planes[at_rank(p)]);
  }
  runs_.add_mixed(bit_);
  advance();
}

void LabelFold::advance() {
  if (++bit_ < 64) return;
  bit_ = 0;
  LabelCube cube = runs_.cube();
  if (cube.is_uniform()) {
    root_.add_uniform(cube_bit_, runs_.labels().front());
  } else {
    cube.first = first_word_;
    cube.first_value = values_.size();
    cubes_.push_back(cube);
    values_.insert(values_.end(), runs_.labels().begin(), runs_.labels().end());
    root_.add_mixed(cube_bit_);
  }
  first_word_ = palette_of_.size();
  runs_ = {};
  ++cube_bit_;
}

LabelArrays LabelFold::finish() {
  LabelArrays out;
  out.labels = values_;
  out.labels.insert(out.labels.end(), root_.labels().begin(), root_.labels().end());
  sort_unique(out.labels);
  const std::span<const std::int64_t> mixed = palettes_.all_labels();
  out.labels.insert(out.labels.end(), mixed.begin(), mixed.end());
  sort_unique(out.labels);
  out.labels.shrink_to_fit();
  std::vector<std::uint32_t> numbers = take_palettes(palettes_, out);
  for (std::uint32_t& palette : palette_of_) palette = numbers[palette];
  out.palettes = PackedNumbers(palette_of_);
  for (std::size_t p = 0; p < planes_.size(); ++p) {
    out.planes[p].assign(planes_[p].begin(), planes_[p].end());
    planes_[p].clear();
  }
  find_deeper(out);
  out.cubes = {{cubes_.begin(), cubes_.end()}, {root_.cube()}};
  out.values = {PackedNumbers(places_in(out.labels, values_)),
                PackedNumbers(places_in(out.labels, root_.labels()))};
  palettes_.clear();
  palette_of_.clear();
  cubes_.clear();
  values_.clear();
  root_ = {};
  cube_bit_ = 0;
  first_word_ = 0;
  return out;
}

LabelTree join_labels(const Size3& size, std::vector<LabelPart> parts) {
  checked_voxel_count(size);
  return Join(size, std::move(parts)).make();
}

}  // namespace octavo
