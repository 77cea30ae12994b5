#pragma once

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/gpu/filters/device_filter.h>
#include <fuse_flow/gpu/fusion/find_hidden_colors.h>
#include <fuse_flow/gpu/fusion/write_points.h>

namespace fuse_flow {
namespace gpu {

/** \brief Eq. 8 for each pixel of the only view, to rows without padding. */
struct BackprojectPixels {
  PixelGrid grid;
  const float* depth;
  float* z;
  Vec3* points;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    const int width = view.model.intrinsics.width;
    if (a.u >= width) return;  // padding
    const std::size_t place =
        static_cast<std::size_t>(a.v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(a.u);
    z[place] = depth[index];
    points[place] = view.model.T_world_camera * pointOnRay(view.ray(a.u, a.v), depth[index]);
  }
};

/** \brief Eq. 8 for each pixel of the only view, into an organised cloud. */
template <typename Layout>
struct WriteBackprojected {
  using Words = typename Layout::Words;
  Layout layout;
  Appearance appearance;
  bool with_color;
  /** \brief Null, or the cloud that the depth came from, whose other fields stay. */
  const Words* input;
  /** \brief Null, or which pixels are wanted. */
  const std::uint8_t* wanted;
  float user_filter_value;
  /** \brief Which wanted pixels have no point. */
  std::uint8_t* removed;
  /** \brief How many pixels have none, wanted or not. */
  std::uint32_t* missing_count;
  Words* output;

  FUSE_FLOW_HD void operator()(std::uint32_t place) const {
    const DeviceView& view = appearance.grid.views[0];
    const auto width = static_cast<std::uint32_t>(view.model.intrinsics.width);
    const int u = static_cast<int>(place % width), v = static_cast<int>(place / width);
    const float z = appearance.z[view.indexOf(u, v)];
    const bool is_wanted = wanted == nullptr || wanted[place] != 0;
    Words w = layout.blank;
    if (input != nullptr) {
      w = input[place];
      Layout::setNormal(w, rotate(view.model.T_world_camera, Layout::normal(w)));
    }
    if (z > 0 && is_wanted) {
      Layout::setPosition(w, view.model.T_world_camera * pointOnRay(view.ray(u, v), z));
      if (input == nullptr)
        Layout::setConfidence(w, view.confidence ? givenConfidence(view.confidence.row(v)[u]) : 1.0f);
      if (with_color) {
        const Vec3 rgb = appearance.color({0, u, v}).rgb;
        Layout::setColor(w, rgb);
        Layout::setIntensity(w, luminance(rgb));
      }
    } else {
      Layout::setPosition(w, {user_filter_value, user_filter_value, user_filter_value});
      atomicAddTo(missing_count, 1u);
    }
    removed[place] = is_wanted && !(z > 0) ? 1 : 0;
    output[place] = w;
  }
};

/** \brief The z of each point of a cloud. */
template <typename Layout>
struct ReadZ {
  const typename Layout::Words* points;
  float* z;
  FUSE_FLOW_HD void operator()(std::uint32_t k) const { z[k] = Layout::position(points[k]).z; }
};

}  // namespace gpu

/** \brief On the GPU, for images and clouds in host memory or on the device. \copydetails DepthBackprojection */
template <typename PointT>
class DepthBackprojection<PointT, device::Thrust> : public DepthBackprojection<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in every PCL filter. */
  using PointCloud = typename DepthBackprojection<PointT, device::Host>::PointCloud;
  using Ptr = pcl::shared_ptr<DepthBackprojection>;
  using ConstPtr = pcl::shared_ptr<const DepthBackprojection>;
  ///@}

  /** \copydoc DepthBackprojection<PointT, device::Host>::DepthBackprojection
   *  \throws pcl::PCLException if there is no GPU */
  explicit DepthBackprojection(bool extract_removed_indices = false)
      : DepthBackprojection<PointT, device::Host>(extract_removed_indices), device_("fuse_flow::DepthBackprojection") {}

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { device_.run.stream = stream; }

  using DeviceCloud = gpu::DeviceCloud<PointT>;
  using DepthBackprojection<PointT, device::Host>::filter;

  /** \copydoc DepthBackprojection<PointT, device::Host>::setView */
  void setView(const DepthView& view) {
    device_input_.reset();
    DepthBackprojection<PointT, device::Host>::setView(view);
  }

  /** \brief As with a cloud in host memory; its z are read by filter(DeviceCloud&). Forgets the view. */
  void setInputCloud(const typename PointCloud::ConstPtr& cloud) override {
    device_input_.reset();
    DepthBackprojection<PointT, device::Host>::setInputCloud(cloud);
  }
  void setInputCloud(const typename DeviceCloud::ConstPtr& cloud) {
    this->view_ = {};
    device_input_ = cloud;
  }

  /** \brief As filter() into a cloud in host memory, with indices, user filter value and removed indices, from the view that
   *  setView() set, whose images may be in host or in device memory, or from the cloud on the device. Only the number of
   *  points without a measurement comes back over the bus. \param output may be the input
   *  \throws pcl::BadArgumentException if the image or cloud does not have the camera's size */
  void filter(DeviceCloud& output) {
    const detail::OneThread::Inside inside(this->one_thread_, "fuse_flow::DepthBackprojection");
    constexpr const char* owner = "fuse_flow::DepthBackprojection";
    using Layout = gpu::PointLayout<PointT>;
    const gpu::DeviceFilter::Visit visit(device_);
    checkCamera(this->camera_);
    const Intrinsics& K = this->camera_.intrinsics;
    const auto width = static_cast<std::uint32_t>(K.width), height = static_cast<std::uint32_t>(K.height);
    const std::size_t size = std::size_t{width} * height;
    gpu::Execution& run = device_.run;
    DepthView view = this->view_;
    const bool from_cloud = view.missing();
    if (from_cloud) {
      const DeviceCloud& input = gpu::DeviceFilter::inputOf(owner, device_input_);
      if (input.width != width || input.height != height)
        detail::throwBadArgument(owner, ": the input cloud is ", input.width, "x", input.height, ", camera '",
                                 this->camera_.name, "' is ", K.width, "x", K.height);
      z_.resize(size);
      run.forEach(size, gpu::ReadZ<Layout>{input.words(), z_.data()});
      view.depth32 = {z_.data(), K.width, K.height};
    } else {
      detail::checkView(this->camera_, view);
    }
    makeDepth(view, Layout::shows_color && !from_cloud);
    uploadWanted(size);
    if (Layout::shows_color && !from_cloud) gpu::findHiddenColors(run, views_, maps_.refined());
    removed_.resize(size);
    missing_count_.resize(1);
    run.fill(missing_count_.data(), 1, 0);
    result_.resize(width, height);
    run.forEach(size, gpu::WriteBackprojected<Layout>{{},
                                                      {views_.grid(), maps_.refined()},
                                                      !from_cloud && view.color,
                                                      from_cloud ? device_input_->words() : nullptr,
                                                      this->use_indices_ ? wanted_.data() : nullptr,
                                                      this->user_filter_value_,
                                                      removed_.data(),
                                                      missing_count_.data(),
                                                      result_.words()});
    describe(from_cloud, size);
    std::swap(output, result_);
  }

 protected:
  void computePoints(const DepthView& view, float* z, Vec3* points) override {
    const gpu::DeviceFilter::Visit visit(device_);
    makeDepth(view, false);
    gpu::Execution& run = device_.run;
    const std::size_t size = static_cast<std::size_t>(view.width()) * static_cast<std::size_t>(view.height());
    z_.resize(size);
    points_.resize(size);
    run.forEach(views_.pixels(), gpu::BackprojectPixels{views_.grid(), maps_.refined(), z_.data(), points_.data()});
    device_.download(z_, size, z);
    device_.download(points_, size, points);
  }

 private:
  /** \brief D^r on the device. */
  void makeDepth(const DepthView& view, bool with_color) {
    RigFrame frame;
    frame.cameras.push_back(this->camera_);
    frame.views.push_back(view);
    views_.assign(device_.run, frame, nullptr, with_color, gpu::copyThreads(this->threads_));
    maps_.make(device_.run, device_.times, views_, gpu::DepthMapParameters::withoutSmoothing(this->parameters_));
  }

  /** \brief Which pixels setIndices() named. */
  void uploadWanted(std::size_t size) {
    if (!this->use_indices_) return;
    host_flags_.assign(size, 0);
    for (const pcl::index_t index : *this->getIndices())
      if (index >= 0 && static_cast<std::size_t>(index) < size) host_flags_[static_cast<std::size_t>(index)] = 1;
    device_.upload(host_flags_.data(), size, wanted_);
  }

  /** \brief All of the result but its points, and the removed indices. */
  void describe(bool from_cloud, std::size_t size) {
    std::uint32_t missing = 0;
    device_.download(missing_count_, 1, &missing);
    result_.is_dense = missing == 0 || std::isfinite(this->user_filter_value_);
    result_.header = from_cloud ? device_input_->header : pcl::PCLHeader();
    result_.sensor_origin_ << this->camera_.T_world_camera.translation().template cast<float>(), 0.0f;
    result_.sensor_orientation_ = Eigen::Quaternionf(this->camera_.T_world_camera.linear().template cast<float>());
    this->removed_indices_->clear();
    if (!this->extract_removed_indices_) return;
    host_flags_.resize(size);
    device_.download(removed_, size, host_flags_.data());
    for (std::size_t k = 0; k < size; ++k)
      if (host_flags_[k]) this->removed_indices_->push_back(static_cast<pcl::index_t>(k));
  }

  gpu::DeviceFilter device_;
  gpu::FrameViews views_;
  gpu::DepthMaps maps_;
  gpu::DeviceBuffer<float> z_;
  gpu::DeviceBuffer<Vec3> points_;
  typename DeviceCloud::ConstPtr device_input_;
  std::vector<std::uint8_t> host_flags_;
  gpu::DeviceBuffer<std::uint8_t> wanted_, removed_;
  gpu::DeviceBuffer<std::uint32_t> missing_count_;
  DeviceCloud result_;
};

}  // namespace fuse_flow
