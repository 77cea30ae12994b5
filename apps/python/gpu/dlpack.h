#pragma once

#include <cstdint>

/** \file
 *  \brief DLPack's structures, as its specification lays them out in memory: what tensors are handed over as (version 0.8), and the functions
 *  by which C and C++ look at them (1.3). */

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

/** \brief As ManagedTensor, of version 1: with the version first. */
struct ManagedTensorVersioned {
  struct {
    std::uint32_t major, minor;
  } version;
  void* context;
  void (*deleter)(ManagedTensorVersioned*);
  std::uint64_t flags;
  Tensor tensor;
};

/** \brief Functions of a library of tensors: the capsule __dlpack_c_exchange_api__ of their class, named kExchangeName. All return 0, or −1 with
 *  an exception of Python's set; they are called with the interpreter's lock. */
struct ExchangeApi {
  struct {
    std::uint32_t major, minor;
  } version;
  ExchangeApi* older;  ///< the table of an older major version, or null
  void* allocate;      ///< not used here
  /** \brief A tensor whose memory stays until its deleter is called, which may be null. */
  int (*managed_of)(void* object, ManagedTensorVersioned** out);
  void* object_of;  ///< not used here
  /** \brief Describes a tensor, which stays its owner's; nobody waits for anybody. Null: the library does not know it. */
  int (*describe)(void* object, Tensor* out);
  /** \brief The stream that the library's work is on now: a cudaStream_t, null: CUDA's legacy default stream. */
  int (*current_stream)(DeviceType type, std::int32_t device, void** out);
};
constexpr std::uint32_t kExchangeMajor = 1;
constexpr const char* kExchangeName = "dlpack_exchange_api";

}  // namespace fuse_flow::python::dlpack
