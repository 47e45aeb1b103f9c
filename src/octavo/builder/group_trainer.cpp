#include "octavo/builder/group_trainer.h"

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include "octavo/builder/training.h"

namespace octavo {

namespace {

// malloc keeps what a thread freed for that thread alone. Any of them may train next: in the end
// each would hold what training takes.
void return_freed_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace

void GroupTrainer::begin_with(ByteSpan first_model) {
  auto codec = parse_model(description_.kind, description_.coded_type(), description_.coding,
                           first_model, settings_.detail_level);
  settings_.axis_order = codec->axis_order();
  first_ = make_model(std::move(codec), description_.coded_type(), description_.coding,
                      settings_.detail_level);
}

const Model& GroupTrainer::train(const VoxelBlock& group) {
  return take([&](const BrickCodec* first) {
    return train_on(levels_, 0, group, description_.kind, settings_, description_.coding, first);
  });
}

const Model& GroupTrainer::train(std::span<const TrainingBrick> chosen, VoxelType type) {
  return take([&](const BrickCodec* first) {
    return train_on_choice(chosen, type, description_.kind, settings_, description_.coding, first);
  });
}

const Model& GroupTrainer::take(
    const std::function<std::unique_ptr<BrickCodec>(const BrickCodec*)>& train) {
  // As the file holds it, so that whoever has the file or a part of it comes to the same models.
  const BrickCodec* const first = first_ ? first_->decoder.get() : nullptr;
  model_ = workers_.run([&] {
    return make_model(train(first), description_.coded_type(), description_.coding,
                      settings_.detail_level);
  });
  return_freed_memory();
  settings_.axis_order = model_.encoder->axis_order();
  if (!first_) first_ = model_;
  return model_;
}

}  // namespace octavo
