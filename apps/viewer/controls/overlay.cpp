#include "viewer/controls/overlay.h"

#include <vtkImageData.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <sstream>

namespace fuse_flow::viewing {
namespace {

constexpr int kMargin = 10;            // pixels, from the window's border
constexpr int kTextSize = 14;          // pixels
constexpr int kNamePlace = 6;          // pixels, from an image's border
constexpr int kLegendWidth = 130;      // pixels
constexpr double kLegendShare = 0.35;  // of the window's height
constexpr int kSmallestText = 6;       // pixels
constexpr int kTitles = 72;            // pixels above the strip: over the timeline and its label
constexpr double kStripShare = 0.2;    // of the window's height, at most

vtkSmartPointer<vtkImageData> toImageData(const io::ColorImage& image) {
  const auto data = vtkSmartPointer<vtkImageData>::New();
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* to = static_cast<unsigned char*>(data->GetScalarPointer());
  for (int v = image.height - 1; v >= 0; --v)  // VTK keeps the bottom row first
    for (int u = 0; u < image.width; ++u)
      for (const std::uint8_t c : {image.at(u, v).r, image.at(u, v).g, image.at(u, v).b}) *to++ = c;
  return data;
}

constexpr std::size_t kColumns = 40;  // of the text that tells how wide a letter is

/** \brief Lines of so many letters at most, broken at blanks where there are any; what goes on is indented. */
std::string broken(const std::string& text, std::size_t columns) {
  constexpr std::size_t kIndent = 4;
  columns = std::max(columns, 2 * kIndent);
  std::istringstream lines(text);
  std::string all;
  for (std::string line; std::getline(lines, line);) {
    while (line.size() > columns) {
      std::size_t end = line.rfind(' ', columns);
      if (end == std::string::npos || end <= kIndent) end = columns;
      all += line.substr(0, end) + "\n";
      line = std::string(kIndent, ' ') + line.substr(line[end] == ' ' ? end + 1 : end);
    }
    all += line + "\n";
  }
  if (!all.empty()) all.pop_back();
  return all;
}

}  // namespace

Overlay::Overlay(Window& window)
    : window_(window),
      legend_(vtkSmartPointer<vtkScalarBarActor>::New()),
      image_mapper_(vtkSmartPointer<vtkImageMapper>::New()) {
  image_mapper_->SetColorWindow(255);
  image_mapper_->SetColorLevel(127.5);
  images_ = vtkSmartPointer<vtkActor2D>::New();
  images_->SetMapper(image_mapper_);
  images_->SetPosition(kMargin, kMargin);
  images_->VisibilityOff();
  window.overlay()->AddActor2D(images_);
  status_ = addText();
  status_->GetTextProperty()->SetVerticalJustificationToTop();
  message_ = addText();
  message_->GetTextProperty()->SetJustificationToCentered();
  message_->GetTextProperty()->SetColor(1, 0.75, 0.2);
  readout_ = addText();
  for (auto& title : titles_) {
    title = addText();
    title->GetTextProperty()->SetJustificationToCentered();
    title->GetTextProperty()->BoldOn();
  }
  legend_->SetNumberOfLabels(5);
  legend_->SetLabelFormat("%.3g");
  legend_->SetAnnotationTextScaling(false);
  legend_->SetVerticalTitleSeparation(kTextSize);
  legend_->DrawBackgroundOn();
  legend_->GetBackgroundProperty()->SetColor(0, 0, 0);
  legend_->GetBackgroundProperty()->SetOpacity(0.55);
  legend_->SetUnconstrainedFontSize(true);
  for (vtkTextProperty* text :
       {legend_->GetLabelTextProperty(), legend_->GetTitleTextProperty(), legend_->GetAnnotationTextProperty()}) {
    text->SetFontSize(kTextSize);
    text->ItalicOff();
    text->ShadowOff();
    text->BoldOff();
  }
  legend_->GetAnnotationTextProperty()->SetBackgroundColor(0, 0, 0);
  legend_->GetAnnotationTextProperty()->SetBackgroundOpacity(0.55);
  window.overlay()->AddActor2D(legend_);
  legend_->VisibilityOff();
  help_ = addText();
  help_->GetTextProperty()->SetBackgroundOpacity(1);
  help_->GetTextProperty()->SetVerticalJustificationToCentered();
  help_->GetTextProperty()->SetJustificationToLeft();
  help_->GetTextProperty()->SetColor(1, 1, 1);
}

vtkSmartPointer<vtkTextActor> Overlay::addText() {
  const auto text = vtkSmartPointer<vtkTextActor>::New();
  text->SetInput("");
  text->GetTextProperty()->SetFontFamilyToCourier();
  text->GetTextProperty()->SetFontSize(kTextSize);
  text->GetTextProperty()->SetColor(1, 1, 1);
  text->GetTextProperty()->SetBackgroundColor(0, 0, 0);
  text->GetTextProperty()->SetBackgroundOpacity(0.55);
  text->PickableOff();
  window_.overlay()->AddActor2D(text);
  return text;
}

void Overlay::setStatus(const std::string& text) {
  status_text_ = text;
  arrangeStatus();
}

/** \brief Broken to the width, and as large as the height has room for. */
void Overlay::arrangeStatus() {
  const double width = window_.width() - 2 * kMargin - taken_, height = window_.height() - kMargin - aboveTitles();
  double extent[2];
  for (int size = kTextSize; size >= kSmallestText; --size) {
    status_->GetTextProperty()->SetFontSize(size);
    status_->SetInput(std::string(kColumns, 'm').c_str());
    status_->GetSize(window_.overlay(), extent);
    status_->SetInput(
        broken(status_text_, static_cast<std::size_t>(std::max(1.0, width * kColumns / extent[0]))).c_str());
    status_->GetSize(window_.overlay(), extent);
    if (extent[1] <= height) break;
  }
  status_->SetPosition(kMargin, window_.height() - kMargin);
}

void Overlay::setHelp(const std::string& text) {
  help_->SetInput(text.c_str());
  arrangeHelp();
}

/** \brief As large as fits. */
void Overlay::arrangeHelp() {
  const std::string text = help_->GetInput();
  if (text.empty()) return;
  int size = kTextSize + 2;
  double extent[2];
  do {
    help_->GetTextProperty()->SetFontSize(--size);
    help_->GetSize(window_.overlay(), extent);
  } while (size > 6 && (extent[0] > window_.width() - 2 * kMargin || extent[1] > window_.height() - 2 * kMargin));
  help_->SetPosition((window_.width() - extent[0]) / 2, window_.height() / 2.0);
}

void Overlay::setLegend(const Legend& legend) {
  legend_empty_ = legend.colors.empty();
  vtkNew<vtkLookupTable> table;
  const auto count = static_cast<vtkIdType>(legend.colors.size());
  table->SetNumberOfTableValues(count);
  table->SetRange(legend.low, legend.high);
  for (vtkIdType k = 0; k < count; ++k) {
    const Rgb8 c = legend.colors[static_cast<std::size_t>(k)];
    table->SetTableValue(k, c.r / 255.0, c.g / 255.0, c.b / 255.0);
  }
  for (std::size_t k = 0; k < legend.labels.size(); ++k)
    table->SetAnnotation(vtkVariant(static_cast<double>(k)), legend.labels[k]);
  table->SetIndexedLookup(!legend.labels.empty());
  legend_->SetLookupTable(table);
  legend_->SetTitle(legend.title.c_str());
  legend_->SetDrawTickLabels(legend.labels.empty());
  // VTK writes the names of categories on the side that numbers are not on.
  legend.labels.empty() ? legend_->SetTextPositionToSucceedScalarBar() : legend_->SetTextPositionToPrecedeScalarBar();
}

void Overlay::setImages(const std::vector<io::ColorImage>& thumbnails, const std::vector<std::string>& names) {
  thumbnails_ = thumbnails;
  while (image_names_.size() > names.size()) {
    window_.overlay()->RemoveActor2D(image_names_.back());
    image_names_.pop_back();
  }
  while (image_names_.size() < names.size()) {
    image_names_.push_back(addText());
    image_names_.back()->SetVisibility(images_visible_);
  }
  names_ = names;
}

void Overlay::showImages(bool visible) {
  images_visible_ = visible;
  for (const auto& name : image_names_) name->SetVisibility(visible);
}

void Overlay::arrangeImages() {
  images_->SetVisibility(images_visible_ && !thumbnails_.empty());
  strip_height_ = 0;
  if (!images_->GetVisibility()) return;
  const Strip strip =
      stripOf(thumbnails_, window_.width() - 2 * kMargin, static_cast<int>(kStripShare * window_.height()));
  image_mapper_->SetInputData(toImageData(strip.image));
  strip_height_ = strip.image.height;
  for (std::size_t k = 0; k < image_names_.size(); ++k) {
    const int end = k + 1 < strip.begin.size() ? strip.begin[k + 1] : strip.image.width;
    image_names_[k]->SetPosition(kMargin + strip.begin[k] + kNamePlace, kMargin + kNamePlace);
    arrangeImageName(k, end - strip.begin[k] - 2 * kNamePlace);
  }
}

/** \brief In one line where that is not wider than the image; the letters as large as it has room for. */
void Overlay::arrangeImageName(std::size_t camera, double width) {
  const std::string& name = names_[camera];
  vtkTextActor* text = image_names_[camera];
  double extent[2];
  const auto fits = [&](const std::string& words) {
    text->SetInput(words.c_str());
    text->GetSize(window_.overlay(), extent);
    return extent[0] <= width;
  };
  int size = kTextSize - 2;
  text->GetTextProperty()->SetFontSize(size);
  if (!thumbnails_[camera].empty() ? fits(name) : fits(name + ": no image")) return;
  while (!fits(thumbnails_[camera].empty() ? name + ":\nno image" : name) && size > kSmallestText)
    text->GetTextProperty()->SetFontSize(--size);
}

int Overlay::aboveImages() const { return kMargin + strip_height_ + (strip_height_ > 0 ? kMargin : 0); }

int Overlay::aboveTitles() const { return aboveImages() + kTitles + 2 * kTextSize; }

void Overlay::arrange(const Panes& panes, double taken) {
  const int width = window_.width(), height = window_.height();
  taken_ = taken;
  arrangeImages();
  arrangeHelp();
  arrangeStatus();
  const int above_strip = aboveImages();
  readout_->SetPosition(kMargin, above_strip);
  message_->SetPosition(width / 2.0, aboveTitles());
  for (std::size_t k = 0; k < kPanes; ++k) {
    const auto [begin, end] = panes.extent(k);
    double extent[2];
    titles_[k]->GetSize(window_.overlay(), extent);
    const double half = extent[0] / 2 + kMargin;  // a narrow pane's title stays within the window
    titles_[k]->SetPosition(std::clamp(width * (begin + end) / 2, half, std::max(half, width - half)),
                            above_strip + kTitles);
    titles_[k]->SetVisibility(*titles_[k]->GetInput() != '\0');
  }
  legend_->SetVisibility(legend_visible_ && !legend_empty_);
  legend_->GetPositionCoordinate()->SetCoordinateSystemToDisplay();
  legend_->GetPosition2Coordinate()->SetCoordinateSystemToDisplay();
  legend_->GetPosition2Coordinate()->SetReferenceCoordinate(nullptr);
  const int low = above_strip + kTitles + 4 * kTextSize;
  legend_->GetPositionCoordinate()->SetValue(kMargin, low);
  legend_->GetPosition2Coordinate()->SetValue(kMargin + kLegendWidth, low + kLegendShare * height);
}

}  // namespace fuse_flow::viewing
