#pragma once

#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/confirmation.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What views confirm about the points of one coarse cell. First all that was measured there is read, then all of it is
 *  weighed, in arrays and a loop without branches, which compilers vectorise. */
class CellConfirmations {
 public:
  void clear() { n_ = 0; }
  std::size_t size() const { return n_; }

  std::size_t capacity() const { return x_.size(); }
  /** \brief Room for n shares; never less than before. */
  void reserve(std::size_t n) {
    if (n <= capacity()) return;
    for (std::vector<float>* a :
         {&x_, &y_, &z_, &here_, &beside_, &opposite_, &below_, &above_, &noise_, &multipath_, &a_, &w_, &pull_})
      a->resize(n);
  }

  /** \brief One share more, for which there must be room. \param refined D^r of the view, with zeros around it
   *  \param x,y,z of ViewModel::locate()  \param noise of the view
   *  \param multipath of the view, see residualMultipath() */
  void add(const DepthMap& refined, float x, float y, float z, const ViewNoise& noise, float multipath) {
    const int u = static_cast<int>(x), v = static_cast<int>(y);
    const float du = x - 0.5f - static_cast<float>(u), dv = y - 0.5f - static_cast<float>(v);
    // Arithmetic, where compilers would make branches of conditions: which side it is is anyone's guess.
    const std::ptrdiff_t right = 1 - 2 * static_cast<std::ptrdiff_t>(du < 0);
    const std::ptrdiff_t down = (1 - 2 * static_cast<std::ptrdiff_t>(dv < 0)) * refined.stride();
    const float* here = refined.row(v) + u;
    x_[n_] = std::fabs(du);
    y_[n_] = std::fabs(dv);
    z_[n_] = z;
    here_[n_] = *here;
    beside_[n_] = here[right];
    opposite_[n_] = here[-right];
    below_[n_] = here[down];
    above_[n_] = here[-down];
    noise_[n_] = noise.at(*here);
    multipath_[n_] = multipath;
    ++n_;
  }

  /** \brief After the last share. */
  void weigh(const Confirmation::Weighing& by) {
    inWideVectors([&] {
      weigh(n_, by, x_.data(), y_.data(), z_.data(), here_.data(), beside_.data(), opposite_.data(), below_.data(),
            above_.data(), noise_.data(), multipath_.data(), a_.data(), w_.data(), pull_.data());
    });
  }

  /** \brief The k-th that was added, after weigh(). */
  Confirmation::Share operator[](std::size_t k) const { return {a_[k], w_[k], pull_[k]}; }

 private:
  static void weigh(std::size_t n, Confirmation::Weighing by, const float* __restrict x, const float* __restrict y,
                    const float* __restrict z, const float* __restrict here, const float* __restrict beside,
                    const float* __restrict opposite, const float* __restrict below, const float* __restrict above,
                    const float* __restrict noise, const float* __restrict multipath, float* __restrict a,
                    float* __restrict w, float* __restrict pull) {
    for (std::size_t k = 0; k < n; ++k) {
      const float refined = depthBetween(x[k], y[k], by.reach, here[k], beside[k], opposite[k], below[k], above[k]);
      const Confirmation::Share share = by.share(z[k], refined, noise[k], multipath[k], here[k]);
      a[k] = share.a;
      w[k] = share.w;
      pull[k] = share.pull;
    }
  }

  std::size_t n_{0};
  std::vector<float> x_, y_, z_;  // in the view: pixels from the centre of one, metres
  std::vector<float> here_, beside_, opposite_, below_, above_;
  std::vector<float> noise_, multipath_;  // of the view, noise at the depth here, metres
  std::vector<float> a_, w_, pull_;
};

}  // namespace host
}  // namespace fuse_flow
