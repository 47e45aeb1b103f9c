#include "octavo/tasks/parts/computed_planes.h"

#include "octavo/core/error.h"

namespace octavo {

namespace {

template <class Work>
std::vector<std::string*> input_places(Work& work) {
  std::vector<std::string*> places;
  std::visit(
      [&](auto& options) {
        using Options = std::decay_t<decltype(options)>;
        if constexpr (std::is_same_v<Options, CombineOptions>) {
          for (std::string& input : options.inputs) places.push_back(&input);
        } else {
          places.push_back(&options.input);
        }
        if constexpr (std::is_same_v<Options, TransformOptions>) {
          if (!options.grid_of.empty()) places.push_back(&options.grid_of);
        }
        if constexpr (std::is_same_v<Options, LabelComponentsOptions>) {
          places.push_back(&options.numbers);
        }
      },
      work);
  return places;
}

ComputedVolume open_work(const ThresholdOptions& options, const TaskContext& context) {
  return threshold_planes(options, context);
}
ComputedVolume open_work(const CondenseVolumeOptions& options, const TaskContext& context) {
  return condensed_planes(options, context);
}
ComputedVolume open_work(const TransformOptions& options, const TaskContext& context) {
  return transformed_planes(options, context);
}
ComputedVolume open_work(const CombineOptions& options, const TaskContext& context) {
  return combined_planes(options, context);
}
ComputedVolume open_work(const LabelComponentsOptions& options, const TaskContext& context) {
  return labeled_planes(options, context);
}

}  // namespace

ComputedVolume open_computed(const ComputedWork& work, const TaskContext& context) {
  return std::visit([&](const auto& options) { return open_work(options, context); }, work);
}

std::vector<std::string> inputs_of(const ComputedWork& work) {
  ComputedWork copy = work;
  std::vector<std::string> inputs;
  for (const std::string* const place : input_places(copy)) inputs.push_back(*place);
  return inputs;
}

ComputedWork with_inputs(ComputedWork work, const std::vector<std::string>& inputs) {
  const std::vector<std::string*> places = input_places(work);
  if (places.size() != inputs.size()) {
    throw Error(ErrorKind::invalid_argument, "the plan names " + std::to_string(inputs.size()) +
                                                 " files, the work reads " +
                                                 std::to_string(places.size()) + "; plan again");
  }
  for (std::size_t i = 0; i < places.size(); ++i) *places[i] = inputs[i];
  return work;
}

}  // namespace octavo
