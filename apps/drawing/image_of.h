#pragma once

#include <fuse_flow/recordings/image.h>

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

namespace fuse_flow::drawing {

/** \brief What a window shows. */
inline io::ColorImage imageOf(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->ReadFrontBufferOff();
  grab->Update();
  vtkImageData* source = grab->GetOutput();
  io::ColorImage image;
  image.resize(source->GetDimensions()[0], source->GetDimensions()[1]);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const auto* rgb = static_cast<const unsigned char*>(source->GetScalarPointer(u, image.height - 1 - v, 0));
      image.at(u, v) = {rgb[0], rgb[1], rgb[2]};  // VTK keeps the bottom row first
    }
  return image;
}

}  // namespace fuse_flow::drawing
