#include "viewer/world/world_axes.h"

#include <vtkCaptionActor2D.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPropCollection.h>
#include <vtkProperty.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <cmath>

namespace fuse_flow::viewing {
namespace {

constexpr double kAxisLength = 0.5;  // metres

}  // namespace

WorldAxes::WorldAxes(Panes& panes) : axes_(vtkSmartPointer<vtkAxesActor>::New()) {
  axes_->SetTotalLength(kAxisLength, kAxisLength, kAxisLength);
  for (vtkCaptionActor2D* caption :
       {axes_->GetXAxisCaptionActor2D(), axes_->GetYAxisCaptionActor2D(), axes_->GetZAxisCaptionActor2D()}) {
    caption->GetTextActor()->SetTextScaleModeToNone();
    caption->GetCaptionTextProperty()->SetFontSize(14);
    caption->GetCaptionTextProperty()->ShadowOff();
    caption->GetCaptionTextProperty()->ItalicOff();
  }
  vtkNew<vtkPropCollection> arrows;
  axes_->GetActors(arrows);
  arrows->InitTraversal();
  while (vtkProp* prop = arrows->GetNextProp()) {  // where the origin lies in the floor, its points would hide them
    vtkMapper* mapper = vtkActor::SafeDownCast(prop)->GetMapper();
    mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(0, kInFront);  // tips
    mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, kInFront);     // shafts
  }
  axes_->PickableOff();
  axes_->VisibilityOff();
  for (std::size_t k = 0; k < kPanes; ++k) {
    panes.renderer(k)->AddActor(axes_);
    const auto grid = vtkSmartPointer<vtkCubeAxesActor>::New();
    grid->SetCamera(panes.camera());
    grid->SetFlyModeToOuterEdges();
    grid->SetGridLineLocation(vtkCubeAxesActor::VTK_GRID_LINES_FURTHEST);
    for (int axis = 0; axis < 3; ++axis) {
      grid->GetTitleTextProperty(axis)->SetFontSize(12);
      grid->GetLabelTextProperty(axis)->SetFontSize(12);
    }
    grid->DrawXGridlinesOn();
    grid->DrawYGridlinesOn();
    grid->DrawZGridlinesOn();
    grid->SetXUnits("m");
    grid->SetYUnits("m");
    grid->SetZUnits("m");
    grid->PickableOff();
    grid->VisibilityOff();
    panes.renderer(k)->AddActor(grid);
    grids_[k] = grid;
  }
}

/** \brief Whole metres: the grid stands still while the cloud's border flickers. */
void WorldAxes::setExtent(const double bounds[6]) {
  double whole[6];
  for (int k = 0; k < 6; ++k) whole[k] = k % 2 == 0 ? std::floor(bounds[k]) : std::ceil(bounds[k]);
  for (const auto& grid : grids_) grid->SetBounds(whole);
}

void WorldAxes::showGrid(bool visible) {
  for (const auto& grid : grids_) grid->SetVisibility(visible);
}

void WorldAxes::setColor(double grey) {
  for (vtkCaptionActor2D* caption :
       {axes_->GetXAxisCaptionActor2D(), axes_->GetYAxisCaptionActor2D(), axes_->GetZAxisCaptionActor2D()})
    caption->GetCaptionTextProperty()->SetColor(grey, grey, grey);
  for (const auto& grid : grids_) {
    for (vtkProperty* lines :
         {grid->GetXAxesGridlinesProperty(), grid->GetYAxesGridlinesProperty(), grid->GetZAxesGridlinesProperty(),
          grid->GetXAxesLinesProperty(), grid->GetYAxesLinesProperty(), grid->GetZAxesLinesProperty()})
      lines->SetColor(grey, grey, grey);
    for (int axis = 0; axis < 3; ++axis) {
      grid->GetTitleTextProperty(axis)->SetColor(grey, grey, grey);
      grid->GetLabelTextProperty(axis)->SetColor(grey, grey, grey);
    }
  }
}

}  // namespace fuse_flow::viewing
