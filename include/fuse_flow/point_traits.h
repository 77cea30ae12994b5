#pragma once

/** \file
 *  \brief The only interface between the algorithms and the point types. It finds the optional fields of a point at compile time, by PCL's
 *  field traits, and reads and writes them. All access uses the registered offset, so a point type whose members and fields have different
 *  names works too. */

#include <fuse_flow/math/vec3.h>
#include <fuse_flow/point_types.h>

#include <pcl/type_traits.h>

#include <array>
#include <cstring>
#include <type_traits>

namespace fuse_flow {
namespace point {

/** \brief Whether PointT has a field of that name (pcl::fields), registered with PCL, of one of these types. A field of another type, such
 *  as an intensity of one byte, has another meaning, and is not used. */
template <typename PointT, typename Field, typename... Types>
constexpr bool hasFieldOf() {
  if constexpr (pcl::traits::has_field<PointT, Field>::value)
    return (std::is_same_v<typename pcl::traits::datatype<PointT, Field>::type, Types> || ...);
  return false;
}

/** \brief Whether PointT has a confidence, of type float. */
template <typename PointT>
constexpr bool has_confidence = hasFieldOf<PointT, pcl::fields::confidence, float>();
/** \brief Whether PointT has an intensity, of type float. */
template <typename PointT>
constexpr bool has_intensity = hasFieldOf<PointT, pcl::fields::intensity, float>();
/** \brief Whether PointT has a camera_mask of two std::uint32_t: the bits of cameras 0 to 31, then of 32 to 63. */
template <typename PointT>
constexpr bool has_camera_mask = hasFieldOf<PointT, pcl::fields::camera_mask, std::uint32_t[2]>();
/** \brief Whether PointT has a view_count, an integer of 32 bits. */
template <typename PointT>
constexpr bool has_view_count = hasFieldOf<PointT, pcl::fields::view_count, std::uint32_t, std::int32_t>();
/** \brief Whether PointT has rgba, in 32 bits. */
template <typename PointT>
constexpr bool has_rgba = hasFieldOf<PointT, pcl::fields::rgba, std::uint32_t, float>();
/** \brief Whether PointT has rgba or rgb, in 32 bits. */
template <typename PointT>
constexpr bool has_color = has_rgba<PointT> || hasFieldOf<PointT, pcl::fields::rgb, std::uint32_t, float>();
/** \brief Whether PointT has a field that a colour image fills. */
template <typename PointT>
constexpr bool shows_color = has_color<PointT> || has_intensity<PointT>;
// Versions of clang-format differ in what && after a template is.
// clang-format off
/** \brief Whether PointT has all of normal_x, normal_y, normal_z, of type float. */
template <typename PointT>
constexpr bool has_normal = hasFieldOf<PointT, pcl::fields::normal_x, float>() &&
                            hasFieldOf<PointT, pcl::fields::normal_y, float>() &&
                            hasFieldOf<PointT, pcl::fields::normal_z, float>();
// clang-format on
/** \brief Which of the two holds a colour, where has_color. */
template <typename PointT>
using ColorField = std::conditional_t<has_rgba<PointT>, pcl::fields::rgba, pcl::fields::rgb>;

/** \brief Writes a field that PointT has; Value must have the field's type. */
template <typename Field, typename Value, typename PointT>
void setField(PointT& point, const Value& value) {
  std::memcpy(reinterpret_cast<char*>(&point) + pcl::traits::offset<PointT, Field>::value, &value, sizeof(Value));
}

/** \brief Reads a field that PointT has; Value must have the field's type. */
template <typename Field, typename Value, typename PointT>
Value getField(const PointT& point) {
  Value value;
  std::memcpy(&value, reinterpret_cast<const char*>(&point) + pcl::traits::offset<PointT, Field>::value, sizeof(Value));
  return value;
}

/** \brief Metres, in the cloud's frame. */
template <typename PointT>
void setPosition(PointT& point, const Vec3& p) {
  point.x = p.x;
  point.y = p.y;
  point.z = p.z;
}

/** \brief Red, green and blue in 0 … 255, so that they can be averaged; 0 where PointT has no colour. */
template <typename PointT>
Vec3 getColor(const PointT& point) {
  std::uint32_t rgba = 0;
  if constexpr (has_color<PointT>) rgba = getField<ColorField<PointT>, std::uint32_t>(point);
  return {static_cast<float>(rgba >> 16 & 255u), static_cast<float>(rgba >> 8 & 255u), static_cast<float>(rgba & 255u)};
}

/** \brief Red, green and blue in 0 … 255, rounded to the nearest; opaque. */
template <typename PointT>
void setColor(PointT& point, const Vec3& color) {
  const auto channel = [](float value) { return static_cast<std::uint32_t>(value + 0.5f); };
  const std::uint32_t rgba = 0xff000000u | channel(color.x) << 16 | channel(color.y) << 8 | channel(color.z);
  if constexpr (has_color<PointT>) setField<ColorField<PointT>>(point, rgba);
}

/** \brief To intensity if the point has it. */
template <typename PointT>
void setIntensity(PointT& point, float intensity) {
  if constexpr (has_intensity<PointT>) setField<pcl::fields::intensity>(point, intensity);
}

/** \brief As stored; 0 where PointT has none. */
template <typename PointT>
float getIntensity(const PointT& point) {
  if constexpr (has_intensity<PointT>) return getField<pcl::fields::intensity, float>(point);
  return 0.0f;
}

/** \brief To confidence if the point has it; 0 … 1. */
template <typename PointT>
void setConfidence(PointT& point, float confidence) {
  if constexpr (has_confidence<PointT>) setField<pcl::fields::confidence>(point, confidence);
}

/** \brief As stored; 1 where PointT has none. */
template <typename PointT>
float getConfidence(const PointT& point) {
  if constexpr (has_confidence<PointT>) return getField<pcl::fields::confidence, float>(point);
  return 1.0f;
}

/** \brief To view_count if the point has it. */
template <typename PointT>
void setViewCount(PointT& point, std::uint32_t views) {
  if constexpr (has_view_count<PointT>) setField<pcl::fields::view_count>(point, views);
}

/** \brief The field camera_mask: bits of cameras 0 to 31, then of 32 to 63. */
using CameraMaskWords = std::array<std::uint32_t, 2>;

/** \brief To camera_mask if the point has it. \param point to be written to  \param mask a cameraBit() each */
template <typename PointT>
void setCameraMask(PointT& point, std::uint64_t mask) {
  if constexpr (has_camera_mask<PointT>)
    setField<pcl::fields::camera_mask>(
        point, CameraMaskWords{static_cast<std::uint32_t>(mask), static_cast<std::uint32_t>(mask >> 32)});
}

/** \brief As stored; 0 where PointT has none. */
template <typename PointT>
std::uint64_t getCameraMask(const PointT& point) {
  CameraMaskWords words{};
  if constexpr (has_camera_mask<PointT>) words = getField<pcl::fields::camera_mask, CameraMaskWords>(point);
  return std::uint64_t{words[1]} << 32 | words[0];
}

/** \brief The stored normal, of any length; zero if PointT has none. */
template <typename PointT>
Vec3 getNormal(const PointT& point) {
  if constexpr (has_normal<PointT>)
    return {getField<pcl::fields::normal_x, float>(point), getField<pcl::fields::normal_y, float>(point),
            getField<pcl::fields::normal_z, float>(point)};
  return {};
}

/** \brief To normal_x, normal_y and normal_z if the point has them. */
template <typename PointT>
void setNormal(PointT& point, const Vec3& n) {
  if constexpr (has_normal<PointT>) {
    setField<pcl::fields::normal_x>(point, n.x);
    setField<pcl::fields::normal_y>(point, n.y);
    setField<pcl::fields::normal_z>(point, n.z);
  }
}

}  // namespace point
}  // namespace fuse_flow
