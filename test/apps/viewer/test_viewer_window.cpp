#include "clouds/cloud_io.h"
#include "recordings/images/image_io.h"
#include "viewer/controls/slider_look.h"
#include "viewer_fixture.h"

#include <pcl/io/ifs_io.h>
#include <pcl/io/obj_io.h>
#include <vtkWeakPointer.h>

namespace viewer_test {
namespace {

TEST_F(ViewerWindow, ShowsTheCloud) {
  options_.point_size = 4;
  openWall();
  const io::ColorImage image = bare();
  EXPECT_GT(filled(image), 0.5) << "points of four pixels, less than three apart";
  EXPECT_EQ(image.at(kWidth / 4, kHeight / 2).r, 200) << "the grey half of the wall is on the left";
  EXPECT_EQ(image.at(3 * kWidth / 4, kHeight / 2).g, 30) << "and the red one on the right";
}

TEST_F(ViewerWindow, TheConcatenatedCloudBesideItIsAnother) {
  openTable();
  const io::ColorImage alone = bare();
  press("v");
  ASSERT_TRUE(viewer_->panes().comparing());
  EXPECT_EQ(viewer_->panes().cloud(1)->setting->title, "concatenated");
  EXPECT_GT(viewer_->panes().cloud(1)->cloud->size(), viewer_->panes().cloud(0)->cloud->size());
  const io::ColorImage both = bare();
  io::ColorImage left, right;
  left.resize(kWidth / 2, kHeight);
  right.resize(kWidth / 2, kHeight);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth / 2; ++u) {
      left.at(u, v) = both.at(u, v);
      right.at(u, v) = both.at(u + kWidth / 2, v);
    }
  EXPECT_GT(filled(left), 0.2);
  EXPECT_GT(filled(right), 0.2);
  EXPECT_GT(difference(left, right), 0.05);
  for (std::size_t k = 1; k < FusionControls::comparisonNames().size(); ++k) press("v");
  EXPECT_FALSE(viewer_->panes().comparing());
  EXPECT_LT(difference(bare(), alone), 0.001);
}

/** \brief The same cloud on both sides: then the two parts must be one picture, wherever the line is. */
TEST_F(ViewerWindow, ASplitIsOnePictureOfTwoParts) {
  openTable();
  const io::ColorImage whole = bare();
  press("Return");
  press("d");
  ASSERT_EQ(viewer_->panes().layout(), Layout::Split);
  for (const double split : {0.5, 0.2, 0.83}) {
    viewer_->panes().setSplit(split);
    EXPECT_LT(difference(bare(), whole), 0.01) << "split at " << split;
  }
}

TEST_F(ViewerWindow, TheLineOfASplitIsDraggedAndTheViewStays) {
  options_.compare = "concatenate";
  options_.layout = Layout::Split;
  openTable();
  const Eigen::Vector3d before(viewer_->panes().camera()->GetPosition());
  drag(kWidth / 2 + 3, 200, kWidth / 4, 100);
  EXPECT_NEAR(viewer_->panes().split(), 0.25, 0.01);
  EXPECT_EQ(Eigen::Vector3d(viewer_->panes().camera()->GetPosition()), before);
}

TEST_F(ViewerWindow, TurningOneViewTurnsTheOther) {
  options_.compare = "concatenate";
  openTable();
  const io::ColorImage before = bare();
  drag(100, 150, 160, 150);
  viewer_->settle();
  const io::ColorImage after = bare();
  EXPECT_GT(difference(before, after, 0, kWidth / 2), 0.05);
  EXPECT_GT(difference(before, after, kWidth / 2, kWidth), 0.05);
}

TEST_F(ViewerWindow, SwitchingMeasurementConfidenceOffChangesThePictureAndTheText) {
  openTable();
  const io::ColorImage on = bare();
  const std::size_t points = viewer_->panes().cloud(0)->cloud->size();
  press("1");
  EXPECT_FALSE(viewer_->panes().cloud(0)->setting->options.parameters.use_measurement_confidence);
  EXPECT_NE(viewer_->panes().cloud(0)->cloud->size(), points);
  EXPECT_GT(difference(bare(), on), 0.005);
  press("1");
  EXPECT_LT(difference(bare(), on), 0.001);
}

TEST_F(ViewerWindow, TheKeyThatRefinesPosesLowersTheDisagreementAndGivesThemBack) {
  error_ = 0.02;
  scale_ = 0.5;  // smaller images do not tell poses
  openTable();
  const auto disagreement = [this] { return viewer_->panes().cloud(0)->quality->multi_view_error; };
  const auto error = [this] { return *viewer_->panes().cloud(0)->truth_distance; };
  const double given = disagreement(), given_error = error();
  const io::ColorImage before = bare();
  press("0");
  EXPECT_TRUE(viewer_->shown()->refined);
  EXPECT_LT(error(), 0.8 * given_error) << "all cameras together stay where they were: the first may be off as well";
  EXPECT_LT(disagreement(), 0.95 * given);
  EXPECT_GT(difference(bare(), before), 0.05) << "clouds and frusta are where the new poses put them";
  press("0");
  EXPECT_FALSE(viewer_->shown()->refined);
  EXPECT_EQ(disagreement(), given);
  options_.fixed_rig = false;
  openWall();
  press("0");
  EXPECT_FALSE(viewer_->shown()->refined);
  EXPECT_NE(viewer_->message().find("slide"), std::string::npos) << viewer_->message();
}

TEST_F(ViewerWindow, EachSliderMovesItsParameterOfTheNextFrame) {
  openWall();
  press("k");
  for (std::size_t k = 0; k < sliderParameters().size(); ++k) {
    const SliderParameter& parameter = sliderParameters()[k];
    vtkSliderRepresentation2D* slider = viewer_->sliders().representation(k);
    vtkRenderer* overlay = viewer_->window().overlay();
    const Eigen::Vector2i left =
        Eigen::Vector2d(slider->GetPoint1Coordinate()->GetComputedDoubleDisplayValue(overlay)).cast<int>();
    const Eigen::Vector2i right =
        Eigen::Vector2d(slider->GetPoint2Coordinate()->GetComputedDoubleDisplayValue(overlay)).cast<int>();
    int from = left.x();
    for (; from < right.x(); ++from) {
      double at[2] = {static_cast<double>(from), static_cast<double>(left.y())};
      slider->StartWidgetInteraction(at);
      if (slider->GetInteractionState() == vtkSliderRepresentation::Slider) break;
    }
    const int to = (left.x() + right.x()) / 2;
    drag(from + 3, left.y(), to, left.y());
    viewer_->settle();
    FuseFlowParameters fused = viewer_->panes().cloud(0)->setting->options.parameters;
    const double middle = parameter.scale * (parameter.low + parameter.high) / 2;
    EXPECT_NEAR(static_cast<double>(parameter.member(fused)), middle,
                0.1 * parameter.scale * (parameter.high - parameter.low))
        << parameter.title;
  }
  press("BackSpace");
  EXPECT_FLOAT_EQ(viewer_->panes().cloud(0)->setting->options.parameters.consistency.sigma, 0.02f);
}

TEST(ParameterSliders, TheSmallestCellAndTheCellTakeEachOtherWithThem) {
  const auto slider = [](const std::string& title) {
    return *std::find_if(sliderParameters().begin(), sliderParameters().end(),
                         [&](const SliderParameter& p) { return p.title == title; });
  };
  FuseFlowParameters p;
  setParameter(slider("cell size, mm"), 0.05f, p);
  setParameter(slider("smallest cell, mm"), 0.06f, p);
  EXPECT_EQ(p.aggregation.cell_size, 0.06f);
  setParameter(slider("cell size, mm"), 0.01f, p);
  EXPECT_EQ(p.aggregation.min_cell_size, 0.01f);
  setParameter(slider("cell size, mm"), 0.08f, p);
  EXPECT_EQ(p.aggregation.min_cell_size, 0.01f) << "which is no larger";
}

TEST(ParameterSliders, EachDefaultIsAtLeastATwentiethOfItsSliderFromTheEnds) {
  FuseFlowParameters p;
  for (const SliderParameter& parameter : sliderParameters()) {
    if (parameter.title == "tau") continue;  // at its end: nothing is dropped
    const double value = static_cast<double>(parameter.member(p)) / parameter.scale;
    const double twentieth = (parameter.high - parameter.low) / 20;
    EXPECT_GE(value, parameter.low + twentieth) << parameter.title;
    EXPECT_LE(value, parameter.high - twentieth) << parameter.title;
  }
}

TEST_F(ViewerWindow, WithTheSlidersOpenNothingLiesOverAnythingElse) {
  options_.compare = "concatenate";
  for (const auto& [width, height] : {std::array<int, 2>{1280, 800}, {800, 600}, {500, 380}}) {
    options_.width = width;
    options_.height = height;
    openTable();
    press("k");
    vtkRenderer* overlay = viewer_->window().overlay();
    std::vector<std::pair<std::string, Eigen::AlignedBox2d>> boxes;
    const auto addText = [&](const std::string& name, vtkTextActor* text) {
      double box[4];
      text->GetBoundingBox(overlay, box);
      const Eigen::Vector2d at(text->GetPosition());
      boxes.emplace_back(
          name, Eigen::AlignedBox2d(at + Eigen::Vector2d(box[0], box[2]), at + Eigen::Vector2d(box[1], box[3])));
    };
    const auto addSlider = [&](const std::string& name, vtkSliderRepresentation2D* slider) {
      const Eigen::Vector2d left(slider->GetPoint1Coordinate()->GetComputedDoubleDisplayValue(overlay));
      const Eigen::Vector2d right(slider->GetPoint2Coordinate()->GetComputedDoubleDisplayValue(overlay));
      boxes.emplace_back(
          name, Eigen::AlignedBox2d(left - Eigen::Vector2d(8, kSliderHalf), right + Eigen::Vector2d(8, kSliderHalf)));
    };
    addText("status", viewer_->overlay().statusActor());
    for (std::size_t k = 0; k < kPanes; ++k) addText("title " + std::to_string(k), viewer_->overlay().title(k));
    for (std::size_t k = 0; k < sliderParameters().size(); ++k) {
      addText("caption " + std::to_string(k), viewer_->sliders().caption(k));
      addSlider("slider " + std::to_string(k), viewer_->sliders().representation(k));
    }
    boxes.emplace_back(
        "strip", Eigen::AlignedBox2d(Eigen::Vector2d(0, 0), Eigen::Vector2d(width, viewer_->overlay().aboveImages())));
    const Eigen::AlignedBox2d window(Eigen::Vector2d(0, 0), Eigen::Vector2d(width, height));
    for (std::size_t a = 0; a < boxes.size(); ++a) {
      EXPECT_TRUE(window.contains(boxes[a].second)) << boxes[a].first << " in " << width << " x " << height;
      for (std::size_t b = 0; b < a; ++b)
        EXPECT_TRUE(boxes[a].second.intersection(boxes[b].second).isEmpty())
            << boxes[a].first << " over " << boxes[b].first << " in " << width << " x " << height;
    }
    press("k");
  }
}

TEST_F(ViewerWindow, TheTimelineSeeks) {
  openWall(21);
  vtkSliderRepresentation2D* slider = viewer_->timeline().representation();
  vtkRenderer* overlay = viewer_->window().overlay();
  const double* left = slider->GetPoint1Coordinate()->GetComputedDoubleDisplayValue(overlay);
  const int begin = static_cast<int>(left[0]), y = static_cast<int>(left[1]);
  const int end = static_cast<int>(slider->GetPoint2Coordinate()->GetComputedDoubleDisplayValue(overlay)[0]);
  moveTo((begin + end) / 2, y);
  pressButton();
  releaseButton();
  viewer_->settle();
  EXPECT_NEAR(static_cast<double>(viewer_->shown()->frame), 10, 1);
  press("Home");
  EXPECT_EQ(slider->GetValue(), 1) << "it shows what is played, counted from 1";
  press("End");
  EXPECT_EQ(slider->GetValue(), 21);
  EXPECT_EQ(viewer_->overlay().status().rfind("frame 21 of 21 (000020), ", 0), 0u) << viewer_->overlay().status();
}

TEST_F(ViewerWindow, TheCropBoxBeginsInViewInAColorOfItsOwn) {
  openTable();
  const auto count = [](const io::ColorImage& image, const std::array<int, 3>& c) {
    return std::count_if(image.data.begin(), image.data.end(), [&](const Rgb8& p) {
      return std::abs(p.r - c[0]) + std::abs(p.g - c[1]) + std::abs(p.b - c[2]) < 8;
    });
  };
  const io::ColorImage before = bare();
  press("b");
  const Eigen::AlignedBox3f box = viewer_->panes().boxInView();
  Eigen::AlignedBox3f cloud;
  for (const PointFused& p : *viewer_->panes().cloud(0)->cloud) cloud.extend(p.getVector3fMap());
  EXPECT_TRUE(cloud.contains(box));
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-0.5f, 0.5f}) {
      const std::array<int, 2> handle =
          drawnAt((box.center() + side * box.sizes()[axis] * Eigen::Vector3f::Unit(axis)).cast<double>());
      EXPECT_TRUE(handle[0] > 0 && handle[0] < kWidth && handle[1] > 0 && handle[1] < kHeight);
    }
  for (const bool day : {false, true}) {
    if (day) press("n");
    const io::ColorImage image = bare();
    const Rgb8 wanted = day ? Rgb8{0, 102, 128} : Rgb8{51, 230, 255};
    EXPECT_GT(count(image, {wanted.r, wanted.g, wanted.b}), 200) << (day ? "by day" : "at night");
    EXPECT_EQ(count(image, {2 * wanted.r, std::min(255, 2 * wanted.g), std::min(255, 2 * wanted.b)}), 0)
        << "lit from the side it would be twice as bright";
  }
}

TEST_F(ViewerWindow, DraggingAHandleOfTheCropBoxCropsTheCloud) {
  openTable();
  press("b");
  EXPECT_FALSE(viewer_->controls().parameters().crop_box) << "nothing is cropped until a handle moves";
  const Eigen::AlignedBox3f box = viewer_->panes().boxInView();
  const Eigen::Vector3d middle = box.center().cast<double>();
  const Eigen::Vector3d face(middle.x(), middle.y(), static_cast<double>(box.max().z()));
  const std::array<int, 2> from = drawnAt(face), to = drawnAt(middle);
  drag(from[0], from[1], to[0], to[1]);
  viewer_->settle();
  const std::optional<Eigen::AlignedBox3f> crop = viewer_->controls().parameters().crop_box;
  ASSERT_TRUE(crop) << "the handle on top of the box was not met";
  EXPECT_LT(crop->max().z(), box.max().z() - 0.2f * box.sizes().z());
  for (const PointFused& p : *viewer_->panes().cloud(0)->cloud) EXPECT_LE(p.z, crop->max().z() + 0.03f);
  press("r");
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-0.5f, 0.5f}) {
      const std::array<int, 2> handle =
          drawnAt((crop->center() + side * crop->sizes()[axis] * Eigen::Vector3f::Unit(axis)).cast<double>());
      EXPECT_TRUE(handle[0] > 0 && handle[0] < kWidth && handle[1] > 0 && handle[1] < kHeight) << axis;
    }
  press("b");
  EXPECT_FALSE(viewer_->controls().parameters().crop_box);
}

TEST_F(ViewerWindow, ThePointUnderTheCursorIsWhereTheRayMeetsTheWall) {
  openWall();
  Probe probe(viewer_->panes());
  for (const auto& [x, y] : {std::array<int, 2>{200, 150}, {120, 60}, {300, 220}}) {
    const std::optional<PickedPoint> point = probe.pick(x, y);
    ASSERT_TRUE(point) << x << ", " << y;
    const double per_pixel = 2 * 2 * std::tan(15 * M_PI / 180) / kHeight;  // metres on the wall, 2 m away
    EXPECT_NEAR(point->position.x(), per_pixel * (x - 199.5), 0.03);
    EXPECT_NEAR(point->position.y(), -per_pixel * (y - 149.5), 0.03) << "y points down";
    EXPECT_NEAR(point->position.z(), 2, 0.005);
    EXPECT_EQ((*viewer_->panes().cloud(0)->cloud)[point->index].getVector3fMap(), point->position);
  }
  viewer_->panes().camera()->Yaw(180);
  EXPECT_FALSE(probe.pick(200, 150)) << "nothing is behind";
}

TEST_F(ViewerWindow, WhatIsUnderTheCursorIsThePointsOwn) {
  openWall();
  moveTo(120, 200);
  viewer_->settle();
  const std::optional<PickedPoint> point = Probe(viewer_->panes()).pick(120, 200);
  ASSERT_TRUE(point);
  const PointFused& p = (*viewer_->panes().cloud(0)->cloud)[point->index];
  char expected[96];
  std::snprintf(expected, sizeof(expected), "x %.3f, y %.3f, z %.3f m, omega %.2f, %u views", static_cast<double>(p.x),
                static_cast<double>(p.y), static_cast<double>(p.z), static_cast<double>(p.confidence), p.view_count);
  EXPECT_EQ(p.view_count, 2u) << "both cameras see the middle of the wall";
  EXPECT_EQ(viewer_->overlay().readout(), expected);
}

TEST_F(ViewerWindow, TwoMarkedPointsAreAsFarApartAsOnTheWall) {
  openWall();
  std::vector<Eigen::Vector3f> places;
  for (const int x : {100, 300}) {
    moveTo(x, 150, true);
    pressButton();
    releaseButton();
    places.push_back(Probe(viewer_->panes()).pick(x, 150)->position);
    EXPECT_EQ(viewer_->overlay().readout().find("marked: one point") != std::string::npos, places.size() == 1)
        << viewer_->overlay().readout();
  }
  const double per_pixel = 2 * 2 * std::tan(15 * M_PI / 180) / kHeight;
  ASSERT_TRUE(viewer_->markedDistance());
  EXPECT_NEAR(*viewer_->markedDistance(), 200 * per_pixel, 0.04) << "points of the wall are some pixels apart";
  EXPECT_FLOAT_EQ(static_cast<float>(*viewer_->markedDistance()), (places[1] - places[0]).norm());
  char said[64];
  std::snprintf(said, sizeof(said), "marked: %.1f mm apart", 1000 * *viewer_->markedDistance());
  EXPECT_NE(viewer_->overlay().readout().find(said), std::string::npos) << viewer_->overlay().readout();
  press("Escape");
  EXPECT_FALSE(viewer_->markedDistance());
  EXPECT_EQ(viewer_->overlay().readout().find("marked"), std::string::npos) << viewer_->overlay().readout();
}

TEST_F(ViewerWindow, TheLineBetweenTwoMarksIsSeenOverTheSurfaceThatItLiesOn) {
  options_.point_size = 6;
  openWall();
  for (const int x : {100, 300}) {
    moveTo(x, 150);
    press("m");
  }
  const io::ColorImage image = bare();
  const auto marked = [&](int u, int v) { return image.at(u, v).r == 255 && image.at(u, v).b == 51; };
  int columns = 0;
  for (int u = 110; u < 290; ++u) {
    int v = 140;
    while (v < 160 && !marked(u, v)) ++v;
    if (v < 160) ++columns;
  }
  EXPECT_EQ(columns, 180);
}

TEST_F(ViewerWindow, ADraggedRectangleTellsWhatIsInIt) {
  openWall();
  press("x");
  drag(100, 100, 300, 200);
  const double per_pixel = 2 * 2 * std::tan(15 * M_PI / 180) / kHeight;
  int points = 0;
  float width = 0, height = 0;
  ASSERT_EQ(std::sscanf(viewer_->message().c_str(), "%d points of FUSE-Flow, %f x %f x", &points, &width, &height), 3)
      << viewer_->message();
  EXPECT_NEAR(width, 200 * per_pixel, 0.03);
  EXPECT_NEAR(height, 100 * per_pixel, 0.03);
  const Eigen::Vector3d before(viewer_->panes().camera()->GetPosition());
  int expected = 0;
  for (const PointFused& p : *viewer_->panes().cloud(0)->cloud) {
    const std::array<int, 2> at = drawnAt(p.getVector3fMap().cast<double>());
    if (at[0] >= 100 && at[0] <= 300 && at[1] >= 100 && at[1] <= 200) ++expected;
  }
  EXPECT_NEAR(points, expected, 0.03 * expected) << "but for the rectangle's border";
  EXPECT_EQ(Eigen::Vector3d(viewer_->panes().camera()->GetPosition()), before);
  EXPECT_NE(viewer_->overlay().readout().find("x: the left button drags a rectangle"), std::string::npos);
  for (const std::string key : {"x", "Escape"}) {
    press("x");
    if (key == "Escape") press(key);
    EXPECT_EQ(viewer_->overlay().readout().find("rectangle"), std::string::npos) << key;
    drag(100, 100, 300, 200);
    EXPECT_GT((Eigen::Vector3d(viewer_->panes().camera()->GetPosition()) - before).norm(), 0.1) << "it turns again";
    viewer_->panes().camera()->SetPosition(before.data());
  }
}

TEST_F(ViewerWindow, AltRGoesToTheCamerasOfTheRigOneAfterAnother) {
  openWall();
  for (const double x : {-0.1, 0.1, -0.1}) {
    press("alt+r");
    EXPECT_NEAR(viewer_->panes().camera()->GetPosition()[0], x, 1e-9);
    EXPECT_NEAR(viewer_->panes().camera()->GetFocalPoint()[2], 1, 1e-9) << "along its axis";
    EXPECT_EQ(viewer_->panes().camera()->GetViewUp()[1], -1);
    EXPECT_NEAR(viewer_->panes().camera()->GetViewAngle(), 2 * std::atan(0.3) * 180 / M_PI, 1e-4)
        << "120 rows, a focal length of 200";
  }
}

TEST_F(ViewerWindow, AltFMakesTheWindowAsLargeAsTheScreenAndBack) {
  openWall();
  const int* screen = viewer_->window().renderWindow()->GetScreenSize();
  press("alt+f");
  EXPECT_EQ(viewer_->window().width(), screen[0]);
  EXPECT_EQ(viewer_->window().height(), screen[1]);
  press("alt+f");
  EXPECT_EQ(viewer_->window().width(), kWidth);
  EXPECT_EQ(viewer_->window().height(), kHeight);
}

TEST_F(ViewerWindow, AltSDrawsForTwoEyes) {
  openTable();
  const io::ColorImage one = bare();
  press("alt+s");
  EXPECT_TRUE(viewer_->window().renderWindow()->GetStereoRender());
  EXPECT_GT(difference(bare(), one), 0.05);
  press("alt+s");
  EXPECT_LT(difference(bare(), one), 0.001);
}

TEST_F(ViewerWindow, APointPickedInTheRightViewIsOfTheRightCloud) {
  options_.compare = "concatenate";
  options_.layout = Layout::Split;
  openWall();
  viewer_->panes().setSplit(0.3);
  const std::optional<PickedPoint> point = Probe(viewer_->panes()).pick(300, 150);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->pane, 1u);
  const double per_pixel = 2 * 2 * std::tan(15 * M_PI / 180) / kHeight;
  EXPECT_NEAR(point->position.x(), per_pixel * (300 - 199.5), 0.03);
}

TEST_F(ViewerWindow, AFrameThatCannotBeReadIsNamedAndPlayingGoesOn) {
  openWall(20, 3);
  viewer_->playback().seek(3);
  viewer_->settle();
  EXPECT_NE(viewer_->message().find("frame 4 (000003): 000002.png: is cut short"), std::string::npos)
      << viewer_->message();
  EXPECT_EQ(viewer_->shown()->frame, 0u);
  EXPECT_EQ(viewer_->overlay().status().rfind("frame 1 of 20", 0), 0u) << "what is shown is the frame before";
  EXPECT_EQ(viewer_->playback().frames(), 20u);
  viewer_->playback().seek(2);
  viewer_->settle();
  EXPECT_TRUE(viewer_->error().empty());
  EXPECT_EQ(viewer_->shown()->frame, 2u);
  EXPECT_EQ(viewer_->problems().size(), 1u);
}

TEST_F(ViewerWindow, ACameraWithADamagedImageIsMissingFromThatFrameAndPlayingGoesOn) {
  auto source = std::make_unique<WallSource>(20);
  source->damageRight(3);
  viewer_ = std::make_unique<Viewer>(std::move(source), options_);
  for (std::size_t frame : {0u, 3u, 4u, 3u}) {
    viewer_->playback().seek(frame);
    viewer_->settle();
    EXPECT_EQ(viewer_->shown()->frame, frame);
    EXPECT_FALSE(viewer_->panes().cloud(0)->cloud->empty());
    EXPECT_EQ(viewer_->overlay().status().find("camera 'right' is missing") != std::string::npos, frame == 3)
        << viewer_->overlay().status();
  }
  EXPECT_EQ(viewer_->problems(), (std::vector<std::string>{"frame 4 (000003): camera 'right' is missing: "
                                                           "right/depth/000003.png: is cut short"}));
  EXPECT_EQ(viewer_->message(), viewer_->problems()[0]);
}

/** \brief Keys pressed, and nothing come of them yet. */
TEST_F(ViewerWindow, TitlesAndFiguresAreOfWhatIsShownNotOfWhatIsAskedFor) {
  openWall();
  const auto title = [this](std::size_t pane) { return std::string(viewer_->overlay().title(pane)->GetInput()); };
  viewer_->window().pressKey("v");
  EXPECT_EQ(title(0), "FUSE-Flow");
  EXPECT_EQ(title(1), "concatenated: being fused ...");
  viewer_->settle();
  EXPECT_EQ(title(1), "concatenated");
  viewer_->window().pressKey("v");
  EXPECT_EQ(title(1), "concatenated");
  viewer_->settle();
  EXPECT_EQ(title(1), "pcl::VoxelGrid, 10 mm");
  viewer_->window().pressKey("1");
  viewer_->window().pressKey("Right");
  EXPECT_NE(viewer_->overlay().status().find("1 MF on"), std::string::npos) << viewer_->overlay().status();
  EXPECT_EQ(viewer_->overlay().status().rfind("frame 1 of 20", 0), 0u) << viewer_->overlay().status();
  viewer_->settle();
  EXPECT_NE(viewer_->overlay().status().find("1 MF OFF"), std::string::npos) << viewer_->overlay().status();
  EXPECT_EQ(viewer_->overlay().status().rfind("frame 2 of 20", 0), 0u) << viewer_->overlay().status();
  EXPECT_EQ(viewer_->overlay().status().find("being fused"), std::string::npos) << viewer_->overlay().status();
}

TEST_F(ViewerWindow, KeysThatCanDoNothingHereSaySo) {
  openTable();
  press("End");
  EXPECT_EQ(viewer_->message(), "cameras that run have no last frame");
  EXPECT_EQ(viewer_->overlay().status().find("looping"), std::string::npos);
  for (const std::string said : {"legend off", "legend on; of these colours there is none"}) {
    press("u");
    EXPECT_EQ(viewer_->message(), said);
  }
}

TEST_F(ViewerWindow, WhatLeavesNoPointIsSaid) {
  openWall();
  viewer_->controls().change([](FuseFlowParameters& p) { p.confidence.threshold = 1, p.gate_noise = 0; });
  viewer_->settle();
  EXPECT_STREQ(viewer_->overlay().title(0)->GetInput(), "no point passes tau = 1");
  EXPECT_TRUE(viewer_->overlay().title(0)->GetVisibility());
  EXPECT_NE(viewer_->overlay().status().find("0 points, no point passes tau = 1"), std::string::npos);
  press("BackSpace");
  EXPECT_FALSE(viewer_->overlay().title(0)->GetVisibility());
}

TEST_F(ViewerWindow, TitlesLieOverTheTimelineAndWithinTheWindow) {
  options_.compare = "outlier_removal";
  openWall();
  vtkRenderer* overlay = viewer_->window().overlay();
  const double* slider =
      viewer_->timeline().representation()->GetPoint1Coordinate()->GetComputedDoubleDisplayValue(overlay);
  const double label_top = slider[1] + 35;
  for (const double split : {0.5, 0.05, 0.95}) {
    viewer_->panes().setLayout(Layout::Split);
    viewer_->panes().setSplit(split);
    viewer_->settle();
    for (std::size_t k = 0; k < kPanes; ++k) {
      double extent[2];
      viewer_->overlay().title(k)->GetSize(overlay, extent);
      const double* place = viewer_->overlay().title(k)->GetPosition();
      EXPECT_GT(place[1], label_top);
      EXPECT_GE(place[0] - extent[0] / 2, 0);
      EXPECT_LE(place[0] + extent[0] / 2, kWidth);
    }
  }
}

TEST_F(ViewerWindow, TheTimelineGoesDownToWhereTheImagesWere) {
  openWall();
  press("i");
  const double* left = viewer_->timeline().representation()->GetPoint1Coordinate()->GetComputedDoubleDisplayValue(
      viewer_->window().overlay());
  const int begin = static_cast<int>(left[0]), row = kHeight - 1 - static_cast<int>(left[1]);
  const io::ColorImage image = picture();
  int orange = 0;
  for (int u = begin; u < begin + 30; ++u) orange += image.at(u, row).r > 240 && image.at(u, row).b < 80;
  EXPECT_GT(orange, 8) << "its handle";
}

TEST_F(ViewerWindow, WhatIsUnderTheCursorIsOfTheCloudThatIsShownAndGoesWithTheCursor) {
  openWall();
  moveTo(200, 150);
  viewer_->settle();
  EXPECT_EQ(viewer_->overlay().readout().rfind("x ", 0), 0u) << viewer_->overlay().readout();
  EXPECT_NE(viewer_->overlay().readout().find("omega"), std::string::npos) << viewer_->overlay().readout();
  moveTo(210, 150);
  EXPECT_EQ(viewer_->overlay().readout(), "") << "it moves";
  viewer_->tick(1);
  EXPECT_NE(viewer_->overlay().readout(), "");
  viewer_->controls().change([](FuseFlowParameters& p) { p.confidence.threshold = 1, p.gate_noise = 0; });
  viewer_->settle();
  EXPECT_EQ(viewer_->overlay().readout(), "") << "there is no point any more";
  press("BackSpace");
  EXPECT_NE(viewer_->overlay().readout(), "");
  viewer_->window().interactor()->InvokeEvent(vtkCommand::LeaveEvent);
  EXPECT_EQ(viewer_->overlay().readout(), "");
  press("Right");
  EXPECT_EQ(viewer_->overlay().readout(), "") << "nor does a new cloud bring it back";
}

TEST_F(ViewerWindow, AConcatenatedCloudHasNoConfidence) {
  options_.compare = "concatenate";
  openWall();
  press("5");
  EXPECT_STREQ(viewer_->overlay().title(0)->GetInput(), "FUSE-Flow");
  EXPECT_STREQ(viewer_->overlay().title(1)->GetInput(), "concatenated: has no confidence, grey");
  moveTo(300, 150);
  viewer_->settle();
  EXPECT_EQ(viewer_->overlay().readout().find("omega"), std::string::npos) << viewer_->overlay().readout();
  const io::ColorImage image = bare();
  EXPECT_EQ(image.at(300, 150).r, 128);
}

TEST_F(ViewerWindow, WrittenCloudsHaveThePointsThatAreShown) {
  options_.compare = "concatenate";
  for (const std::string& format : cloudFormats()) {
    options_.format = format;
    openWall();
    press("ctrl+w");
    const fs::path file = folder_ / ("frame_000000_FUSE_Flow_000." + format);
    ASSERT_TRUE(fs::exists(file)) << viewer_->message();
    EXPECT_TRUE(fs::exists(folder_ / ("frame_000000_concatenated_000." + format)));
    if (format == "vtk") continue;  // PCL has no reader of points for it
    pcl::PointCloud<pcl::PointXYZ> cloud;
    if (format == "ifs") {
      ASSERT_EQ(pcl::io::loadIFSFile(file.string(), cloud), 0);
    } else if (format == "obj") {
      ASSERT_EQ(pcl::io::loadOBJFile(file.string(), cloud), 0);
    } else {
      io::readCloud(file.string(), cloud);
    }
    const Cloud& shown = *viewer_->panes().cloud(0)->cloud;
    ASSERT_EQ(cloud.size(), shown.size()) << format;
    for (std::size_t k = 0; k < shown.size(); ++k)
      ASSERT_EQ(cloud[k].getVector3fMap(), shown[k].getVector3fMap()) << format << ", point " << k;
  }
}

TEST_F(ViewerWindow, ACloudThatCannotBeWrittenIsNamedAndLeavesNothing) {
  openWall();
  const Cloud& cloud = *viewer_->panes().cloud(0)->cloud;
  for (const std::string& format : cloudFormats()) {
    fs::create_directory(folder_ / ("taken." + format));
    try {
      writeShownCloud((folder_ / ("taken." + format)).string(), cloud);
      ADD_FAILURE() << format;
    } catch (const io::OutputError& error) {
      EXPECT_NE(std::string(error.what()).find("taken." + format), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(files(), cloudFormats().size()) << "no part of a file is left";
  for (const std::string format : {"ifs", "obj", "vtk"})
    EXPECT_THROW(writeShownCloud((folder_ / ("empty." + format)).string(), Cloud()), io::OutputError) << format;
}

TEST_F(ViewerWindow, AScreenshotIsWhatTheWindowShowsAndOverwritesNothing) {
  openWall();
  const io::ColorImage shown = picture();
  press("j");
  press("j");
  EXPECT_TRUE(fs::exists(folder_ / "screenshot_001.png"));
  viewer_->panes().camera()->Azimuth(40);
  EXPECT_TRUE(viewer_->window().style()->loadCameraParameters((folder_ / "screenshot_000.cam").string()));
  EXPECT_NEAR(viewer_->panes().camera()->GetPosition()[2], 0, 1e-4) << "where it was taken from";
  io::ColorImage written;
  io::readColor((folder_ / "screenshot_000.png").string(), written);
  EXPECT_EQ(difference(written, shown), 0);
  EXPECT_EQ(viewer_->message(), "wrote " + (folder_ / "screenshot_001.png").string());
  io::readColor((folder_ / "screenshot_001.png").string(), written);
  EXPECT_EQ(difference(written, shown), 0) << "what was said of the first one is not in the second one";
  EXPECT_GT(difference(picture(), shown), 0) << "but in the window";
  writeScreenshot((folder_ / "shot.jpg").string(), viewer_->window().renderWindow());
  io::readColor((folder_ / "shot.jpg").string(), written);
  EXPECT_EQ(written.width, kWidth);
}

TEST_F(ViewerWindow, WrittenCloudsMayBeReadByWhoeverMayReadFilesOfThisUser) {
  openWall();
  const auto rights = [&](const std::string& name) { return fs::status(folder_ / name).permissions(); };
  std::ofstream(folder_ / "any");
  for (const std::string& format : cloudFormats()) {
    writeShownCloud((folder_ / ("cloud." + format)).string(), *viewer_->shown()->clouds[0]->cloud);
    EXPECT_EQ(rights("cloud." + format), rights("any")) << format;
  }
}

TEST_F(ViewerWindow, AnExportThatCannotBeWrittenIsSaidInTheWindow) {
  options_.folder = "/dev/null/nowhere";
  openWall();
  press("j");
  EXPECT_NE(viewer_->message().find("/dev/null/nowhere"), std::string::npos) << viewer_->message();
}

TEST_F(ViewerWindow, AFilmGoesOnceAroundTheCloud) {
  openWall();
  const Eigen::Vector3d start(viewer_->panes().camera()->GetPosition());
  viewer_->film((folder_ / "film").string());
  std::vector<io::ColorImage> pictures(4);
  for (int k = 0; k < 4; ++k)
    io::readColor((folder_ / "film" / ("00000" + std::to_string(k) + ".png")).string(),
                  pictures[static_cast<std::size_t>(k)]);
  EXPECT_FALSE(fs::exists(folder_ / "film" / "000004.png"));
  EXPECT_GT(difference(pictures[0], pictures[1]), 0.2) << "from the side the wall is a line";
  EXPECT_NEAR((Eigen::Vector3d(viewer_->panes().camera()->GetPosition()) - start).norm(), 0, 1e-6);
  viewer_->film((folder_ / "film.ogv").string());
  {
    const auto still = makePictureSequence((folder_ / "still.ogv").string());
    for (int k = 0; k < 4; ++k) still->add(viewer_->window().renderWindow());
  }
  EXPECT_GT(fs::file_size(folder_ / "still.ogv"), 1000u);
  EXPECT_GT(fs::file_size(folder_ / "film.ogv"), 1.3 * static_cast<double>(fs::file_size(folder_ / "still.ogv")))
      << "what does not move takes no room";
}

TEST_F(ViewerWindow, TheKeyOfFilmsMakesNumberedPicturesWhereTheyAreAskedFor) {
  options_.film_format = "png";
  openWall();
  press("ctrl+p");
  EXPECT_EQ(viewer_->message(), "filming into " + (folder_ / "film_000").string());
  for (int k = 0; k < 4; ++k) {
    viewer_->settle();
    viewer_->tick(0);
  }
  EXPECT_FALSE(viewer_->filming());
  EXPECT_TRUE(fs::exists(folder_ / "film_000" / "000003.png"));
  io::ColorImage written;
  io::readColor((folder_ / "film_000" / "000000.png").string(), written);
  viewer_->say("");
  EXPECT_EQ(difference(written, picture()), 0) << "the film's name is not in it";
}

TEST_F(ViewerWindow, AFilmThatIsStoppedLeavesTheCameraWhereItWas) {
  options_.film_format = "png";
  openWall();
  const Eigen::Vector3d start(viewer_->panes().camera()->GetPosition());
  viewer_->window().pressKey("ctrl+p");
  viewer_->settle();
  viewer_->tick(0);
  EXPECT_GT((Eigen::Vector3d(viewer_->panes().camera()->GetPosition()) - start).norm(), 0.1);
  press("ctrl+p");
  EXPECT_FALSE(viewer_->filming());
  EXPECT_NEAR((Eigen::Vector3d(viewer_->panes().camera()->GetPosition()) - start).norm(), 0, 1e-6);
}

TEST_F(ViewerWindow, TruthIsShownWhereItIsKnownElseThatIsSaid) {
  openWall();
  press("8");
  EXPECT_EQ(viewer_->coloredBy(), ColorBy::Rgb);
  EXPECT_EQ(viewer_->message(), "the truth of this recording is not known");
  EXPECT_EQ(viewer_->overlay().status().find("off truth"), std::string::npos) << viewer_->overlay().status();
  openTable();
  EXPECT_NE(viewer_->overlay().status().find("mm off truth"), std::string::npos) << viewer_->overlay().status();
  const io::ColorImage rgb = bare();
  press("8");
  EXPECT_EQ(viewer_->coloredBy(), ColorBy::TruthDistance);
  EXPECT_GT(difference(bare(), rgb), 0.2);
}

TEST_F(ViewerWindow, TheTextStaysWithinTheWindowAndAboveWhatLiesBelow) {
  options_.compare = "voxel_grid";
  for (const auto& [width, height] : {std::array<int, 2>{800, 600}, {500, 380}, {400, 300}}) {
    options_.width = width;
    options_.height = height;
    openTable();
    double box[4];
    vtkTextActor* text = viewer_->overlay().statusActor();
    text->GetBoundingBox(viewer_->window().overlay(), box);
    EXPECT_LE(text->GetPosition()[0] + box[1], width);
    EXPECT_GE(text->GetPosition()[1] + box[2], viewer_->overlay().aboveTitles()) << width << " pixels";
    std::string words = text->GetInput(), all = viewer_->overlay().status();
    for (std::string* each : {&words, &all})
      each->erase(std::remove_if(each->begin(), each->end(), [](char c) { return std::isspace(c); }), each->end());
    EXPECT_EQ(words, all) << "nothing is lost where lines are broken";
  }
}

TEST_F(ViewerWindow, WhilePlayingTheNextFramesAreShown) {
  options_.play = true;
  openWall();
  EXPECT_EQ(viewer_->shown()->frame, 0u);
  viewer_->playback().advance(0.1);
  viewer_->settle();
  EXPECT_EQ(viewer_->shown()->frame, 2u) << "at the 20 frames a second that the recording tells";
}

TEST_F(ViewerWindow, ARecordingThatTellsNoRateIsPlayedAtThirtyFramesASecond) {
  options_.play = true;
  rate_.reset();
  openWall();
  viewer_->playback().advance(0.11);
  viewer_->settle();
  EXPECT_EQ(viewer_->shown()->frame, 3u);
}

TEST_F(ViewerWindow, ItPlaysAtTheRateAndTheSpeedThatItIsGiven) {
  options_.play = true;
  options_.frames_per_second = 10;
  options_.speed = 2;
  openWall();
  viewer_->playback().advance(0.25);
  viewer_->settle();
  EXPECT_EQ(viewer_->shown()->frame, 5u);
}

TEST_F(ViewerWindow, AMovingViewDrawsFewerPointsAndAStandingOneAll) {
  openThreeSlices();
  const std::size_t all = viewer_->panes().cloud(0)->cloud->size();
  EXPECT_EQ(viewer_->panes().drawnPoints(), all);
  viewer_->panes().setCoarsePoints(2 * all / 3);
  viewer_->window().style()->InvokeEvent(vtkCommand::StartInteractionEvent);
  EXPECT_EQ(viewer_->panes().drawnPoints(), all / 3) << "the one slice that is spread over all of the cloud";
  viewer_->panes().setCoarsePoints(all);
  EXPECT_EQ(viewer_->panes().drawnPoints(), all);
  viewer_->panes().setCoarsePoints(1);
  EXPECT_EQ(viewer_->panes().drawnPoints(), all / 3) << "never nothing";
  viewer_->window().style()->InvokeEvent(vtkCommand::EndInteractionEvent);
  viewer_->tick(1);
  EXPECT_EQ(viewer_->panes().drawnPoints(), all);
}

/** \brief What the window shows is left as it is, then drawn coarse, and whole again when nobody waits any more. */
TEST_F(ViewerWindow, APictureOfAllPointsIsAbandonedWhenSomebodyWaits) {
  openThreeSlices();
  int asked = 0;
  bool waits = true;
  viewer_->setInterrupt([&] {
    ++asked;
    return waits;
  });
  viewer_->panes().camera()->Azimuth(20);
  viewer_->redraw();
  viewer_->tick(0);
  EXPECT_EQ(asked, 1) << "the first slice, and no further one";
  EXPECT_TRUE(viewer_->panes().coarse());
  viewer_->tick(0);
  EXPECT_EQ(asked, 1) << "a coarse picture is never abandoned";
  viewer_->tick(0.3);
  EXPECT_EQ(asked, 2) << "tried again, once it has stood for a while";
  waits = false;
  viewer_->tick(0);
  viewer_->tick(0.3);
  EXPECT_EQ(asked, 5);
  EXPECT_FALSE(viewer_->panes().coarse());
  waits = true;
  picture();
  EXPECT_EQ(asked, 5) << "nor what is written to a file";
}

TEST_F(ViewerWindow, ANewTextOverAPictureOfAllPointsThatIsAbandonedLeavesItAsItIs) {
  openThreeSlices();
  viewer_->setInterrupt([] { return true; });
  viewer_->say("new");
  viewer_->tick(0);
  EXPECT_FALSE(viewer_->panes().coarse()) << "all points are in the window";
  viewer_->tick(0.3);
  EXPECT_FALSE(viewer_->panes().coarse());
}

TEST_F(ViewerWindow, NothingOfItIsLeftWhenTheViewerIsGone) {
  openWall();
  press("v");
  press("b");
  press("k");
  const vtkWeakPointer<vtkRenderWindow> window = viewer_->window().renderWindow();
  const vtkWeakPointer<ViewerStyle> style = viewer_->window().style();
  const vtkWeakPointer<vtkPolyData> points = viewer_->panes().cloud(1)->slices[0].Get();
  ASSERT_TRUE(window && style && points);
  viewer_.reset();
  EXPECT_FALSE(window);
  EXPECT_FALSE(style);
  EXPECT_FALSE(points);
}

TEST_F(ViewerWindow, ClosingTheWindowEndsTheViewer) {
  openWall(std::nullopt);
  viewer_->playback().play();
  viewer_->window().interactor()->InvokeEvent(vtkCommand::ExitEvent);
  EXPECT_TRUE(viewer_->quitting());
  viewer_->run();  // returns
  EXPECT_EQ(viewer_->message().rfind("h: ", 0), 0u) << "whoever opens a window is told the key that tells the others";
  EXPECT_TRUE(viewer_->stopWithin(std::chrono::minutes(1)));
}

}  // namespace
}  // namespace viewer_test
