#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/calibration/block_average.h>
#include <fuse_flow/math/multipath.h>

#include <algorithm>
#include <array>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A view as alignment sees it, with the memory of its blocks. */
class AlignmentView {
 public:
  AlignmentView() = default;
  AlignmentView(AlignmentView&&) = default;
  AlignmentView(const AlignmentView&) = delete;  // the blocks of a copy would be the original's

  void assign(const ViewGeometry& geometry, const DepthView& view, const ExtrinsicParameters& p) {
    makeDepthMap(p.preprocessing, geometry, view, full_);
    noise_ = viewNoise(noiseParameters(p), geometry.ownNoise());
    noise_.scale = measureNoiseScale(noise_.model, full_);
    begin(geometry, p, blockReduction(p, full_.width(), noise_.level()));
    average();
    smooth(p);
    findNormals(p);
    if (!view.color || !p.use_color) return;
    averageLuma(geometry, view);
    for (int scale = 1; scale < kScales; ++scale) blurLuma(scale, 1 << (scale - 1));
  }
  void clear() { image_ = {}; }

  /** \brief Valid until the next assign(). */
  const BlockImage& image() const { return image_; }

  bool missing() const { return image_.missing(); }
  int width() const { return image_.width; }
  int height() const { return image_.height; }
  int reduction() const { return image_.reduction; }
  bool hasColor() const { return image_.hasColor(); }
  /** \brief Scales at which grey levels are compared; each blurred twice as far as the one before. */
  static constexpr int kScales = kLumaScales;

  std::size_t index(int u, int v) const { return static_cast<std::size_t>(image_.index(u, v)); }
  Vec3 point(int u, int v) const { return image_.point(u, v); }
  /** \brief The block that a point of the camera's frame projects into. False where the image does not reach. */
  bool locate(const Vec3& q, int& u, int& v) const { return image_.locate(q, u, v); }
  /** \brief Unit, facing the camera; zero where the surface is not smooth. */
  const Vec3& normal(int u, int v) const { return image_.normal(u, v); }
  /** \brief Standard deviation of a block's depth along its normal, metres. */
  float noise(int u, int v) const { return image_.deviation(u, v); }
  /** \brief 0 … 255; negative where there is none. */
  float luma(int u, int v, int scale = 0) const { return image_.luma(u, v, scale); }
  /** \brief Median sine of the angle between normals that are independent of each other, over √2. */
  float normalNoise() const { return normal_noise_; }

 private:
  /** \brief What is known of the blocks before any is averaged. */
  void begin(const ViewGeometry& geometry, const ExtrinsicParameters& p, int reduction) {
    image_ = {};
    image_.intrinsics = geometry.intrinsics;
    image_.ideal = geometry.ideal;
    image_.max_squared_radius = geometry.max_squared_radius;
    image_.reduction = reduction;
    image_.noise = noise_.model;
    image_.residual_multipath = residualMultipath(geometry.multipath, p.residual_multipath);
    image_.width = full_.width() / reduction;
    image_.height = full_.height() / reduction;
    image_.pitch = image_.width;
    z_.clear();
    z_.resize(width(), height());
    rays_.resize(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()));
    image_.rays = rays_.data();
    if (z_.empty()) return;  // missing, then
    image_.z = z_.row(0);
    image_.z_pitch = z_.stride();
  }

  /** \brief Of each block the mean inverse depth. */
  void average() {
    const int reduction = image_.reduction;
    const float steepest = steepestBlock();
    for (int v = 0; v < height(); ++v)
      for (int u = 0; u < width(); ++u) {
        BlockDepth block;
        for (int dv = 0; dv < reduction; ++dv) {
          const float* row = full_.row(v * reduction + dv) + u * reduction;
          for (int du = 0; du < reduction; ++du) block.add(row[du]);
        }
        z_.row(v)[u] = block.mean(image_.intrinsics, reduction, steepest, noise_.model, noise_.scale);
        rays_[index(u, v)] = blockRay(image_.intrinsics, reduction, u, v);
      }
  }

  void smooth(const ExtrinsicParameters& p) {
    image_.noise_scale = noise_.scale = measureNoiseScale(noise_.model, z_);
    for (DepthMap& map : scratch_) {
      map.clear();
      if (&map != &scratch_[2] || twicingPasses(p.smoothing) > 0) map.resize(width(), height());
    }
    for (int v = 0; v < height(); ++v) invertRow(z_.row(v), width(), scratch_[1].row(v));
    for (int v = 0; v < height(); ++v) despeckleRow(p, v);
    for (int pass = 0; pass < smoothingPasses(p.smoothing); ++pass)
      for (int v = 0; v < height(); ++v)
        smoothRow(p.smoothing, pass, noise_, scratch_[smoothingMap(p.smoothing, pass)], v,
                  scratch_[smoothingMap(p.smoothing, pass + 1)].row(v),
                  scratch_[smoothingMap(p.smoothing, p.smoothing.passes)]);
    const int result = smoothingMap(p.smoothing, smoothingPasses(p.smoothing));
    if (result != 0) std::swap(scratch_[0], scratch_[result]);
    if (p.smoothing.passes == 0) scratch_[0] = z_;
  }

  /** \brief One row of inverse depths, from scratch_[1] to scratch_[0]. */
  void despeckleRow(const ExtrinsicParameters& p, int v) {
    const RowsOfPatch rows(scratch_[1], v, 1);
    float* out = scratch_[0].row(v);
    const float noise_scale = image_.noise_scale;
    const int columns = width();
    const float largest = p.max_speckle;
    inWideVectors([=] {
      const NoiseModel noise = noise_.model;  // copies: the compiler then knows that nothing overwrites them
      const RowsOfPatch patches = rows;
      float* __restrict despeckled_row = out;
      for (int u = 0; u < columns; ++u) {
        const float centre = patches.here[u];
        const float despeckled =
            despeckledInverseDepth(patches[u].z, speckleBound(largest, noise, noise_scale, centre));
        despeckled_row[u] = centre > 0 ? despeckled : 0.0f;
      }
    });
  }

  void findNormals(const ExtrinsicParameters& p) {
    normals_.assign(rays_.size(), Vec3{});
    image_.normals = normals_.data();
    BlockMap smoothed = image_;
    smoothed.z = scratch_[0].row(0);
    smoothed.z_pitch = scratch_[0].stride();
    image_.smooth_z = smoothed.z;  // of a map as large as z_
    const float tolerance = 2.449490f * p.smoothing.tolerance * image_.noise_scale;
    for (int v = kNormalSpacing; v < height() - kNormalSpacing; ++v)
      for (int u = kNormalSpacing; u < width() - kNormalSpacing; ++u)
        normals_[index(u, v)] = blockNormal(smoothed, u, v, point(u, v), noise_.model, tolerance);
    measureNormalNoise();
  }

  void measureNormalNoise() {
    std::vector<float> sines;
    for (int v = 0; v < height(); v += kNormalStride)
      for (int u = 0; u + kNormalsApart < width(); u += kNormalStride) {
        const float sine = squaredSine(normal(u, v), normal(u + kNormalsApart, v));
        if (sine >= 0) sines.push_back(sine);
      }
    const auto middle = sines.begin() + static_cast<std::ptrdiff_t>(sines.size() / 2);
    std::nth_element(sines.begin(), middle, sines.end());
    normal_noise_ = fuse_flow::normalNoise(sines.size(), sines.empty() ? 0.0f : *middle);
  }

  void averageLuma(const ViewGeometry& geometry, const DepthView& view) {
    const int reduction = image_.reduction;
    const int columns = width() * reduction, rows = height() * reduction;
    grey_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (int v = 0; v < rows; ++v) {
      const float* z = z_.row(v / reduction);
      float* out = grey_.data() + static_cast<std::ptrdiff_t>(v) * columns;
      for (int u = 0; u < columns; ++u)
        out[u] = pixelLuma(geometry, view.color, u, v, geometry.ray(u, v), z[u / reduction]);
    }
    squares_.assign(grey_.size(), -1.0f);
    for (int v = 0; v + reduction <= rows; ++v)
      squareRow(grey_.data() + static_cast<std::ptrdiff_t>(v) * columns, columns, reduction,
                squares_.data() + static_cast<std::ptrdiff_t>(v) * columns);
    image_.squares = squares_.data();
    image_.squares_pitch = columns;
    lumas_[0].resize(rays_.size());
    image_.lumas[0] = lumas_[0].data();
    for (int v = 0; v < height(); ++v)
      for (int u = 0; u < width(); ++u)
        lumas_[0][index(u, v)] = squares_[static_cast<std::size_t>(v * reduction) * static_cast<std::size_t>(columns) +
                                          static_cast<std::size_t>(u * reduction)];
  }

  /** \brief Grey levels of the squares that begin in one row of pixels. */
  static void squareRow(const float* grey, int columns, int reduction, float* out) {
    inWideVectors([=] {
      float* __restrict squares = out;
      for (int u = 0; u + reduction <= columns; ++u) squares[u] = squareLuma(grey + u, columns, reduction);
    });
  }

  void blurLuma(int scale, int spacing) {
    std::vector<float>& out = lumas_[static_cast<std::size_t>(scale)];
    out.resize(rays_.size());
    image_.lumas[scale] = out.data();
    static_assert(DepthMap::kBorder >= 2 << (kScales - 2), "so far a blur looks, and finds no depth");
    constexpr int border = DepthMap::kBorder;
    const int stride = width() + 2 * border;
    blurred_.assign(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height() + 2 * border), 0.0f);
    float* rows = blurred_.data() + border * stride + border;  // with a border of what no depth belongs to
    line_.assign(static_cast<std::size_t>(stride), 0.0f);
    for (int v = 0; v < height(); ++v) {
      std::copy_n(image_.lumas[scale - 1] + index(0, v), width(), line_.data() + border);
      blurRow(z_.row(v), line_.data() + border, width(), spacing, spacing, rows + v * stride);
    }
    for (int v = 0; v < height(); ++v)
      blurRow(z_.row(v), rows + v * stride, width(), spacing * z_.stride(), spacing * stride, out.data() + index(0, v));
  }

  /** \brief A row of blurred grey levels. \param z_step, step from block to block, of depths and of grey levels */
  static void blurRow(const float* z, const float* from, int width, int z_step, int step, float* out) {
    inWideVectors([=] {
      float* __restrict blurred = out;
      for (int u = 0; u < width; ++u) {
        LumaBlur blur(z[u]);
        for (int k = -2; k <= 2; ++k) blur.add(k, z[u + k * z_step], from[u + k * step]);
        blurred[u] = blur.mean();
      }
    });
  }

  BlockImage image_;
  ViewNoise noise_;  ///< of the pixels, and then of the blocks
  float normal_noise_{0.05f};
  DepthMap full_;
  DepthMap z_;
  DepthMap scratch_[3];  // the last for twicing
  std::vector<Ray> rays_;
  std::vector<Vec3> normals_;
  std::array<std::vector<float>, kScales> lumas_;
  std::vector<float> grey_, squares_;
  std::vector<float> blurred_, line_;
};

}  // namespace host
}  // namespace fuse_flow
