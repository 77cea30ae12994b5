#pragma once

#include <fuse_flow/gpu/device_cloud.h>

#include <pcl/pcl_base.h>
#include <pcl/types.h>

#include <cmath>

namespace fuse_flow {
namespace gpu {

/** \brief Which points of a cloud a filter is to look at: all, or those that setIndices() named, in that order. */
struct PointList {
  /** \brief Null: all. */
  const std::uint32_t* indices;
  FUSE_FLOW_HD std::uint32_t operator[](std::uint32_t k) const { return indices == nullptr ? k : indices[k]; }
};

/** \brief What a filter writes into the confidence field of the points that it hands on. */
struct ConfidenceField {
  enum class Change { Set, Scale };
  Change change;
  /** \brief Of each point of the input. */
  const float* values;

  template <typename Layout>
  FUSE_FLOW_HD void apply(typename Layout::Words& w, std::uint32_t index) const {
    if constexpr (Layout::has_confidence) {
      const float value = values[index];
      Layout::setConfidence(w, change == Change::Set ? value : Layout::confidence(w) * value);
    }
  }
};

/** \brief Whether the k-th point of a list stays, or does not. */
struct ListedPoint {
  PointList list;
  const std::uint8_t* keep;
  bool kept;
  FUSE_FLOW_HD bool operator()(std::uint32_t k) const { return (keep[list[k]] != 0) == kept; }
};

/** \brief Copies points of a list one after the other. */
template <typename Layout>
struct CopyListedPoints {
  using Words = typename Layout::Words;
  const Words* input;
  PointList list;
  /** \brief Which of the list; null: the list is not asked, all points of the input. */
  const std::uint32_t* chosen;
  ConfidenceField confidence;
  Words* output;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t index = chosen == nullptr ? k : list[chosen[k]];
    Words w = input[index];
    confidence.apply<Layout>(w, index);
    output[k] = w;
  }
};

/** \brief In a copy of the input, the points of a list: those that go lose their coordinates. */
template <typename Layout>
struct MarkListedPoints {
  using Words = typename Layout::Words;
  PointList list;
  const std::uint8_t* keep;
  float user_filter_value;
  const Words* input;
  ConfidenceField confidence;
  Words* output;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t index = list[k];
    Words w = input[index];
    confidence.apply<Layout>(w, index);
    if (!keep[index]) Layout::setPosition(w, {user_filter_value, user_filter_value, user_filter_value});
    output[index] = w;
  }
};

/** \brief The settings of the base class pcl::FilterIndices. */
struct SelectionSettings {
  bool keep_organized;
  float user_filter_value;
  bool extract_removed_indices;
};

/** \brief What pcl::FilterIndices does once it is decided which points stay, on the device: same points, same order. */
template <typename PointT>
class CloudSelection {
 public:
  using Layout = PointLayout<PointT>;

  /** \brief The list of points to look at. \param indices null: all \throws pcl::PCLException for an index beyond the
   *  cloud */
  void list(Execution& run, const DeviceCloud<PointT>& input, const pcl::IndicesConstPtr& indices) {
    listed_ = indices ? indices->size() : input.size();
    all_ = indices == nullptr;
    if (all_) return;
    for (const pcl::index_t index : *indices)
      if (index < 0 || static_cast<std::size_t>(index) >= input.size())
        throw pcl::PCLException("fuse_flow::gpu: index " + std::to_string(index) + " in a cloud of " +
                                std::to_string(input.size()) + " points");
    const std::vector<std::uint32_t> numbers(indices->begin(), indices->end());
    indices_.resize(listed_);
    run.copy(indices_.data(), numbers.data(), listed_);
    run.wait();
  }

  PointList points() const { return {all_ ? nullptr : indices_.data()}; }
  std::size_t size() const { return listed_; }
  /** \brief One for each point of the input, to be filled with whether it stays; zeros to begin with. */
  std::uint8_t* keep(Execution& run, std::size_t points) {
    keep_.resize(points);
    if (points > 0) run.fill(keep_.data(), points, 0);
    return keep_.data();
  }

  /** \brief \param output another cloud than the input  \param removed filled if the settings say so */
  void apply(Execution& run, const SelectionSettings& settings, const ConfidenceField& confidence,
             const DeviceCloud<PointT>& input, DeviceCloud<PointT>& output, pcl::Indices& removed) {
    DeviceCloud<PointT>::copyHeader(input, output);
    if (settings.keep_organized) {
      output.resize(input.width, input.height);
      if (confidence.change == ConfidenceField::Change::Set) {
        copyAll(run, confidence, input, output);
      } else {
        run.copy(output.words(), input.words(), input.size());
      }
      run.forEach(listed_, MarkListedPoints<Layout>{points(), keep_.data(), settings.user_filter_value, input.words(),
                                                    confidence, output.words()});
      if (!std::isfinite(settings.user_filter_value)) output.is_dense = false;
    } else {
      const std::uint32_t count = choose(run, true);
      if (count == input.size()) {  // as pcl::copyPointCloud(): the whole cloud, in its own order
        output.resize(input.width, input.height);
        copyAll(run, confidence, input, output);
      } else {
        output.resize(count, 1);
        run.forEach(count,
                    CopyListedPoints<Layout>{input.words(), points(), chosen_.data(), confidence, output.words()});
      }
    }
    removed.clear();
    if (settings.extract_removed_indices || settings.keep_organized) removedIndices(run, removed);
  }

 private:
  void copyAll(Execution& run, const ConfidenceField& confidence, const DeviceCloud<PointT>& input,
               DeviceCloud<PointT>& output) {
    run.forEach(input.size(), CopyListedPoints<Layout>{input.words(), points(), nullptr, confidence, output.words()});
  }

  /** \brief The listed points that stay, or go, to chosen_; returns how many. */
  std::uint32_t choose(Execution& run, bool kept) {
    chosen_.resize(listed_ + 1);
    count_.resize(1);
    host_count_.resize(1);
    run.select(listed_, ListedPoint{points(), keep_.data(), kept}, chosen_.data(), count_.data());
    run.copy(host_count_.data(), count_.data(), 1);
    run.wait();
    return host_count_.data()[0];
  }

  void removedIndices(Execution& run, pcl::Indices& removed) {
    const std::uint32_t count = choose(run, false);
    std::vector<std::uint32_t> places(count), numbers(listed_);
    run.copy(places.data(), chosen_.data(), count);
    if (!all_) run.copy(numbers.data(), indices_.data(), listed_);
    run.wait();
    removed.reserve(count);
    for (const std::uint32_t place : places)
      removed.push_back(static_cast<pcl::index_t>(all_ ? place : numbers[place]));
  }

  bool all_{true};
  std::size_t listed_{0};
  DeviceBuffer<std::uint32_t> indices_, chosen_, count_;
  DeviceBuffer<std::uint8_t> keep_;
  PinnedBuffer<std::uint32_t> host_count_;
};

}  // namespace gpu
}  // namespace fuse_flow
