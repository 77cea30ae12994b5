#pragma once

#include "../cloud.h"

#include <fuse_flow/stream/cloud_view.h>
#include <fuse_flow/stream/encoded_frame.h>

#include <pybind11/numpy.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace fuse_flow::python {

/** \brief What Python sends, a Cloud, a StreamedCloud, or arrays, as the encoder reads it. To be made and destroyed with the interpreter's
 *  lock. */
class PublishedCloud {
 public:
  /** \brief Arrays beside the points; None where there is none. */
  struct Fields {
    pybind11::object colors, confidence, view_count, normals, camera_mask;
  };

  /** \throws pybind11::value_error for an array that does not fit, and for fields of a cloud that has its own */
  PublishedCloud(const pybind11::object& cloud, const Fields& fields);

  /** \brief Needs no lock. Points without fields are read where they lie; arrays become points, which are a copy. */
  stream::CloudView view();

 private:
  void setFields(const Fields& fields);

  pybind11::object kept_;        ///< the Cloud
  const Cloud* fused_{nullptr};  ///< in it; null: the following are arrays
  std::size_t size_{0};
  std::optional<pybind11::array_t<float>> points_, confidence_, normals_;
  std::optional<pybind11::array_t<std::uint8_t>> colors_;
  std::optional<pybind11::array_t<std::uint32_t>> view_count_, camera_mask_;
  std::vector<std::uint32_t> packed_;  ///< words, as each field is some of them
};

/** \brief Counts the frames that are sent. */
class FrameNumbers {
 public:
  /** \brief Of a cloud as it is sent. What is not given is a StreamedCloud's own; else the number is one more than that before, and the time
   *  is not known. */
  stream::FrameTimes timesOf(const pybind11::object& cloud, const std::optional<std::uint64_t>& number,
                             const std::optional<std::int64_t>& captured);

 private:
  std::uint64_t next_{0};
};

}  // namespace fuse_flow::python
