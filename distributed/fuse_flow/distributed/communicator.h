#pragma once

#include <pcl/exceptions.h>

#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Thrown where another rank is gone or silent, has another rig or other parameters, could not do its part of a frame, or sends what
 *  cannot be. After silence a communicator is of no more use; after all others the next frame may be tried. */
class RankError : public pcl::PCLException {
 public:
  /** \param rank whose fault it is  \param what it is, as the rest of a sentence that begins with the rank */
  RankError(int rank, const std::string& what)
      : pcl::PCLException("fuse_flow::distributed: rank " + std::to_string(rank) + " " + what), rank_(rank) {}

  /** \brief Whose fault it is. */
  int rank() const { return rank_; }

 private:
  int rank_;
};

/** \brief Leaves what it makes as it finds it: a message is written as a whole, and zeros before would only take time. */
template <typename T>
struct Unwritten : std::allocator<T> {
  template <typename U>
  struct rebind {
    using other = Unwritten<U>;
  };
  template <typename U, typename... Args>
  void construct(U* place, Args&&... args) {
    if constexpr (sizeof...(Args) == 0) {
      ::new (static_cast<void*>(place)) U;
    } else {
      ::new (static_cast<void*>(place)) U(std::forward<Args>(args)...);
    }
  }
};

/** \brief The bytes that one rank sends to another. */
using Message = std::vector<char, Unwritten<char>>;

/** \brief How the ranks of a frame reach each other. Ranks are numbered from 0. MpiCommunicator has them in processes, on one machine or
 *  several; ThreadRanks in the threads of one process. Only one thread at a time may use an object. */
class Communicator {
 public:
  /** \brief A message on its way; the sender keeps the bytes until exchange() returns. */
  struct Outgoing {
    int rank;          ///< who gets it; another one
    const char* data;  ///< its bytes
    std::size_t size;  ///< how many; may be 0
  };

  virtual ~Communicator() = default;

  /** \brief This rank's number. */
  virtual int rank() const = 0;
  /** \brief How many ranks there are. */
  virtual int size() const = 0;

  /** \brief Sends messages, and waits for one from each of some ranks. All ranks call this equally often, so that the k-th call of one
   *  meets the k-th call of every other.
   *  \param out what is sent, at most one message a rank  \param from who sends to this rank in this call
   *  \param in receives the messages, in the order of \p from; keeps its memory
   *  \throws RankError if one of them does not send in time */
  virtual void exchange(const std::vector<Outgoing>& out, const std::vector<int>& from, std::vector<Message>& in) = 0;
};

/** \brief All ranks but one's own. */
inline std::vector<int> otherRanks(const Communicator& communicator) {
  std::vector<int> others;
  for (int r = 0; r < communicator.size(); ++r)
    if (r != communicator.rank()) others.push_back(r);
  return others;
}

/** \brief Sends one message to all other ranks, and waits for none. */
inline void sendToOthers(Communicator& communicator, const Message& message) {
  std::vector<Communicator::Outgoing> out;
  for (const int r : otherRanks(communicator)) out.push_back({r, message.data(), message.size()});
  std::vector<Message> none;
  communicator.exchange(out, {}, none);
}

/** \brief Every rank sends one message to all others. \returns theirs, in the order of otherRanks() */
inline std::vector<Message> exchangeWithOthers(Communicator& communicator, const Message& own) {
  const std::vector<int> others = otherRanks(communicator);
  std::vector<Communicator::Outgoing> out;
  for (const int r : others) out.push_back({r, own.data(), own.size()});
  std::vector<Message> in;
  communicator.exchange(out, others, in);
  return in;
}

}  // namespace distributed
}  // namespace fuse_flow
