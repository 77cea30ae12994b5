#pragma once

#include <fuse_flow/impl/rig_frame.hpp>
#include <fuse_flow/impl/stereo/stereo_rig.hpp>
#include <fuse_flow/impl/stereo/stereo_steps.hpp>

#include <chrono>
#include <cstring>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief The views of the images that stereo looks at, see stereoCamera(). */
struct ColorViews {
  std::vector<Camera> cameras;
  std::vector<bool> present;  ///< whether there is a colour image

  /** \brief \throws pcl::BadArgumentException as MultiViewStereo::estimate() */
  explicit ColorViews(const RigFrame& frame) {
    constexpr const char* owner = "fuse_flow::MultiViewStereo";
    if (frame.cameras.size() != frame.views.size())
      throwBadArgument(owner, ": the frame has ", frame.cameras.size(), " cameras but ", frame.views.size(), " views");
    std::size_t images = 0;
    for (std::size_t k = 0; k < frame.cameras.size(); ++k) {
      checkCamera(frame.cameras[k]);
      cameras.push_back(stereoCamera(frame.cameras[k]));
      const ImageView<Rgb8>& color = frame.views[k].color;
      checkImage({"fuse_flow::DepthView of camera '", cameras[k].name, "'"}, "color", color, cameras[k].intrinsics);
      present.push_back(static_cast<bool>(color));
      images += color ? 1 : 0;
    }
    if (images < 2)
      throwBadArgument(owner, ": ", images, " of ", frame.cameras.size(),
                       " views have a colour image, must be two or more");
  }
};

/** \brief Multi-view stereo on a device. Keeps memory, and what depends on the calibration alone.
 *  \tparam Backend where it runs: Buffer<Value>, forEach(n, step), upload(values, buffer), download(buffer, n, to), reachable(image) */
template <typename Backend>
class StereoPipeline {
 public:
  Backend backend;
  StereoParameters parameters;

  /** \brief What comes before the search: who is matched with whom, and the images in all sizes. */
  void prepareImages(const RigFrame& frame) {
    prepare(ColorViews(frame));
    uploadImages(frame);
    makeImages();
  }
  /** \brief After prepareImages(): how many sizes there are. */
  std::size_t sizes() const { return levels_.size(); }
  /** \brief The views at one size, 0: the largest; in the device's memory. */
  const StereoLevel* levels(std::size_t size) { return level_table_.data() + views() * size; }

  /** \brief Finds the planes of all pixels, and writes depth, confidence and normals to device memory, row by row, one view after the
   *  other. */
  void run(const RigFrame& frame) {
    prepareImages(frame);
    const std::size_t coarsest = levels_.size() - 1;
    backend.forEach(blocks_.back(), SweepPlanes{gridOf(coarsest, block_table_.data()), form(0)});
    backend.forEach(pixels(coarsest), BeginPass{grid(coarsest)});
    backend.forEach(pixels(coarsest), FitSlopes{grid(coarsest), parameters.min_incidence});
    std::uint32_t pass = 0;
    for (std::size_t l = levels_.size(); l-- > 0;) {
      if (l < coarsest) backend.forEach(pixels(l), TakePlanesOver{grid(l), level_table_.data() + views() * (l + 1)});
      const int passes = l == 0 ? parameters.fine_passes : parameters.coarse_passes;
      // Where nothing but the sweep has been seen, other views' depth would do more harm than good.
      for (int k = 0; k < passes; ++k, ++pass)
        propagate(l, l < coarsest || k > 0 ? parameters.geometric_weight : 0, pass, 2.0f / static_cast<float>(1 << k));
    }
    backend.forEach(pixels(0), BeginPass{grid(0)});
    StereoForm last = form(0);
    last.geometric_limit = 10;
    const bool repetition = parameters.repetition_reach > 0;
    if (repetition)
      backend.forEach(repetition_blocks_.back(),
                      MarkRepetition{gridOf(0, repetition_table_.data()), last, parameters.repetition_reach});
    backend.forEach(first_color_.back(), WriteStereoDepth{grid(0), first_color_table_.data(), last, lens_table_.data(),
                                                          output_table_.data(), parameters.edge_step, repetition});
  }

  /** \brief After run(): what it was. */
  std::size_t views() const { return rig_.cameras().size(); }
  const StereoRig& rig() const { return rig_; }
  /** \brief Number of the first pixel of each view in depth(), confidence() and normals(), and of all. */
  const std::vector<std::uint32_t>& firstPixels() const { return first_color_; }
  /** \brief The colour images, where the device reads them. */
  const std::vector<ImageView<Rgb8>>& images() const { return images_; }
  float* depth() { return depth_.data(); }
  float* confidence() { return confidence_.data(); }
  Vec3* normals() { return normals_.data(); }

 private:
  template <typename Value>
  using Buffer = typename Backend::template Buffer<Value>;

  /** \brief What is known of a size of the images on the host. */
  struct Level {
    std::vector<Intrinsics> K;  ///< of the views
    std::vector<std::uint32_t> first,
        half;  ///< number of the first pixel of each view, of all columns and of every second one
  };

  StereoGrid gridOf(std::size_t l, const std::uint32_t* first) {
    return {level_table_.data() + views() * l, first, static_cast<std::uint32_t>(views())};
  }
  StereoGrid grid(std::size_t l) { return gridOf(l, first_table_.data() + (views() + 1) * l); }
  StereoGrid halfGrid(std::size_t l) { return gridOf(l, half_table_.data() + (views() + 1) * l); }
  std::size_t pixels(std::size_t l) const { return levels_[l].first.back(); }

  StereoForm form(float geometric_weight) const {
    const StereoParameters& p = parameters;
    return {{p.window_spacing, p.level_sigma, p.min_variance},
            p.best_sources,
            geometric_weight,
            p.geometric_limit,
            p.min_incidence};
  }

  void propagate(std::size_t l, float geometric_weight, std::uint32_t pass, float reach) {
    const std::size_t coarsest = levels_.size() - 1;
    backend.forEach(pixels(l), BeginPass{grid(l)});
    backend.forEach(pixels(l), CostPlanes{grid(l), form(geometric_weight)});
    for (const int color : {0, 1})
      backend.forEach(levels_[l].half.back(),
                      PropagatePlanes{halfGrid(l), form(geometric_weight), color, parameters.seed, pass, reach,
                                      l == 0 && l < coarsest ? kNearAreas : kPropagationAreas});
  }

  static bool sameCameras(const std::vector<Camera>& a, const std::vector<Camera>& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t k = 0; k < a.size(); ++k)
      if (!sameCalibration(a[k], b[k])) return false;
    return true;
  }
  static bool sameParameters(const StereoParameters& a, const StereoParameters& b) {
    return a.max_sources == b.max_sources && a.min_depth == b.min_depth && a.max_depth == b.max_depth &&
           a.levels == b.levels && a.sweep_step == b.sweep_step && a.max_planes == b.max_planes;
  }

  void prepare(const ColorViews& color) {
    if (ready_ && color.present == present_ && sameCameras(color.cameras, rig_.cameras()) &&
        sameParameters(parameters, of_parameters_))
      return;
    ready_ = false;
    present_ = color.present;
    of_parameters_ = parameters;
    rig_.assign(color.cameras, color.present, parameters);
    sizeLevels();
    allocate();
    describeLevels();
    ready_ = true;
  }

  /** \brief Half as large from level to level, as long as the smallest image has more than a window. */
  void sizeLevels() {
    levels_.clear();
    for (int l = 0; l < parameters.levels; ++l) {
      Level level;
      bool large_enough = true;
      for (std::size_t k = 0; k < views(); ++k) {
        level.K.push_back(l == 0 ? rig_.ideal(k) : halved(levels_.back().K[k]));
        large_enough = large_enough && std::min(level.K[k].width, level.K[k].height) >= 8;
      }
      if (l > 0 && !large_enough) break;
      std::uint64_t first = 0, half = 0;
      for (std::size_t k = 0; k <= views(); ++k) {
        level.first.push_back(static_cast<std::uint32_t>(first));
        level.half.push_back(static_cast<std::uint32_t>(half));
        if (k == views()) break;
        const auto width = static_cast<std::uint64_t>(level.K[k].width),
                   height = static_cast<std::uint64_t>(level.K[k].height);
        first += width * height;
        half += (width + 1) / 2 * height;
      }
      if (first > std::numeric_limits<std::int32_t>::max())
        throwBadArgument("fuse_flow::MultiViewStereo", ": the images have ", first, " pixels, must be less than 2^31");
      levels_.push_back(std::move(level));
    }
    blocks_.assign(1, 0);
    for (const Intrinsics& K : levels_.back().K)
      blocks_.push_back(blocks_.back() +
                        static_cast<std::uint32_t>((K.width + 1) / 2) * static_cast<std::uint32_t>((K.height + 1) / 2));
    repetition_blocks_.assign(1, 0);
    for (const Intrinsics& K : levels_.front().K)
      repetition_blocks_.push_back(repetition_blocks_.back() + repetitionBlocks(K.width) * repetitionBlocks(K.height));
    first_color_.assign(1, 0);
    for (const Camera& camera : rig_.cameras()) {
      const auto size =
          static_cast<std::uint32_t>(camera.intrinsics.width) * static_cast<std::uint32_t>(camera.intrinsics.height);
      first_color_.push_back(first_color_.back() + size);
    }
  }

  void allocate() {
    std::size_t all = 0;
    for (const Level& level : levels_) all += level.first.back();
    grey_.resize(all);
    quads_.resize(all);
    planes_.resize(all);
    before_.resize(all);
    costs_.resize(all);
    repeated_.resize(repetition_blocks_.back());
    depth_.resize(first_color_.back());
    confidence_.resize(first_color_.back());
    normals_.resize(first_color_.back());
  }

  void describeLevels() {
    std::vector<StereoLevel> table;
    std::vector<std::uint8_t*> grey;
    std::vector<std::uint32_t*> quads;
    std::vector<std::uint32_t> first, half;
    std::size_t offset = 0;
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const Level& level = levels_[l];
      for (std::size_t k = 0; k < views(); ++k) {
        table.push_back(describe(l, k, offset + level.first[k]));
        grey.push_back(grey_.data() + offset + level.first[k]);
        quads.push_back(quads_.data() + offset + level.first[k]);
      }
      first.insert(first.end(), level.first.begin(), level.first.end());
      half.insert(half.end(), level.half.begin(), level.half.end());
      offset += level.first.back();
    }
    std::vector<Intrinsics> lenses;
    std::vector<StereoOutput> outputs;
    for (std::size_t k = 0; k < views(); ++k) {
      lenses.push_back(rig_.cameras()[k].intrinsics);
      const std::size_t place = first_color_[k];
      outputs.push_back({depth_.data() + place, confidence_.data() + place, normals_.data() + place,
                         toRigidTransform(rig_.cameras()[k].T_world_camera)});
    }
    backend.upload(table, level_table_);
    backend.upload(grey, grey_table_);
    backend.upload(quads, quad_table_);
    backend.upload(first, first_table_);
    backend.upload(half, half_table_);
    backend.upload(blocks_, block_table_);
    backend.upload(repetition_blocks_, repetition_table_);
    backend.upload(first_color_, first_color_table_);
    backend.upload(lenses, lens_table_);
    backend.upload(outputs, output_table_);
  }

  StereoLevel describe(std::size_t l, std::size_t k, std::size_t place) {
    const Intrinsics& K = levels_[l].K[k];
    const StereoGeometry& geometry = rig_.geometry(k);
    StereoLevel level{};
    level.K = K;
    level.pixel_x = 1 / K.fx;
    level.pixel_y = 1 / K.fy;
    level.image = {grey_.data() + place, quads_.data() + place, K.width, K.height};
    level.plane = planes_.data() + place;
    level.before = before_.data() + place;
    level.cost = costs_.data() + place;
    if (l == 0) level.repeated = repeated_.data() + repetition_blocks_[k];
    level.sources = static_cast<int>(geometry.sources.size());
    if (level.sources == 0) return level;
    level.min_inverse_depth = 1.0f / geometry.max_depth;
    level.max_inverse_depth = 1.0f / geometry.min_depth;
    double widest = 0;
    for (int s = 0; s < level.sources; ++s) {
      const std::size_t source = geometry.sources[static_cast<std::size_t>(s)];
      // Between cameras, in double precision: far from the world's origin the difference of two poses is small.
      const Eigen::Isometry3d T = rig_.cameras()[source].T_world_camera.inverse() * rig_.cameras()[k].T_world_camera;
      const Intrinsics& K_source = levels_[l].K[source];
      level.source[s] = {static_cast<std::uint32_t>(source), viewWarp(K_source, T), toRigidTransform(T.inverse())};
      widest = std::max(widest, T.translation().norm() * K_source.fx);
    }
    level.pixels_per_inverse_depth = static_cast<float>(widest);
    const double steps = widest * (level.max_inverse_depth - level.min_inverse_depth) / parameters.sweep_step;
    level.planes = static_cast<int>(std::min(std::ceil(steps), static_cast<double>(parameters.max_planes)));
    level.planes = std::max(level.planes, 2);
    return level;
  }

  /** \brief \param T reference → source */
  static ViewWarp viewWarp(const Intrinsics& K, const Eigen::Isometry3d& T) {
    Eigen::Matrix3d intrinsic;
    intrinsic << K.fx, 0, K.cx, 0, K.fy, K.cy, 0, 0, 1;
    const Eigen::Matrix3f M = (intrinsic * T.linear()).cast<float>();
    const Eigen::Vector3f t = (intrinsic * T.translation()).cast<float>();
    const auto row = [&](int r) { return Vec3{M(r, 0), M(r, 1), M(r, 2)}; };
    return {row(0), row(1), row(2), {t.x(), t.y(), t.z()}};
  }

  void uploadImages(const RigFrame& frame) {
    images_.clear();
    for (std::size_t k = 0; k < views(); ++k) images_.push_back(backend.reachable(k, frame.views[k].color));
    backend.upload(images_, color_table_);
  }

  void makeImages() {
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      std::uint8_t* const* grey = grey_table_.data() + views() * l;
      if (l == 0) {
        backend.forEach(pixels(l), MakeGreyImage{grid(l), color_table_.data(), lens_table_.data(), grey});
      } else {
        backend.forEach(pixels(l), HalveGreyImage{grid(l), level_table_.data() + views() * (l - 1), grey});
      }
      backend.forEach(pixels(l), MakeQuads{grid(l), quad_table_.data() + views() * l});
    }
  }

  bool ready_{false};
  std::vector<bool> present_;
  StereoParameters of_parameters_;
  StereoRig rig_;
  std::vector<Level> levels_;
  std::vector<ImageView<Rgb8>> images_;
  std::vector<std::uint32_t>
      blocks_;  ///< number of the first block of 2 × 2 pixels of each view at the coarsest level, and of all
  std::vector<std::uint32_t>
      repetition_blocks_;  ///< number of the first block of each view that is looked at for repetition, and of all
  std::vector<std::uint32_t> first_color_;  ///< see firstPixels()
  Buffer<std::uint8_t> grey_, repeated_;
  Buffer<std::uint32_t> quads_;
  Buffer<InversePlane> planes_, before_;
  Buffer<float> costs_, depth_, confidence_;
  Buffer<Vec3> normals_;
  Buffer<StereoLevel> level_table_;
  Buffer<std::uint8_t*> grey_table_;
  Buffer<std::uint32_t*> quad_table_;
  Buffer<std::uint32_t> first_table_, half_table_, block_table_, repetition_table_, first_color_table_;
  Buffer<Intrinsics> lens_table_;
  Buffer<StereoOutput> output_table_;
  Buffer<ImageView<Rgb8>> color_table_;
};

/** \brief What a frame becomes, from what a pipeline has found. \param time since which */
template <typename Pipeline>
void writeStereoFrame(Pipeline& pipeline, const RigFrame& frame, bool normals,
                      std::chrono::steady_clock::time_point time, StereoFrame& result) {
  const std::size_t n = frame.cameras.size();
  result.rig.cameras = pipeline.rig().resultCameras();
  result.rig.stamp = frame.stamp;
  result.rig.views.assign(n, {});
  result.views.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    StereoView& view = result.views[k];
    view.geometry = pipeline.rig().geometry(k);
    view.agreeing = 0;
    const std::uint32_t first = pipeline.firstPixels()[k];
    const bool found = !view.geometry.sources.empty();
    const std::size_t size = found ? pipeline.firstPixels()[k + 1] - first : 0;
    view.depth.resize(size);
    view.confidence.resize(size);
    view.normals.resize(normals ? size : 0);
    if (!found) continue;
    pipeline.backend.download(pipeline.depth() + first, size, view.depth.data());
    pipeline.backend.download(pipeline.confidence() + first, size, view.confidence.data());
    if (normals) pipeline.backend.download(pipeline.normals() + first, size, view.normals.data());
    const Intrinsics& K = result.rig.cameras[k].intrinsics;
    DepthView& images = result.rig.views[k];
    images.color = frame.views[k].color;
    images.depth32 = {view.depth.data(), K.width, K.height};
    images.confidence = {view.confidence.data(), K.width, K.height};
  }
  pipeline.backend.wait();
  for (StereoView& view : result.views)
    for (const float c : view.confidence) view.agreeing += c > 0 ? 1 : 0;
  result.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - time).count();
}

}  // namespace detail
}  // namespace fuse_flow
