#pragma once

#include <cstdint>

/** \file
 *  \brief DLPack's structures, as its specification (version 0.8) lays them out in memory: what tensors are handed over as. */

namespace fuse_flow::python::dlpack {

enum DeviceType : std::int32_t { kHost = 1, kCuda = 2, kCudaManaged = 13 };
enum TypeCode : std::uint8_t { kInt = 0, kUInt = 1, kFloat = 2 };

struct Device {
  std::int32_t type;
  std::int32_t id;
};

struct DataType {
  std::uint8_t code;
  std::uint8_t bits;
  std::uint16_t lanes;  ///< 1: no vectors
};

struct Tensor {
  void* data;
  Device device;
  std::int32_t ndim;
  DataType dtype;
  std::int64_t* shape;
  std::int64_t* strides;  ///< elements; null: row by row without gaps
  std::uint64_t byte_offset;
};

struct ManagedTensor {
  Tensor tensor;
  void* context;
  void (*deleter)(ManagedTensor*);
};

}  // namespace fuse_flow::python::dlpack
