#include "viewer/controls/key_bindings.h"
#include "viewer_fixture.h"

#include <vtkBillboardTextActor3D.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPropCollection.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include <map>

namespace viewer_test {
namespace {

TEST_F(ViewerWindow, TheKeysOfPlayingGoWhereTheHelpSays) {
  openWall(40);
  Playback& playback = viewer_->playback();
  const auto expectFrame = [&](const std::string& key, std::size_t frame) {
    press(key);
    EXPECT_EQ(viewer_->shown()->frame, frame) << key;
  };
  for (const bool playing : {true, false}) {
    viewer_->window().pressKey("space");
    EXPECT_EQ(playback.playing(), playing);
  }
  expectFrame("Right", 1);
  expectFrame("Next", 11);
  expectFrame("Prior", 1);
  expectFrame("Left", 0);
  expectFrame("Left", 39);
  expectFrame("Right", 0);
  expectFrame("End", 39);
  press("ctrl+l");
  EXPECT_FALSE(playback.loop());
  expectFrame("Right", 39);
  expectFrame("Home", 0);
  expectFrame("Left", 0);
  press("ctrl+l");
  EXPECT_TRUE(playback.loop());
  for (const double speed : {2.0, 4.0}) {
    press("bracketright");
    EXPECT_EQ(playback.speed(), speed);
  }
  for (const double speed : {2.0, 1.0, 0.5}) {
    press("bracketleft");
    EXPECT_EQ(playback.speed(), speed);
  }
}

TEST_F(ViewerWindow, Keys1To3SwitchTheComponentThatTheHelpNamesAndNoOther) {
  openWall();
  const std::vector<std::pair<std::string, Component>> components{
      {"MF", Component::MeasurementConfidence}, {"DC", Component::DistanceConsistency}, {"SA", Component::SpatialHash}};
  for (std::size_t k = 0; k < components.size(); ++k) {
    const std::string key = std::to_string(k + 1);
    EXPECT_EQ(findBinding(key)->help.rfind(components[k].first + ",", 0), 0u);
    press(key);
    for (const auto& [name, component] : components) {
      const bool on = component != components[k].second;
      EXPECT_EQ(uses(viewer_->panes().cloud(0)->setting->options.parameters, component), on) << key << ", " << name;
      EXPECT_NE(viewer_->overlay().status().find(name + (on ? " on" : " OFF")), std::string::npos)
          << viewer_->overlay().status();
    }
    press(key);
  }
}

TEST_F(ViewerWindow, Keys4To9ColorByWhatTheHelpAndTheListSay) {
  openTable();
  const std::vector<std::pair<ColorBy, std::string>> modes{
      {ColorBy::Rgb, "rgb"},       {ColorBy::Confidence, "confidence"},           {ColorBy::Views, "number of views"},
      {ColorBy::Camera, "camera"}, {ColorBy::TruthDistance, "distance to truth"}, {ColorBy::Normal, "normal"}};
  io::ColorImage before = bare();
  for (std::size_t k = modes.size(); k-- > 0;) {
    const auto& [mode, help] = modes[k];
    const std::string key = std::to_string(4 + k);
    EXPECT_EQ(findBinding(key)->help.rfind(help, 0), 0u) << key;
    press(key);
    EXPECT_EQ(viewer_->shown()->color_by, mode) << key;
    const io::ColorImage now = bare();
    EXPECT_GT(difference(now, before), 0.1) << key;
    before = now;
    testing::internal::CaptureStdout();
    press("l");
    testing::internal::GetCapturedStdout();
    const std::string listed = colorByNames()[static_cast<std::size_t>(mode)] + " (" + key + ")";
    EXPECT_NE(viewer_->message().find(listed), std::string::npos) << viewer_->message();
  }
}

TEST_F(ViewerWindow, EachKeyOfTheViewSwitchesWhatTheHelpNamesAndNothingElse) {
  options_.color_by = ColorBy::Confidence;
  openWall();
  const auto visible = [&](vtkRenderer* renderer, const char* type) {
    double any = 0;
    vtkPropCollection* props = renderer->GetViewProps();
    props->InitTraversal();
    while (vtkProp* prop = props->GetNextProp())
      if (prop->IsA(type) && prop->GetVisibility()) any = 1;
    return any;
  };
  const std::map<std::string, std::string> named{{"a", "axes"},     {"g", "grid"}, {"i", "images"}, {"n", "background"},
                                                 {"o", "parallel"}, {"t", "text"}, {"u", "legend"}, {"y", "names"}};
  const auto states = [&] {
    vtkRenderer* pane = viewer_->panes().renderer(0);
    return std::map<std::string, double>{{"a", visible(pane, "vtkAxesActor")},
                                         {"g", visible(pane, "vtkCubeAxesActor")},
                                         {"i", viewer_->overlay().imageName(0)->GetVisibility()},
                                         {"n", pane->GetBackground()[0] > 0.5},
                                         {"o", viewer_->panes().camera()->GetParallelProjection()},
                                         {"t", viewer_->overlay().statusActor()->GetVisibility()},
                                         {"u", visible(viewer_->window().overlay(), "vtkScalarBarActor")},
                                         {"y", visible(pane, "vtkBillboardTextActor3D")}};
  };
  const std::map<std::string, double> before = states();
  for (const auto& [key, what] : named) {
    EXPECT_NE(findBinding(key)->help.find(what), std::string::npos) << key;
    std::map<std::string, double> expected = before;
    expected[key] = 1 - expected[key];
    press(key);
    EXPECT_EQ(states(), expected) << key;
    press(key);
    EXPECT_EQ(states(), before) << key;
  }
}

TEST_F(ViewerWindow, KeysOfTheCameraMoveItWhereTheHelpSays) {
  openWall();
  vtkCamera* camera = viewer_->panes().camera();
  const auto place = [&] { return Eigen::Vector3d(camera->GetPosition()); };
  const Eigen::Vector3d start = place();
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  press("c");
  EXPECT_NE(testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(place(), start) << "c prints";
  moveTo(250, 150);
  const std::optional<PickedPoint> point = Probe(viewer_->panes()).pick(250, 150);
  ASSERT_TRUE(point);
  press("f");
  EXPECT_NEAR((Eigen::Vector3d(camera->GetFocalPoint()) - point->position.cast<double>()).norm(), 0, 1e-3);
  press("r");
  EXPECT_NEAR((place() - start).norm(), 0, 1e-9);
  EXPECT_NEAR(camera->GetFocalPoint()[0], 0, 1e-9);
}

TEST_F(ViewerWindow, NoPointHidesTheAxes) {
  options_.point_size = 6;
  openWall();
  viewer_->panes().camera()->SetPosition(0, 0, 5);
  viewer_->panes().fitClippingRange();
  const auto green = [&] {  // of the wall nothing is
    const io::ColorImage image = bare();
    return std::count_if(image.data.begin(), image.data.end(),
                         [](const Rgb8& p) { return p.g > 80 && p.r < 40 && p.b < 40; });
  };
  press("y");
  EXPECT_EQ(green(), 0);
  press("a");
  EXPECT_GT(green(), 20) << "the y axis, behind the wall";
}

TEST_F(ViewerWindow, PlusMakesPointsLargerAndMinusSmaller) {
  options_.point_size = 1;
  openWall();
  double before = filled(bare());
  for (const double size : {2.0, 3.0}) {
    press("plus");
    EXPECT_EQ(viewer_->pointSize(), size);
    const double now = filled(bare());
    EXPECT_GT(now, before);
    before = now;
  }
  press("minus");
  EXPECT_EQ(viewer_->pointSize(), 2);
  EXPECT_LT(filled(bare()), before);
}

TEST_F(ViewerWindow, TheHelpIsShownWhole) {
  options_.width = 800;
  options_.height = 600;
  openWall();
  press("k");
  press("h");
  EXPECT_EQ(viewer_->overlay().help()->GetInput(), helpText());
  double extent[2];
  viewer_->overlay().help()->GetSize(viewer_->window().overlay(), extent);
  EXPECT_LT(extent[0], 800);
  EXPECT_LT(extent[1], 600);
  EXPECT_EQ(viewer_->overlay().help()->GetTextProperty()->GetBackgroundOpacity(), 1);
  const auto seen = [&] {
    return viewer_->overlay().statusActor()->GetVisibility() + viewer_->overlay().imageName(0)->GetVisibility() +
           viewer_->sliders().caption(0)->GetVisibility() +
           viewer_->window().overlay()->HasViewProp(viewer_->sliders().representation(0));
  };
  EXPECT_EQ(seen(), 0) << "nothing shines through";
  press("h");
  EXPECT_EQ(seen(), 4);
  EXPECT_STREQ(viewer_->overlay().help()->GetInput(), "");
}

TEST_F(ViewerWindow, EachCameraHasItsNameInTheWorldAndOverItsImage) {
  openWall();
  std::vector<std::string> names;
  vtkPropCollection* props = viewer_->panes().renderer(0)->GetViewProps();
  props->InitTraversal();
  while (vtkProp* prop = props->GetNextProp())
    if (auto* text = vtkBillboardTextActor3D::SafeDownCast(prop)) {
      names.push_back(text->GetInput());
      EXPECT_NEAR(text->GetPosition()[0], names.back() == "left" ? -0.1 : 0.1, 1e-6);
    }
  EXPECT_EQ(names, (std::vector<std::string>{"left", "right"}));
  EXPECT_STREQ(viewer_->overlay().imageName(0)->GetInput(), "left");
  EXPECT_STREQ(viewer_->overlay().imageName(1)->GetInput(), "right");
}

TEST_F(ViewerWindow, CamerasAsDotsAndLinesAreSeenAndTheirNamesStayReadable) {
  openWall();
  for (const auto& [key, form] :
       std::map<std::string, int>{{"p", VTK_POINTS}, {"w", VTK_WIREFRAME}, {"s", VTK_SURFACE}}) {
    press(key);
    int names = 0, frusta = 0;
    vtkPropCollection* props = viewer_->panes().renderer(0)->GetViewProps();
    props->InitTraversal();
    while (vtkProp* prop = props->GetNextProp()) {
      vtkNew<vtkPropCollection> parts;
      prop->GetActors(parts);
      parts->InitTraversal();
      while (auto* actor = vtkActor::SafeDownCast(parts->GetNextProp())) {
        auto* lines = vtkPolyData::SafeDownCast(actor->GetMapper() ? actor->GetMapper()->GetInput() : nullptr);
        if (vtkBillboardTextActor3D::SafeDownCast(prop)) {
          ++names;
          EXPECT_EQ(actor->GetProperty()->GetRepresentation(), VTK_SURFACE) << key;
        } else if (lines && lines->GetNumberOfLines() == 2 * 8) {
          ++frusta;
          EXPECT_EQ(actor->GetProperty()->GetRepresentation(), form) << key;
          EXPECT_GT(actor->GetProperty()->GetPointSize(), 3);
        }
      }
    }
    EXPECT_EQ(names, 2);
    EXPECT_EQ(frusta, 1);
  }
}

TEST_F(ViewerWindow, NoWallHidesTheNamesOfTheCamerasBehindIt) {
  options_.point_size = 6;
  openWall();
  viewer_->panes().camera()->SetPosition(0, 0, 5);
  viewer_->panes().fitClippingRange();
  const io::ColorImage image = bare();
  for (const Rgb8 color : {cameraColor(0), cameraColor(1)})
    EXPECT_GT(std::count_if(image.data.begin(), image.data.end(),
                            [&](const Rgb8& p) {
                              return std::abs(p.r - color.r) + std::abs(p.g - color.g) + std::abs(p.b - color.b) < 60;
                            }),
              30);
}

TEST_F(ViewerWindow, WhatStandsOverAnImageIsNoWiderThanTheImage) {
  for (const int width : {800, 500, 320}) {
    options_.width = width;
    auto source = std::make_unique<WallSource>(20);
    source->damageRight(0);
    viewer_ = std::make_unique<Viewer>(std::move(source), options_);
    viewer_->settle();
    Overlay& overlay = viewer_->overlay();
    io::ColorImage seen;
    seen.resize(80, 60);
    const std::vector<io::ColorImage> images{io::ColorImage(), io::ColorImage(), seen, seen, seen};
    overlay.setImages(images, {"camera_00", "camera_01", "camera_02", "camera_03", "camera_04"});
    overlay.arrange(viewer_->panes(), 0);
    for (std::size_t k = 0; k < images.size(); ++k) {
      double extent[2];
      overlay.imageName(k)->GetSize(viewer_->window().overlay(), extent);
      const double end = k + 1 < images.size() ? overlay.imageName(k + 1)->GetPosition()[0] : width - 10;
      EXPECT_LE(overlay.imageName(k)->GetPosition()[0] + extent[0], end) << k << " of " << width << " pixels";
      const std::string text = overlay.imageName(k)->GetInput();
      EXPECT_EQ(text.find("no image") != std::string::npos, images[k].empty()) << text;
    }
  }
}

TEST_F(ViewerWindow, TheStripShowsWhatTheCamerasSeeInTheFrameThatIsShown) {
  simulation::SimulationOptions simulation;
  simulation.scene = "person";
  simulation.rig = "ring-2";
  simulation.scale = 0.2;
  viewer_ = std::make_unique<Viewer>(makeSimulatedSource(simulation), options_);
  viewer_->settle();
  // Two images of 80 x 60 pixels, 10 from the window's border, are all that is seen in these columns and rows.
  const auto strip = [&] {
    const io::ColorImage image = picture();
    io::ColorImage part;
    part.resize(140, 50);
    for (int v = 0; v < part.height; ++v)
      for (int u = 0; u < part.width; ++u) part.at(u, v) = image.at(20 + u, kHeight - 65 + v);
    return part;
  };
  const io::ColorImage before = strip();
  viewer_->playback().seek(30);
  viewer_->settle();
  EXPECT_GT(difference(before, strip()), 0.02) << "the person walks";
  viewer_->playback().seek(0);
  viewer_->settle();
  EXPECT_EQ(difference(before, strip()), 0);
}

}  // namespace
}  // namespace viewer_test
