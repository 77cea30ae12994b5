#pragma once

#include <fuse_flow/extrinsic_parameters.h>
#include <fuse_flow/impl/host/depth_map.hpp>
#include <fuse_flow/impl/host/preprocessing.hpp>
#include <fuse_flow/impl/host/rig_geometry.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A view as alignment sees it: blocks of pixels averaged, with a normal each. All in the camera's own frame, so that poses
 *  may change. Only the normals come from smoothed depth: smoothing sets rounded surfaces back, away from whichever camera looks,
 *  and so would drive the cameras apart. */
class AlignmentView {
 public:
  void assign(const ViewGeometry& geometry, const DepthView& view, const ExtrinsicParameters& p) {
    geometry_ = geometry;
    reduction_ = p.reduction;
    makeDepthMap(p.preprocessing, view, full_);
    average(p);
    smooth(p);
    findNormals(p);
    for (std::vector<float>& luma : lumas_) luma.clear();
    if (!view.color || !p.use_color) return;
    averageLuma(view);
    for (std::size_t scale = 1; scale < kScales; ++scale) blurLuma(scale, 1 << (scale - 1));
  }
  void clear() { z_.clear(); }

  bool missing() const { return z_.empty(); }
  int width() const { return z_.width(); }
  int height() const { return z_.height(); }
  int reduction() const { return reduction_; }
  const ViewGeometry& geometry() const { return geometry_; }
  bool hasColor() const { return !lumas_[0].empty(); }
  /** \brief Scales at which grey levels are compared; each blurred twice as far as the one before. */
  static constexpr std::size_t kScales = 5;

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width()) + static_cast<std::size_t>(u);
  }
  Vec3 point(int u, int v) const { return pointOnRay(rays_[index(u, v)], z_.row(v)[u]); }
  /** \brief The block that a point of the camera's frame projects into. False where the image does not reach. */
  bool locate(const Vec3& q, int& u, int& v) const {
    if (!(q.z > 0)) return false;
    if (!geometry_.ideal && q.x * q.x + q.y * q.y > 1.02f * geometry_.max_squared_radius * q.z * q.z) return false;
    const Pixel pixel = project(geometry_.intrinsics, q);
    const float per_block = 1.0f / static_cast<float>(reduction_);
    const float a = (pixel.u + 0.5f) * per_block, b = (pixel.v + 0.5f) * per_block;
    if (!((a >= 0) & (a < static_cast<float>(width())) & (b >= 0) & (b < static_cast<float>(height())))) return false;
    u = static_cast<int>(a);
    v = static_cast<int>(b);
    return true;
  }
  /** \brief Unit, facing the camera; zero where the surface is not smooth. */
  const Vec3& normal(int u, int v) const { return normals_[index(u, v)]; }
  /** \brief Standard deviation of a block's depth along its normal, metres. */
  float noise(int u, int v) const {
    const float z = z_.row(v)[u];
    return noise_scale_ * axialNoise(noise_, z) * std::fabs(normal(u, v).z);
  }
  /** \brief 0 … 255; negative where there is none. */
  float luma(int u, int v, std::size_t scale = 0) const { return lumas_[scale][index(u, v)]; }
  /** \brief Median sine of the angle between normals that are independent of each other, over √2. */
  float normalNoise() const { return normal_noise_; }

 private:
  /** \brief Of each block the mean inverse depth, unless it spans a jump or is mostly holes. */
  void average(const ExtrinsicParameters& p) {
    const Intrinsics& K = geometry_.intrinsics;
    const int width = full_.width() / reduction_, height = full_.height() / reduction_;
    z_.clear();
    z_.resize(width, height);
    const float noise_scale = measureNoiseScale(p.noise, full_);
    const float step = 2.0f * std::tan(1.3f) / K.fx * static_cast<float>(reduction_);
    const int enough = (reduction_ * reduction_ + 1) / 2;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) {
        float least = std::numeric_limits<float>::max(), most = 0, sum = 0;
        int count = 0;
        for (int dv = 0; dv < reduction_; ++dv) {
          const float* row = full_.row(v * reduction_ + dv) + u * reduction_;
          for (int du = 0; du < reduction_; ++du) {
            if (!(row[du] > 0)) continue;
            least = std::min(least, row[du]);
            most = std::max(most, row[du]);
            sum += 1.0f / row[du];
            ++count;
          }
        }
        const bool whole = count >= enough && most - least < step * least + 6 * noise_scale * axialNoise(p.noise, most);
        z_.row(v)[u] = whole ? static_cast<float>(count) / sum : 0.0f;
      }
    rays_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const float middle = 0.5f * static_cast<float>(reduction_ - 1);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        rays_[index(u, v)] =
            unproject(K, {static_cast<float>(u * reduction_) + middle, static_cast<float>(v * reduction_) + middle});
  }

  void smooth(const ExtrinsicParameters& p) {
    noise_ = p.noise;
    noise_scale_ = measureNoiseScale(p.noise, z_);
    SmoothingParameters smoothing = p.smoothing;
    for (DepthMap& map : scratch_) {
      map.clear();
      map.resize(width(), height());
    }
    for (int v = 0; v < height(); ++v) invertRow(z_.row(v), width(), scratch_[0].row(v));
    for (int pass = 0; pass < smoothing.passes; ++pass)
      for (int v = 0; v < height(); ++v)
        smoothRow(smoothing, p.noise, pass, noise_scale_, scratch_[pass % 2], v, scratch_[(pass + 1) % 2].row(v));
    if (smoothing.passes % 2 == 1) std::swap(scratch_[0], scratch_[1]);
    if (smoothing.passes == 0) scratch_[0] = z_;
  }

  /** \brief From the neighbours two blocks away, which must lie on one smooth surface with the middle. */
  void findNormals(const ExtrinsicParameters& p) {
    constexpr int step = 2;
    normals_.assign(rays_.size(), Vec3{});
    const auto straight = [&](float before, float z, float after) {
      if (!(before > 0 && after > 0)) return false;
      const float q = 1.0f / z;
      return std::fabs(1.0f / before - 2 * q + 1.0f / after) <
             2.449490f * p.smoothing.tolerance * noise_scale_ * inverseDepthNoise(p.noise, q);
    };
    const auto smoothPoint = [&](int u, int v) { return pointOnRay(rays_[index(u, v)], scratch_[0].row(v)[u]); };
    for (int v = step; v < height() - step; ++v) {
      const float *above = scratch_[0].row(v - step), *here = scratch_[0].row(v), *below = scratch_[0].row(v + step);
      for (int u = step; u < width() - step; ++u) {
        if (!(here[u] > 0) || !straight(here[u - step], here[u], here[u + step]) ||
            !straight(above[u], here[u], below[u]))
          continue;
        const Vec3 along_u = smoothPoint(u + step, v) - smoothPoint(u - step, v);
        const Vec3 along_v = smoothPoint(u, v + step) - smoothPoint(u, v - step);
        const Vec3 n = cross(along_v, along_u);
        const float norm = std::sqrt(squaredNorm(n));
        if (!(norm > 0)) continue;
        const Vec3 unit = (1.0f / norm) * n;
        const Vec3 p_C = point(u, v);
        // What is seen at a glance is measured badly, and moves a lot with the pixel.
        if (-dot(unit, p_C) > 0.2f * std::sqrt(squaredNorm(p_C))) normals_[index(u, v)] = unit;
      }
    }
    measureNormalNoise();
  }

  void measureNormalNoise() {
    constexpr int apart = 12;  // beyond what smoothing and differences share
    std::vector<float> sines;
    for (int v = 0; v < height(); v += 2)
      for (int u = 0; u + apart < width(); u += 2) {
        const Vec3 &a = normal(u, v), &b = normal(u + apart, v);
        if (squaredNorm(a) > 0 && squaredNorm(b) > 0 && dot(a, b) > 0.9f) sines.push_back(squaredNorm(cross(a, b)));
      }
    normal_noise_ = 0.05f;
    if (sines.size() < 50) return;
    const auto middle = sines.begin() + static_cast<std::ptrdiff_t>(sines.size() / 2);
    std::nth_element(sines.begin(), middle, sines.end());
    normal_noise_ = std::min(0.15f, std::max(0.003f, std::sqrt(0.5f * *middle)));
  }

  void averageLuma(const DepthView& view) {
    lumas_[0].assign(rays_.size(), -1.0f);
    for (int v = 0; v < height(); ++v)
      for (int u = 0; u < width(); ++u) {
        const float z = z_.row(v)[u];
        if (!(z > 0)) continue;
        float sum = 0;
        for (int dv = 0; dv < reduction_; ++dv)
          for (int du = 0; du < reduction_; ++du) {
            const int a = u * reduction_ + du, b = v * reduction_ + dv;
            const Vec3 c = viewColor(geometry_, view.color, a, b, geometry_.ray(a, b), z);
            sum += 0.299f * c.x + 0.587f * c.y + 0.114f * c.z;
          }
        lumas_[0][index(u, v)] = sum / static_cast<float>(reduction_ * reduction_);
      }
  }

  /** \brief Over the same surface only: what lies behind it is another thing in every view. */
  void blurLuma(std::size_t scale, int spacing) {
    static constexpr float kernel[] = {1, 4, 6, 4, 1};
    std::vector<float>& out = lumas_[scale];
    std::vector<float> rows(rays_.size(), -1.0f);
    out.assign(rays_.size(), -1.0f);
    const auto pass = [&](const std::vector<float>& from, std::vector<float>& to, int du, int dv) {
      for (int v = 0; v < height(); ++v)
        for (int u = 0; u < width(); ++u) {
          const float z = z_.row(v)[u];
          if (!(z > 0)) continue;
          float sum = 0, weights = 0;
          for (int k = -2; k <= 2; ++k) {
            const int a = u + k * du, b = v + k * dv;
            if (a < 0 || b < 0 || a >= width() || b >= height()) continue;
            if (!(std::fabs(z_.row(b)[a] - z) < kSameSurface * z)) continue;
            sum += kernel[k + 2] * from[index(a, b)];
            weights += kernel[k + 2];
          }
          to[index(u, v)] = sum / weights;
        }
    };
    pass(lumas_[scale - 1], rows, spacing, 0);
    pass(rows, out, 0, spacing);
  }

  /** \brief Share of its depth by which a surface may differ within the reach of a blur. */
  static constexpr float kSameSurface = 0.05f;

  ViewGeometry geometry_;
  int reduction_{1};
  ConfidenceParameters noise_;
  float noise_scale_{1};
  float normal_noise_{0.05f};
  DepthMap full_;
  DepthMap z_;
  DepthMap scratch_[2];
  std::vector<Ray> rays_;
  std::vector<Vec3> normals_;
  std::array<std::vector<float>, kScales> lumas_;
};

}  // namespace host
}  // namespace fuse_flow
