#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace fuse_flow::python {

/** \brief Where the fields of a point lie, in bytes from its beginning. */
struct PointLayout {
  std::size_t size{0};  ///< of a point, bytes
  std::size_t rgba{0}, confidence{0}, view_count{0};
  std::optional<std::size_t> normal, camera_mask;
};

/** \brief A fused cloud, which shares its memory with the arrays that are made of it. */
struct Cloud {
  std::shared_ptr<const void> memory;  ///< keeps the points
  std::byte* points{nullptr};
  std::size_t size{0};
  PointLayout layout;
  std::uint64_t stamp{0};
};

}  // namespace fuse_flow::python
