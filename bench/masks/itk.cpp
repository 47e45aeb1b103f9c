#include <itkConnectedComponentImageFilter.h>
#include <itkImage.h>
#include <itkLabelImageToShapeLabelMapFilter.h>

#include "bench/masks/engine.h"

namespace octavo::bench {
namespace {

using MaskImage = itk::Image<unsigned char, 3>;
using LabelImage = itk::Image<unsigned int, 3>;

MaskImage::Pointer image_of(const MaskVolume& volume) {
  auto image = MaskImage::New();
  image->SetRegions(MaskImage::SizeType{{static_cast<itk::SizeValueType>(volume.size.x),
                                         static_cast<itk::SizeValueType>(volume.size.y),
                                         static_cast<itk::SizeValueType>(volume.size.z)}});
  image->Allocate();
  unsigned char* const to = image->GetBufferPointer();
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    to[i] = volume.voxels[i] >= volume.lowest ? 1 : 0;
  }
  return image;
}

class ItkMasks : public MaskEngine {
 public:
  explicit ItkMasks(const MaskVolume& a) : image_(image_of(a)) {}

  std::string name() const override { return "itk"; }
  std::uint64_t memory_bytes() const override {
    return image_->GetLargestPossibleRegion().GetNumberOfPixels();
  }

  std::vector<MaskOperation> operations() override {
    return {{"components",
             [this] {
               auto filter = itk::ConnectedComponentImageFilter<MaskImage, LabelImage>::New();
               filter->SetInput(image_);
               filter->FullyConnectedOff();
               filter->Update();
               return static_cast<std::uint64_t>(filter->GetObjectCount());
             },
             {}},
            {"volume and moments",
             [this] {
               auto filter = itk::LabelImageToShapeLabelMapFilter<MaskImage>::New();
               filter->SetInput(image_);
               filter->ComputePerimeterOff();
               filter->ComputeFeretDiameterOff();
               filter->Update();
               const auto* map = filter->GetOutput();
               return static_cast<std::uint64_t>(map->GetNthLabelObject(0)->GetNumberOfPixels());
             },
             {}}};
  }

 private:
  MaskImage::Pointer image_;
};

}  // namespace

std::unique_ptr<MaskEngine> make_itk_masks(const MaskVolume& a, const MaskVolume&) {
  return std::make_unique<ItkMasks>(a);
}

}  // namespace octavo::bench
