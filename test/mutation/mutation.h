#pragma once

/** \file
 *  \brief Mutants of the library in one program: mutate.py writes a < b as a < FUSE_FLOW_MUTANT(17) < b, which is a < b unless
 *  mutant 17 is chosen, and then a <= b. Precedence stays, since the operator is the same on both sides. */

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <type_traits>

namespace fuse_flow_mutation {

constexpr int kMaxMutants = 1 << 14;

/** \brief What a run has met: 1, it is reached; 2, there is no such mutant, as the types have no such operator. */
inline unsigned char met[kMaxMutants];

/** \brief Writes what was met to the file that FUSE_FLOW_MUTATION_MET names, when the program ends. */
struct Record {
  const char* path{std::getenv("FUSE_FLOW_MUTATION_MET")};
  ~Record() {
    if (path == nullptr) return;
    if (std::FILE* file = std::fopen(path, "wb")) {
      std::fwrite(met, 1, sizeof met, file);
      std::fclose(file);
    }
  }
};
inline const Record record;

/** \brief The mutant of this run; 0: none. */
inline int chosen() {
  const char* number = std::getenv("FUSE_FLOW_MUTANT");
  return number ? std::atoi(number) : 0;
}
inline const int mutant = chosen();

template <int id>
constexpr bool on() {
  if (__builtin_is_constant_evaluated()) return false;
  if (met[id] == 0) met[id] = 1;
  return mutant == id;
}
template <int id>
constexpr void none() {
  if (!__builtin_is_constant_evaluated()) met[id] = 2;
}

/** \brief Stands between an operator and itself. */
template <int id>
struct Between {};

// Whether there is a − b where there is a + b, and so on: else the mutant does not exist.
#define FUSE_FLOW_MUTATION_HAS(name, op)                                                                            \
  template <typename A, typename B, typename Same, typename = void>                                                 \
  struct name : std::false_type {};                                                                                 \
  template <typename A, typename B, typename Same>                                                                  \
  struct name<                                                                                                      \
      A, B, Same,                                                                                                   \
      std::enable_if_t<std::is_convertible<decltype(std::declval<A&>() op std::declval<const B&>()), Same>::value>> \
      : std::true_type {};
FUSE_FLOW_MUTATION_HAS(HasPlus, +)
FUSE_FLOW_MUTATION_HAS(HasMinus, -)
FUSE_FLOW_MUTATION_HAS(HasTimes, *)
FUSE_FLOW_MUTATION_HAS(HasDivide, /)

// a op Between<id>: holds a until op b comes. The body says what is returned instead of a op b.
#define FUSE_FLOW_MUTATION(Holder, op, ...)                            \
  template <int id, typename A>                                        \
  struct Holder {                                                      \
    A&& a;                                                             \
    template <typename B>                                              \
    constexpr auto operator op(const B& b) const -> decltype(a op b) { \
      __VA_ARGS__                                                      \
      return a op b;                                                   \
    }                                                                  \
  };                                                                   \
  template <int id, typename A>                                        \
  constexpr Holder<id, A> operator op(A&& a, Between<id>) {            \
    return {static_cast<A&&>(a)};                                      \
  }
#define FUSE_FLOW_MUTATION_ONE(Holder, op, other) FUSE_FLOW_MUTATION(Holder, op, if (on<id>()) return a other b;)
// Two mutants: the next one along the boundary, and the opposite.
#define FUSE_FLOW_MUTATION_RELATION(Holder, op, boundary, opposite) \
  FUSE_FLOW_MUTATION(Holder, op, if (on<id>()) return a boundary b; if (on<id + 1>()) return a opposite b;)
#define FUSE_FLOW_MUTATION_ARITHMETIC(Holder, op, Has, other)         \
  FUSE_FLOW_MUTATION(                                                 \
      Holder, op, if constexpr (Has<A, B, decltype(a op b)>::value) { \
        if (on<id>()) return a other b;                               \
      } else none<id>();)
FUSE_FLOW_MUTATION_ARITHMETIC(Plus, +, HasMinus, -)
FUSE_FLOW_MUTATION_ARITHMETIC(Minus, -, HasPlus, +)
FUSE_FLOW_MUTATION_ARITHMETIC(Times, *, HasDivide, /)
FUSE_FLOW_MUTATION_ARITHMETIC(Divide, /, HasTimes, *)
FUSE_FLOW_MUTATION_RELATION(Less, <, <=, >=)
FUSE_FLOW_MUTATION_RELATION(LessEqual, <=, <, >)
FUSE_FLOW_MUTATION_RELATION(Greater, >, >=, <=)
FUSE_FLOW_MUTATION_RELATION(GreaterEqual, >=, >, <)
FUSE_FLOW_MUTATION_ONE(Equal, ==, !=)
FUSE_FLOW_MUTATION_ONE(NotEqual, !=, ==)
FUSE_FLOW_MUTATION_ONE(And, &, |)
FUSE_FLOW_MUTATION_ONE(Or, |, &)

// a += b: written a += FUSE_FLOW_MUTANT(17) += b, which is read from the right.
template <int id, typename B>
constexpr B negated(const B& b) {
  if constexpr (HasMinus<B, B, B>::value) {
    if (on<id>()) return b - b - b;
  } else {
    none<id>();
  }
  return b;
}
template <int id, typename B>
constexpr B operator+=(Between<id>, const B& b) {
  return negated<id>(b);
}
template <int id, typename B>
constexpr B operator-=(Between<id>, const B& b) {
  return negated<id>(b);
}
template <int id, typename B>
constexpr B operator*=(Between<id>, const B& b) {
  return on<id>() ? B(1) / b : b;
}
template <int id, typename B>
constexpr B operator|=(Between<id>, const B& b) {
  return on<id>() ? B{} : b;
}
template <int id, typename B>
constexpr B operator&=(Between<id>, const B& b) {
  return on<id>() ? static_cast<B>(~B{}) : b;
}

template <int id, typename T>
constexpr const T& min(const T& a, const T& b) {
  return on<id>() ? std::max(a, b) : std::min(a, b);
}
template <int id, typename T>
constexpr const T& max(const T& a, const T& b) {
  return on<id>() ? std::min(a, b) : std::max(a, b);
}

}  // namespace fuse_flow_mutation

#define FUSE_FLOW_MUTANT(id) \
  ::fuse_flow_mutation::Between<id> {}
