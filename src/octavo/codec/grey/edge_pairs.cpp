#include "octavo/codec/grey/edge_pairs.h"

namespace octavo::grey {

template <class Sample>
void mark_edges(const Stage& stage, Workspace<Sample>& work) {
  stage_functions().of<Sample>().mark_edges(stage, work);
}

template <class Sample>
void take_edges(const Stage& stage, Workspace<Sample>& work, SymbolReader& symbols) {
  stage_functions().of<Sample>().take_edges(stage, work, symbols);
}

template void mark_edges(const Stage&, Workspace<std::int16_t>&);
template void mark_edges(const Stage&, Workspace<std::int32_t>&);
template void take_edges(const Stage&, Workspace<std::int16_t>&, SymbolReader&);
template void take_edges(const Stage&, Workspace<std::int32_t>&, SymbolReader&);

}  // namespace octavo::grey
