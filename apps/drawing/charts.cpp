#include "drawing/charts.h"

#include "drawing/image_of.h"

#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPlot.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>

namespace fuse_flow::drawing {
namespace {

constexpr std::array<std::array<unsigned char, 3>, 8> kColors = {{{27, 98, 168},
                                                                  {214, 96, 36},
                                                                  {120, 120, 120},
                                                                  {60, 150, 80},
                                                                  {150, 80, 160},
                                                                  {200, 170, 40},
                                                                  {90, 180, 200},
                                                                  {180, 60, 90}}};

class Chart {
 public:
  explicit Chart(const ChartText& text) {
    view_->GetRenderer()->SetBackground(1, 1, 1);
    view_->GetRenderWindow()->SetOffScreenRendering(1);
    view_->GetRenderWindow()->SetSize(1000, 520);
    view_->GetScene()->AddItem(chart_);
    chart_->SetTitle(text.title);
    chart_->GetTitleProperties()->SetFontSize(18);
    chart_->SetShowLegend(true);
    chart_->GetLegend()->SetLabelSize(14);
    chart_->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
    chart_->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);
    chart_->GetLegend()->SetInline(false);  // beside the plot: over it, it would hide the tops of bars
    describe(vtkAxis::BOTTOM, text.x);
    describe(vtkAxis::LEFT, text.y);
  }

  vtkChartXY& operator*() { return *chart_; }
  vtkChartXY* operator->() { return chart_; }

  /** \brief The values of two columns, drawn as one plot. */
  vtkPlot* add(int type, const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
    vtkNew<vtkTable> table;
    vtkNew<vtkDoubleArray> abscissa, ordinate;
    abscissa->SetName("x");
    ordinate->SetName(name.c_str());
    for (const double value : x) abscissa->InsertNextValue(value);
    for (const double value : y) ordinate->InsertNextValue(value);
    table->AddColumn(abscissa);
    table->AddColumn(ordinate);
    vtkPlot* plot = chart_->AddPlot(type);
    plot->SetInputData(table, 0, 1);
    const auto& color = kColors[plots_++ % kColors.size()];
    plot->SetColor(color[0], color[1], color[2], 255);
    for (const double value : y) highest_ = std::max(highest_, value);
    return plot;
  }

  io::ColorImage draw() {
    vtkAxis* left = chart_->GetAxis(vtkAxis::LEFT);
    left->SetBehavior(vtkAxis::FIXED);
    left->SetMinimum(0);
    left->SetMaximum(1.05 * highest_);
    view_->GetRenderWindow()->SetMultiSamples(0);
    view_->GetRenderWindow()->Render();
    return imageOf(view_->GetRenderWindow());
  }

 private:
  void describe(int axis, const std::string& title) {
    chart_->GetAxis(axis)->SetTitle(title);
    chart_->GetAxis(axis)->GetTitleProperties()->SetFontSize(15);
    chart_->GetAxis(axis)->GetLabelProperties()->SetFontSize(14);
  }

  vtkNew<vtkContextView> view_;
  vtkNew<vtkChartXY> chart_;
  std::size_t plots_{0};
  double highest_{0};
};

}  // namespace

io::ColorImage drawLines(const ChartText& text, const std::vector<Series>& series) {
  Chart chart(text);
  double farthest = 0;
  for (const Series& line : series) {
    vtkPlot* plot = chart.add(vtkChart::LINE, line.name, line.x, line.y);
    plot->SetWidth(2.5f);
    vtkPlotPoints::SafeDownCast(plot)->SetMarkerStyle(vtkPlotPoints::CIRCLE);
    vtkPlotPoints::SafeDownCast(plot)->SetMarkerSize(9);
    for (const double value : line.x) farthest = std::max(farthest, value);
  }
  vtkAxis* bottom = chart->GetAxis(vtkAxis::BOTTOM);
  bottom->SetBehavior(vtkAxis::FIXED);
  bottom->SetMinimum(0);
  bottom->SetMaximum(1.05 * farthest);
  return chart.draw();
}

io::ColorImage drawBars(const ChartText& text, const std::vector<std::string>& groups,
                        const std::vector<std::string>& names, const std::vector<std::vector<double>>& values) {
  Chart chart(text);
  vtkNew<vtkDoubleArray> positions;
  vtkNew<vtkStringArray> labels;
  std::vector<double> x;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    x.push_back(static_cast<double>(g));
    positions->InsertNextValue(static_cast<double>(g));
    labels->InsertNextValue(groups[g]);
  }
  for (std::size_t k = 0; k < names.size(); ++k) chart.add(vtkChart::BAR, names[k], x, values[k]);
  vtkAxis* bottom = chart->GetAxis(vtkAxis::BOTTOM);
  bottom->SetCustomTickPositions(positions, labels);
  bottom->SetBehavior(vtkAxis::FIXED);
  bottom->SetMinimum(-0.6);
  bottom->SetMaximum(static_cast<double>(groups.size()) - 0.4);
  bottom->SetGridVisible(false);
  return chart.draw();
}

}  // namespace fuse_flow::drawing
